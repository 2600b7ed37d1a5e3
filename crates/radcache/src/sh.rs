//! Real spherical harmonics: the basis [slide 18], evaluated by recurrences that stay stable at any order, and windows
//! against ringing. Function (l, m) is at index l (l + 1) + m; an order n has the n^2 functions with l < n.
//!
//! Signs are those of \[Green03\] without the Condon-Shortley phase: band 1 is (y, z, x).

use std::f32::consts::PI;
use std::sync::LazyLock;

use glam::{Vec3, Vec3A};

pub use crate::params::{Basis, MAX_ORDER, Window};

/// Number of functions of the largest order.
pub const MAX_FUNCTIONS: usize = MAX_ORDER * MAX_ORDER;

/// Coefficients of a colour; the three channels are the lanes of a vector.
pub type Coefficients = [Vec3A; MAX_FUNCTIONS];

/// Index of function (l, m).
#[inline]
pub const fn index(l: usize, m: isize) -> usize {
    ((l * (l + 1)) as isize + m) as usize
}

impl Basis {
    /// All functions of order `n` at the unit direction `d`. Hemispherical functions are zero below the horizon.
    #[inline]
    pub fn evaluate(self, n: usize, d: Vec3, out: &mut [f32; MAX_FUNCTIONS]) {
        match self {
            Basis::Sh => evaluate(n, d, out),
            Basis::Hsh if d.z <= 0.0 => out[..n * n].fill(0.0),
            // Mapping cos to 2 cos - 1 doubles the solid-angle density.
            Basis::Hsh => {
                let across = 2.0 * (d.z / (1.0 + d.z)).sqrt();
                evaluate(n, Vec3::new(d.x * across, d.y * across, 2.0 * d.z - 1.0), out);
                out[..n * n].iter_mut().for_each(|y| *y *= std::f32::consts::SQRT_2);
            }
        }
    }

    /// Integral of a function over its directions, from its first coefficient.
    pub fn integral(self) -> f32 {
        match self {
            Basis::Sh => (4.0 * PI).sqrt(),
            Basis::Hsh => (2.0 * PI).sqrt(),
        }
    }
}

/// Factors of the recurrence over l, normalised: P(l, m) = a (z P(l - 1, m) - b P(l - 2, m)).
struct Factors {
    /// P(m, m) divided by sin^m, with the factor of the azimuthal part.
    start: [f32; MAX_ORDER],
    a: [[f32; MAX_ORDER]; MAX_ORDER],
    b: [[f32; MAX_ORDER]; MAX_ORDER],
}

static FACTORS: LazyLock<Factors> = LazyLock::new(|| {
    let mut f = Factors {
        start: [0.0; MAX_ORDER],
        a: [[0.0; MAX_ORDER]; MAX_ORDER],
        b: [[0.0; MAX_ORDER]; MAX_ORDER],
    };
    let mut p = (0.25 / std::f64::consts::PI).sqrt();
    for m in 0..MAX_ORDER {
        if m > 0 {
            p *= ((2 * m + 1) as f64 / (2 * m) as f64).sqrt();
        }
        f.start[m] = (if m == 0 { p } else { p * std::f64::consts::SQRT_2 }) as f32;
        for l in m + 1..MAX_ORDER {
            let sq = |k: usize| (k * k) as f64;
            f.a[l][m] = ((4.0 * sq(l) - 1.0) / (sq(l) - sq(m))).sqrt() as f32;
            f.b[l][m] = ((sq(l - 1) - sq(m)) / (4.0 * sq(l - 1) - 1.0)).sqrt() as f32;
        }
    }
    f
});

/// All spherical harmonics of order `n` at the unit direction `d`.
#[inline]
pub fn evaluate(n: usize, d: Vec3, out: &mut [f32; MAX_FUNCTIONS]) {
    let f = &*FACTORS;
    // (x + i y)^m = sin^m (cos(m phi) + i sin(m phi)).
    let (mut c, mut s) = (1.0, 0.0);
    for m in 0..n {
        if m > 0 {
            (c, s) = (c * d.x - s * d.y, c * d.y + s * d.x);
        }
        let (mut last, mut p) = (0.0, f.start[m]);
        for l in m..n {
            if l > m {
                (last, p) = (p, f.a[l][m] * (d.z * p - f.b[l][m] * last));
            }
            out[l * (l + 1) + m] = p * c;
            if m > 0 {
                out[l * (l + 1) - m] = p * s;
            }
        }
    }
}

