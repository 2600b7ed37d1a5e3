//! Errors of a picture against a reference, in linear radiance: interleaved RGB, row by row.

/// Errors over the whole picture. No outliers are removed: a firefly counts in full.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metrics {
    /// Mean squared error over pixels and channels.
    pub mse: f64,
    /// Its square root.
    pub rmse: f64,
    /// Mean of (squared error) / (squared reference + [`RELATIVE_FLOOR`]).
    pub rel_mse: f64,
    /// Mean absolute error.
    pub mae: f64,
    /// Mean of 2 |a - r| / (|a| + |r| + [`RELATIVE_FLOOR`]).
    pub smape: f64,
    /// Fraction of the pixels that are close: the absolute error, summed over the channels, is at most [`CLOSE`] times the reference.
    pub close: f64,
    /// Sum of the picture divided by the sum of the reference, per channel; 1 if both are black.
    pub mean_ratio: [f64; 3],
    /// Number of excluded pixels: those with an infinite or NaN value in the picture or the reference.
    pub left_out: usize,
}

/// Keeps relative errors of dark pixels finite.
pub const RELATIVE_FLOOR: f64 = 1e-2;

/// Relative error up to which a pixel is close.
pub const CLOSE: f64 = 0.02;

/// For each pixel, whether it is finite in every channel of all pictures.
///
/// # Panics
/// If the pictures differ in size.
pub fn finite_pixels(pictures: &[&[f32]]) -> Vec<bool> {
    let values = pictures.first().map_or(0, |p| p.len());
    assert!(pictures.iter().all(|p| p.len() == values), "pictures of the same size");
    let finite =
        |i: usize| pictures.iter().all(|p| p[3 * i..3 * i + 3].iter().all(|v| v.is_finite()));
    (0..values / 3).map(finite).collect()
}

/// Compare a picture with a reference of the same size, on the pixels that are finite in both.
///
/// # Errors
/// The sizes differ, or no pixel is left.
pub fn compare(picture: &[f32], reference: &[f32]) -> Result<Metrics, String> {
    if picture.len() != reference.len() || picture.is_empty() || !picture.len().is_multiple_of(3) {
        return Err(format!(
            "{} values against {}: not two RGB pictures of the same size",
            picture.len(),
            reference.len()
        ));
    }
    let finite = finite_pixels(&[picture, reference]);
    let pixels = finite.iter().filter(|f| **f).count();
    if pixels == 0 {
        return Err("no pixel is finite in both pictures".into());
    }
    let (mut square, mut relative, mut absolute, mut symmetric) = (0.0, 0.0, 0.0, 0.0);
    let (mut sums, mut reference_sums) = ([0.0; 3], [0.0; 3]);
    for (i, (&a, &r)) in picture.iter().zip(reference).enumerate().filter(|(i, _)| finite[i / 3]) {
        let (a, r) = (f64::from(a), f64::from(r));
        let d = a - r;
        square += d * d;
        relative += d * d / (r * r + RELATIVE_FLOOR);
        absolute += d.abs();
        symmetric += 2.0 * d.abs() / (a.abs() + r.abs() + RELATIVE_FLOOR);
        sums[i % 3] += a;
        reference_sums[i % 3] += r;
    }
    let is_close = |i: usize| {
        let [mut error, mut whole] = [0.0; 2];
        for k in 3 * i..3 * i + 3 {
            error += (f64::from(picture[k]) - f64::from(reference[k])).abs();
            whole += f64::from(reference[k]);
        }
        error <= CLOSE * whole
    };
    let close = (0..finite.len()).filter(|&i| finite[i] && is_close(i)).count();
    let n = (3 * pixels) as f64;
    let ratio =
        |k: usize| if sums[k] == reference_sums[k] { 1.0 } else { sums[k] / reference_sums[k] };
    Ok(Metrics {
        mse: square / n,
        rmse: (square / n).sqrt(),
        rel_mse: relative / n,
        mae: absolute / n,
        smape: symmetric / n,
        close: close as f64 / pixels as f64,
        mean_ratio: [ratio(0), ratio(1), ratio(2)],
        left_out: finite.len() - pixels,
    })
}

