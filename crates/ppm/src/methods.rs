//! The radius of the four methods.

use std::f64::consts::PI;

use crate::error::Moments;
pub use crate::params::Method;
pub use gi_core::grid::probabilistic_radius;

/// Radius of the kernel for derivatives over the initial radius. Derivatives need more photons than the estimate.
const DERIVATIVE_WIDTH: f64 = 2.0;

/// R_k / R_0 of the kernel for second derivatives. The asymptotically optimal width shrinks with the tenth root of the
/// number of photons, in two dimensions and for second derivatives \[Silverman86, 4.3; Wand95, 4.9\].
pub fn derivative_radius(k: u32) -> f64 {
    DERIVATIVE_WIDTH * f64::from(k + 1).powf(-0.1)
}

/// The radius that minimises the asymptotic error of the mean over passes, from the moments of passes 0 to k - 1. Also
/// returns whether the limit `most` applies instead \[Kaplanyan13\].
///
/// With r_i^2 = a i^(-1/3) in pass i, the mean over k passes has the bias 3/2 a k^(-1/3) lap / 8 and the variance 3/4 S
/// / (pi a) k^(-2/3). The sum of bias^2 and variance is smallest for a^3 = 64 S / (6 pi lap^2). S is the density of
/// squared contributions, lap the Laplacian of the radiance over the surface.
pub fn adaptive_radius(k: u32, moments: &Moments, most: f64) -> (f64, bool) {
    let (squares, laplacian_sq) = (moments.squares(), moments.laplacian_sq());
    if !(squares > 0.0 && laplacian_sq > 0.0) {
        return (most, true);
    }
    let a = (64.0 * squares / (6.0 * PI * laplacian_sq)).cbrt();
    let radius = (a * f64::from(k + 1).powf(-1.0 / 3.0)).sqrt();
    if radius < most { (radius, false) } else { (most, true) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_adaptive_radius_minimises_the_error() {
        let (squares, laplacian) = (3.0, 40.0);
        let moments = Moments::known(squares, laplacian);
        // Bias and variance after k passes with r_i^2 = a i^(-1/3), by direct summation.
        let k = 20_000;
        let error = |a: f64| {
            let (mut areas, mut inverse) = (0.0, 0.0);
            for i in 1..=k {
                let r_sq = a * f64::from(i).powf(-1.0 / 3.0);
                areas += r_sq;
                inverse += 1.0 / r_sq;
            }
            let n = f64::from(k);
            (areas / n / 8.0 * laplacian).powi(2) + squares / PI * inverse / (n * n)
        };
        let a = adaptive_radius(0, &moments, f64::MAX).0.powi(2);
        assert!(error(a) < error(1.03 * a) && error(a) < error(a / 1.03));
        let (first, later) =
            (adaptive_radius(0, &moments, 9.0).0, adaptive_radius(63, &moments, 9.0).0);
        assert!((first / later - 2.0).abs() < 1e-12, "r^2 falls with the cube root");
        assert_eq!(adaptive_radius(0, &moments, 1e-3), (1e-3, true));
        assert_eq!(adaptive_radius(5, &Moments::default(), 0.5), (0.5, true));
    }
}
