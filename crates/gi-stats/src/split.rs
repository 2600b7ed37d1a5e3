//! Splits the error of an estimator into bias and variance, from several pictures with independent seeds.

use crate::metrics::finite_pixels;

/// Bias and variance of an estimator, for each value of the picture and for the whole picture.
///
/// For K pictures with mean m and variance s^2, and a reference r, the expectation of (m - r)^2 is bias^2 + s^2 / K. So
/// s^2 / K is subtracted, and also the variance of the reference if it is known. The estimate of bias^2 is then
/// unbiased; it may be negative if the bias is close to zero. bias^2 + s^2 is exactly the mean squared error of the
/// pictures, minus the reference's variance.
#[derive(Clone, Debug, PartialEq)]
pub struct Split {
    /// Mean of the pictures minus the reference, for each value; 0 at excluded pixels.
    pub bias: Vec<f64>,
    /// Unbiased estimate of the variance of one picture, for each value; 0 at excluded pixels.
    pub variance: Vec<f64>,
    /// Estimate of bias^2, averaged over the picture.
    pub mean_bias_sq: f64,
    /// Standard error of `mean_bias_sq` by the jackknife over the pictures; needs at least three. It does not include
    /// the reference's noise.
    pub mean_bias_sq_error: Option<f64>,
    /// Variance of one picture, averaged over the picture.
    pub mean_variance: f64,
    /// Number of excluded pixels: those that are not finite in all pictures and the reference.
    pub left_out: usize,
}

/// Split the error of pictures that differ only in their seeds. `reference_variance` is the variance of the
/// reference's values, if known.
///
/// # Errors
/// Fewer than two pictures, pictures of different sizes, or no pixel that is finite in all.
pub fn split(
    pictures: &[&[f32]],
    reference: &[f32],
    reference_variance: Option<&[f32]>,
) -> Result<Split, String> {
    let k = pictures.len() as f64;
    if pictures.len() < 2 {
        return Err("bias and variance need at least two pictures".into());
    }
    let all = [pictures, &[reference], reference_variance.as_slice()].concat();
    if all.iter().any(|p| p.len() != reference.len()) || !reference.len().is_multiple_of(3) {
        return Err("not RGB pictures of the same size".into());
    }
    let finite = finite_pixels(&all);
    let pixels = finite.iter().filter(|f| **f).count();
    if pixels == 0 {
        return Err("no pixel is finite in all pictures".into());
    }
    let (mut bias, mut variance) = (vec![0.0; reference.len()], vec![0.0; reference.len()]);
    let mut known_noise = 0.0;
    let mut products = Products::new(pictures.len());
    for i in (0..reference.len()).filter(|i| finite[i / 3]) {
        let d: Vec<f64> =
            pictures.iter().map(|p| f64::from(p[i]) - f64::from(reference[i])).collect();
        bias[i] = d.iter().sum::<f64>() / k;
        variance[i] = d.iter().map(|v| (v - bias[i]).powi(2)).sum::<f64>() / (k - 1.0);
        known_noise += reference_variance.map_or(0.0, |v| f64::from(v[i]));
        products.add(&d);
    }
    let n = (3 * pixels) as f64;
    Ok(Split {
        mean_bias_sq: products.whole() / n - known_noise / n,
        mean_bias_sq_error: (pictures.len() > 2).then(|| products.jackknife() / n),
        mean_variance: variance.iter().sum::<f64>() / n,
        bias,
        variance,
        left_out: finite.len() - pixels,
    })
}

/// Sums over all values of the mean of d_i d_j over all pairs i != j, which equals (m - r)^2 - s^2 / K: for all
/// pictures, and without each one.
struct Products {
    whole: f64,
    without: Vec<f64>,
}

impl Products {
    fn new(pictures: usize) -> Self {
        Products { whole: 0.0, without: vec![0.0; pictures] }
    }

    fn add(&mut self, d: &[f64]) {
        let k = d.len() as f64;
        let (sum, squares) =
            d.iter().fold((0.0, 0.0), |(sum, squares), v| (sum + v, squares + v * v));
        self.whole += (sum * sum - squares) / (k * (k - 1.0));
        if d.len() > 2 {
            for (w, v) in self.without.iter_mut().zip(d) {
                *w += ((sum - v).powi(2) - (squares - v * v)) / ((k - 1.0) * (k - 2.0));
            }
        }
    }

