//! Errors of a picture against a reference, over linear radiance: interleaved RGB, row by row.

/// The whole-picture errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metrics {
    /// Mean squared error over pixels and channels.
    pub mse: f64,
    /// Its square root.
    pub rmse: f64,
    /// Mean of squared error over squared reference plus [`RELATIVE_FLOOR`].
    pub rel_mse: f64,
    /// Mean absolute error.
    pub mae: f64,
    /// Mean of 2 |a - r| / (|a| + |r| + [`RELATIVE_FLOOR`]).
    pub smape: f64,
    /// Sum of the picture over sum of the reference, per channel; 1 for two black channels.
    pub mean_ratio: [f64; 3],
}

/// Keeps relative errors of dark pixels finite.
pub const RELATIVE_FLOOR: f64 = 1e-2;

/// Compare a picture with a reference of the same size.
///
/// # Errors
/// The sizes differ, or a value is not finite: what and where.
pub fn compare(picture: &[f32], reference: &[f32]) -> Result<Metrics, String> {
    if picture.len() != reference.len() || picture.is_empty() || !picture.len().is_multiple_of(3) {
        return Err(format!(
            "{} values against {}: not two RGB pictures of one size",
            picture.len(),
            reference.len()
        ));
    }
    for (name, values) in [("picture", picture), ("reference", reference)] {
        if let Some(i) = values.iter().position(|v| !v.is_finite()) {
            return Err(format!(
                "the {name} is {} in channel {} of pixel {}",
                values[i],
                i % 3,
                i / 3
            ));
        }
    }
    let (mut square, mut relative, mut absolute, mut symmetric) = (0.0, 0.0, 0.0, 0.0);
    let (mut sums, mut reference_sums) = ([0.0; 3], [0.0; 3]);
    for (i, (&a, &r)) in picture.iter().zip(reference).enumerate() {
        let (a, r) = (f64::from(a), f64::from(r));
        let d = a - r;
        square += d * d;
        relative += d * d / (r * r + RELATIVE_FLOOR);
        absolute += d.abs();
        symmetric += 2.0 * d.abs() / (a.abs() + r.abs() + RELATIVE_FLOOR);
        sums[i % 3] += a;
        reference_sums[i % 3] += r;
    }
    let n = picture.len() as f64;
    let ratio =
        |k: usize| if sums[k] == reference_sums[k] { 1.0 } else { sums[k] / reference_sums[k] };
    Ok(Metrics {
        mse: square / n,
        rmse: (square / n).sqrt(),
        rel_mse: relative / n,
        mae: absolute / n,
        smape: symmetric / n,
        mean_ratio: [ratio(0), ratio(1), ratio(2)],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        let m = compare(&[2.0, 1.0, 0.0], &[1.0, 1.0, 0.0]).expect("comparable");
        assert!((m.mse - 1.0 / 3.0).abs() < 1e-12 && (m.mae - 1.0 / 3.0).abs() < 1e-12);
        assert!((m.rel_mse - 1.0 / 1.01 / 3.0).abs() < 1e-12);
        assert!((m.smape - 2.0 / 3.01 / 3.0).abs() < 1e-12);
        assert_eq!(m.mean_ratio, [2.0, 1.0, 1.0]);
    }

    #[test]
    fn pictures_that_cannot_be_compared_say_why() {
        assert!(compare(&[0.0; 3], &[0.0; 6]).unwrap_err().contains("not two"));
        assert!(
            compare(&[0.0, f32::NAN, 0.0], &[0.0; 3]).unwrap_err().contains("channel 1 of pixel 0")
        );
    }
}