impl Window {
    /// Factor of band `l` of order `n`.
    pub fn factor(self, l: usize, n: usize) -> f32 {
        let t = PI * l as f32 / n as f32;
        match self {
            Window::None => 1.0,
            Window::Hanning => 0.5 + 0.5 * t.cos(),
            Window::Lanczos if l == 0 => 1.0,
            Window::Lanczos => t.sin() / t,
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Directions over the sphere with weights, exact for polynomials up to degree 2 `rings` - 1.
    pub(crate) fn quadrature(rings: usize) -> Vec<(Vec3, f64)> {
        let mut out = Vec::new();
        for (z, w) in gauss_legendre(rings) {
            let (count, sin) = (2 * rings, (1.0 - z * z).sqrt());
            for k in 0..count {
                let phi = 2.0 * std::f64::consts::PI * (k as f64 + 0.5) / count as f64;
                let d = Vec3::new((sin * phi.cos()) as f32, (sin * phi.sin()) as f32, z as f32);
                out.push((d, w * 2.0 * std::f64::consts::PI / count as f64));
            }
        }
        out
    }

    /// Nodes and weights on [-1, 1] by Newton's method on Legendre polynomials.
    pub(crate) fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
        let node = |i: usize| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 0.0;
            for _ in 0..50 {
                let (mut p, mut last) = (1.0, 0.0);
                for k in 1..=n {
                    let k = k as f64;
                    (last, p) = (p, ((2.0 * k - 1.0) * x * p - (k - 1.0) * last) / k);
                }
                slope = n as f64 * (x * p - last) / (x * x - 1.0);
                x -= p / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        };
        (0..n).map(node).collect()
    }

    /// Largest difference of the Gram matrix from the identity.
    fn off_orthonormal(basis: Basis, directions: &[(Vec3, f64)]) -> f64 {
        let count = MAX_FUNCTIONS;
        let mut gram = vec![0.0; count * count];
        let mut y = [0.0; MAX_FUNCTIONS];
        for (d, w) in directions {
            basis.evaluate(MAX_ORDER, *d, &mut y);
            for i in 0..count {
                for j in 0..=i {
                    gram[i * count + j] += w * f64::from(y[i]) * f64::from(y[j]);
                }
            }
        }
        let off = |i: usize, j: usize| (gram[i * count + j] - f64::from(u8::from(i == j))).abs();
        (0..count)
            .flat_map(|i| (0..=i).map(move |j| (i, j)))
            .map(|(i, j)| off(i, j))
            .fold(0.0, f64::max)
    }

    #[test]
    fn both_bases_are_orthonormal_under_quadrature() {
        // The rounding of directions to f32 is multiplied by up to l.
        let sphere = quadrature(MAX_ORDER + 1);
        let off = off_orthonormal(Basis::Sh, &sphere);
        assert!(off < 2e-5, "sphere: {off}");
        // For the hemisphere, map z to the range from 0 to 1.
        let mut half = Vec::new();
        for (x, w) in gauss_legendre(MAX_ORDER + 1) {
            let z = 0.5 + 0.5 * x;
            for k in 0..2 * MAX_ORDER + 2 {
                let step = std::f64::consts::PI / (MAX_ORDER + 1) as f64;
                let (phi, sin) = ((k as f64 + 0.5) * step, (1.0 - z * z).sqrt());
                let d = Vec3::new((sin * phi.cos()) as f32, (sin * phi.sin()) as f32, z as f32);
                half.push((d, 0.5 * w * step));
            }
        }
        let off = off_orthonormal(Basis::Hsh, &half);
        assert!(off < 2e-5, "hemisphere: {off}");
    }

    #[test]
    fn the_first_bands_agree_with_the_textbook() {
        let d = Vec3::new(0.48, -0.6, 0.64);
        let mut y = [0.0; MAX_FUNCTIONS];
        evaluate(3, d, &mut y);
        let (a, b) = ((0.75 / PI).sqrt(), (15.0 / (4.0 * PI)).sqrt());
        let c = (5.0 / (16.0 * PI)).sqrt();
        let expected = [
            (0.25 / PI).sqrt(),
            a * d.y,
            a * d.z,
            a * d.x,
            b * d.x * d.y,
            b * d.y * d.z,
            c * (3.0 * d.z * d.z - 1.0),
            b * d.x * d.z,
            0.5 * b * (d.x * d.x - d.y * d.y),
        ];
        for (k, (found, expected)) in y.iter().zip(expected).enumerate() {
            assert!((found - expected).abs() < 1e-6, "function {k}: {found} is not {expected}");
        }
    }

    #[test]
    fn the_bands_of_the_cosine_lobe_are_pi_two_thirds_pi_and_a_quarter_pi() {
        // A_l = sqrt(4 pi / (2 l + 1)) times the coefficient at m = 0 [Ramamoorthi01].
        let mut coefficient = [0.0f64; 6];
        let mut y = [0.0; MAX_FUNCTIONS];
        for (x, w) in gauss_legendre(16) {
            let z = 0.5 + 0.5 * x;
            evaluate(6, Vec3::new((1.0 - z * z).sqrt() as f32, 0.0, z as f32), &mut y);
            for (l, c) in coefficient.iter_mut().enumerate() {
                *c += 0.5 * w * std::f64::consts::TAU * z * f64::from(y[index(l, 0)]);
            }
        }
        let pi = std::f64::consts::PI;
        let expected = [pi, 2.0 * pi / 3.0, pi / 4.0, 0.0, -pi / 24.0, 0.0];
        for (l, (c, expected)) in coefficient.into_iter().zip(expected).enumerate() {
            let a = c * (4.0 * pi / (2 * l + 1) as f64).sqrt();
            assert!((a - expected).abs() < 1e-6, "band {l}: {a} is not {expected}");
        }
    }

    #[test]
    fn windows_keep_the_mean_and_fade() {
        for window in [Window::None, Window::Hanning, Window::Lanczos] {
            let factors: Vec<f32> = (0..10).map(|l| window.factor(l, 10)).collect();
            assert_eq!(factors[0], 1.0, "{window:?}");
            assert!(
                factors.windows(2).all(|w| w[1] <= w[0] && w[1] > 0.0),
                "{window:?}: {factors:?}"
            );
        }
    }
}
