//! Reconstruction filters, sampled rather than splatted: a pixel's sample positions are drawn in proportion to
//! the filter \[Ernst06\], so that pixels stay independent of each other and of the order of the work.

use std::f32::consts::PI;

use crate::math::sqr;

/// A reconstruction filter, separable; lengths in pixels. Radii and constants as in Mitsuba.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// One pixel wide.
    Box,
    /// A triangle of radius 1.
    Tent,
    /// A Gaussian cut at four standard deviations and lowered to end at zero.
    Gaussian {
        /// Standard deviation, 0.5 unless said.
        stddev: f32,
    },
    /// Mitchell-Netravali with parameters (b, c), 1/3 each unless said.
    Mitchell {
        /// Blur.
        b: f32,
        /// Ringing.
        c: f32,
    },
    /// Catmull-Rom.
    CatmullRom,
    /// A windowed sinc.
    Lanczos {
        /// Lobes, 3 unless said.
        lobes: u32,
    },
}

impl Filter {
    /// Half width in pixels.
    pub fn radius(self) -> f32 {
        match self {
            Filter::Box => 0.5,
            Filter::Tent => 1.0,
            Filter::Gaussian { stddev } => 4.0 * stddev,
            Filter::Mitchell { .. } | Filter::CatmullRom => 2.0,
            Filter::Lanczos { lobes } => lobes as f32,
        }
    }

    /// The filter at distance `x` from the pixel's middle along one axis, not normalised.
    pub fn eval(self, x: f32) -> f32 {
        let x = x.abs();
        if x >= self.radius() {
            return 0.0;
        }
        match self {
            Filter::Box => 1.0,
            Filter::Tent => 1.0 - x,
            Filter::Gaussian { stddev } => {
                let gauss = |x: f32| (-0.5 * sqr(x / stddev)).exp();
                gauss(x) - gauss(4.0 * stddev)
            }
            Filter::Mitchell { b, c } => mitchell(x, b, c),
            Filter::CatmullRom => mitchell(x, 0.0, 0.5),
            Filter::Lanczos { lobes } => sinc(x) * sinc(x / lobes as f32),
        }
    }
}

/// The two-parameter family of cubics \[Mitchell88\].
fn mitchell(x: f32, b: f32, c: f32) -> f32 {
    let (x2, x3) = (x * x, x * x * x);
    let value = if x < 1.0 {
        (12.0 - 9.0 * b - 6.0 * c) * x3 + (-18.0 + 12.0 * b + 6.0 * c) * x2 + (6.0 - 2.0 * b)
    } else {
        (-b - 6.0 * c) * x3
            + (6.0 * b + 30.0 * c) * x2
            + (-12.0 * b - 48.0 * c) * x
            + (8.0 * b + 24.0 * c)
    };
    value / 6.0
}

fn sinc(x: f32) -> f32 {
    if x < 1e-5 { 1.0 } else { (PI * x).sin() / (PI * x) }
}

/// A filter ready to be sampled.
#[derive(Clone, Debug)]
pub struct FilterSampler {
    filter: Filter,
    /// Distribution function of |filter| at the cells' borders, from 0 to 1.
    cdf: Vec<f32>,
    /// Integral of |filter| over integral of the filter, along one axis: 1 for filters without negative lobes.
    sign_weight: f32,
    /// One over the filter's integral along one axis.
    normalisation: f32,
}

/// Cells of the tabulated distribution along one axis; the filters are smooth at a thirtieth of a pixel.
const CELLS: usize = 192;

impl FilterSampler {
    /// Tabulate a filter.
    pub fn new(filter: Filter) -> Self {
        let (radius, n) = (f64::from(filter.radius()), CELLS as f64);
        let width = 2.0 * radius / n;
        let middle = |k: usize| ((k as f64 + 0.5) * width - radius) as f32;
        let mut cdf = vec![0.0];
        let (mut sum, mut signed) = (0.0f64, 0.0f64);
        for k in 0..CELLS {
            let value = f64::from(filter.eval(middle(k)));
            sum += value.abs();
            signed += value;
            cdf.push(sum as f32);
        }
        cdf.iter_mut().for_each(|c| *c /= sum as f32);
        let normalisation = (1.0 / (signed * width)) as f32;
        FilterSampler { filter, cdf, sign_weight: (sum / signed) as f32, normalisation }
    }

