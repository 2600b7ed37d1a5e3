//! Convergence rate of an error.

/// Least-squares line through points on logarithmic axes: its slope, and ln y at ln x = 0. `None` if there are fewer
/// than two points, if all have the same x, or if a coordinate is not positive.
pub fn log_log_line(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    if logs.iter().any(|(x, y)| !(x.is_finite() && y.is_finite())) {
        return None;
    }
    let n = logs.len() as f64;
    let (mx, my) =
        (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let along: f64 = logs.iter().map(|p| (p.0 - mx).powi(2)).sum();
    let across: f64 = logs.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    (along > 0.0).then(|| (across / along, my - across / along * mx))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_found_and_the_rest_refused() {
        let law: Vec<(f64, f64)> =
            [1.0, 2.0, 5.0, 30.0].map(|x: f64| (x, 3.0 * x.powf(-2.0 / 3.0))).to_vec();
        let (slope, at_one) = log_log_line(&law).expect("a line");
        assert!((slope + 2.0 / 3.0).abs() < 1e-12 && (at_one.exp() - 3.0).abs() < 1e-12);
        // By hand: the slopes of the least-squares lines through (0, 0), (1, 1), (2, 0) in logarithms.
        let e = 1f64.exp();
        let (slope, at_one) = log_log_line(&[(1.0, 1.0), (e, e), (e * e, 1.0)]).expect("a line");
        assert!(slope.abs() < 1e-12 && (at_one - 1.0 / 3.0).abs() < 1e-12);
        for none in [&[][..], &[(1.0, 1.0)], &[(2.0, 1.0), (2.0, 3.0)], &[(1.0, 1.0), (2.0, 0.0)]] {
            assert_eq!(log_log_line(none), None, "{none:?}");
        }
    }
}
