//! The position of a record and the region in which it is valid: the part that records of all kinds share.

use gi_core::math::safe_sqrt;
use glam::Vec3;

/// Position, orientation and region of validity of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Unit normal, on the side that the light comes from.
    pub n: Vec3,
    /// Position, world.
    pub p: Vec3,
    /// Radii along `axis` and across it in the tangent plane, world. At this distance the error from distance alone
    /// reaches the accuracy a; on the slide this is a r.
    pub radii: [f32; 2],
    /// Unit tangent.
    pub axis: Vec3,
    /// Lower limit of the radii when neighbours reduce them, world.
    pub least: f32,
    /// Distance to the nearest surface that a gather ray hit, world.
    pub clear: f32,
}

/// A record with a site.
pub trait Sited {
    /// The site.
    fn site(&self) -> &Site;
    /// The site, to limit its radii.
    fn site_mut(&mut self) -> &mut Site;
}

/// The point of a lookup.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    /// Position, world.
    pub p: Vec3,
    /// Unit normal.
    pub n: Vec3,
}

/// Factor on the allowed error for lookups that find no record otherwise.
pub const RELAXED: f32 = 2.0;

/// Largest distance of a query behind a record, as a fraction of the record's radius.
const BEHIND: f32 = 0.05;

impl Site {
    /// Number of floats of a site.
    pub const FLOATS: usize = 3 * 3 + 2 + 2;

    /// The site as floats, for files.
    pub fn put_floats(&self, out: &mut Vec<f32>) {
        let Site { n, p, radii, axis, least, clear } = *self;
        [n, p, axis].iter().for_each(|v| out.extend(v.to_array()));
        out.extend(radii);
        out.extend([least, clear]);
    }

    /// A site from [`Site::FLOATS`] floats.
    pub fn from_floats(floats: &[f32]) -> Self {
        let v = |k: usize| Vec3::from_slice(&floats[k..]);
        let radii = [floats[9], floats[10]];
        Site { n: v(0), p: v(3), axis: v(6), radii, least: floats[11], clear: floats[12] }
    }

    /// The larger of the radii.
    pub fn reach(&self) -> f32 {
        self.radii[0].max(self.radii[1])
    }

    /// Limit the radii to `reach`.
    pub fn limit(&mut self, reach: f32) {
        self.radii = self.radii.map(|r| r.min(reach));
    }

    /// The estimate of the error at `q` [slide 11], in units of the accuracy a:
    /// (|x - x_j| / r_j + sqrt(1 - n . n_j)) / a. The record is valid at the query if this is below 1.
    #[inline]
    pub fn error(&self, q: &Query, accuracy: f32) -> f32 {
        let d = q.p - self.p;
        let across = self.n.cross(self.axis);
        let (u, v) = (d.dot(self.axis) / self.radii[0], d.dot(across) / self.radii[1]);
        let h = d.dot(self.n) / self.radii[0].min(self.radii[1]);
        (u * u + v * v + h * h).sqrt() + safe_sqrt(1.0 - self.n.dot(q.n)) / accuracy
    }

    /// Whether the record is in front of the query, so that the record may see light that is hidden from the query. The
    /// test uses the plane through the record with the mean of both normals \[Ward88\].
    #[inline]
    pub fn is_in_front_of(&self, q: &Query) -> bool {
        (q.p - self.p).dot(self.n + q.n) * 0.5 < -BEHIND * self.reach()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_the_slides_and_grows_with_distance_and_angle() {
        let site = Site {
            n: Vec3::Z,
            p: Vec3::ZERO,
            radii: [0.2, 0.2],
            axis: Vec3::X,
            least: 0.0,
            clear: 1.0,
        };
        // On the slide a r = 0.2, so with a = 0.1, r is 2.
        let slide = |q: &Query| (q.p.length() / 2.0 + (1.0 - q.n.z).max(0.0).sqrt()) / 0.1;
        let mut last = 0.0;
        for k in 1..10 {
            let t = 0.02 * k as f32;
            let q = Query {
                p: Vec3::new(t, -0.5 * t, 0.0),
                n: Vec3::new(0.05 * t, 0.0, 1.0).normalize(),
            };
            let error = site.error(&q, 0.1);
            assert!((error - slide(&q)).abs() < 1e-4, "{error}");
            assert!(error > last);
            last = error;
        }
        assert_eq!(site.error(&Query { p: Vec3::ZERO, n: Vec3::Z }, 0.1), 0.0);
        let narrow = Site { radii: [0.2, 0.1], ..site };
        let along = narrow.error(&Query { p: Vec3::X * 0.1, n: Vec3::Z }, 0.1);
        let across = narrow.error(&Query { p: Vec3::Y * 0.1, n: Vec3::Z }, 0.1);
        assert!((along - 0.5).abs() < 1e-6 && (across - 1.0).abs() < 1e-6);
    }
}