    /// Which filter this is.
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// An offset from the pixel's middle, and the weight of a sample there:
    /// one, or of either sign where the filter has negative lobes.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> ([f32; 2], f32) {
        match self.filter {
            Filter::Box => ([u[0] - 0.5, u[1] - 0.5], 1.0),
            Filter::Tent => (u.map(sample_tent), 1.0),
            _ => {
                let [(x, wx), (y, wy)] = u.map(|u| self.sample_table(u));
                ([x, y], wx * wy)
            }
        }
    }

    /// The adjoint: which pixel a splat at `film` (pixels from the corner, one entry an axis) falls on, and its
    /// weight there. In the mean every pixel gets the filter's value at its distance. The pixel may lie outside.
    #[inline]
    pub fn splat(&self, film: [f32; 2], u: [f32; 2]) -> ([i32; 2], f32) {
        let (x, wx) = self.splat_axis(film[0], u[0]);
        let (y, wy) = self.splat_axis(film[1], u[1]);
        ([x, y], wx * wy)
    }

    /// Choose a pixel in proportion to the filter's magnitude at its distance.
    fn splat_axis(&self, x: f32, u: f32) -> (i32, f32) {
        if self.filter == Filter::Box {
            return (x.floor() as i32, 1.0);
        }
        let radius = self.filter.radius();
        let pixels = (x - radius).floor() as i32..=(x + radius).floor() as i32;
        let value = |i: i32| self.filter.eval(x - (i as f32 + 0.5)) * self.normalisation;
        let total: f32 = pixels.clone().map(|i| value(i).abs()).sum();
        let mut rest = u * total;
        for i in pixels {
            let v = value(i);
            rest -= v.abs();
            if rest < 0.0 {
                return (i, total.copysign(v));
            }
        }
        (x.floor() as i32, 0.0)
    }

    fn sample_table(&self, u: f32) -> (f32, f32) {
        let k = (self.cdf.partition_point(|&c| c <= u).max(1) - 1).min(CELLS - 1);
        let (c0, c1) = (self.cdf[k], self.cdf[k + 1]);
        let within = if c1 > c0 { (u - c0) / (c1 - c0) } else { 0.5 };
        let cell = 2.0 * self.filter.radius() / CELLS as f32;
        let middle = (k as f32 + 0.5) * cell - self.filter.radius();
        (
            (k as f32 + within) * cell - self.filter.radius(),
            self.sign_weight * self.filter.eval(middle).signum(),
        )
    }
}

/// Invert the tent's distribution function on [-1, 1].
#[inline]
fn sample_tent(u: f32) -> f32 {
    let v = 2.0 * u;
    if v < 1.0 { v.sqrt() - 1.0 } else { 1.0 - (2.0 - v).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Filter; 6] = [
        Filter::Box,
        Filter::Tent,
        Filter::Gaussian { stddev: 0.5 },
        Filter::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 },
        Filter::CatmullRom,
        Filter::Lanczos { lobes: 3 },
    ];

    #[test]
    fn samples_have_the_filters_moments() {
        for filter in ALL {
            let sampler = FilterSampler::new(filter);
            let n = 4000;
            let (mut zeroth, mut second) = (0.0f64, 0.0f64);
            for i in 0..n {
                let ([x, y], w) = sampler.sample([(i as f32 + 0.5) / n as f32, 0.5]);
                // At v = 0.5 the second axis contributes the constant sign weight of the filter's middle.
                let w = f64::from(
                    w / if matches!(filter, Filter::Box | Filter::Tent) {
                        1.0
                    } else {
                        sampler.sign_weight
                    },
                );
                assert!(y.abs() < 0.02, "{filter:?}: the median is the middle");
                zeroth += w / n as f64;
                second += w * f64::from(x * x) / n as f64;
            }
            let (mut area, mut moment) = (0.0f64, 0.0f64);
            let steps = 20_000;
            for i in 0..steps {
                let x = ((i as f32 + 0.5) / steps as f32 * 2.0 - 1.0) * filter.radius();
                area += f64::from(filter.eval(x));
                moment += f64::from(filter.eval(x) * x * x);
            }
            assert!((zeroth - 1.0).abs() < 2e-3, "{filter:?}: weights sum to {zeroth}");
            assert!(
                (second - moment / area).abs() < 4e-3,
                "{filter:?}: {second} is not {}",
                moment / area
            );
        }
    }

    #[test]
    fn splats_give_each_pixel_the_filters_value_at_its_distance() {
        for filter in ALL {
            let sampler = FilterSampler::new(filter);
            let (n, x) = (20_000, 7.3f32);
            let mut got = [0.0f64; 16];
            for i in 0..n {
                let ([px, _], w) = sampler.splat([x, 3.5], [(i as f32 + 0.5) / n as f32, 0.5]);
                // The second axis: at u = 0.5 the middle pixel is chosen, whose weight is a constant of the filter.
                let (_, wy) = sampler.splat_axis(3.5, 0.5);
                got[px as usize] += f64::from(w / wy) / n as f64;
            }
            for (i, &g) in got.iter().enumerate() {
                let expected = filter.eval(x - (i as f32 + 0.5)) * sampler.normalisation;
                assert!(
                    (g - f64::from(expected)).abs() < 1e-3,
                    "{filter:?}, pixel {i}: {g} is not {expected}"
                );
            }
        }
    }
}
