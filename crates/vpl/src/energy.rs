//! What the bound cuts off, counted.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Light that connections brought and that bounds cut off, as whole numbers: their sum does not depend on the order in which
/// threads add to it.
#[derive(Debug, Default)]
pub struct Energy {
    kept: AtomicU64,
    cut: AtomicU64,
    connections: AtomicU64,
}

/// Parts of a unit of radiance.
const PARTS: f32 = 1_048_576.0;

impl Energy {
    /// Count the light of one point.
    pub fn note(&self, kept: f32, cut: f32, connections: u64) {
        self.kept.fetch_add((kept.max(0.0) * PARTS) as u64, Relaxed);
        self.cut.fetch_add((cut.max(0.0) * PARTS) as u64, Relaxed);
        self.connections.fetch_add(connections, Relaxed);
    }

    /// Radiance kept and cut off, summed over all points.
    pub fn kept_and_cut(&self) -> [f64; 2] {
        [&self.kept, &self.cut].map(|n| n.load(Relaxed) as f64 / f64::from(PARTS))
    }

    /// All counts, to go on from with [`Energy::from_parts`].
    pub fn parts(&self) -> [u64; 3] {
        [&self.kept, &self.cut, &self.connections].map(|n| n.load(Relaxed))
    }

    /// Go on counting.
    pub fn from_parts(parts: [u64; 3]) -> Self {
        let [kept, cut, connections] = parts.map(AtomicU64::new);
        Energy { kept, cut, connections }
    }

    /// How many lights were connected with points, turned toward each other.
    pub fn connections(&self) -> u64 {
        self.connections.load(Relaxed)
    }
}
