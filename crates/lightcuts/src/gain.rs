//! How strongly a glossy light may scatter toward a point.
//!
//! The sphere of directions is divided into pieces. A gain bounds, for each piece, the fraction that the light scatters
//! into it. The gain of a cluster is the mean of its lights' gains, weighted by their powers: times the power of the
//! cluster, it bounds the sum over the lights, although their lobes point in different directions. The bound toward a
//! point is the largest one of the pieces that the directions to the point touch.

use std::sync::LazyLock;

use gi_core::bsdf::Toward;
use gi_core::math::{Bounds, Rgb};
use gi_core::scene::Scene;
use glam::Vec3;
use vpl::LitSurface;

/// Number of pieces along the side of a face of the cube around the sphere, and in all.
const SIDE: usize = 3;
const PIECES: usize = 6 * SIDE * SIDE;
/// Number of parts along the side of a piece whose bounds are computed separately.
const PARTS: usize = 2;

/// Upper bounds of the fraction of arriving power that glossy lights scatter, per solid angle, in the largest channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// The bound for each piece of the sphere, as a logarithm.
    most: [u8; PIECES],
    /// The bound of the fraction divided by the cosine with the geometric normal.
    over_cos: [u8; PIECES],
    /// Whether light may leave on both sides of the surface.
    pub both_sides: bool,
}

/// The bounds toward some directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GainToward {
    /// The bound of the fraction.
    pub most: f32,
    /// The bound of the fraction divided by the cosine with the geometric normal.
    pub over_cos: f32,
}

impl Default for Gain {
    /// The gain of lights that scatter nothing.
    fn default() -> Self {
        Gain { most: [0; PIECES], over_cos: [0; PIECES], both_sides: false }
    }
}

/// Steps per factor of two, and the step that stands for one. Zero stands for zero.
const STEPS: f32 = 8.0;
const ONE: f32 = 128.0;

/// The smallest stored number that is no less.
fn store(bound: f32) -> u8 {
    if bound <= 0.0 { 0 } else { (STEPS * bound.log2() + ONE).ceil().clamp(1.0, 255.0) as u8 }
}

/// The bound that a number stands for.
fn read(stored: u8) -> f32 {
    match stored {
        0 => 0.0,
        // It may stand for any larger bound.
        255 => 1e30,
        k => ((f32::from(k) - ONE) / STEPS).exp2() * (1.0 + 1e-5),
    }
}

/// A gain while clusters are joined. Rounding up at each join would loosen the bound.
#[derive(Clone)]
pub(crate) struct Exact {
    most: [f32; PIECES],
    over_cos: [f32; PIECES],
    both_sides: bool,
}

impl From<&Gain> for Exact {
    fn from(gain: &Gain) -> Self {
        let Gain { most, over_cos, both_sides } = *gain;
        Exact { most: most.map(read), over_cos: over_cos.map(read), both_sides }
    }
}

impl From<&Exact> for Gain {
    fn from(exact: &Exact) -> Self {
        let Exact { most, over_cos, both_sides } = exact;
        Gain { most: most.map(store), over_cos: over_cos.map(store), both_sides: *both_sides }
    }
}

impl Exact {
    /// The gain of two clusters with these powers: the mean weighted by power, in the channel in which it is largest.
    pub(crate) fn join(parts: [&Exact; 2], powers: [Rgb; 2]) -> Self {
        let share =
            powers[0].zip(powers[0] + powers[1], |a, sum| if sum > 0.0 { a / sum } else { 0.5 });
        let shares = share.to_array();
        let (low, high) = shares.iter().fold((1.0f32, 0.0f32), |(l, h), s| (l.min(*s), h.max(*s)));
        // A mean is largest at the largest or the smallest share.
        let mean = |a: f32, b: f32| {
            (b + (a - b) * if a > b { high } else { low }) * (1.0 + 4.0 * f32::EPSILON)
        };
        let means = |of: fn(&Exact) -> &[f32; PIECES]| {
            let [a, b] = parts.map(of);
            std::array::from_fn(|k| mean(a[k], b[k]))
        };
        Exact {
            most: means(|e| &e.most),
            over_cos: means(|e| &e.over_cos),
            both_sides: parts.iter().any(|e| e.both_sides),
        }
    }
}