/// MSE and relMSE against the mean of two references, without the references' own noise.
///
/// A squared error against one noisy reference is too large by the variance of that reference. If `a` and `b` are
/// unbiased and their noise is independent, the product `(x - a) (x - b)` has the mean of the squared error against
/// the truth. The denominator of relMSE still contains noise: with an error d and a noise s, both relative to the
/// truth, it adds about 2 d s^2 + 1.5 s^4. Over a picture that is nearly exact, the result may be slightly negative.
///
/// # Errors
/// The sizes differ, or no pixel is left.
pub fn compare_with_twins(picture: &[f32], [a, b]: [&[f32]; 2]) -> Result<[f64; 2], String> {
    for reference in [a, b] {
        compare(picture, reference)?;
    }
    let finite = finite_pixels(&[picture, a, b]);
    let n = 3.0 * finite.iter().filter(|f| **f).count() as f64;
    let (mut square, mut relative) = (0.0, 0.0);
    for i in (0..picture.len()).filter(|i| finite[i / 3]) {
        let [x, a, b] = [picture[i], a[i], b[i]].map(f64::from);
        let product = (x - a) * (x - b);
        square += product;
        relative += product / ((0.5 * (a + b)).powi(2) + RELATIVE_FLOOR);
    }
    Ok([square / n, relative / n])
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
        let reference = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 2.0, 2.0, 2.0];
        let near = [1.05, 1.0, 1.0, 0.0, 0.0, 0.0, 2.0, 2.2, 2.0];
        let close = compare(&near, &reference).expect("comparable").close;
        assert!((close - 2.0 / 3.0).abs() < 1e-12, "5 % of one channel is 1.7 % of all: {close}");
    }

    #[test]
    fn agrees_with_numpy() {
        // Expected values: computed with numpy in double precision from the definitions of the errors, on the same
        // pictures.
        let value = |i: u32, k: u32| (i * 7919 + k * 104_729) % 1009;
        let truth: Vec<f32> = (0..3072).map(|i| 0.004 * value(i, 1) as f32).collect();
        let picture: Vec<f32> =
            (0..3072).map(|i| truth[i as usize] * (0.5 + 0.001 * value(i, 2) as f32)).collect();
        let m = compare(&picture, &truth).expect("comparable");
        for (name, ours, numpy) in [
            ("MSE", m.mse, NUMPY[0]),
            ("RMSE", m.rmse, NUMPY[1]),
            ("relMSE", m.rel_mse, NUMPY[2]),
            ("MAE", m.mae, NUMPY[3]),
            ("SMAPE", m.smape, NUMPY[4]),
            ("red ratio", m.mean_ratio[0], NUMPY[5]),
            ("green ratio", m.mean_ratio[1], NUMPY[6]),
            ("blue ratio", m.mean_ratio[2], NUMPY[7]),
        ] {
            assert!((ours / numpy - 1.0).abs() < 1e-12, "{name}: {ours} is not {numpy}");
        }
    }

    /// MSE, RMSE, relMSE, MAE, SMAPE, and the ratios of means.
    const NUMPY: [f64; 8] = [
        0.21507839556892647,
        0.46376545318611917,
        0.08033235107176899,
        0.38578968565980176,
        0.2570567176883183,
        1.0076952294390027,
        1.0074009996313205,
        1.007183441416621,
    ];

    #[test]
    fn pixels_that_are_not_finite_are_counted_and_excluded() {
        let truth = [1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0];
        let mut picture = [2.0; 9];
        picture[4] = f32::NAN;
        let mut broken = truth;
        broken[6] = f32::INFINITY;
        let m = compare(&picture, &broken).expect("a pixel is left");
        let first = compare(&picture[..3], &truth[..3]).expect("comparable");
        assert_eq!(m, Metrics { left_out: 2, ..first });
        assert!(compare(&[f32::NAN; 3], &[0.0; 3]).unwrap_err().contains("no pixel"));
    }

    #[test]
    fn the_noise_of_two_references_does_not_enlarge_the_error() {
        // The picture is 0.01 too bright everywhere; the references are exact but for noise of 0.02 (uniform, independent).
        // Splitmix64 of a counter.
        let noise = |i: u32, seed: u64| {
            let mut z = (u64::from(i) + (seed << 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            0.02 * 12.0_f64.sqrt() * ((z ^ (z >> 31)) as f64 / 2.0_f64.powi(64) - 0.5)
        };
        const N: u32 = 300_000;
        let reference = |seed| (0..N).map(|i| (1.0 + noise(i, seed)) as f32).collect::<Vec<f32>>();
        let (picture, a, b) = (vec![1.01; N as usize], reference(1), reference(2));
        let [mse, relative] = compare_with_twins(&picture, [&a, &b]).expect("comparable");
        // Variance of a product: 2 d^2 s^2 + s^4, so the mean of N has the standard deviation 9e-7.
        assert!((mse - 1e-4).abs() < 4.0 * 9e-7, "{mse}");
        let (d, s) = (0.01, 0.02_f64);
        let expected = (d * d + 2.0 * d * s.powi(2) + 1.5 * s.powi(4)) / 1.01;
        assert!((relative - expected).abs() < 4.0 * 9e-7, "{relative} and {expected}");
        let once = compare(&picture, &a).expect("comparable");
        assert!((once.mse - 5e-4).abs() < 5e-6, "{}", once.mse);
    }

    #[test]
    fn pictures_of_different_sizes_are_refused() {
        assert!(compare(&[0.0; 3], &[0.0; 6]).unwrap_err().contains("not two"));
    }
}
