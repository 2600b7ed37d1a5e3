//! What cuts cost, counted.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Duration;

use vpl::{Energy, Vpls};

use crate::cut::Lit;

/// Counts of all passes. Whole numbers: their sums do not depend on the order in which threads add.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    energy: Energy,
    points: AtomicU64,
    clusters: AtomicU64,
    rays: AtomicU64,
    /// Of what the eye sees alone.
    seen: AtomicU64,
    seen_clusters: AtomicU64,
    seen_rays: AtomicU64,
    at_most: AtomicU64,
    reconstructed: AtomicU64,
    sample_rays: AtomicU64,
    lights: [u64; 2],
    building: Duration,
}

impl Tally {
    /// A point was lit; `seen`: by what the eye sees, not further down a path.
    pub(crate) fn note(&self, lit: &Lit, seen: bool) {
        let mut counts =
            vec![(&self.points, 1), (&self.clusters, lit.size), (&self.rays, lit.rays)];
        if seen {
            counts.extend([
                (&self.seen, 1),
                (&self.seen_clusters, lit.size),
                (&self.seen_rays, lit.rays),
            ]);
        }
        counts.push((&self.at_most, u32::from(lit.at_most)));
        counts.into_iter().for_each(|(c, n)| _ = c.fetch_add(n.into(), Relaxed));
        self.energy.note(lit.indirect.luminance(), lit.cut_off, 0);
    }

    /// A point was reconstructed.
    pub(crate) fn reconstructed(&self) {
        self.reconstructed.fetch_add(1, Relaxed);
    }

    /// A sample for reconstruction took so many rays.
    pub(crate) fn sampled(&self, rays: u32) {
        self.sample_rays.fetch_add(rays.into(), Relaxed);
    }

    /// A set's trees were built.
    pub(crate) fn built(&mut self, set: &Vpls, time: Duration) {
        let direct = set.up_to(0).len();
        self.lights = [direct as u64, (set.lights.len() - direct) as u64];
        self.building += time;
    }

    pub(crate) fn statistics(&self) -> Vec<(String, f64)> {
        let n = |c: &AtomicU64| c.load(Relaxed) as f64;
        let mean = |c: &AtomicU64, of: &AtomicU64| n(c) / n(of).max(1.0);
        let rays = n(&self.sample_rays);
        let [kept, cut] = self.energy.kept_and_cut();
        [
            ("lights_direct", self.lights[0] as f64),
            ("lights_indirect", self.lights[1] as f64),
            ("tree_seconds", self.building.as_secs_f64()),
            ("points", n(&self.points)),
            ("mean_cut", mean(&self.clusters, &self.points)),
            ("rays_a_point", (n(&self.rays) + rays) / n(&self.points).max(1.0)),
            ("seen_points", n(&self.seen)),
            ("seen_mean_cut", mean(&self.seen_clusters, &self.seen)),
            ("seen_rays_a_point", (n(&self.seen_rays) + rays) / n(&self.seen).max(1.0)),
            ("at_max_cut", n(&self.at_most)),
            ("reconstructed", n(&self.reconstructed)),
            ("energy_cut", cut / (kept + cut).max(f64::MIN_POSITIVE)),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .to_vec()
    }
}
