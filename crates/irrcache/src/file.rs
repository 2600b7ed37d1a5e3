//! The cache as a file: its records, level by level.

use lightcache::file::{Body, Reader, Writer};
use lightcache::record::Record;

/// A cache as it was saved.
pub type SavedCache = lightcache::file::SavedCache<Levels>;

/// Records of each level.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels(pub Vec<Vec<Record>>);

impl Body for Levels {
    const MAGIC: &'static [u8; 8] = b"gilab-ic";
    const VERSION: u32 = 1;
    const WHAT: &'static str = "an irradiance cache";

    fn write(&self, out: &mut Writer) {
        out.u32(self.0.len() as u32);
        self.0.iter().for_each(|level| out.table(level, Record::put_floats));
    }

    fn read(r: &mut Reader) -> Result<Self, String> {
        let level = |r: &mut Reader| r.table(Record::FLOATS, Record::from_floats);
        (0..r.u32()?).map(|_| level(r)).collect::<Result<_, _>>().map(Levels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_that_were_saved_are_read() {
        let record = |k: usize| {
            let floats: Vec<f32> =
                (0..Record::FLOATS).map(|i| (i + 100 * k) as f32 * 0.25).collect();
            Record::from_floats(&floats)
        };
        let body = Levels(vec![(0..5).map(record).collect(), vec![record(9)], vec![]]);
        let saved = SavedCache { world: 7, settings: "accuracy 0.1".into(), body };
        assert_eq!(SavedCache::from_bytes(&saved.to_bytes()), Ok(saved));
    }
}
