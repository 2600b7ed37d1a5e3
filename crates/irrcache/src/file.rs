//! Reads and writes the cache as a file: its records, level by level.

use gi_core::bytes::{Reader, Writer};
use lightcache::Cache;
use lightcache::file::Body;
use lightcache::record::Record;

use crate::params::Params;

/// A cache as it is stored in a file.
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

/// Insert the records of a saved cache, and return their number.
///
/// # Errors
/// A message of one line: the cache was made for another scene or with other settings.
pub(crate) fn insert(
    saved: SavedCache,
    world: u64,
    params: &Params,
    levels: &mut [Cache<Record>],
) -> Result<usize, String> {
    saved.check(world, &shaping_settings(params))?;
    let mut count = 0;
    for (cache, records) in levels.iter_mut().zip(&saved.body.0) {
        count += records.len();
        // The records have limited each other's radii already: inserting them changes none.
        records.iter().for_each(|r| cache.insert(*r));
    }
    Ok(count)
}

/// Caches in the form that a file stores.
pub(crate) fn saved(world: u64, params: &Params, levels: &[Cache<Record>]) -> SavedCache {
    let body = Levels(levels.iter().map(|c| c.records().to_vec()).collect());
    SavedCache { world, settings: shaping_settings(params), body }
}

/// The settings that affect the contents of records. A saved cache can be used only with the same ones.
fn shaping_settings(params: &Params) -> String {
    let Params { accuracy, bounces, radius, error, limits, .. } = params;
    let bounces = bounces.map_or("path".to_string(), |b| b.to_string());
    let depth = limits.max_depth.map_or(-1, |d| d as i32);
    let caustics = if params.caustics.by_photons() { "photon" } else { "path" };
    format!(
        "--accuracy {accuracy} --error {error:?} --radius {radius:?} --bounces {bounces} --max-depth {depth} --caustics {caustics}"
    )
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
