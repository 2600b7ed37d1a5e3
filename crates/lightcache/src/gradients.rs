//! Gradients of irradiance by position and by normal, from the rays of the record
//! [slide 12] \[Ward92\].

use std::f32::consts::PI;

use gi_core::math::{Frame, Rgb};
use glam::Vec3;

use crate::hemisphere::{Hemisphere, Strata};

/// A gradient of a colour: one vector per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gradient(pub [Vec3; 3]);

impl Gradient {
    /// Change along `d`.
    #[inline]
    pub fn along(&self, d: Vec3) -> Rgb {
        Rgb::from(self.0.map(|g| g.dot(d)))
    }

    /// Limit the gradient so that within `reach` no channel more than doubles or becomes negative. Gradients next to an
    /// edge are unbounded.
    pub fn limited(mut self, value: Rgb, reach: f32) -> Self {
        for (g, v) in self.0.iter_mut().zip(value.to_array()) {
            *g *= (v / (g.length() * reach)).min(1.0);
            // Without light this is zero over zero.
            *g = if g.is_finite() { *g } else { Vec3::ZERO };
        }
        self
    }

    /// From local to world.
    pub fn to_world(self, frame: &Frame) -> Self {
        Gradient(self.0.map(|g| frame.to_world(g)))
    }

    /// Add `d` times a colour.
    fn add(&mut self, d: Vec3, colour: Rgb) {
        for (g, c) in self.0.iter_mut().zip(colour.to_array()) {
            *g += d * c;
        }
    }
}

/// Unit vector in the tangent plane at angle `phi`.
fn tangent(phi: f32) -> Vec3 {
    let (sin, cos) = phi.sin_cos();
    Vec3::new(cos, sin, 0.0)
}

/// Rotational gradient, the integral of L (n x w): for a normal n' near n, E(n') = E(n) + (n x n') . gradient. The
/// tangent of the angle is averaged over each ring, because it is unbounded for rays near the horizon. The result is
/// unbiased if radiance is constant across each ring.
pub fn rotational(h: &Hemisphere) -> Gradient {
    let Strata { rings, sectors } = h.strata;
    let mut gradient = Gradient::default();
    for j in 0..rings {
        let tan = mean_tangent(h.strata.sin_sq(j), h.strata.sin_sq(j + 1));
        for k in 0..sectors {
            let seen = h.at(j, k);
            let axis = Vec3::Z.cross(seen.direction).normalize_or_zero();
            gradient.add(axis, seen.radiance * (tan * PI / h.strata.count() as f32));
        }
    }
    gradient
}

/// Mean of tan(theta) over a ring, with sin^2(theta) uniformly distributed as for the rays.
fn mean_tangent(from: f32, to: f32) -> f32 {
    // The integral of sqrt(s / (1 - s)).
    let integral = |s: f32| s.min(1.0).sqrt().asin() - (s * (1.0 - s).max(0.0)).sqrt();
    (integral(to) - integral(from)) / (to - from)
}

