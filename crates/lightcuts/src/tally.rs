//! Counts the work of cuts, and computes the statistics from the counts.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Duration;

use gi_core::bytes::{Reader, Writer};
use gi_core::caustics::FocusedLight;
use vpl::{Energy, Vpls};

use crate::cut::Lit;
use crate::tree::Forest;

/// The counts.
#[derive(Clone, Copy)]
enum Count {
    Points,
    Clusters,
    Rays,
    /// The same three counts, for directly visible points only.
    Seen,
    SeenClusters,
    SeenRays,
    /// Cuts that reached the maximum number of clusters.
    AtMost,
    Reconstructed,
    /// Shadow rays of the samples for reconstruction.
    SampleRays,
    /// Gather points of `--method multidimensional`, whose cuts belong to pixels.
    GatherPoints,
}

/// Counts of all passes. They are whole numbers, so sums do not depend on the order in which threads add.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    energy: Energy,
    counts: [AtomicU64; 10],
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

    /// Count an illuminated point; `seen` if it is directly visible.
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

    /// Count a reconstructed point.
    pub(crate) fn reconstructed(&self) {
        self.add(Count::Reconstructed, 1);
    }

    /// Count the shadow rays of a sample for reconstruction.
    pub(crate) fn sampled(&self, rays: u32) {
        self.add(Count::SampleRays, rays);
    }

    /// Count the gather points of a pixel.
    pub(crate) fn gathered(&self, points: u32) {
        self.add(Count::GatherPoints, points);
    }

    /// Count the lights of a pass and the time for building their trees.
    pub(crate) fn built(&mut self, set: &Vpls, time: Duration) {
        let direct = set.up_to(0).len();
        self.lights = [direct as u64, (set.lights.len() - direct) as u64];
        self.building += time;
    }

    /// The counts for a resumed run. Passes are independent and need nothing else.
    pub(crate) fn save(&self) -> Vec<u8> {
        let mut w = Writer::default();
        w.counts(&self.counts);
        self.energy.parts().into_iter().for_each(|n| w.u64(n));
        w.into_bytes()
    }

    /// Add stored counts.
    pub(crate) fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        let mut r = Reader::new(state);
        r.add_to_counts(&self.counts)?;
        self.energy.add([r.u64()?, r.u64()?, r.u64()?]);
        r.end()
    }

    pub(crate) fn statistics(
        &self,
        focused: &FocusedLight,
        vpls: &Vpls,
        forest: &Forest,
    ) -> Vec<(String, f64)> {
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
            ("gather_points", n(GatherPoints)),
            ("energy_cut", cut / (kept + cut).max(f64::MIN_POSITIVE)),
            ("caustic_photons", focused.photons() as f64),
            ("caustic_radius", focused.mean_radius()),
            ("light_bytes", vpls.memory_bytes() as f64),
            ("tree_bytes", forest.memory_bytes() as f64),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .to_vec()
    }
}
