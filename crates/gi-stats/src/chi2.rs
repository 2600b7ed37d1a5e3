use crate::special::gamma_q;

/// The result of a chi^2 test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chi2 {
    /// The statistic.
    pub statistic: f64,
    /// Degrees of freedom.
    pub degrees: usize,
    /// Probability of a statistic at least this large if the counts follow the expectation.
    pub p_value: f64,
}

/// Cells with a smaller expected count are pooled.
const LEAST_EXPECTED: f64 = 5.0;

/// Pearson's test that `observed` counts were drawn in proportion to `expected`. These are expected counts, so their
/// sum must be the number of draws, except for integration error and regions that the density does not cover.
///
/// # Errors
/// A count in a cell with expectation zero is impossible; the index of the cell is returned.
pub fn chi2_test(observed: &[u64], expected: &[f64]) -> Result<Chi2, usize> {
    assert_eq!(observed.len(), expected.len(), "one expectation per cell");
    if let Some(cell) = (0..observed.len()).find(|&i| expected[i] == 0.0 && observed[i] > 0) {
        return Err(cell);
    }
    // Pool from the least expected cell up, until every group has a large enough expectation.
    let mut order: Vec<usize> = (0..observed.len()).filter(|&i| expected[i] > 0.0).collect();
    order.sort_by(|&a, &b| expected[a].total_cmp(&expected[b]));
    let (mut statistic, mut groups) = (0.0, 0usize);
    let (mut pool_observed, mut pool_expected) = (0.0, 0.0);
    for (rank, &i) in order.iter().enumerate() {
        pool_observed += observed[i] as f64;
        pool_expected += expected[i];
        let rest: f64 = order[rank + 1..].iter().map(|&j| expected[j]).sum();
        if pool_expected >= LEAST_EXPECTED && (rest == 0.0 || rest >= LEAST_EXPECTED) {
            statistic +=
                (pool_observed - pool_expected) * (pool_observed - pool_expected) / pool_expected;
            groups += 1;
            (pool_observed, pool_expected) = (0.0, 0.0);
        }
    }
    let degrees = groups.saturating_sub(1);
    let p_value = if degrees == 0 { 1.0 } else { gamma_q(0.5 * degrees as f64, 0.5 * statistic) };
    Ok(Chi2 { statistic, degrees, p_value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_textbook_case() {
        // A die thrown 60 times.
        let found = chi2_test(&[5, 8, 9, 8, 10, 20], &[10.0; 6]).expect("all cells are possible");
        assert!((found.statistic - 13.4).abs() < 1e-9 && found.degrees == 5);
        assert!((found.p_value - 0.0199).abs() < 1e-4, "{found:?}");
    }

    #[test]
    fn impossible_counts_and_pooled_cells() {
        assert_eq!(chi2_test(&[1, 9], &[0.0, 10.0]), Err(0));
        let found = chi2_test(&[1, 2, 1, 3, 93], &[1.0, 2.0, 2.0, 2.0, 93.0]).expect("possible");
        assert_eq!(found.degrees, 1, "four cells make one group of seven");
    }
}
