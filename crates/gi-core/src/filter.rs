//! Reconstruction filters: their values, tabulated values, and positions distributed in proportion to them.

mod places;

use std::f32::consts::PI;

use crate::math::sqr;
pub use places::FilterPlaces;

/// A separable reconstruction filter; lengths in pixels. Radii and constants as in Mitsuba.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// One pixel wide.
    Box,
    /// A triangle of radius 1.
    Tent,
    /// A Gaussian, cut off at four standard deviations and shifted down so that it ends at zero.
    Gaussian {
        /// Standard deviation; 0.5 by default.
        stddev: f32,
    },
    /// Mitchell-Netravali with parameters (b, c); 1/3 each by default.
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
        /// Number of lobes; 3 by default.
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

    /// The kind of filter and its parameters, as numbers that define it.
    pub fn numbers(self) -> Vec<f32> {
        match self {
            Filter::Box => vec![0.0],
            Filter::Tent => vec![1.0],
            Filter::Gaussian { stddev } => vec![2.0, stddev],
            Filter::Mitchell { b, c } => vec![3.0, b, c],
            Filter::CatmullRom => vec![4.0],
            Filter::Lanczos { lobes } => vec![5.0, lobes as f32],
        }
    }

    /// The unnormalised filter at distance `x` from the pixel's centre along one axis.
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

/// A filter, tabulated.
#[derive(Clone, Debug)]
pub struct FilterTable {
    filter: Filter,
    /// Values at distances k / STEPS from the centre, up to the radius and one beyond.
    values: Vec<f32>,
    /// One over the filter's integral along one axis.
    normalisation: f32,
}

/// Table entries per pixel: between them, filters are interpolated linearly.
const STEPS: f32 = 64.0;

impl FilterTable {
    /// Tabulate a filter.
    pub fn new(filter: Filter) -> Self {
        let entries = (filter.radius() * STEPS).ceil() as usize;
        let values = (0..=entries + 1).map(|k| filter.eval(k as f32 / STEPS)).collect();
        // Midpoint rule over both halves.
        let n = 64 * entries;
        let width = filter.radius() / n as f32;
        let half: f64 =
            (0..n).map(|k| f64::from(filter.eval((k as f32 + 0.5) * width) * width)).sum();
        FilterTable { filter, values, normalisation: (0.5 / half) as f32 }
    }

    /// The filter.
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// Number of pixels that the filter reaches on each side of a sample's own pixel.
    pub fn reach(&self) -> usize {
        // A sample is up to half a pixel away from its pixel's centre.
        (self.filter.radius() + 0.5).ceil() as usize - 1
    }

    /// The unnormalised filter at distance `x` along one axis.
    #[inline]
    pub fn weight(&self, x: f32) -> f32 {
        if self.filter == Filter::Tent {
            return (1.0 - x.abs()).max(0.0);
        }
        let t = x.abs() * STEPS;
        let k = t as usize;
        match self.values.get(k..k + 2) {
            Some(&[a, b]) => a + (b - a) * (t - k as f32),
            _ => 0.0,
        }
    }

    /// Choose the pixel that receives light at position `film` (pixels from the corner), and its weight. On average,
    /// every pixel receives the value of the normalised filter at its distance. The pixel may be outside the picture.
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
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) const ALL: [Filter; 6] = [
        Filter::Box,
        Filter::Tent,
        Filter::Gaussian { stddev: 0.5 },
        Filter::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 },
        Filter::CatmullRom,
        Filter::Lanczos { lobes: 3 },
    ];

    #[test]
    fn the_table_is_the_filter() {
        for filter in ALL {
            let table = FilterTable::new(filter);
            let samples = 4001;
            let mut integral = 0.0f64;
            for i in 0..samples {
                let x = (i as f32 / (samples - 1) as f32 * 2.0 - 1.0) * (filter.radius() + 0.3);
                // The box filter is discontinuous within the last step of its table.
                let near_jump = filter == Filter::Box && (x.abs() - 0.5).abs() < 1.0 / STEPS;
                assert!(
                    near_jump || (table.weight(x) - filter.eval(x)).abs() < 2e-3,
                    "{filter:?} at {x}"
                );
                integral +=
                    f64::from(filter.eval(x) * (2.0 * (filter.radius() + 0.3)) / samples as f32);
            }
            assert!(
                (integral * f64::from(table.normalisation) - 1.0).abs() < 2e-3,
                "{filter:?}: {integral}"
            );
        }
        assert_eq!(ALL.map(|f| FilterTable::new(f).reach()), [0, 1, 2, 2, 2, 3]);
    }

    #[test]
    fn on_average_splats_give_each_pixel_the_filters_value() {
        for filter in ALL {
            let table = FilterTable::new(filter);
            let (n, x) = (20_000, 7.3f32);
            let mut got = [0.0f64; 16];
            for i in 0..n {
                let ([px, _], w) = table.splat([x, 3.5], [(i as f32 + 0.5) / n as f32, 0.5]);
                // On the second axis, u = 0.5 chooses the middle pixel, whose weight is a constant of the filter.
                let (_, wy) = table.splat_axis(3.5, 0.5);
                got[px as usize] += f64::from(w / wy) / n as f64;
            }
            for (i, &g) in got.iter().enumerate() {
                let expected = filter.eval(x - (i as f32 + 0.5)) * table.normalisation;
                assert!(
                    (g - f64::from(expected)).abs() < 1e-3,
                    "{filter:?}, pixel {i}: {g} is not {expected}"
                );
            }
        }
    }
}
