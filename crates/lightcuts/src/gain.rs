//! How strongly a glossy light may scatter toward a point.
//!
//! The sphere of directions is divided into pieces. A gain bounds, for each piece, the fraction that the light scatters
//! into it. The gain of a cluster is the mean of its lights' gains, weighted by their powers: times the power of the
//! cluster, it bounds the sum over the lights, although their lobes point in different directions. The bound toward a
//! point is the largest one of the pieces that the directions to the point touch.

use std::sync::LazyLock;

use gi_core::bsdf::Toward;
use gi_core::math::Rgb;
use gi_core::scene::Scene;
use glam::Vec3;
use vpl::LitSurface;

use crate::squares::Squares;

/// Number of pieces: 3 x 3 on each face of a cube around the sphere.
const PIECES: usize = 6 * 3 * 3;
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
        // Light travels opposite to the direction in which the point sees the light.
        let touched = SPHERE.squares.touched((-axis, sin, cos), [0, u8::MAX]);
        let (mut most, mut over_cos) = (0, 0);
        for ((t, m), o) in touched.iter().zip(&self.most).zip(&self.over_cos) {
            most = most.max(m & t);
            over_cos = over_cos.max(o & t);
        }
        GainToward {
            most: SPHERE.bounds[usize::from(most)],
            over_cos: SPHERE.bounds[usize::from(over_cos)],
        }
    }
}

/// The pieces of the sphere.
struct Sphere {
    squares: Squares<PIECES>,
    /// The bounds that stored numbers stand for.
    bounds: [f32; 256],
}

static SPHERE: LazyLock<Sphere> = LazyLock::new(|| Sphere {
    squares: Squares::new(),
    bounds: std::array::from_fn(|k| read(k as u8)),
});

/// The gain of a glossy light.
pub fn gain(scene: &Scene, lit: &LitSurface) -> Gain {
    let Some(bsdf) = lit.bsdf(scene) else { return Gain::default() };
    let mut gain = Gain { both_sides: !bsdf.is_flat() || bsdf.transmits(), ..Gain::default() };
    for k in 0..PIECES {
        for i in 0..PARTS * PARTS {
            let part = Squares::<PIECES>::part(k, PARTS, [i % PARTS, i / PARTS]);
            let bound = bsdf.bound(lit.wo, &Toward::new(Vec3::ZERO, &part));
            gain.most[k] = gain.most[k].max(store(bound.f_cos.max()));
            gain.over_cos[k] = gain.over_cos[k].max(store(bound.f.max()));
        }
    }
    gain
}