    fn whole(&self) -> f64 {
        self.whole
    }

    /// Standard error of the sum for all pictures.
    fn jackknife(&self) -> f64 {
        let k = self.without.len() as f64;
        let mean = self.without.iter().sum::<f64>() / k;
        let spread: f64 = self.without.iter().map(|w| (w - mean).powi(2)).sum();
        (spread * (k - 1.0) / k).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::compare;

    /// Random numbers with mean 0 and variance 1: the sum of twelve uniform ones.
    struct Normal(u64);

    impl Normal {
        fn next(&mut self) -> f64 {
            let mut uniform = || {
                self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (self.0 >> 11) as f64 / (1u64 << 53) as f64
            };
            (0..12).map(|_| uniform()).sum::<f64>() - 6.0
        }
    }

    const VALUES: usize = 3 * 64 * 64;
    const PICTURES: usize = 8;

    fn truth() -> Vec<f32> {
        (0..VALUES).map(|i| 1.0 + (i % 17) as f32).collect()
    }

    /// Pictures with bias `bias` and noise of variance `sigma`^2.
    fn pictures(bias: f64, sigma: f64) -> Vec<Vec<f32>> {
        let (mut normal, truth) = (Normal(11), truth());
        let mut noisy = |t: &f32| (f64::from(*t) + bias + sigma * normal.next()) as f32;
        (0..PICTURES).map(|_| truth.iter().map(&mut noisy).collect()).collect()
    }

    fn split_of(pictures: &[Vec<f32>], noise: Option<&[f32]>) -> Split {
        let pictures: Vec<&[f32]> = pictures.iter().map(Vec::as_slice).collect();
        split(&pictures, &truth(), noise).expect("it splits")
    }

    #[test]
    fn a_known_bias_and_a_known_variance_are_found() {
        let (k, n) = (PICTURES as f64, VALUES as f64);
        for (bias, sigma) in [(0.0, 0.5), (0.1, 0.5), (-0.3, 0.2), (0.5, 0.0)] {
            let s = split_of(&pictures(bias, sigma), None);
            // Variances of the two estimates for normal noise; single precision adds 1e-6.
            let of_bias = 4.0 * (bias * sigma).powi(2) / k + 2.0 * sigma.powi(4) / (k * (k - 1.0));
            let of_variance = 2.0 * sigma.powi(4) / (k - 1.0);
            let near = |found: f64, right: f64, variance: f64| {
                (found - right).abs() < 4.0 * (variance / n).sqrt() + 1e-6
            };
            assert!(near(s.mean_bias_sq, bias * bias, of_bias), "{bias} {sigma}: {s:?}");
            assert!(near(s.mean_variance, sigma * sigma, of_variance), "{bias} {sigma}: {s:?}");
            // The square of the jackknife error has seven degrees of freedom: it must be within its 1e-4 quantiles.
            let error = s.mean_bias_sq_error.expect("of eight");
            let ratio = error / (of_bias / n).sqrt();
            assert!(sigma == 0.0 || (0.2..2.1).contains(&ratio), "{bias} {sigma}: {ratio}");
        }
    }

    #[test]
    fn the_parts_add_up_to_the_mean_squared_error() {
        let pictures = pictures(0.2, 0.3);
        let s = split_of(&pictures, None);
        let mse = |p: &Vec<f32>| compare(p, &truth()).expect("comparable").mse;
        let mean = pictures.iter().map(mse).sum::<f64>() / PICTURES as f64;
        assert!((s.mean_bias_sq + s.mean_variance - mean).abs() < 1e-12);
        let less = split_of(&pictures, Some(&vec![0.01; VALUES]));
        assert!((s.mean_bias_sq - less.mean_bias_sq - 0.01).abs() < 1e-9);
    }

    #[test]
    fn invalid_input_is_refused_and_broken_pixels_are_excluded() {
        let mut pictures = pictures(0.1, 0.1);
        pictures[3][7] = f32::NAN;
        let s = split_of(&pictures, None);
        assert_eq!((s.left_out, s.bias[6], s.variance[8]), (1, 0.0, 0.0));
        assert!(s.mean_bias_sq.is_finite());
        assert!(split(&[&[0.0; 3]], &[0.0; 3], None).unwrap_err().contains("two"));
        assert!(split(&[&[0.0; 3], &[0.0; 6]], &[0.0; 3], None).unwrap_err().contains("size"));
    }
}
