use crate::running::Running;
use crate::special::{beta_i, normal_two_sided};

/// p-value of the hypothesis that two means are equal. The variances are those of the means, and must be known
/// accurately.
pub fn z_test(mean_a: f64, variance_a: f64, mean_b: f64, variance_b: f64) -> f64 {
    let sigma = (variance_a + variance_b).sqrt();
    if sigma == 0.0 {
        return if mean_a == mean_b { 1.0 } else { 0.0 };
    }
    normal_two_sided((mean_a - mean_b) / sigma)
}

/// p-value of Welch's t-test: that two samples with different variances have the same mean.
pub fn welch_t_test(a: &Running, b: &Running) -> f64 {
    let (va, vb) = (a.variance_of_mean(), b.variance_of_mean());
    if va + vb == 0.0 {
        return if a.mean() == b.mean() { 1.0 } else { 0.0 };
    }
    let t = (a.mean() - b.mean()) / (va + vb).sqrt();
    let part = |v: f64, n: u64| v * v / (n as f64 - 1.0).max(1.0);
    let degrees = (va + vb) * (va + vb) / (part(va, a.count()) + part(vb, b.count()));
    student_two_sided(t, degrees)
}

/// Probability that a variable of Student's distribution with this many degrees of freedom is at least as far from zero as `t`.
pub fn student_two_sided(t: f64, degrees: f64) -> f64 {
    beta_i(0.5 * degrees, 0.5, degrees / (degrees + t * t))
}

/// The significance level for each of `tests` independent tests, so that the probability of any false alarm is `alpha`.
pub fn sidak(alpha: f64, tests: usize) -> f64 {
    // 1 - (1 - alpha)^(1/n), in a form that is accurate for small alpha.
    -((-alpha).ln_1p() / tests.max(1) as f64).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn welch_matches_an_independent_implementation() {
        // The p-value comes from an independent implementation; all its digits must agree.
        let a = [
            27.5, 21.0, 19.0, 23.6, 17.0, 17.9, 16.9, 20.1, 21.9, 22.6, 23.1, 19.6, 19.0, 21.7,
            21.4,
        ];
        let b = [
            27.1, 22.0, 20.8, 23.4, 23.4, 23.5, 25.8, 22.0, 24.8, 20.2, 21.9, 22.1, 22.9, 30.5,
            24.4,
        ];
        let [a, b] = [a, b].map(|s| s.into_iter().collect::<Running>());
        let p = welch_t_test(&a, &b);
        assert!((p - 0.008_071_938_172_194_9).abs() < 1e-12, "{p}");
    }

    #[test]
    fn z_and_sidak() {
        assert!((z_test(1.0, 0.5, 1.0 + 1.959_963_984_540_054, 0.5) - 0.05).abs() < 1e-9);
        assert_eq!(z_test(2.0, 0.0, 2.0, 0.0), 1.0);
        let each = sidak(0.01, 100);
        assert!((1.0 - (1.0 - each).powi(100) - 0.01).abs() < 1e-12);
    }
}
