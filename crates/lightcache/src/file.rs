//! Caches as files that a later run can read. All kinds of caches share a header, the world and the settings for which the
//! records are valid, and a checksum. Each technique adds its own [`Body`].

use std::path::Path;

use gi_core::bytes::{Reader, Writer, unseal};
use gi_core::files;

/// The part of a cache file that is specific to a technique.
pub trait Body: Sized {
    /// First bytes of the file.
    const MAGIC: &'static [u8; 8];
    /// Version of the format. Increase it whenever the bytes of a record or their meaning change.
    const VERSION: u32;
    /// Name of this kind of file, with its article.
    const WHAT: &'static str;

    /// Write the body.
    fn write(&self, out: &mut Writer);

    /// Read the body.
    ///
    /// # Errors
    /// One line: the file is damaged.
    fn read(reader: &mut Reader) -> Result<Self, String>;
}

/// A saved cache: the world and settings for which it is valid, and its records.
#[derive(Clone, Debug, PartialEq)]
pub struct SavedCache<B> {
    /// Identity of the world for which it was made.
    pub world: u64,
    /// The settings that change what records hold, as text.
    pub settings: String,
    /// The records.
    pub body: B,
}

impl<B: Body> SavedCache<B> {
    /// The bytes of the file: little-endian, with a checksum at the end.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Writer::default();
        out.raw(B::MAGIC);
        out.u32(B::VERSION);
        out.u64(self.world);
        out.u32(self.settings.len() as u32);
        out.raw(self.settings.as_bytes());
        self.body.write(&mut out);
        out.seal()
    }

    /// Read the file that the user named.
    ///
    /// # Errors
    /// One line with the file's name and the cause.
    pub fn open(path: &Path) -> Result<Self, String> {
        let bytes = files::read(path)?;
        Self::from_bytes(&bytes).map_err(|e| files::refusal(path, &e))
    }

    /// Read the bytes of such a file.
    ///
    /// # Errors
    /// One line with the cause: not a cache, another version, damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let mut r = Reader::new(bytes);
        if r.take(B::MAGIC.len())? != B::MAGIC {
            return Err(format!("it is not {}", B::WHAT));
        }
        let version = r.u32()?;
        if version != B::VERSION {
            return Err(format!(
                "its format is version {version}, but this program reads version {}: create the cache again with --cache-out",
                B::VERSION
            ));
        }
        unseal(bytes)?;
        let world = r.u64()?;
        let length = r.u32()? as usize;
        let settings = String::from_utf8_lossy(r.take(length)?).into_owned();
        let body = B::read(&mut r)?;
        Ok(SavedCache { world, settings, body })
    }

    /// Check that the cache is valid for this world and these settings.
    ///
    /// # Errors
    /// One line that names the difference.
    pub fn check(&self, world: u64, settings: &str) -> Result<(), String> {
        if self.world != world {
            return Err("it was made for another scene: shapes, materials or lights differ".into());
        }
        if self.settings != settings {
            return Err(format!(
                "the cache was made with {}, but this run has {settings}: use the same settings",
                self.settings
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Record;

    #[derive(Clone, Debug, PartialEq)]
    struct Records(Vec<Record>);

    impl Body for Records {
        const MAGIC: &'static [u8; 8] = b"a test's";
        const VERSION: u32 = 1;
        const WHAT: &'static str = "an irradiance cache";

        fn write(&self, out: &mut Writer) {
            out.table(&self.0, Record::put_floats);
        }

        fn read(r: &mut Reader) -> Result<Self, String> {
            r.table(Record::FLOATS, Record::from_floats).map(Records)
        }
    }

    fn saved() -> SavedCache<Records> {
        let record = |k: usize| {
            let floats: Vec<f32> =
                (0..Record::FLOATS).map(|i| (i + 100 * k) as f32 * 0.25).collect();
            Record::from_floats(&floats)
        };
        let body = Records((0..5).map(record).collect());
        SavedCache { world: 0x0123_4567_89ab_cdef, settings: "accuracy 0.1".into(), body }
    }

    type Saved = SavedCache<Records>;

    #[test]
    fn what_was_saved_is_read() {
        assert_eq!(Saved::from_bytes(&saved().to_bytes()), Ok(saved()));
    }

    #[test]
    fn damaged_and_foreign_files_are_refused() {
        let bytes = saved().to_bytes();
        for cut in 0..bytes.len() {
            assert!(Saved::from_bytes(&bytes[..cut]).is_err(), "cut at {cut}");
        }
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x40;
            assert!(Saved::from_bytes(&damaged).is_err(), "a bit of byte {at} turned");
        }
        let mut newer = bytes.clone();
        newer[8] += 1;
        let error = Saved::from_bytes(&newer).expect_err("another version");
        assert!(error.contains("version 2"), "{error}");
        let error = Saved::from_bytes(b"PK\x03\x04 something else").expect_err("another file");
        assert!(error.contains("not an irradiance cache"), "{error}");
    }
}