/// Translational gradient in the tangent plane \[Ward92, Krivanek05\]. When the point moves, the border between two
/// strata moves with a speed of one over the distance of the nearer stratum.
///
/// The border between rings j - 1 and j lies at theta_j with sin^2(theta_j) = j / M. An index that is off by one
/// changes the gradient by 14 to 18 %.
pub fn translational(h: &Hemisphere) -> Gradient {
    let Strata { rings, sectors } = h.strata;
    let mut gradient = Gradient::default();
    let sector = 2.0 * PI / sectors as f32;
    for k in 0..sectors {
        let before = (k + sectors - 1) % sectors;
        // A move along the middle of the sector moves the borders between rings by cos(theta) / r.
        let u = tangent(h.strata.phi(k) + 0.5 * sector);
        // A move across the first border of the sector turns that border by 1 / (r sin(theta)).
        let v = Vec3::Z.cross(tangent(h.strata.phi(k)));
        for j in 0..rings {
            let here = h.at(j, k);
            let (sin_sq, sin_sq_next) = (h.strata.sin_sq(j), h.strata.sin_sq(j + 1));
            if j > 0 {
                let inner = h.at(j - 1, k);
                let r = here.distance.min(inner.distance);
                let wall = sector * (1.0 - sin_sq) * sin_sq.sqrt() / r;
                gradient.add(u, (here.radiance - inner.radiance) * wall);
            }
            let side = h.at(j, before);
            let r = here.distance.min(side.distance);
            let wall = (sin_sq_next.sqrt() - sin_sq.sqrt()) / r;
            gradient.add(v, (here.radiance - side.radiance) * wall);
        }
    }
    gradient
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::tests::hemisphere;

    /// Mean and standard error of the mean of a component of a gradient over independent hemispheres.
    fn mean_and_error(values: &[f64]) -> (f64, f64) {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, (variance / n).sqrt())
    }

    /// A ceiling at height 1 that emits radiance 1 where `x > edge`, seen from the origin.
    fn half_plane(edge: f32) -> impl Fn(Vec3) -> (Rgb, f32, Vec3) {
        move |w| {
            let t = 1.0 / w.z;
            (Rgb::grey(if t * w.x > edge { 1.0 } else { 0.0 }), t, -Vec3::Z)
        }
    }

    #[test]
    fn translational_gradient_of_the_half_plane_emitter_for_all_m_and_n() {
        // E = pi / 2 (1 - edge / sqrt(edge^2 + 1)); moving by dx moves the edge by -dx.
        for rays in [100, 300, 1000, 5000] {
            for edge in [0.0, 0.4, -0.7] {
                let exact = 0.5 * f64::from(PI) / (f64::from(edge * edge) + 1.0).powf(1.5);
                let strata = Strata::of(rays);
                let of = |seed| {
                    let h = hemisphere(strata, seed, half_plane(edge));
                    f64::from(translational(&h).0[1].x)
                };
                let (mean, error) = mean_and_error(&(0..200).map(of).collect::<Vec<_>>());
                // Using the nearer distance causes a bias of the order of one stratum: half of one of M rings.
                let bias = 0.5 / strata.rings as f64;
                assert!(
                    (mean / exact - 1.0).abs() < bias + 4.0 * error / exact,
                    "{rays} rays, edge {edge}: {mean} +- {error} is not {exact}"
                );
            }
        }
    }

    #[test]
    fn rotational_gradient_of_the_half_plane_emitter_for_all_m_and_n() {
        // At a point below its edge, the emitter fills half of the sky: E(n) = pi / 2 (1 + n . x) for the half x > 0.
        for rays in [30, 100, 1000, 5000] {
            let exact = 0.5 * f64::from(PI);
            let of = |seed| {
                let h = hemisphere(Strata::of(rays), seed, half_plane(0.0));
                let turned = Vec3::Z.cross(Vec3::X); // n x n' per angle toward x
                f64::from(rotational(&h).along(turned).g)
            };
            let (mean, error) = mean_and_error(&(0..100).map(of).collect::<Vec<_>>());
            assert!(
                (mean / exact - 1.0).abs() < 1e-3 + 4.0 * error / exact,
                "{rays} rays: {mean} +- {error} is not {exact}"
            );
        }
    }

    /// Lambert's formula: irradiance at `p` with normal `n` from a polygon of radiance 1 above the horizon.
    fn polygon_irradiance(corners: &[Vec3], p: Vec3, n: Vec3) -> f64 {
        let edges = corners.iter().zip(corners.iter().cycle().skip(1));
        let term = |(a, b): (&Vec3, &Vec3)| {
            let (a, b) = ((*a - p).as_dvec3().normalize(), (*b - p).as_dvec3().normalize());
            a.dot(b).acos() * a.cross(b).normalize().dot(n.as_dvec3())
        };
        edges.map(term).sum::<f64>() * 0.5
    }

    #[test]
    fn gradients_agree_with_finite_differences_of_a_polygon_light() {
        // A rectangle overhead, off to a side, in a ceiling at height 1.
        let corners =
            [(-0.2, -0.5), (0.9, -0.5), (0.9, 0.4), (-0.2, 0.4)].map(|(x, y)| Vec3::new(x, y, 1.0));
        let look = |w: Vec3| {
            let q = w / w.z;
            let inside = q.x > -0.2 && q.x < 0.9 && q.y > -0.5 && q.y < 0.4;
            (Rgb::grey(if inside { 1.0 } else { 0.0 }), q.length(), -Vec3::Z)
        };
        let h = 1e-3;
        let e = |p: Vec3, n: Vec3| polygon_irradiance(&corners, p, n.normalize());
        let difference = |d: Vec3| (e(d * h, Vec3::Z) - e(-d * h, Vec3::Z)) / f64::from(2.0 * h);
        let turn = |d: Vec3| {
            (e(Vec3::ZERO, Vec3::Z + d * h) - e(Vec3::ZERO, Vec3::Z - d * h)) / f64::from(2.0 * h)
        };
        for rays in [1000, 5000] {
            let strata = Strata::of(rays);
            for d in [Vec3::X, Vec3::Y, Vec3::new(0.6, -0.8, 0.0)] {
                let runs: Vec<_> = (0..200).map(|s| hemisphere(strata, s, look)).collect();
                let move_along = |h: &Hemisphere| f64::from(translational(h).along(d).r);
                let turn_to = |h: &Hemisphere| f64::from(rotational(h).along(Vec3::Z.cross(d)).r);
                let (moved, error) =
                    mean_and_error(&runs.iter().map(move_along).collect::<Vec<_>>());
                let exact = difference(d);
                let slack = 0.5 / strata.rings as f64 * difference(Vec3::X).abs();
                assert!(
                    (moved - exact).abs() < slack + 4.0 * error,
                    "{rays} rays, moved along {d}: {moved} +- {error} is not {exact}"
                );
                let (turned, error) = mean_and_error(&runs.iter().map(turn_to).collect::<Vec<_>>());
                let exact = turn(d);
                assert!(
                    (turned - exact).abs() < 2e-3 + 4.0 * error,
                    "{rays} rays, turned to {d}: {turned} +- {error} is not {exact}"
                );
            }
        }
    }
}
