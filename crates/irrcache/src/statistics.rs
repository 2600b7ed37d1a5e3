//! The numbers that are printed and stored with the picture.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use gi_core::bytes::{Reader, Writer};
use lightcache::Cache;
use lightcache::record::Record;

/// Counts of lookups that found no valid record.
#[derive(Default)]
pub(crate) struct LookupCounts {
    /// Lookups that used a record with up to twice the allowed error.
    pub(crate) relaxed: AtomicU64,
    /// Lookups that found nothing: the path continued.
    pub(crate) failed: AtomicU64,
}

impl LookupCounts {
    /// Count a lookup that had to be relaxed.
    pub(crate) fn add(&self, found: bool) {
        if found { &self.relaxed } else { &self.failed }.fetch_add(1, Relaxed);
    }

    fn all(&self) -> [&AtomicU64; 2] {
        [&self.relaxed, &self.failed]
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

/// Statistics of the caches: `records_read` came from a file, and a record of level k took `rays(k)` gather rays.
pub(crate) fn statistics(
    levels: &[Cache<Record>],
    records_read: usize,
    rays: impl Fn(usize) -> usize,
    lookups: &LookupCounts,
) -> Vec<(String, f64)> {
    let first = levels[0].records();
    let made = levels.iter().map(|c| c.records().len()).sum::<usize>() - records_read;
    let gather_rays: usize =
        levels.iter().enumerate().map(|(k, c)| c.records().len() * rays(k)).sum();
    let radii = first.iter().map(|r| f64::from(r.site.reach()));
    let mut all = vec![
        ("records".to_string(), first.len() as f64),
        ("records_made".to_string(), made as f64),
        ("records_read".to_string(), records_read as f64),
        ("gather_rays".to_string(), gather_rays as f64),
        ("mean_radius".to_string(), radii.sum::<f64>() / first.len().max(1) as f64),
        ("lookups_relaxed".to_string(), lookups.relaxed.load(Relaxed) as f64),
        ("lookups_failed".to_string(), lookups.failed.load(Relaxed) as f64),
    ];
    for (k, level) in levels.iter().enumerate().skip(1) {
        all.push((format!("records_level_{}", k + 1), level.records().len() as f64));
    }
    all
}
