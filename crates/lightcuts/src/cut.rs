//! Lightcuts [slides 58-61]: a partition of all lights into clusters, chosen for one point.

use std::collections::BinaryHeap;

use gi_core::math::Rgb;

pub use crate::params::{Limits, Rule};

/// By how much the errors of clusters, added up as squares, may exceed the error of the whole: bounds are rarely reached.
/// Measured, so that 99 of 100 points of the gallery and of the patio stay below.
const QUADRATURE: f64 = 1.5;

/// A cluster of a cut, and what its representative says of it.
#[derive(Clone, Copy, Debug)]
pub struct Cluster {
    /// How far its estimate may be wrong, as luminance; 0 for a light.
    pub error: f32,
    /// Which tree.
    pub tree: u32,
    /// Which node.
    pub node: u32,
    /// What the representative would bring if its power were one: shadows and the bound of the geometric term included.
    pub unit: Rgb,
    /// The share of it that the bound of the geometric term has left.
    pub kept: f32,
    /// Where its record is, if cuts are recorded.
    pub slot: u32,
}

/// Light that a cut brings, and what it cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lit {
    /// Radiance from points of lights.
    pub direct: Rgb,
    /// Radiance from lights of surfaces.
    pub indirect: Rgb,
    /// Luminance of indirect light that the bound of the geometric term cut off.
    pub cut_off: f32,
    /// Clusters, those that cannot bring anything left out.
    pub size: u32,
    /// Shadow rays.
    pub rays: u32,
    /// Whether the cut ended at the most clusters, and not at its error.
    pub at_most: bool,
}

impl Lit {
    /// All of it.
    pub fn all(&self) -> Rgb {
        self.direct + self.indirect
    }
}

/// A cut while it is refined.
#[derive(Default)]
pub struct Cut {
    pub(crate) clusters: Vec<Cluster>,
    /// Those that may be refined, the worst on top: its error's bits (errors are not negative: their bits are in their
    /// order), and below them its number.
    pub(crate) open: BinaryHeap<u64>,
    /// Estimate of the whole, as luminance.
    pub total: f64,
    /// Sum of the squares of the open clusters' errors, once no cluster alone is worse than it may be: before that some
    /// are so much larger than others that taking them out again would leave nothing but rounding.
    pub(crate) squares: Option<f64>,
    pub(crate) rays: u32,
}

impl Cut {
    /// Forget everything.
    pub fn clear(&mut self) {
        self.open.clear();
        self.clusters.clear();
        (self.total, self.squares, self.rays) = (0.0, None, 0);
    }

    /// All clusters, in no order that means anything, but always the same.
    pub fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// Whether no error is larger than it may be.
    pub(crate) fn is_good(&mut self, limits: &Limits) -> bool {
        let allowed = f64::from(limits.error) * self.total;
        let error = |worst: &u64| f64::from(f32::from_bits((worst >> 32) as u32));
        if self.open.peek().is_some_and(|worst| error(worst) > allowed) {
            self.squares = None;
            return false;
        }
        if limits.rule == Rule::Cluster || self.open.is_empty() {
            return true;
        }
        let squares = || self.open.iter().map(|c| error(c).powi(2)).sum();
        let squares = *self.squares.get_or_insert_with(squares);
        squares <= (QUADRATURE * allowed).powi(2)
    }
}
