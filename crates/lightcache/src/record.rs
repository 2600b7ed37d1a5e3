//! The irradiance record of a point: irradiance and its gradients.

use gi_core::math::Rgb;
use glam::Vec3;

use crate::gradients::Gradient;
pub use crate::options::Gradients;
use crate::site::{Query, Site, Sited};

/// A record of the cache: the lecture's irradiance sample [slide 10], with gradients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// Irradiance E of indirect light.
    pub e: Rgb,
    /// Normal n, position p, and the radii of validity: the slide's range r times the accuracy a.
    pub site: Site,
    /// Rotational gradient: E(n') = E(n) + (n x n') . gradient.
    pub rotational: Gradient,
    /// Translational gradient in the tangent plane, per world unit.
    pub translational: Gradient,
}

impl Sited for Record {
    fn site(&self) -> &Site {
        &self.site
    }

    fn site_mut(&mut self) -> &mut Site {
        &mut self.site
    }
}

impl Record {
    /// The irradiance E_i(x) at the query, extrapolated from the record along its gradients \[Ward92, eq. 6\].
    #[inline]
    pub fn extrapolate(&self, q: &Query, gradients: Gradients) -> Rgb {
        let mut e = self.e;
        if matches!(gradients, Gradients::Rotation | Gradients::Both) {
            e += self.rotational.along(self.site.n.cross(q.n));
        }
        if matches!(gradients, Gradients::Translation | Gradients::Both) {
            e += self.translational.along(q.p - self.site.p);
        }
        e
    }
}

impl Record {
    /// Number of floats of a record.
    pub const FLOATS: usize = 3 + Site::FLOATS + 2 * 9;

    /// The record as floats, for files.
    pub fn put_floats(&self, out: &mut Vec<f32>) {
        out.extend(self.e.to_array());
        self.site.put_floats(out);
        for g in [&self.rotational, &self.translational] {
            g.0.iter().for_each(|v| out.extend(v.to_array()));
        }
    }

    /// A record from [`Record::FLOATS`] floats.
    pub fn from_floats(floats: &[f32]) -> Self {
        let v = |k: usize| Vec3::from_slice(&floats[k..]);
        let gradient = |k: usize| Gradient([v(k), v(k + 3), v(k + 6)]);
        let site = Site::from_floats(&floats[3..3 + Site::FLOATS]);
        let e = Rgb::from(v(0).to_array());
        Record { e, site, rotational: gradient(16), translational: gradient(25) }
    }
}
