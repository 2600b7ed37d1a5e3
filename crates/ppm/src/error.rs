//! Estimate the error of a pixel without a reference: noise from the variance over passes, bias from the Laplacian of
//! the radiance \[Hachisuka10\].
//!
//! A disc of radius R blurs: on a flat surface the estimate is L + R^2 / 8 lap L + ... The photons themselves give the
//! Laplacian, with the second derivatives of a kernel instead of the disc.

use gi_core::bytes::{Reader, Writer};

use crate::gather::Gathered;

/// Sums over passes for the error of a pixel, in luminance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// Number of passes.
    pub passes: u32,
    /// Mean of the radiance, and sum of squared deviations from it.
    mean: f64,
    deviation: f64,
    /// Mean of the Laplacian, and sum of squared deviations from it.
    laplacian: f64,
    laplacian_deviation: f64,
    /// Means of R^2, and of the density of squared contributions.
    radius_sq: f64,
    squares: f64,
}

impl Moments {
    /// Add a pass: the radiance of the sample, and the photons gathered with `radius`.
    pub(crate) fn add(&mut self, radiance: f64, gathered: &Gathered, radius: f64) {
        self.passes += 1;
        let share = 1.0 / f64::from(self.passes);
        let welford = |mean: &mut f64, deviation: &mut f64, x: f64| {
            let d = x - *mean;
            *mean += d * share;
            *deviation += d * (x - *mean);
        };
        welford(&mut self.mean, &mut self.deviation, radiance);
        welford(&mut self.laplacian, &mut self.laplacian_deviation, gathered.laplacian);
        self.squares += (gathered.squares - self.squares) * share;
        self.radius_sq += (radius * radius - self.radius_sq) * share;
    }

    /// Density of squared contributions per pass.
    pub(crate) fn squares(&self) -> f64 {
        self.squares
    }

    /// The squared Laplacian: the square of its mean minus the variance of the mean. It may be negative.
    pub(crate) fn laplacian_sq(&self) -> f64 {
        self.laplacian * self.laplacian - self.variance_of(self.laplacian_deviation)
    }

    /// Variance of the mean radiance.
    pub fn noise_sq(&self) -> f64 {
        self.variance_of(self.deviation)
    }

    /// Squared bias. It is negative if noise exceeds it, so that its mean over a picture is unbiased.
    pub fn bias_sq(&self) -> f64 {
        (self.radius_sq / 8.0).powi(2) * self.laplacian_sq()
    }

    /// Mean radiance, luminance.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Estimated bias, signed.
    pub fn bias(&self) -> f64 {
        self.radius_sq / 8.0 * self.laplacian
    }

    /// Variance of a mean over passes, from summed squared deviations; infinite after one pass.
    fn variance_of(&self, deviation: f64) -> f64 {
        let n = f64::from(self.passes);
        if self.passes > 1 { deviation / (n * (n - 1.0)) } else { f64::INFINITY }
    }

    /// Write every field, bit for bit.
    pub(crate) fn write(&self, w: &mut Writer) {
        let Moments { passes, mean, deviation, laplacian, .. } = *self;
        w.u32(passes);
        w.f64s(&[mean, deviation, laplacian]);
        w.f64s(&[self.laplacian_deviation, self.radius_sq, self.squares]);
    }

    /// Read what [`Moments::write`] wrote.
    pub(crate) fn read(r: &mut Reader) -> Result<Self, String> {
        let passes = r.u32()?;
        let [mean, deviation, laplacian] = r.f64s()?;
        let [laplacian_deviation, radius_sq, squares] = r.f64s()?;
        Ok(Moments { passes, mean, deviation, laplacian, laplacian_deviation, radius_sq, squares })
    }

    #[cfg(test)]
    pub(crate) fn known(squares: f64, laplacian: f64) -> Self {
        Moments { passes: 2, squares, laplacian, ..Moments::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gather::laplacian_kernel;
    use gi_core::rng::Pcg;
    use glam::Vec2;
    use std::f64::consts::PI;

    #[test]
    fn the_kernel_gives_the_laplacian_of_a_quadratic_and_zero_for_a_plane() {
        // Midpoint sums over the disc of radius h of (c + g x + q x^2 / 2 + p y^2 / 2) times the kernel.
        let (h, n) = (0.7f32, 600);
        let mut sum = 0.0f64;
        let (c, g, q, p) = (5.0f32, -3.0f32, 2.0f32, -0.5f32);
        let step = 2.0 * h / n as f32;
        for i in 0..n {
            for j in 0..n {
                let at = Vec2::new((i as f32 + 0.5) * step - h, (j as f32 + 0.5) * step - h);
                let s = at.length_squared() / (h * h);
                if s < 1.0 {
                    let f = c + g * at.x + 0.5 * (q * at.x * at.x + p * at.y * at.y);
                    sum += f64::from(f * laplacian_kernel(s) * step * step / h.powi(4));
                }
            }
        }
        assert!((sum - f64::from(q + p)).abs() < 2e-3, "{sum}");
    }

    #[test]
    fn noise_and_bias_of_a_known_density_are_found() {
        // Photons of equal flux over the plane with density 1 + 8 (x^2 + y^2), whose Laplacian is 32, gathered at the
        // origin.
        let (emitted, radius, wide) = (4000u32, 0.25f64, 0.4f64);
        let total = 4.0 * (1.0 + 8.0 * 2.0 / 3.0); // over the square from -1 to 1
        let mut moments = Moments::default();
        let mut rng = Pcg::new(8, 1);
        let passes = 600;
        for _ in 0..passes {
            let mut gathered = Gathered::default();
            let mut flux = 0.0;
            for _ in 0..emitted {
                // By rejection: the density is at most 17.
                let at = loop {
                    let [x, y] = rng.next_2d().map(|u| 2.0 * u - 1.0);
                    if rng.next_f32() * 17.0 < 1.0 + 8.0 * (x * x + y * y) {
                        break Vec2::new(x, y);
                    }
                };
                let w = total / f64::from(emitted);
                let d = f64::from(at.length_squared());
                if d < radius * radius {
                    flux += w;
                }
                if d < wide * wide {
                    let s = (d / (wide * wide)) as f32;
                    gathered.laplacian += w * f64::from(laplacian_kernel(s));
                    gathered.squares += w * w;
                }
            }
            let radiance = flux / (PI * radius * radius);
            gathered.laplacian /= wide.powi(4);
            gathered.squares /= PI * wide * wide;
            moments.add(radiance, &gathered, radius);
        }
        // The mean of 8 r^2 over the disc is 4 R^2 = 0.25: that is the bias.
        let noise = moments.noise_sq().sqrt();
        assert!((moments.mean() - 1.25).abs() < 4.0 * noise, "{} +- {noise}", moments.mean());
        assert!((moments.bias() - 0.25).abs() < 0.03, "{}", moments.bias());
        // Poisson distribution: the variance of a pass is the squared weight times the number in the disc, divided by
        // the squared area.
        let w = total / f64::from(emitted);
        let expected = w * 1.25 / (PI * radius * radius) / f64::from(passes);
        assert!((moments.noise_sq() / expected - 1.0).abs() < 0.2, "{noise}");
    }
}
