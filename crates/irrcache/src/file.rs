//! Caches as files: to be read again ([`SavedCache`]), and to be looked at (PLY, CSV).

use gi_core::math::Rgb;
use glam::Vec3;

use crate::gradients::Gradient;
use crate::record::Record;
use crate::site::Site;

/// First bytes of the file.
const MAGIC: &[u8; 8] = b"gilab-ic";
/// Version of the format. Raise it whenever a record's bytes, or what they mean, change.
const VERSION: u32 = 1;
/// Floats of a record.
const FLOATS: usize = 3 * 4 + 2 + 2 + 6 * 3;

/// A cache as it was saved: what it is good for, and its records level by level.
#[derive(Clone, Debug, PartialEq)]
pub struct SavedCache {
    /// Identity of the world that it was made in.
    pub world: u64,
    /// The settings that shape records, in words.
    pub settings: String,
    /// Records of each level.
    pub levels: Vec<Vec<Record>>,
}

impl SavedCache {
    /// The file's bytes: little-endian, a checksum at the end.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        out.extend(VERSION.to_le_bytes());
        out.extend(self.world.to_le_bytes());
        out.extend((self.settings.len() as u32).to_le_bytes());
        out.extend(self.settings.as_bytes());
        out.extend((self.levels.len() as u32).to_le_bytes());
        for level in &self.levels {
            out.extend((level.len() as u64).to_le_bytes());
            for record in level {
                floats(record).iter().for_each(|f| out.extend(f.to_le_bytes()));
            }
        }
        let sum = checksum(&out);
        out.extend(sum.to_le_bytes());
        out
    }

    /// Read such a file.
    ///
    /// # Errors
    /// One line about why it is not one: not a cache, another version, damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let mut r = Reader { bytes };
        if r.take(MAGIC.len())? != MAGIC {
            return Err("it is not an irradiance cache".into());
        }
        let version = r.u32()?;
        if version != VERSION {
            return Err(format!(
                "its format is version {version}, this program reads {VERSION}: make it anew"
            ));
        }
        let body = bytes.len().checked_sub(8).ok_or_else(cut_off)?;
        if checksum(&bytes[..body]).to_le_bytes() != bytes[body..] {
            return Err("it is damaged: its checksum is wrong".into());
        }
        let world = r.u64()?;
        let length = r.u32()? as usize;
        let settings = String::from_utf8_lossy(r.take(length)?).into_owned();
        let levels = (0..r.u32()?).map(|_| r.level()).collect::<Result<_, _>>()?;
        Ok(SavedCache { world, settings, levels })
    }
}

fn cut_off() -> String {
    "it is damaged: it ends too early".to_string()
}

struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.bytes.split_at_checked(n).ok_or_else(cut_off)?;
        self.bytes = rest;
        Ok(taken)
    }

    fn u32(&mut self) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.take(4)?.try_into().expect("four bytes")))
    }

    fn u64(&mut self) -> Result<u64, String> {
        Ok(u64::from_le_bytes(self.take(8)?.try_into().expect("eight bytes")))
    }

    fn level(&mut self) -> Result<Vec<Record>, String> {
        let count = usize::try_from(self.u64()?).map_err(|_| cut_off())?;
        let bytes = self.take(count.checked_mul(4 * FLOATS).ok_or_else(cut_off)?)?;
        let mut records = Vec::with_capacity(count);
        for run in bytes.chunks_exact(4 * FLOATS) {
            let mut floats = [0.0; FLOATS];
            for (f, b) in floats.iter_mut().zip(run.chunks_exact(4)) {
                *f = f32::from_le_bytes(b.try_into().expect("four bytes"));
            }
            records.push(record(&floats));
        }
        Ok(records)
    }
}

/// A record as floats.
fn floats(r: &Record) -> [f32; FLOATS] {
    let mut out = Vec::with_capacity(FLOATS);
    out.extend(r.e.to_array());
    let Site { n, p, radii, axis, least, clear } = r.site;
    for v in [n, p, axis] {
        out.extend(v.to_array());
    }
    out.extend(radii);
    out.extend([least, clear]);
    for g in [&r.rotational, &r.translational] {
        g.0.iter().for_each(|v| out.extend(v.to_array()));
    }
    out.try_into().expect("as many floats as a record has")
}

