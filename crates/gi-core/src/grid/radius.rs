//! A radius of searches that shrinks from pass to pass, so that the blur vanishes in the limit.

/// R_k / R_0 of pass `k` (the first is 0) without statistics:
/// R_(i+1)^2 / R_i^2 = (i + alpha) / (i + 1) for i = 1, 2, ... \[Knaus11, eq. 20\].
pub fn probabilistic_radius(k: u32, alpha: f64) -> f64 {
    // The product of (i + alpha) / (i + 1) for i from 1 to k is Gamma(k + 1 + alpha) / (Gamma(1 + alpha) Gamma(k + 2)).
    let k = f64::from(k);
    let log = ln_gamma(k + 1.0 + alpha) - ln_gamma(1.0 + alpha) - ln_gamma(k + 2.0);
    (0.5 * log).exp()
}

/// Logarithm of the gamma function for x > 0: Stirling's series, after shifting the argument up [Abramowitz64, 6.1.41].
fn ln_gamma(x: f64) -> f64 {
    const RAISED: f64 = 12.0;
    let (mut x, mut shift) = (x, 0.0);
    while x < RAISED {
        shift += x.ln();
        x += 1.0;
    }
    let inv_sq = 1.0 / (x * x);
    let series =
        (1.0 / 12.0 - inv_sq * (1.0 / 360.0 - inv_sq * (1.0 / 1260.0 - inv_sq / 1680.0))) / x;
    (x - 0.5) * x.ln() - x + 0.5 * (2.0 * std::f64::consts::PI).ln() + series - shift
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_probabilistic_radius_is_its_product_and_falls_like_a_power() {
        for alpha in [0.5, 2.0 / 3.0, 0.9, 1.0] {
            let mut product = 1.0f64;
            for k in 0..3000u32 {
                let error = probabilistic_radius(k, alpha) / product.sqrt() - 1.0;
                assert!(error.abs() < 1e-11, "alpha {alpha}, pass {k}: {error:e}");
                let i = f64::from(k + 1);
                product *= (i + alpha) / (i + 1.0);
            }
            let squared = |k| probabilistic_radius(k, alpha).powi(2);
            let slope = (squared(4_000_000) / squared(1_000_000)).ln() / 4f64.ln();
            assert!((slope - (alpha - 1.0)).abs() < 1e-5, "alpha {alpha}: slope {slope}");
        }
    }
}
