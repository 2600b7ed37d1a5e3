//! What cuts cost, counted.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Duration;

use gi_core::bytes::{Reader, Writer};
use vpl::{Energy, Vpls};

use crate::cut::Lit;

/// What is counted.
#[derive(Clone, Copy)]
enum Count {
    Points,
    Clusters,
    Rays,
    /// Of what the eye sees alone.
    Seen,
    SeenClusters,
    SeenRays,
    /// Cuts that ended at the most clusters.
    AtMost,
    Reconstructed,
    /// Rays of samples that were reconstructed from.
    SampleRays,
}

/// Counts of all passes. Whole numbers: their sums do not depend on the order in which threads add.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    energy: Energy,
    counts: [AtomicU64; 9],
    lights: [u64; 2],
    building: Duration,
}

impl Tally {
    fn add(&self, count: Count, n: u32) {
        self.counts[count as usize].fetch_add(n.into(), Relaxed);
    }

    fn get(&self, count: Count) -> f64 {
        self.counts[count as usize].load(Relaxed) as f64
    }

    /// A point was lit; `seen`: by what the eye sees, not further down a path.
    pub(crate) fn note(&self, lit: &Lit, seen: bool) {
        self.add(Count::Points, 1);
        self.add(Count::Clusters, lit.size);
        self.add(Count::Rays, lit.rays);
        self.add(Count::AtMost, lit.at_most.into());
        if seen {
            self.add(Count::Seen, 1);
            self.add(Count::SeenClusters, lit.size);
            self.add(Count::SeenRays, lit.rays);
        }
        self.energy.note(lit.indirect.luminance(), lit.cut_off, lit.rays.into());
    }

    /// A point was reconstructed.
    pub(crate) fn reconstructed(&self) {
        self.add(Count::Reconstructed, 1);
    }

    /// A sample for reconstruction took so many rays.
    pub(crate) fn sampled(&self, rays: u32) {
        self.add(Count::SampleRays, rays);
    }

    /// A set's trees were built.
    pub(crate) fn built(&mut self, set: &Vpls, time: Duration) {
        let direct = set.up_to(0).len();
        self.lights = [direct as u64, (set.lights.len() - direct) as u64];
        self.building += time;
    }

    /// Keep what a resumed run goes on counting from.
    pub(crate) fn save(&self, w: &mut Writer) {
        self.counts.iter().for_each(|n| w.u64(n.load(Relaxed)));
        self.energy.parts().into_iter().for_each(|n| w.u64(n));
    }

    /// Go on counting.
    pub(crate) fn restore(&mut self, r: &mut Reader) -> Result<(), String> {
        for n in &self.counts {
            n.store(r.u64()?, Relaxed);
        }
        self.energy = Energy::from_parts([r.u64()?, r.u64()?, r.u64()?]);
        Ok(())
    }

    pub(crate) fn statistics(&self) -> Vec<(String, f64)> {
        use Count::*;
        let n = |c| self.get(c);
        let mean = |sum: f64, of| sum / n(of).max(1.0);
        let [kept, cut] = self.energy.kept_and_cut();
        [
            ("lights_direct", self.lights[0] as f64),
            ("lights_indirect", self.lights[1] as f64),
            ("tree_seconds", self.building.as_secs_f64()),
            ("points", n(Points)),
            ("mean_cut", mean(n(Clusters), Points)),
            ("rays_a_point", mean(n(Rays) + n(SampleRays), Points)),
            ("seen_points", n(Seen)),
            ("seen_mean_cut", mean(n(SeenClusters), Seen)),
            ("seen_rays_a_point", mean(n(SeenRays) + n(SampleRays), Seen)),
            ("at_max_cut", n(AtMost)),
            ("reconstructed", n(Reconstructed)),
            ("energy_cut", cut / (kept + cut).max(f64::MIN_POSITIVE)),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .to_vec()
    }
}
