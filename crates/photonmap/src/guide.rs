//! Guide gather rays toward the directions that photons came from \[Jensen95\].

use std::f32::consts::FRAC_PI_4;

use gi_core::math::Frame;
use gi_core::warp;
use glam::{Vec2, Vec3};

/// Number of cells along each side of the unit square that parametrizes the hemisphere.
const N: usize = 4;

/// A piecewise constant density over the unit square. [`warp::cosine_hemisphere`] maps the square to directions: cells of equal area
/// receive equal irradiance under a constant sky.
pub(crate) struct Guide {
    /// Density of each cell, row by row.
    density: [[f32; N]; N],
    /// Mean of each row.
    rows: [f32; N],
}

impl Guide {
    /// Draw a fraction `guided` of the directions by the weighted photon directions, and the rest by the cosine alone. The density of
    /// every direction is at least 1 - `guided` of that by the cosine. `None` without photons.
    pub(crate) fn new(
        frame: &Frame,
        guided: f32,
        photons: impl Iterator<Item = (Vec3, f32)>,
    ) -> Option<Self> {
        let (mut flux, mut total) = ([[0.0; N]; N], 0.0);
        for (d, weight) in photons {
            let d = frame.to_local(d);
            if d.z > 0.0 {
                let cell = |u: f32| ((u * N as f32) as usize).min(N - 1);
                let [x, y] = square(d.truncate());
                flux[cell(y)][cell(x)] += weight;
                total += weight;
            }
        }
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let scale = guided * (N * N) as f32 / total;
        let density = flux.map(|row| row.map(|f| 1.0 - guided + scale * f));
        let rows = density.map(|row| row.iter().sum::<f32>() / N as f32);
        Some(Guide { density, rows })
    }

    /// A local direction, and the ratio of its density to that by the cosine. The map from the square is continuous.
    pub(crate) fn sample(&self, [u, v]: [f32; 2]) -> (Vec3, f32) {
        let (row, y) = pick(&self.rows, v);
        let (column, x) = pick(&self.density[row], u);
        (warp::cosine_hemisphere([x, y]), self.density[row][column])
    }
}

/// The cell that `u` selects by these densities, and the position within the cell, in [0, 1).
fn pick(densities: &[f32; N], u: f32) -> (usize, f32) {
    let mut left = u * densities.iter().sum::<f32>();
    for (k, &d) in densities.iter().enumerate() {
        if left < d || k == N - 1 {
            return (k, (k as f32 + (left / d).min(0.999_999)) / N as f32);
        }
        left -= d;
    }
    unreachable!("the last cell takes what is left")
}

/// Inverse of [`warp::disk`].
fn square(p: Vec2) -> [f32; 2] {
    let r = p.length();
    let place = if p.x == 0.0 && p.y == 0.0 {
        Vec2::ZERO
    } else if p.x.abs() > p.y.abs() {
        let x = r.copysign(p.x);
        Vec2::new(x, (p.y / p.x).atan() * x / FRAC_PI_4)
    } else {
        let y = r.copysign(p.y);
        Vec2::new((p.x / p.y).atan() * y / FRAC_PI_4, y)
    };
    ((place + Vec2::ONE) * 0.5).to_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use gi_core::rng::Pcg;
    use gi_stats::chi2_test;

    #[test]
    fn the_square_of_a_point_of_the_disk() {
        let mut rng = Pcg::new(1, 1);
        for _ in 0..10_000 {
            let u = rng.next_2d();
            let back = square(warp::disk(u));
            assert!((Vec2::from(u) - Vec2::from(back)).length() < 1e-5, "{u:?} {back:?}");
        }
    }

    #[test]
    fn directions_are_drawn_with_the_density_that_is_said() {
        let mut rng = Pcg::new(2, 1);
        let frame = Frame::from_normal(Vec3::new(0.3, -0.5, 0.7).normalize());
        let photons: Vec<(Vec3, f32)> =
            (0..50).map(|_| (warp::sphere(rng.next_2d()), rng.next_f32())).collect();
        let guide = Guide::new(&frame, 0.7, photons.into_iter()).expect("photons");
        // Counts in a grid that is finer than the guide's, against the cells' densities.
        const FINE: usize = 2 * N;
        let n = 100_000;
        let (mut counts, mut inverse) = (vec![0u64; FINE * FINE], 0.0);
        for _ in 0..n {
            let (d, density) = guide.sample(rng.next_2d());
            let [x, y] = square(d.truncate()).map(|u| ((u * FINE as f32) as usize).min(FINE - 1));
            counts[y * FINE + x] += 1;
            assert!(density >= 0.3 - 1e-6);
            inverse += f64::from(1.0 / density) / f64::from(n);
        }
        let expected: Vec<f64> = (0..FINE * FINE)
            .map(|k| {
                let density = guide.density[k / FINE / 2][k % FINE / 2];
                f64::from(n) * f64::from(density) / (FINE * FINE) as f64
            })
            .collect();
        let result = chi2_test(&counts, &expected).expect("no impossible cell");
        assert!(result.p_value > 1e-3, "{result:?}");
        // One over the density has a mean of 1 and lies within [0, 1 / 0.3].
        assert!((inverse - 1.0).abs() < 4.0 * 1.7 / f64::from(n).sqrt(), "{inverse}");
    }
}
