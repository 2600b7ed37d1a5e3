//! Rotation of coefficients. Rotation does not mix bands, so each band has a matrix of its own.
//!
//! [`band_matrices`] builds the matrices for any rotation \[Ivanic96, with the corrections of Ivanic98\]. The faster
//! [`Turn`] splits a rotation into rotations about z, whose matrices are sparse, and quarter turns about x, whose
//! matrices are constant.

use std::sync::LazyLock;

use gi_core::math::Frame;
use glam::{Mat3, Vec3, Vec3A};

use crate::sh::{MAX_FUNCTIONS, MAX_ORDER, index};

/// The matrix M of a band, row by row: Y(R d) = M Y(d). It also rotates the coefficients of a function by R.
#[derive(Clone, Debug)]
pub struct BandMatrix {
    l: isize,
    entries: Vec<f64>,
}

impl BandMatrix {
    fn new(l: usize, entry: impl Fn(isize, isize) -> f64) -> Self {
        let l = l as isize;
        let entries =
            (-l..=l).flat_map(|m| (-l..=l).map(move |n| (m, n))).map(|(m, n)| entry(m, n));
        let entries = entries.collect();
        BandMatrix { l, entries }
    }

    /// The entry of row `m` and column `n`, both from -l to l.
    pub fn at(&self, m: isize, n: isize) -> f64 {
        self.entries[((m + self.l) * (2 * self.l + 1) + n + self.l) as usize]
    }
}

/// Matrices of the bands below `order` for a rotation, by recurrence from band to band.
pub fn band_matrices(order: usize, rotation: Mat3) -> Vec<BandMatrix> {
    // Band 1 is (y, z, x).
    let axis = |m: isize| [1, 2, 0][(m + 1) as usize];
    let first = |i: isize, j: isize| f64::from(rotation.col(axis(j))[axis(i)]);
    let mut bands = vec![BandMatrix::new(0, |_, _| 1.0)];
    for l in 1..order {
        let band = match l {
            1 => BandMatrix::new(1, first),
            _ => {
                let step = Step { l: l as isize, first: &first, before: &bands[l - 1] };
                BandMatrix::new(l, |m, n| step.entry(m, n))
            }
        };
        bands.push(band);
    }
    bands.truncate(order);
    bands
}

/// The recurrence from band l - 1 to band l.
struct Step<'b> {
    l: isize,
    first: &'b dyn Fn(isize, isize) -> f64,
    before: &'b BandMatrix,
}

impl Step<'_> {
    fn entry(&self, m: isize, n: isize) -> f64 {
        let (l, a) = (self.l as f64, m.abs() as f64);
        let below = if n.abs() == self.l {
            2.0 * l * (2.0 * l - 1.0)
        } else {
            ((self.l + n) * (self.l - n)) as f64
        };
        let zero = if m == 0 { 1.0 } else { 0.0 };
        let u = ((l - a) * (l + a) / below).sqrt();
        let v = 0.5 * ((1.0 + zero) * (l + a - 1.0) * (l + a) / below).sqrt() * (1.0 - 2.0 * zero);
        let w = -0.5 * ((l - a - 1.0) * (l - a) / below).sqrt() * (1.0 - zero);
        let term = |factor: f64, value: &dyn Fn() -> f64| {
            if factor == 0.0 { 0.0 } else { factor * value() }
        };
        term(u, &|| self.p(0, m, n)) + term(v, &|| self.v(m, n)) + term(w, &|| self.w(m, n))
    }

    fn v(&self, m: isize, n: isize) -> f64 {
        let root = std::f64::consts::SQRT_2;
        match m {
            0 => self.p(1, 1, n) + self.p(-1, -1, n),
            1 => self.p(1, 0, n) * root,
            -1 => self.p(-1, 0, n) * root,
            _ if m > 0 => self.p(1, m - 1, n) - self.p(-1, 1 - m, n),
            _ => self.p(1, m + 1, n) + self.p(-1, -m - 1, n),
        }
    }

    fn w(&self, m: isize, n: isize) -> f64 {
        if m > 0 {
            self.p(1, m + 1, n) + self.p(-1, -m - 1, n)
        } else {
            self.p(1, m - 1, n) - self.p(-1, 1 - m, n)
        }
    }

    fn p(&self, i: isize, m: isize, n: isize) -> f64 {
        let (r, b, k) = (self.first, self.before, self.l - 1);
        if n == self.l {
            r(i, 1) * b.at(m, k) - r(i, -1) * b.at(m, -k)
        } else if n == -self.l {
            r(i, 1) * b.at(m, -k) + r(i, -1) * b.at(m, k)
        } else {
            r(i, 0) * b.at(m, n)
        }
    }
}

