//! How strongly a cluster of glossy points may scatter light from a direction toward the eye.
//!
//! The faces of a cube around the sphere of directions are divided into squares. A map stores, for each square, the sum of
//! the bounds of the points [Walter06, 4.2]. The bound for light from a cone of directions is the largest one of the
//! squares that the cone touches.

use std::sync::LazyLock;

use gi_core::bsdf::{Bsdf, Toward};
use glam::Vec3;

use crate::squares::Squares;

/// Number of squares: 6 x 6 on each face.
const SQUARES: usize = 6 * 6 * 6;

/// Upper bounds for each square of the cube. They are bits of floats that are not negative, which sort like the values: the
/// compiler can vectorise the maximum of integers.
#[derive(Clone, Copy)]
pub(super) struct CubeMap {
    /// Of the sum of strength times f cos, in the largest channel.
    f_cos: [u32; SQUARES],
    /// The same divided by the cosine with the geometric normal.
    f: [u32; SQUARES],
    /// Whether light from below the surface may be scattered.
    pub(super) both_sides: bool,
}

impl CubeMap {
    /// No points.
    pub(super) const EMPTY: CubeMap =
        CubeMap { f_cos: [0; SQUARES], f: [0; SQUARES], both_sides: false };

    /// A point with a strength.
    pub(super) fn new(bsdf: &Bsdf, wo: Vec3, strength: f32) -> Self {
        let both_sides = !bsdf.is_flat() || bsdf.transmits();
        let mut map = CubeMap { both_sides, ..Self::EMPTY };
        for (k, toward) in CUBE.toward.iter().enumerate() {
            let bound = bsdf.bound(wo, toward);
            map.f_cos[k] = (strength * bound.f_cos.max()).to_bits();
            map.f[k] = (strength * bound.f.max()).to_bits();
        }
        map
    }

    /// The points of both.
    pub(super) fn join(a: &Self, b: &Self) -> Self {
        let sum = |a: u32, b: u32| (f32::from_bits(a) + f32::from_bits(b)).to_bits();
        CubeMap {
            f_cos: std::array::from_fn(|k| sum(a.f_cos[k], b.f_cos[k])),
            f: std::array::from_fn(|k| sum(a.f[k], b.f[k])),
            both_sides: a.both_sides || b.both_sides,
        }
    }

    /// Upper bounds of f cos and of f over these directions.
    #[inline]
    pub(super) fn from(&self, toward: &Toward) -> [f32; 2] {
        let touched = CUBE.squares.touched(toward.around(), [0, u32::MAX]);
        let (mut f_cos, mut f) = (0, 0);
        for ((t, a), b) in touched.iter().zip(&self.f_cos).zip(&self.f) {
            (f_cos, f) = (f_cos.max(a & t), f.max(b & t));
        }
        [f_cos, f].map(f32::from_bits)
    }
}

/// The squares, and the directions into them.
struct Cube {
    squares: Squares<SQUARES>,
    toward: [Toward; SQUARES],
}

static CUBE: LazyLock<Cube> =
    LazyLock::new(|| Cube { squares: Squares::new(), toward: Squares::<SQUARES>::toward() });
