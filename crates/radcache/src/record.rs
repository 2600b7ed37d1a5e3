//! The radiance record of a point on a glossy surface: its irradiance, and incoming radiance as coefficients of the
//! basis with their gradients \[Krivanek05\].

use gi_core::math::Frame;
use glam::{Vec2, Vec3, Vec3A};
use lightcache::hemisphere::Hemisphere;
use lightcache::record::Record;
use lightcache::site::{Query, RELAXED, Site, Sited};

use crate::project::Projection;
use crate::rotate::about_z;
use crate::sh::{Basis, Coefficients, MAX_FUNCTIONS};

/// A radiance record.
///
/// Spherical harmonics are stored in world space. Rotation does not change the bands of a function, so nothing is lost;
/// records with different normals can be added directly, and their mean is rotated into the shading frame once.
/// Hemispherical harmonics cannot be rotated to a tilted surface: they are stored in the frame that
/// [`Frame::from_normal`] makes of the record's normal.
#[derive(Clone, Debug, PartialEq)]
pub struct RadianceRecord {
    /// Position, radius and irradiance.
    pub irradiance: Record,
    /// Coefficients of incoming indirect radiance, then their gradients along the tangents that [`Frame::from_normal`]
    /// makes, per world unit: three times as many as the order has functions.
    pub light: Box<[Vec3A]>,
}

impl Sited for RadianceRecord {
    fn site(&self) -> &Site {
        &self.irradiance.site
    }

    fn site_mut(&mut self) -> &mut Site {
        &mut self.irradiance.site
    }
}

impl RadianceRecord {
    /// The record of the light that a hemisphere of rays found, with directions in `frame`; `irradiance` is from the
    /// same rays.
    pub fn new(
        irradiance: Record,
        frame: &Frame,
        h: &Hemisphere,
        basis: Basis,
        order: usize,
    ) -> Self {
        let own = Frame::from_normal(irradiance.site.n);
        let into = |local: Vec3| {
            let world = frame.to_world(local);
            if basis == Basis::Sh { world } else { own.to_local(world) }
        };
        let along = |local: Vec3| own.to_local(frame.to_world(local)).truncate();
        let sums = Projection::new(basis, order);
        let mut light = sums.project(h, into).differentiate(h, into, along).coefficients;
        limit(&mut light, RELAXED * irradiance.site.reach());
        RadianceRecord { irradiance, light: light.into() }
    }

    /// Add `weight` times the light at the query to `out`, extrapolated along the gradients if `gradients`. `frame` is
    /// the frame of the query.
    #[inline]
    pub fn add_to(
        &self,
        out: &mut Coefficients,
        q: &Query,
        frame: &Frame,
        basis: Basis,
        gradients: bool,
        weight: f32,
    ) {
        let Site { n, p, .. } = self.irradiance.site;
        let own = Frame::from_normal(n);
        let moved = if gradients { own.to_local(q.p - p).truncate() } else { Vec2::ZERO };
        let count = self.light.len() / 3;
        let (value, slopes) = self.light.split_at(count);
        let (by_s, by_t) = slopes.split_at(count);
        let (s, t) = (weight * moved.x, weight * moved.y);
        let extrapolated = |k: usize| value[k] * weight + by_s[k] * s + by_t[k] * t;
        match basis {
            Basis::Sh => {
                out[..count].iter_mut().enumerate().for_each(|(k, c)| *c += extrapolated(k));
            }
            Basis::Hsh => {
                // Move the record's frame to the query's normal, then rotate about that normal.
                let mut turned = [Vec3A::ZERO; MAX_FUNCTIONS];
                turned[..count].iter_mut().enumerate().for_each(|(k, c)| *c = extrapolated(k));
                let axis = Vec2::new(own.s.dot(frame.s), own.s.dot(frame.t)).normalize_or(Vec2::X);
                about_z(count.isqrt(), axis.to_array(), &mut turned);
                out[..count].iter_mut().zip(turned).for_each(|(c, turned)| *c += turned);
            }
        }
    }
}

/// Limit each channel's gradient: within `reach` it may at most double the norm of the coefficients.
fn limit(light: &mut [Vec3A], reach: f32) {
    let (value, slopes) = light.split_at_mut(light.len() / 3);
    let norm = |c: &[Vec3A]| Vec3::from(c.iter().map(|v| *v * *v).sum::<Vec3A>()).map(f32::sqrt);
    let (value, slope) = (norm(value), norm(slopes));
    let factor = |k: usize| {
        let f = (value[k] / (slope[k] * reach)).min(1.0);
        if f.is_finite() { f } else { 0.0 }
    };
    let factor = Vec3A::new(factor(0), factor(1), factor(2));
    slopes.iter_mut().for_each(|s| *s *= factor);
}

#[cfg(test)]
mod tests;
