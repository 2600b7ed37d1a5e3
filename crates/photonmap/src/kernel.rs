//! Kernels of the density estimate.

use std::f32::consts::PI;

pub use crate::params::Kernel;

/// The cone reaches zero at this many radii.
const CONE: f32 = 1.1;
/// Height and width of Jensen's Gaussian.
const ALPHA: f32 = 0.918;
const BETA: f32 = 1.953;

impl Kernel {
    /// All of them.
    pub const ALL: [Kernel; 6] = [
        Kernel::Lecture,
        Kernel::Box,
        Kernel::Cone,
        Kernel::Gaussian,
        Kernel::Epanechnikov,
        Kernel::Simpson,
    ];

    /// Weight of a photon at squared distance `t` in units of the squared radius; its mean over the disc is 1.
    #[inline]
    pub fn weight(self, t: f32) -> f32 {
        match self {
            Kernel::Lecture | Kernel::Box => 1.0,
            // The mean of 1 - d / c over the disc is 1 - 2 / 3c.
            Kernel::Cone => (1.0 - t.sqrt() / CONE) / (1.0 - 2.0 / (3.0 * CONE)),
            Kernel::Gaussian => gaussian(t) / gaussian_mean(),
            Kernel::Epanechnikov => 2.0 * (1.0 - t),
            Kernel::Simpson => 3.0 * (1.0 - t) * (1.0 - t),
        }
    }

    /// Density per area that a photon at squared distance `d2` adds to an estimate whose radius squared is `r2`.
    ///
    /// The k-th photon sets the radius and lies on the edge of the disc. Counting it makes the estimate too bright by k / (k - 1),
    /// 2 % at k = 50. So it adds nothing, except in the lecture's formula. If a radius limit left fewer than k photons, none lies on
    /// the edge.
    #[inline]
    pub fn weigh(self, d2: f32, r2: f32) -> f32 {
        if d2 >= r2 && self != Kernel::Lecture {
            return 0.0;
        }
        self.weight((d2 / r2).min(1.0)) / (PI * r2)
    }
}

/// Jensen's Gaussian as published.
#[inline]
fn gaussian(t: f32) -> f32 {
    ALPHA * (1.0 - (1.0 - (-0.5 * BETA * t).exp()) / (1.0 - (-BETA).exp()))
}

/// Its mean over the disc, 0.5312, which it must be divided by: with t uniform in [0, 1], exp(-beta t / 2) has the mean
/// (1 - exp(-beta / 2)) / (beta / 2).
fn gaussian_mean() -> f32 {
    let mean_exp = (1.0 - (-0.5 * BETA).exp()) / (0.5 * BETA);
    ALPHA * (1.0 - (1.0 - mean_exp) / (1.0 - (-BETA).exp()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gi_core::rng::Pcg;

    #[test]
    fn every_kernel_has_a_mean_of_one_over_its_disc() {
        for kernel in Kernel::ALL {
            // Squared distances are uniform over a disc.
            let n = 100_000;
            let mean =
                (0..n).map(|i| f64::from(kernel.weight((i as f32 + 0.5) / n as f32))).sum::<f64>()
                    / f64::from(n);
            assert!((mean - 1.0).abs() < 2e-5, "{kernel:?}: {mean}");
        }
    }

    #[test]
    fn jensens_gaussian_has_a_mean_of_0_5312() {
        assert!((gaussian_mean() - 0.5312).abs() < 5e-5, "{}", gaussian_mean());
    }

    /// Mean of many estimates of a density of one at the middle of evenly strewn photons, and its standard error.
    fn estimate(kernel: Kernel, k: usize, runs: u32) -> (f64, f64) {
        let mut rng = Pcg::new(7, k as u64);
        let (mut sum, mut square) = (0.0, 0.0);
        for _ in 0..runs {
            // Of points strewn with density one, pi d^2 is the sum of exponential steps.
            let mut area = 0.0f64;
            let d2: Vec<f32> = (0..k)
                .map(|_| {
                    area -= f64::from(1.0 - rng.next_f32()).ln();
                    (area / std::f64::consts::PI) as f32
                })
                .collect();
            let density: f64 = d2.iter().map(|&d| f64::from(kernel.weigh(d, d2[k - 1]))).sum();
            sum += density;
            square += density * density;
        }
        let n = f64::from(runs);
        let mean = sum / n;
        (mean, ((square / n - mean * mean) / n).sqrt())
    }

    #[test]
    fn the_lectures_formula_is_too_bright_by_k_over_k_less_1_and_the_others_are_not() {
        for k in [10, 50] {
            for kernel in Kernel::ALL {
                let (mean, error) = estimate(kernel, k, 40_000);
                let expected =
                    if kernel == Kernel::Lecture { k as f64 / (k as f64 - 1.0) } else { 1.0 };
                assert!(
                    (mean - expected).abs() < 4.0 * error,
                    "{kernel:?}, k = {k}: {mean} is not {expected} +- {error}"
                );
                // Otherwise the two could not be told apart.
                assert!(error < 0.1 / k as f64, "{kernel:?}, k = {k}: {error}");
            }
        }
    }
}
