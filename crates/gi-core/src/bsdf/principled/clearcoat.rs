//! The clearcoat: a weak, isotropic second reflection with long tails.

use std::f32::consts::PI;

use glam::Vec3;

use super::schlick_weight;
use crate::bsdf::fresnel::{self, reflect};
use crate::math::{safe_sqrt, sin_cos_turns, sqr};

/// Width of the shadowing term [Burley12, 5.4].
const SHADOW_ALPHA: f32 = 0.25;

/// A clearcoat over a body. Both directions are above. As in Mitsuba 3, shadowing is Smith's G, and the lobe is not
/// divided by 4 cos cos', which Burley's own code includes in its G.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clearcoat {
    /// Weight, already multiplied by the quarter that Burley gives the lobe.
    weight: f32,
    /// Width of the distribution.
    alpha: f32,
}

impl Clearcoat {
    pub(super) fn new(clearcoat: f32, gloss: f32) -> Self {
        Clearcoat { weight: 0.25 * clearcoat, alpha: 0.1 + (0.001 - 0.1) * gloss }
    }

    /// Width of the reflection; 1 if there is none.
    pub(super) fn width(&self) -> f32 {
        if self.weight > 0.0 { self.alpha } else { 1.0 }
    }

    /// f without the cosine for facet `m`; `eta` is the index of the body.
    #[inline]
    pub(super) fn f(&self, wo: Vec3, wi: Vec3, m: Vec3, eta: f32) -> f32 {
        if self.weight == 0.0 {
            return 0.0;
        }
        self.weight * schlick(wo.dot(m), eta) * self.d(m) * g1(wo.z) * g1(wi.z)
    }

    /// Density per solid angle of [`Clearcoat::sample`].
    #[inline]
    pub(super) fn pdf_w(&self, wo: Vec3, m: Vec3) -> f32 {
        self.d(m) * m.z / (4.0 * wo.dot(m))
    }

    /// Mirror `wo` at a facet that is sampled by D cos.
    pub(super) fn sample(&self, wo: Vec3, u: [f32; 2]) -> Option<Vec3> {
        // [Burley12, B.2, eq. 2]
        let a2 = sqr(self.alpha);
        let cos_sq = ((1.0 - a2.powf(1.0 - u[0])) / (1.0 - a2)).clamp(0.0, 1.0);
        let (sin, (s, c)) = (safe_sqrt(1.0 - cos_sq), sin_cos_turns(u[1]));
        let m = Vec3::new(c * sin, s * sin, cos_sq.sqrt());
        let wi = reflect(wo, m);
        (wo.dot(m) > 0.0 && wi.z > 0.0).then_some(wi)
    }

    /// Sampling weight of the lobe.
    pub(super) fn importance(&self, wo: Vec3, eta: f32) -> f32 {
        // For a reflection at the normal, f cos divided by the density is 4 cos^2 F.
        self.weight * 4.0 * sqr(wo.z) * schlick(wo.z, eta).max(0.05)
    }

    /// Generalised Trowbridge and Reitz's distribution with exponent 1 [Burley12, B.2, eq. 4].
    #[inline]
    fn d(&self, m: Vec3) -> f32 {
        self.d_at(m.x * m.x + m.y * m.y, sqr(m.z))
    }

    #[inline]
    fn d_at(&self, sin_sq: f32, cos_sq: f32) -> f32 {
        let a2 = sqr(self.alpha);
        (a2 - 1.0) / (PI * a2.ln() * (sin_sq + a2 * cos_sq))
    }

    /// Upper bound of f for `wi` with cosines up to `cos`, over facets whose squared tangent is at least `tan_sq` and
    /// whose cosine with the directions is at least `min_cos`.
    pub(super) fn bound(&self, cos_o: f32, cos: f32, tan_sq: f32, min_cos: f32, eta: f32) -> f32 {
        if self.weight == 0.0 {
            return 0.0;
        }
        let cos_sq = 1.0 / (1.0 + tan_sq);
        self.weight
            * schlick(min_cos, eta)
            * self.d_at(tan_sq * cos_sq, cos_sq)
            * g1(cos_o)
            * g1(cos)
    }
}

/// Schlick's term for polyurethane, with index 1.5. Toward a thinner medium, the angle of the refracted direction is
/// used.
fn schlick(cos: f32, eta: f32) -> f32 {
    let cos = if eta > 1.0 { cos } else { fresnel::dielectric(cos, eta).cos_t.abs() };
    0.04 + 0.96 * schlick_weight(cos)
}

/// Smith's shadowing of a direction above.
#[inline]
fn g1(cos: f32) -> f32 {
    let cos_sq = sqr(cos);
    2.0 * cos / (cos + (sqr(SHADOW_ALPHA) * (1.0 - cos_sq) + cos_sq).sqrt())
}
