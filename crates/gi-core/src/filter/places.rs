//! Positions distributed in proportion to a filter, for techniques that gather many samples for one pixel \[Ernst06\].

use super::{Filter, STEPS};

/// Importance sampling of a filter: positions around a pixel with densities in proportion to the magnitude of the filter.
#[derive(Clone, Debug)]
pub struct FilterPlaces {
    filter: Filter,
    /// Integral of the magnitude along one axis, from the left end to each multiple of the step.
    integral: Vec<f32>,
}

impl FilterPlaces {
    /// Tabulate a filter.
    pub fn new(filter: Filter) -> Self {
        let cells = 2 * (filter.radius() * STEPS).ceil() as usize;
        let mut integral = vec![0.0];
        for k in 0..cells {
            let magnitude = filter.eval(middle_of(k, cells)).abs();
            integral.push(integral[k] + magnitude / STEPS);
        }
        FilterPlaces { filter, integral }
    }

    /// A position along one axis, in pixels from the middle of pixel `pixel` of `pixels`, and its weight: about 1, or about
    /// -1 where the filter is negative. All positions are inside the picture.
    pub fn sample(&self, u: f32, pixel: usize, pixels: usize) -> (f32, f32) {
        if self.filter == Filter::Box {
            return (u - 0.5, 1.0);
        }
        let cells = self.integral.len() - 1;
        let left = -(pixel as f32 + 0.5);
        let [low, high] = [left, left + pixels as f32].map(|x| self.integral_to(x));
        let target = low + u * (high - low);
        // The cell in which the integral reaches the target; cells without magnitude are passed over.
        let k = self.integral.partition_point(|&i| i <= target).clamp(1, cells) - 1;
        let magnitude = self.filter.eval(middle_of(k, cells)).abs();
        if magnitude == 0.0 {
            return (0.0, 0.0);
        }
        let within = ((target - self.integral[k]) * STEPS / magnitude).clamp(0.0, 1.0);
        let x = (k as f32 + within - 0.5 * cells as f32) / STEPS;
        let x = x.clamp(left, left + pixels as f32);
        (x, self.filter.eval(x) / magnitude)
    }

    /// A position around a pixel in a picture of `size` pixels, in pixels from the pixel's corner, and its weight.
    pub fn sample_2d(&self, u: [f32; 2], pixel: [usize; 2], size: [usize; 2]) -> ([f32; 2], f32) {
        let [(x, along_x), (y, along_y)] =
            [0, 1].map(|axis| self.sample(u[axis], pixel[axis], size[axis]));
        ([x + 0.5, y + 0.5], along_x * along_y)
    }

    /// Mean weight of [`FilterPlaces::sample`] for pixel `pixel` of `pixels`.
    pub fn mean_weight(&self, pixel: usize, pixels: usize) -> f32 {
        if self.filter == Filter::Box {
            return 1.0;
        }
        let cells = self.integral.len() - 1;
        let left = -(pixel as f32 + 0.5);
        let (mut sum, mut magnitude) = (0.0, 0.0);
        for k in 0..cells {
            let middle = middle_of(k, cells);
            let inside = 0.5 + STEPS * (middle - left).min(left + pixels as f32 - middle);
            let value = self.filter.eval(middle) * inside.clamp(0.0, 1.0);
            sum += value;
            magnitude += self.filter.eval(middle).abs() * inside.clamp(0.0, 1.0);
        }
        sum / magnitude
    }

    /// The integral up to `x`.
    fn integral_to(&self, x: f32) -> f32 {
        let cells = self.integral.len() - 1;
        let at = (x * STEPS + 0.5 * cells as f32).clamp(0.0, cells as f32);
        let k = (at as usize).min(cells - 1);
        self.integral[k] + (self.integral[k + 1] - self.integral[k]) * (at - k as f32)
    }
}

/// The middle of cell `k` of `cells`.
fn middle_of(k: usize, cells: usize) -> f32 {
    (k as f32 + 0.5 - 0.5 * cells as f32) / STEPS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::tests::ALL;

    #[test]
    fn weighted_positions_give_the_means_of_the_filter_inside_the_picture() {
        for filter in ALL {
            let places = FilterPlaces::new(filter);
            for (pixel, pixels) in [(20, 40), (0, 40), (1, 40), (39, 40), (1, 3)] {
                let [left, right] = [0, pixels].map(|k| k as f32 - (pixel as f32 + 0.5));
                // The mean of a smooth function, from the filter and from weighted positions.
                let value = |x: f32| f64::from(1.0 + 0.3 * x + 0.5 * (2.0 * x).sin());
                let (mut expected, mut found) = ([0.0f64; 2], [0.0f64; 2]);
                let n = 40_000;
                for i in 0..n {
                    let u = (i as f32 + 0.5) / n as f32;
                    let x = filter.radius() * (2.0 * u - 1.0);
                    if (left..right).contains(&x) {
                        let f = f64::from(filter.eval(x));
                        expected = [expected[0] + f * value(x), expected[1] + f];
                    }
                    let (x, w) = places.sample(u, pixel, pixels);
                    assert!((left..=right).contains(&x), "{filter:?}: {x}");
                    assert!((w.abs() - 1.0).abs() < 0.6 || filter.eval(x).abs() < 0.05);
                    found = [found[0] + f64::from(w) * value(x), found[1] + f64::from(w)];
                }
                let mean = found[1] / f64::from(n);
                let known = f64::from(places.mean_weight(pixel, pixels));
                assert!((mean - known).abs() < 2e-3, "{filter:?}, {pixel}: {mean}, not {known}");
                let [a, b] = [expected, found].map(|[sum, weight]| sum / weight);
                assert!(
                    (a - b).abs() < 2e-3,
                    "{filter:?}, pixel {pixel} of {pixels}: {b}, not {a}"
                );
            }
        }
    }
}
