//! What is kept of a point: its irradiance, how that changes, and how far it is good for.

use gi_core::math::{Rgb, safe_sqrt};
use glam::Vec3;

use crate::gradients::Gradient;

/// A record of the cache: the lecture's irradiance sample [slide 10], with gradients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// Irradiance E of indirect light.
    pub e: Rgb,
    /// Unit normal, on the side that the light comes from.
    pub n: Vec3,
    /// Position, world.
    pub p: Vec3,
    /// How far the record is good for along `axis` and across it in the tangent plane, world: where the error that comes
    /// with distance alone reaches the accuracy asked for. In the slide's terms a r.
    pub radii: [f32; 2],
    /// Unit tangent.
    pub axis: Vec3,
    /// The smallest that neighbours may make the radii, world.
    pub least: f32,
    /// Distance of the nearest surface that any ray met, world.
    pub clear: f32,
    /// E(n') = E(n) + (n x n') . this, a gradient by rotation.
    pub rotational: Gradient,
    /// Gradient by the position, in the tangent plane, per world unit.
    pub translational: Gradient,
}

/// Where irradiance is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    /// Position, world.
    pub p: Vec3,
    /// Unit normal.
    pub n: Vec3,
}

/// Which gradients interpolation uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gradients {
    /// None: slide 11 as it stands.
    Off,
    /// By the normal.
    Rotation,
    /// By the position.
    Translation,
    /// Both.
    Both,
}

/// How far behind the record's tangent plane a point may lie, in units of the record's reach.
const BEHIND: f32 = 0.05;

impl Record {
    /// The larger of the radii.
    pub fn reach(&self) -> f32 {
        self.radii[0].max(self.radii[1])
    }

    /// Let the radii be no larger than `reach`.
    pub fn limit(&mut self, reach: f32) {
        self.radii = self.radii.map(|r| r.min(reach));
    }

    /// The estimate of the error at `q` [slide 11], in units of the accuracy a:
    /// (|x - x_j| / r_j + sqrt(1 - n . n_j)) / a. The record is good for the query below 1.
    #[inline]
    pub fn error(&self, q: &Query, accuracy: f32) -> f32 {
        let d = q.p - self.p;
        let across = self.n.cross(self.axis);
        let (u, v) = (d.dot(self.axis) / self.radii[0], d.dot(across) / self.radii[1]);
        let h = d.dot(self.n) / self.radii[0].min(self.radii[1]);
        (u * u + v * v + h * h).sqrt() + safe_sqrt(1.0 - self.n.dot(q.n)) / accuracy
    }

    /// Whether the point lies so far behind the record that what the record sees may be hidden from it: below the
    /// plane with the mean of both normals \[Ward88\].
    #[inline]
    pub fn is_in_front_of(&self, q: &Query) -> bool {
        (q.p - self.p).dot(self.n + q.n) * 0.5 < -BEHIND * self.reach()
    }

    /// The record's irradiance brought to the query along its gradients \[Ward92, eq. 6\].
    #[inline]
    pub fn extrapolate(&self, q: &Query, gradients: Gradients) -> Rgb {
        let mut e = self.e;
        if matches!(gradients, Gradients::Rotation | Gradients::Both) {
            e += self.rotational.along(self.n.cross(q.n));
        }
        if matches!(gradients, Gradients::Translation | Gradients::Both) {
            e += self.translational.along(q.p - self.p);
        }
        e
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_the_slides_and_grows_with_distance_and_angle() {
        let record = Record {
            e: Rgb::WHITE,
            n: Vec3::Z,
            p: Vec3::ZERO,
            radii: [0.2, 0.2],
            axis: Vec3::X,
            least: 0.0,
            clear: 1.0,
            rotational: Gradient::default(),
            translational: Gradient::default(),
        };
        // a r = 0.2 with a = 0.1 is r = 2.
        let slide = |q: &Query| (q.p.length() / 2.0 + (1.0 - q.n.z).max(0.0).sqrt()) / 0.1;
        let mut last = 0.0;
        for k in 1..10 {
            let t = 0.02 * k as f32;
            let q = Query {
                p: Vec3::new(t, -0.5 * t, 0.0),
                n: Vec3::new(0.05 * t, 0.0, 1.0).normalize(),
            };
            let error = record.error(&q, 0.1);
            assert!((error - slide(&q)).abs() < 1e-4, "{error}");
            assert!(error > last);
            last = error;
        }
        assert_eq!(record.error(&Query { p: Vec3::ZERO, n: Vec3::Z }, 0.1), 0.0);
        let narrow = Record { radii: [0.2, 0.1], ..record };
        let along = narrow.error(&Query { p: Vec3::X * 0.1, n: Vec3::Z }, 0.1);
        let across = narrow.error(&Query { p: Vec3::Y * 0.1, n: Vec3::Z }, 0.1);
        assert!((along - 0.5).abs() < 1e-6 && (across - 1.0).abs() < 1e-6);
    }
}