/// The quarter turn about x and its inverse, row by row of all bands: the non-zero entries with their columns.
struct Quarter {
    rows: Vec<Vec<(u32, f32)>>,
}

/// Quarter turns about x: forward (y to z), back.
static QUARTERS: LazyLock<[Quarter; 2]> = LazyLock::new(|| {
    let angle = std::f32::consts::FRAC_PI_2;
    [angle, -angle].map(|angle| {
        let bands = band_matrices(MAX_ORDER, Mat3::from_rotation_x(angle).map_rounded());
        let mut rows = Vec::new();
        for (l, band) in bands.iter().enumerate() {
            let range = -(l as isize)..=l as isize;
            for m in range.clone() {
                let row = range.clone().map(|n| (index(l, n) as u32, band.at(m, n) as f32));
                rows.push(row.filter(|(_, v)| v.abs() > 1e-9).collect());
            }
        }
        Quarter { rows }
    })
});

/// Rounds matrix entries that should be exactly -1, 0 or 1.
trait Rounded {
    fn map_rounded(self) -> Self;
}

impl Rounded for Mat3 {
    fn map_rounded(self) -> Self {
        Mat3::from_cols(self.x_axis.round(), self.y_axis.round(), self.z_axis.round())
    }
}

/// A rotation as three rotations: about z by `first`, about y by `second`, about z by `third`; each as (cos, sin).
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    first: [f32; 2],
    second: [f32; 2],
    third: [f32; 2],
}

impl Turn {
    /// The rotation from world directions to a frame.
    pub fn into_frame(frame: &Frame) -> Self {
        let n = frame.n;
        let sin = n.x.hypot(n.y);
        // If the normal is along z, any first rotation is correct: the third compensates for it.
        let first = if sin > 0.0 { [-n.x / sin, n.y / sin] } else { [1.0, 0.0] };
        // The direction that is on the x axis before the third rotation.
        let (c, s) = (first[0], first[1]);
        let x = Vec3::new(c * n.z, -s * n.z, sin);
        let (a, b) = (frame.s.dot(x), frame.t.dot(x));
        let length = a.hypot(b);
        Turn { first, second: [n.z, sin], third: [a / length, b / length] }
    }

    /// Rotate the coefficients of order `n`.
    #[inline]
    pub fn apply(&self, n: usize, c: &mut [Vec3A; MAX_FUNCTIONS]) {
        let [forward, back] = &*QUARTERS;
        about_z(n, self.first, c);
        forward.apply(n, c);
        about_z(n, self.second, c);
        back.apply(n, c);
        about_z(n, self.third, c);
    }
}

impl Quarter {
    #[inline]
    fn apply(&self, n: usize, c: &mut [Vec3A; MAX_FUNCTIONS]) {
        let from = *c;
        for (to, row) in c[..n * n].iter_mut().zip(&self.rows) {
            *to = row.iter().map(|&(k, v)| from[k as usize] * v).sum();
        }
    }
}

