//! Reads and writes the caches as a file: the records of both.

use gi_core::bytes::{Reader, Writer};
use glam::Vec3A;
use lightcache::file::Body;
use lightcache::record::Record;

use crate::caches::Caches;
use crate::params::Params;
use crate::record::RadianceRecord;
use crate::sh::MAX_FUNCTIONS;

/// Caches as they are stored in a file.
pub type SavedCache = lightcache::file::SavedCache<Records>;

/// Records of both kinds.
#[derive(Clone, Debug, PartialEq)]
pub struct Records {
    /// Irradiance records.
    pub diffuse: Vec<Record>,
    /// Radiance records, all of one order.
    pub glossy: Vec<RadianceRecord>,
}

impl Body for Records {
    const MAGIC: &'static [u8; 8] = b"gilab-rc";
    const VERSION: u32 = 1;
    const WHAT: &'static str = "a radiance cache";

    fn write(&self, out: &mut Writer) {
        out.table(&self.diffuse, Record::put_floats);
        out.u32(self.glossy.first().map_or(0, |r| r.light.len() as u32));
        out.table(&self.glossy, |r, floats| {
            r.irradiance.put_floats(floats);
            r.light.iter().for_each(|c| floats.extend(c.to_array()));
        });
    }

    fn read(r: &mut Reader) -> Result<Self, String> {
        let diffuse = r.table(Record::FLOATS, Record::from_floats)?;
        let count = r.u32()? as usize;
        if count > 3 * MAX_FUNCTIONS
            || !count.is_multiple_of(3)
            || !(count / 3).isqrt().pow(2).eq(&(count / 3))
        {
            return Err("it is damaged: the size of its records fits no order of the basis".into());
        }
        let glossy = r.table(Record::FLOATS + 3 * count, |floats| RadianceRecord {
            irradiance: Record::from_floats(floats),
            light: floats[Record::FLOATS..].chunks_exact(3).map(Vec3A::from_slice).collect(),
        })?;
        Ok(Records { diffuse, glossy })
    }
}

/// Insert the records of a saved cache, and return their number. `order` is that of this run's radiance records.
///
/// # Errors
/// A message of one line: the cache was made for another scene or with other settings, or it is damaged.
pub(crate) fn insert(
    saved: SavedCache,
    world: u64,
    params: &Params,
    order: usize,
    caches: &mut Caches,
) -> Result<usize, String> {
    saved.check(world, &shaping_settings(params, order))?;
    let Records { diffuse, glossy } = saved.body;
    if glossy.iter().any(|r| r.light.len() != 3 * order.pow(2)) {
        return Err("the cache is damaged: its records are not of the order that it states".into());
    }
    let count = diffuse.len() + glossy.len();
    // The records have limited each other's radii already: inserting them changes none.
    diffuse.into_iter().for_each(|r| caches.diffuse.insert(r));
    glossy.into_iter().for_each(|r| caches.glossy.insert(r));
    Ok(count)
}

/// Caches in the form that a file stores.
pub(crate) fn saved(world: u64, params: &Params, order: usize, caches: &Caches) -> SavedCache {
    let Caches { diffuse, glossy } = caches;
    let body = Records { diffuse: diffuse.records().to_vec(), glossy: glossy.records().to_vec() };
    SavedCache { world, settings: shaping_settings(params, order), body }
}

/// The settings that affect the contents of records. A saved cache can be used only with the same ones.
fn shaping_settings(params: &Params, order: usize) -> String {
    let Params { accuracy, glossy_accuracy, basis, min_roughness, limits, .. } = params;
    let Params { error, glossy_error, radius, .. } = params;
    let depth = limits.max_depth.map_or(-1, |d| d as i32);
    let caustics = if params.caustics.by_photons() { "photon" } else { "path" };
    format!(
        "--accuracy {accuracy} ({error:?}) --glossy-accuracy {glossy_accuracy} ({glossy_error:?}, {radius:?}) \
         --order {order} --basis {basis:?} --min-roughness {min_roughness} --max-depth {depth} --caustics {caustics}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_of_both_kinds_that_were_saved_are_read() {
        let irradiance = |k: usize| {
            let floats: Vec<f32> = (0..Record::FLOATS).map(|i| (i + 100 * k) as f32).collect();
            Record::from_floats(&floats)
        };
        let glossy = |k: usize| RadianceRecord {
            irradiance: irradiance(k),
            light: (0..27).map(|i| Vec3A::new(i as f32, k as f32, 0.5)).collect(),
        };
        for count in [0, 3] {
            let body = Records {
                diffuse: (0..5).map(irradiance).collect(),
                glossy: (0..count).map(glossy).collect(),
            };
            let saved = SavedCache { world: 3, settings: "--order 3".into(), body };
            assert_eq!(SavedCache::from_bytes(&saved.to_bytes()), Ok(saved));
        }
    }
}
