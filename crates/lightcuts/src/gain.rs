//! How strongly a glossy light may scatter toward any direction.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use gi_core::bsdf::Toward;
use gi_core::math::Bounds;
use gi_core::scene::Scene;
use glam::Vec3;
use vpl::LitSurface;

/// Upper bound of the fraction of arriving power that glossy lights scatter toward any direction, per solid angle, in
/// the largest channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gain {
    /// The bound.
    pub most: f32,
    /// The bound of the fraction divided by the cosine with the geometric normal.
    pub over_cos: f32,
    /// Whether light may leave on both sides of the surface.
    pub both_sides: bool,
}

impl Gain {
    /// The larger of both.
    pub fn max(self, o: Gain) -> Gain {
        Gain {
            most: self.most.max(o.most),
            over_cos: self.over_cos.max(o.over_cos),
            both_sides: self.both_sides || o.both_sides,
        }
    }
}

/// Number of times that a piece of the sphere of directions is split.
const PIECES: usize = 48;

/// A piece of the sphere of directions; pieces are ordered by their bounds.
struct Piece(f32, Bounds);

impl PartialEq for Piece {
    fn eq(&self, o: &Self) -> bool {
        self.cmp(o) == Ordering::Equal
    }
}
impl Eq for Piece {}
impl PartialOrd for Piece {
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}
impl Ord for Piece {
    fn cmp(&self, o: &Self) -> Ordering {
        self.0.total_cmp(&o.0)
    }
}

/// The gain of a glossy light: the largest bound over pieces of the sphere. The piece with the largest bound is split
/// repeatedly.
pub fn gain(scene: &Scene, lit: &LitSurface) -> Gain {
    let Some(bsdf) = lit.bsdf(scene) else { return Gain::default() };
    Gain {
        most: worst(|toward| bsdf.bound(lit.wo, toward).f_cos.max()),
        over_cos: worst(|toward| bsdf.bound(lit.wo, toward).f.max()),
        both_sides: !bsdf.is_flat() || bsdf.transmits(),
    }
}

/// The largest value of `bound` over all directions.
fn worst(bound: impl Fn(&Toward) -> f32) -> f32 {
    let piece = |b: Bounds| Piece(bound(&Toward::new(Vec3::ZERO, &b)), b);
    let mut pieces = BinaryHeap::with_capacity(PIECES + 8);
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut face = Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE };
            (face.min[axis], face.max[axis]) = (side, side);
            pieces.push(piece(face));
        }
    }
    for _ in 0..PIECES {
        let Some(Piece(_, b)) = pieces.pop() else { break };
        let extent = b.extent();
        let axis = extent.max_position();
        let middle = b.center()[axis];
        let (mut low, mut high) = (b, b);
        (low.max[axis], high.min[axis]) = (middle, middle);
        pieces.push(piece(low));
        pieces.push(piece(high));
    }
    pieces.peek().map_or(0.0, |p| p.0)
}