fn record(floats: &[f32; FLOATS]) -> Record {
    let v = |k: usize| Vec3::new(floats[k], floats[k + 1], floats[k + 2]);
    let gradient = |k: usize| Gradient([v(k), v(k + 3), v(k + 6)]);
    let site = Site {
        n: v(3),
        p: v(6),
        axis: v(9),
        radii: [floats[12], floats[13]],
        least: floats[14],
        clear: floats[15],
    };
    let e = Rgb::from(v(0).to_array());
    Record { e, site, rotational: gradient(16), translational: gradient(25) }
}

/// FNV-1a, 64 bits: against damage, not against malice.
fn checksum(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3))
}

/// Records as a table: position, normal, irradiance, radii, gradient by position of the channels' mean.
pub fn to_csv(records: &[Record]) -> String {
    let mut out =
        String::from("x,y,z,nx,ny,nz,e_r,e_g,e_b,radius_u,radius_v,clear,grad_x,grad_y,grad_z\n");
    for r in records {
        let g = r.translational.0.iter().sum::<Vec3>() / 3.0;
        let numbers = [r.site.p.to_array(), r.site.n.to_array(), r.e.to_array()].concat();
        let more = [r.site.radii[0], r.site.radii[1], r.site.clear, g.x, g.y, g.z];
        let row: Vec<String> = numbers.iter().chain(&more).map(f32::to_string).collect();
        out += &row.join(",");
        out.push('\n');
    }
    out
}

/// Records as a point cloud: position, normal, colour (irradiance over the largest one), radius.
pub fn to_ply(records: &[Record]) -> Vec<u8> {
    let properties = ["x", "y", "z", "nx", "ny", "nz", "e_r", "e_g", "e_b", "radius"];
    let mut out =
        format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", records.len());
    properties.iter().for_each(|p| out += &format!("property float {p}\n"));
    ["red", "green", "blue"].iter().for_each(|p| out += &format!("property uchar {p}\n"));
    out += "end_header\n";
    let mut out = out.into_bytes();
    let brightest = records.iter().map(|r| r.e.max()).fold(f32::MIN_POSITIVE, f32::max);
    for r in records {
        let numbers = [r.site.p.to_array(), r.site.n.to_array(), r.e.to_array()].concat();
        numbers.iter().chain([&r.site.reach()]).for_each(|f| out.extend(f.to_le_bytes()));
        let byte = |c: f32| ((c / brightest).powf(1.0 / 2.2) * 255.0 + 0.5) as u8;
        out.extend(r.e.to_array().map(byte));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn saved() -> SavedCache {
        let record = |k: usize| {
            let mut floats = [0.0; FLOATS];
            floats.iter_mut().enumerate().for_each(|(i, f)| *f = (i + 100 * k) as f32 * 0.25);
            record(&floats)
        };
        let levels = vec![(0..5).map(record).collect(), vec![record(9)], vec![]];
        SavedCache { world: 0x0123_4567_89ab_cdef, settings: "accuracy 0.1".into(), levels }
    }

    #[test]
    fn what_was_saved_is_read() {
        assert_eq!(SavedCache::from_bytes(&saved().to_bytes()), Ok(saved()));
    }

    #[test]
    fn damaged_and_foreign_files_are_refused() {
        let bytes = saved().to_bytes();
        for cut in 0..bytes.len() {
            assert!(SavedCache::from_bytes(&bytes[..cut]).is_err(), "cut at {cut}");
        }
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x40;
            assert!(SavedCache::from_bytes(&damaged).is_err(), "a bit of byte {at} turned");
        }
        let mut newer = bytes.clone();
        newer[8] += 1;
        let error = SavedCache::from_bytes(&newer).expect_err("another version");
        assert!(error.contains("version 2"), "{error}");
        let error = SavedCache::from_bytes(b"PK\x03\x04 something else").expect_err("another file");
        assert!(error.contains("not an irradiance cache"), "{error}");
    }

    #[test]
    fn exports_have_a_row_a_record() {
        let records = &saved().levels[0];
        assert_eq!(to_csv(records).lines().count(), 6);
        let ply = to_ply(records);
        let header = b"end_header\n";
        let at = ply.windows(header.len()).position(|w| w == header).expect("a header");
        assert_eq!(ply.len() - at - header.len(), 5 * (10 * 4 + 3));
    }
}