impl Gain {
    /// The bounds for light that travels to a point; `toward` are the directions from the point to the lights.
    #[inline]
    pub fn toward(&self, toward: &Toward) -> GainToward {
        let (axis, sin, cos) = toward.around();
        let sphere = &*SPHERE;
        // Loops without branches, so that the compiler can vectorise them.
        let mut touched = [u8::MAX; PIECES];
        if sin < 1.0 {
            for (k, touched) in touched.iter_mut().enumerate() {
                // Light travels opposite to the direction in which the point sees the light.
                let between = sphere.x[k] * axis.x + sphere.y[k] * axis.y + sphere.z[k] * axis.z;
                let touches = -between >= sphere.cos[k] * cos - sphere.sin[k] * sin;
                *touched = if touches { u8::MAX } else { 0 };
            }
        }
        let (mut most, mut over_cos) = (0, 0);
        for ((t, m), o) in touched.iter().zip(&self.most).zip(&self.over_cos) {
            most = most.max(m & t);
            over_cos = over_cos.max(o & t);
        }
        GainToward {
            most: sphere.bounds[usize::from(most)],
            over_cos: sphere.bounds[usize::from(over_cos)],
        }
    }
}

/// The pieces of the sphere, as cones around them: axes, and cosines and sines of the half angles.
struct Sphere {
    x: [f32; PIECES],
    y: [f32; PIECES],
    z: [f32; PIECES],
    cos: [f32; PIECES],
    sin: [f32; PIECES],
    /// The bounds that stored numbers stand for.
    bounds: [f32; 256],
}

static SPHERE: LazyLock<Sphere> = LazyLock::new(|| {
    let face = |k: usize| k / (SIDE * SIDE);
    let boxes: [Bounds; PIECES] =
        std::array::from_fn(|k| square(face(k), SIDE, [k % SIDE, k / SIDE % SIDE]));
    let axis = boxes.map(|b| b.center().normalize());
    let cos: [f32; PIECES] = std::array::from_fn(|k| far_cos(&boxes[k], axis[k]));
    Sphere {
        x: axis.map(|a| a.x),
        y: axis.map(|a| a.y),
        z: axis.map(|a| a.z),
        cos,
        sin: cos.map(|c| (1.0 - c * c).sqrt()),
        bounds: std::array::from_fn(|k| read(k as u8)),
    }
});

/// The smallest cosine between `axis` and a corner of a box seen from the origin, with a margin for rounding.
pub(crate) fn far_cos(b: &Bounds, axis: Vec3) -> f32 {
    let corner = |c: usize| {
        Vec3::from_array([0, 1, 2].map(|i| if c >> i & 1 == 0 { b.min[i] } else { b.max[i] }))
    };
    (0..8).map(|c| corner(c).normalize().dot(axis)).fold(1.0, f32::min) - 1e-4
}

/// A square of a face of the cube around the sphere; `n` squares lie along the side of the face.
pub(crate) fn square(face: usize, n: usize, place: [usize; 2]) -> Bounds {
    let (axis, side) = (face / 2, if face.is_multiple_of(2) { -1.0 } else { 1.0 });
    let (mut min, mut max) = (Vec3::splat(side), Vec3::splat(side));
    for (across, place) in [(axis + 1) % 3, (axis + 2) % 3].into_iter().zip(place) {
        let at = |i: usize| 2.0 * i as f32 / n as f32 - 1.0;
        (min[across], max[across]) = (at(place), at(place + 1));
    }
    Bounds { min, max }
}

/// The gain of a glossy light.
pub fn gain(scene: &Scene, lit: &LitSurface) -> Gain {
    let Some(bsdf) = lit.bsdf(scene) else { return Gain::default() };
    let mut gain = Gain { both_sides: !bsdf.is_flat() || bsdf.transmits(), ..Gain::default() };
    for k in 0..PIECES {
        for i in 0..PARTS * PARTS {
            let place = [k % SIDE * PARTS + i % PARTS, k / SIDE % SIDE * PARTS + i / PARTS];
            let square = square(k / (SIDE * SIDE), SIDE * PARTS, place);
            let bound = bsdf.bound(lit.wo, &Toward::new(Vec3::ZERO, &square));
            gain.most[k] = gain.most[k].max(store(bound.f_cos.max()));
            gain.over_cos[k] = gain.over_cos[k].max(store(bound.f.max()));
        }
    }
    gain
}
