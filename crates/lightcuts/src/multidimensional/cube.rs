//! How strongly a cluster of glossy points may scatter light from a direction toward the eye.
//!
//! The faces of a cube around the sphere of directions are divided into squares. A map stores, for each square, the sum of
//! the bounds of the points [Walter06, 4.2]. The bound for light from a cone of directions is the largest one of the
//! squares that the cone touches.

use std::sync::LazyLock;

use gi_core::bsdf::{Bsdf, Toward};
use gi_core::math::Bounds;
use glam::Vec3;

use crate::gain::{far_cos, square};

/// Number of squares along the side of a face, and in all.
const SIDE: usize = 6;
const SQUARES: usize = 6 * SIDE * SIDE;

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

    /// The bounds of f cos and of f for light from these directions.
    #[inline]
    pub(super) fn from(&self, toward: &Toward) -> [f32; 2] {
        let (axis, sin, cos) = toward.around();
        let cube = &*CUBE;
        // Loops without branches, so that the compiler can vectorise them.
        let mut touched = [u32::MAX; SQUARES];
        if sin < 1.0 {
            for (k, touched) in touched.iter_mut().enumerate() {
                let between = cube.x[k] * axis.x + cube.y[k] * axis.y + cube.z[k] * axis.z;
                let touches = between >= cube.cos[k] * cos - cube.sin[k] * sin;
                *touched = if touches { u32::MAX } else { 0 };
            }
        }
        let (mut f_cos, mut f) = (0, 0);
        for ((t, a), b) in touched.iter().zip(&self.f_cos).zip(&self.f) {
            (f_cos, f) = (f_cos.max(a & t), f.max(b & t));
        }
        [f_cos, f].map(f32::from_bits)
    }
}

/// The squares: directions into them, and cones around them as axes, cosines and sines of the half angles.
struct Cube {
    toward: [Toward; SQUARES],
    x: [f32; SQUARES],
    y: [f32; SQUARES],
    z: [f32; SQUARES],
    cos: [f32; SQUARES],
    sin: [f32; SQUARES],
}

static CUBE: LazyLock<Cube> = LazyLock::new(|| {
    let boxes: [Bounds; SQUARES] =
        std::array::from_fn(|k| square(k / (SIDE * SIDE), SIDE, [k % SIDE, k / SIDE % SIDE]));
    let axis = boxes.map(|b| b.center().normalize());
    let cos: [f32; SQUARES] = std::array::from_fn(|k| far_cos(&boxes[k], axis[k]));
    Cube {
        toward: boxes.map(|b| Toward::new(Vec3::ZERO, &b)),
        x: axis.map(|a| a.x),
        y: axis.map(|a| a.y),
        z: axis.map(|a| a.z),
        cos,
        sin: cos.map(|c| (1.0 - c * c).sqrt()),
    }
});
