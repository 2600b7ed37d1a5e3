//! Sums of the light that the clamped geometry term keeps and cuts off.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Sums of kept and cut-off light. They are whole numbers, so they do not depend on the order in which threads add.
#[derive(Debug, Default)]
pub struct Energy {
    kept: AtomicU64,
    cut: AtomicU64,
    connections: AtomicU64,
}

/// Fixed-point steps per unit of radiance.
const PARTS: f32 = 1_048_576.0;

impl Energy {
    /// Add the light of one point.
    pub fn note(&self, kept: f32, cut: f32, connections: u64) {
        self.kept.fetch_add((kept.max(0.0) * PARTS) as u64, Relaxed);
        self.cut.fetch_add((cut.max(0.0) * PARTS) as u64, Relaxed);
        self.connections.fetch_add(connections, Relaxed);
    }

    /// Radiance kept and cut off, summed over all points.
    pub fn kept_and_cut(&self) -> [f64; 2] {
        [&self.kept, &self.cut].map(|n| n.load(Relaxed) as f64 / f64::from(PARTS))
    }

    /// All sums, for a checkpoint.
    pub fn parts(&self) -> [u64; 3] {
        [&self.kept, &self.cut, &self.connections].map(|n| n.load(Relaxed))
    }

    /// Add sums from [`Energy::parts`].
    pub fn add(&self, parts: [u64; 3]) {
        let sums = [&self.kept, &self.cut, &self.connections];
        sums.into_iter().zip(parts).for_each(|(sum, part)| _ = sum.fetch_add(part, Relaxed));
    }

    /// Number of connections between points and lights that face each other.
    pub fn connections(&self) -> u64 {
        self.connections.load(Relaxed)
    }
}
