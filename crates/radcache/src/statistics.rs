//! The numbers that are printed and stored with the picture.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use gi_core::bytes::{Reader, Writer};
use lightcache::Cache;
use lightcache::site::Sited;

use crate::caches::Caches;
use crate::surfaces::Surfaces;

/// Counts of lookups.
#[derive(Default)]
pub(crate) struct LookupCounts {
    /// Lookups that used a record with up to twice the allowed error.
    pub(crate) relaxed: AtomicU64,
    /// Lookups that found nothing: the path continued.
    pub(crate) failed: AtomicU64,
    /// Lookups with a negative channel due to ringing, which was set to zero.
    pub(crate) negative: AtomicU64,
    /// Lookups of radiance.
    pub(crate) glossy: AtomicU64,
}

impl LookupCounts {
    /// Count a lookup that had to be relaxed.
    pub(crate) fn add_relaxed(&self, found: bool) {
        if found { &self.relaxed } else { &self.failed }.fetch_add(1, Relaxed);
    }

    /// Count a lookup of radiance.
    pub(crate) fn add_glossy(&self) {
        self.glossy.fetch_add(1, Relaxed);
    }

    /// Count a negative radiance.
    pub(crate) fn add_negative(&self) {
        self.negative.fetch_add(1, Relaxed);
    }

    fn all(&self) -> [&AtomicU64; 4] {
        [&self.relaxed, &self.failed, &self.negative, &self.glossy]
    }

    /// The counts for a resumed run.
    pub(crate) fn save(&self) -> Vec<u8> {
        let mut w = Writer::default();
        w.counts(self.all());
        w.into_bytes()
    }

    /// Add stored counts.
    pub(crate) fn restore(&self, state: &[u8]) -> Result<(), String> {
        let mut r = Reader::new(state);
        r.add_to_counts(self.all())?;
        r.end()
    }
}

/// Numbers of gather rays per record.
pub(crate) struct RaysPerRecord {
    pub(crate) diffuse: usize,
    pub(crate) glossy: usize,
}

/// Statistics of the caches and the BRDF tables; `records_read` of the records came from a file.
pub(crate) fn statistics(
    caches: &Caches,
    surfaces: &Surfaces,
    records_read: usize,
    rays: &RaysPerRecord,
    lookups: &LookupCounts,
) -> Vec<(String, f64)> {
    let (diffuse, glossy) = (caches.diffuse.records().len(), caches.glossy.records().len());
    let mut all = [
        ("records", diffuse as f64),
        ("glossy_records", glossy as f64),
        ("records_made", (caches.count() - records_read) as f64),
        ("records_read", records_read as f64),
        ("gather_rays", (diffuse * rays.diffuse + glossy * rays.glossy) as f64),
        ("mean_radius", mean_radius(&caches.diffuse)),
        ("glossy_mean_radius", mean_radius(&caches.glossy)),
        ("glossy_lookups", lookups.glossy.load(Relaxed) as f64),
        ("lookups_relaxed", lookups.relaxed.load(Relaxed) as f64),
        ("lookups_failed", lookups.failed.load(Relaxed) as f64),
        ("lookups_negative", lookups.negative.load(Relaxed) as f64),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .to_vec();
    for (material, table) in surfaces.tables() {
        all.push((format!("material_{material}_order"), table.order as f64));
        all.push((format!("material_{material}_left_out"), f64::from(table.left_out)));
    }
    all
}

fn mean_radius(cache: &Cache<impl Sited>) -> f64 {
    let sum: f64 = cache.records().iter().map(|r| f64::from(r.site().reach())).sum();
    sum / cache.records().len().max(1) as f64
}