/// Rotate coefficients of order `n` about z by the angle with this cosine and sine.
#[inline]
pub fn about_z(n: usize, [cos, sin]: [f32; 2], c: &mut [Vec3A; MAX_FUNCTIONS]) {
    let (mut cm, mut sm) = (1.0, 0.0);
    for m in 1..n {
        (cm, sm) = (cm * cos - sm * sin, cm * sin + sm * cos);
        for l in m..n {
            let (plus, minus) = (l * (l + 1) + m, l * (l + 1) - m);
            (c[plus], c[minus]) = (c[plus] * cm - c[minus] * sm, c[plus] * sm + c[minus] * cm);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::evaluate;
    use gi_core::rng::Pcg;

    fn random_frame(rng: &mut Pcg) -> Frame {
        let mut v = || Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * 2.0 - 1.0;
        Frame::from_normal_tangent(v().normalize(), v())
    }

    fn frames() -> Vec<Frame> {
        let mut rng = Pcg::new(4, 0);
        let mut frames: Vec<Frame> = (0..30).map(|_| random_frame(&mut rng)).collect();
        for n in [Vec3::Z, -Vec3::Z, Vec3::X, Vec3::new(1e-4, -2e-5, 1.0).normalize()] {
            frames.push(Frame::from_normal_tangent(n, Vec3::new(0.3, 0.4, 0.1)));
        }
        frames
    }

    fn random_coefficients(rng: &mut Pcg) -> [Vec3A; MAX_FUNCTIONS] {
        std::array::from_fn(|_| {
            Vec3A::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * 2.0 - 1.0
        })
    }

    fn value(c: &[Vec3A; MAX_FUNCTIONS], d: Vec3) -> Vec3A {
        let mut y = [0.0; MAX_FUNCTIONS];
        evaluate(MAX_ORDER, d, &mut y);
        c.iter().zip(y).map(|(c, y)| *c * y).sum()
    }

    #[test]
    fn rotated_coefficients_give_the_function_at_the_rotated_direction() {
        let mut rng = Pcg::new(5, 0);
        for frame in frames() {
            let c = random_coefficients(&mut rng);
            let mut turned = c;
            Turn::into_frame(&frame).apply(MAX_ORDER, &mut turned);
            for _ in 0..20 {
                let d = random_frame(&mut rng).n;
                let (a, b) = (value(&c, d), value(&turned, frame.to_local(d)));
                // Over directions, the value has a standard deviation of about 2.6 (256 uniform coefficients); angles
                // are f32.
                assert!((a - b).length() < 1e-3, "{a} is not {b}: {frame:?}");
            }
        }
    }

    #[test]
    fn a_rotation_keeps_the_norm_of_every_band() {
        let mut rng = Pcg::new(6, 0);
        for frame in frames() {
            let c = random_coefficients(&mut rng);
            let mut turned = c;
            Turn::into_frame(&frame).apply(MAX_ORDER, &mut turned);
            for l in 0..MAX_ORDER {
                let norm = |c: &[Vec3A; MAX_FUNCTIONS]| -> f32 {
                    c[l * l..(l + 1) * (l + 1)].iter().map(|v| v.length_squared()).sum()
                };
                let ratio = norm(&turned) / norm(&c);
                assert!((ratio - 1.0).abs() < 1e-4, "band {l}: {ratio}");
            }
        }
    }

    #[test]
    fn both_rotations_agree_and_matrices_are_orthogonal() {
        let mut rng = Pcg::new(7, 0);
        for frame in frames() {
            let to_local = Mat3::from_cols(frame.s, frame.t, frame.n).transpose();
            let bands = band_matrices(MAX_ORDER, to_local);
            let c = random_coefficients(&mut rng);
            let mut turned = c;
            Turn::into_frame(&frame).apply(MAX_ORDER, &mut turned);
            for (l, band) in bands.iter().enumerate() {
                let range = -(l as isize)..=l as isize;
                for m in range.clone() {
                    let by_matrix: Vec3A =
                        range.clone().map(|n| c[index(l, n)] * band.at(m, n) as f32).sum();
                    let off = (by_matrix - turned[index(l, m)]).length();
                    assert!(off < 1e-3, "band {l}, {m}: {off}");
                    let norm: f64 = range.clone().map(|n| band.at(m, n).powi(2)).sum();
                    assert!((norm - 1.0).abs() < 1e-5, "band {l}, row {m}: {norm}");
                }
            }
        }
    }
}
