//! Upper bounds of the BSDF for light from a box: the largest contribution of a cluster of lights at a point [Walter05,
//! 3.3].
//!
//! All light from a box arrives within a cone of directions. Each lobe bounds its factors over that cone separately:
//! the cosines over the box, the density of facets over the cone of half vectors, and shadowing by its value at the
//! largest cosine. The bounds hold for the values that [`Bsdf::f`] and [`Bsdf::f_cos`] return, rounding included.

use glam::Vec3;

use super::component::Part;
use super::fresnel::{self, reflect_z};
use super::lobe::Lobe;
use super::microfacet::Microfacets;
use super::models::oren_nayar_factors;
use super::principled::mirrored;
use super::toward::{Toward, UNIT_ROUNDING};
use super::{Bsdf, Component, Transport, Way};
use crate::math::{Frame, INV_PI, Rgb, safe_sqrt, sqr};

/// Relative margin of every bound, against rounding in the bound and in the BSDF.
const SAFETY: f32 = 1.0 + 5e-4;
/// Used instead of infinity, because zero times infinity is not a number.
const UNBOUNDED: f32 = 1e30;
/// Upper bounds over a cone, per channel.
#[derive(Clone, Copy, Debug, Default)]
pub struct ScatterBound {
    /// Bound of [`Bsdf::f_cos`] divided by the cosine of `wi` with the geometric normal. On paths from the eye with a
    /// different shading normal: bound of [`Bsdf::f`].
    pub f: Rgb,
    /// Bound of [`Bsdf::f_cos`].
    pub f_cos: Rgb,
}

impl std::ops::Add for ScatterBound {
    type Output = ScatterBound;

    #[inline]
    fn add(self, other: ScatterBound) -> ScatterBound {
        ScatterBound { f: self.f + other.f, f_cos: self.f_cos + other.f_cos }
    }
}

impl std::ops::AddAssign for ScatterBound {
    #[inline]
    fn add_assign(&mut self, other: ScatterBound) {
        *self = *self + other;
    }
}

impl Bsdf<'_> {
    /// Bound the BSDF between `wo` and any of the directions in `toward`, without delta lobes.
    #[inline]
    pub fn bound(&self, wo: Vec3, toward: &Toward) -> ScatterBound {
        let mut sum = ScatterBound::default();
        for c in self.components() {
            let bound = c.bound(wo, toward, self.way);
            sum.f += bound.f * (c.weight * SAFETY);
            sum.f_cos += bound.f_cos * (c.weight * SAFETY);
        }
        sum
    }

    /// Whether any lobe except delta lobes transmits light.
    pub fn transmits(&self) -> bool {
        self.components().iter().any(|c| match &c.lobe {
            Lobe::RoughDielectric { .. } => true,
            Lobe::Principled(solid) => !solid.is_opaque(),
            Lobe::PrincipledThin(thin) => !thin.is_opaque(),
            _ => false,
        })
    }

    /// Whether all lobes use the geometric normal, or its opposite.
    #[inline]
    pub fn is_flat(&self) -> bool {
        let ng = self.way.ng;
        self.components().iter().all(|c| (c.frame.n == ng || c.frame.n == -ng) && c.bend.is_none())
    }
}

/// The cone as a lobe sees it. Directions are local.
pub(super) struct Cap {
    pub(super) wo: Vec3,
    /// Largest cosine of `wi` above.
    pub(super) cos: f32,
    /// All `wi` are in the ball with this centre and radius: it contains the cap of their cone.
    pub(super) center: Vec3,
    pub(super) radius: f32,
    /// Smallest cosine between `wo` and `wi`.
    pub(super) min_cos_wo: f32,
}

impl Component<'_> {
    #[inline]
    fn bound(&self, wo: Vec3, toward: &Toward, way: Way) -> ScatterBound {
        let bound = self.bound_in(&self.frame, wo, toward, way);
        match &self.bend {
            None => bound,
            // Shadowing leaves at most all of the light. Divided by another cosine than its own, the lobe has no bound.
            Some(_) if way.transport == Transport::Radiance => {
                let f =
                    bound.f_cos.zip(bound.f, |f_cos, _| if f_cos > 0.0 { UNBOUNDED } else { 0.0 });
                ScatterBound { f, ..bound }
            }
            Some(bend) => {
                let flipped = self.bound_in(&bend.flipped(self.frame), wo, toward, way);
                ScatterBound {
                    f: bound.f.zip(flipped.f, f32::max),
                    f_cos: bound.f_cos.zip(flipped.f_cos, f32::max),
                }
            }
        }
    }

    /// The bound of the lobe in `frame`, with the same cosines as in [`Component::f_cos`].
    #[inline]
    fn bound_in(&self, frame: &Frame, wo: Vec3, toward: &Toward, way: Way) -> ScatterBound {
        let mut bound = self.bound_of_lobe(frame, wo, toward, way.transport);
        if let Some(Part { diffuse, rest }) = self.part {
            let most = diffuse.zip(rest, f32::max);
            (bound.f, bound.f_cos) = (bound.f * most, bound.f_cos * most);
        }
        let Way { transport, ng } = way;
        if transport == Transport::Radiance || frame.n == ng || frame.n == -ng {
            return bound;
        }
        let turned = (wo.dot(frame.n) / wo.dot(ng)).abs().min(UNBOUNDED);
        let cos = [ng, -ng].map(|n| toward.max_cos(&Frame::from_normal(n)));
        let f = bound.f * turned;
        ScatterBound { f, f_cos: f * cos[0].max(cos[1]).max(0.0) }
    }

    /// One match over all kinds of lobe, therefore long.
    #[inline]
    fn bound_of_lobe(
        &self,
        frame: &Frame,
        world_wo: Vec3,
        toward: &Toward,
        transport: Transport,
    ) -> ScatterBound {
        let (wo, cos) = (frame.to_local(world_wo), toward.max_cos(frame));
        // A part with factor zero needs no bound.
        let rest = self.part.is_none_or(|p| !p.rest.is_black());
        if !self.is_two_sided(wo) && (wo.z <= 0.0 || cos <= 0.0) {
            return ScatterBound::default();
        }
        let cap = || Cap::new(frame, world_wo, toward, cos);
        match self.lobe {
            Lobe::Diffuse { albedo } => lambert_bound(cos, albedo),
            Lobe::OrenNayar { albedo, sigma_sq } => oren_nayar_bound(wo.z, cos, albedo, sigma_sq),
            Lobe::Phong { diffuse, specular, exponent } => {
                let mirrored = frame.to_world(reflect_z(wo));
                let peak = if rest { phong_peak(toward, mirrored, exponent) } else { 0.0 };
                let f = diffuse * INV_PI + specular * peak;
                ScatterBound { f, f_cos: f * cos }
            }
            Lobe::RoughConductor { eta, k, tint, facets } => {
                let cap = cap();
                let fresnel = fresnel::conductor_bound(cap.min_cos_half(), eta, k) * tint;
                cap.reflected(&facets, fresnel)
            }
            Lobe::Plastic { coat, diffuse, specular } => {
                let base = coat.base_bound(wo, cos, diffuse);
                let mut bound = ScatterBound { f: base, f_cos: base * cos };
                if let Some(facets) = coat.facets().filter(|_| rest) {
                    let cap = cap();
                    let fresnel = coat.fresnel(cap.min_cos_half());
                    bound += cap.reflected(facets, specular * fresnel);
                }
                bound
            }
            Lobe::RoughDielectric { eta, reflect, transmit, facets } => {
                cap().through(&facets, (eta, reflect, transmit), transport)
            }
            Lobe::Principled(solid) => {
                solid.bound(&cap(), toward.cone().max_cos(world_wo), transport)
            }
            Lobe::PrincipledThin(thin) => {
                let mut bound = ScatterBound::default();
                if cos > 0.0 {
                    bound += thin.reflected_bound(&cap(), toward.cone().max_cos(world_wo));
                }
                if let Some(cap) = self.turned_cap(wo, toward) {
                    bound += thin.passing_bound(&cap);
                }
                bound
            }
            Lobe::Conductor { .. }
            | Lobe::Dielectric { .. }
            | Lobe::ThinDielectric { .. }
            | Lobe::Null => ScatterBound::default(),
        }
    }

    /// Whether the lobe may scatter light for directions on both sides.
    fn is_two_sided(&self, wo: Vec3) -> bool {
        match &self.lobe {
            Lobe::RoughDielectric { .. } => true,
            Lobe::Principled(solid) => !solid.is_opaque(),
            Lobe::PrincipledThin(thin) => wo.z > 0.0 && !thin.is_opaque(),
            _ => false,
        }
    }

    /// The cap of the directions below, mirrored to above; `None` if there are none.
    fn turned_cap(&self, wo: Vec3, toward: &Toward) -> Option<Cap> {
        let cos = toward.max_cos(&Frame { n: -self.frame.n, ..self.frame });
        let cone = toward.cone();
        let world_turned = self.frame.to_world(mirrored(wo));
        (cos > 0.0).then(|| Cap {
            wo,
            cos,
            center: mirrored(self.frame.to_local(cone.axis)) * cone.cos,
            radius: cone.sin + UNIT_ROUNDING,
            min_cos_wo: -cone.max_cos(-world_turned),
        })
    }
}

impl Cap {
    /// The directions `toward` in `frame`. `cos` is their largest cosine with its normal.
    fn new(frame: &Frame, wo: Vec3, toward: &Toward, cos: f32) -> Self {
        let cone = toward.cone();
        Cap {
            wo: frame.to_local(wo),
            cos,
            center: frame.to_local(cone.axis) * cone.cos,
            radius: cone.sin + UNIT_ROUNDING,
            min_cos_wo: -cone.max_cos(-wo),
        }
    }

    /// The smallest cosine between `wo` and a half vector: that of half the angle between `wo` and `wi`.
    #[inline]
    pub(super) fn min_cos_half(&self) -> f32 {
        (safe_sqrt(0.5 * (1.0 + self.min_cos_wo)) - UNIT_ROUNDING).clamp(0.0, 1.0)
    }

    /// F D G / (4 cos cos'), and the same times cos', for directions on one side.
    #[inline]
    pub(super) fn reflected(&self, facets: &Microfacets, fresnel: Rgb) -> ScatterBound {
        let d = facets.d_bound(self.wo + self.center, self.radius);
        let shared = d * facets.g1_seen(self.wo) / (4.0 * self.wo.z.abs());
        let [g1, g1_over_cos] = facets.g1_bounds(self.cos);
        ScatterBound { f: fresnel * (shared * g1_over_cos), f_cos: fresnel * (shared * g1) }
    }

    /// Both sides of a rough dielectric [Walter07, eqs. 20 and 21].
    fn through(
        &self,
        facets: &Microfacets,
        (eta, reflect, transmit): (f32, Rgb, Rgb),
        transport: Transport,
    ) -> ScatterBound {
        // Use the cap without its limit on the cosine, because the light may come from either side.
        let both = Cap { cos: 1.0, ..*self };
        let fresnel = fresnel::dielectric(self.min_cos_half().copysign(self.wo.z), eta).reflectance;
        both.reflected(facets, reflect * fresnel) + self.refracted(facets, eta, transmit, transport)
    }

    /// The part that facets refract, to either side.
    pub(super) fn refracted(
        &self,
        facets: &Microfacets,
        eta: f32,
        transmit: Rgb,
        transport: Transport,
    ) -> ScatterBound {
        let eta = if self.wo.z > 0.0 { eta } else { 1.0 / eta };
        let (h, radius) = (self.wo + self.center * eta, self.radius * eta);
        let shortest = (h.length() - radius).max((1.0 - eta).abs() - UNIT_ROUNDING).max(1e-9);
        let jacobian = sqr(eta / shortest);
        let d = facets.d_bound(h, radius);
        let shared =
            d * jacobian * facets.g1_seen(self.wo) / self.wo.z.abs() * transport.refraction(eta);
        let [g1, g1_over_cos] = facets.g1_bounds(1.0);
        ScatterBound { f: transmit * (shared * g1_over_cos), f_cos: transmit * (shared * g1) }
    }
}

/// Bound of Lambert's model.
fn lambert_bound(cos: f32, albedo: Rgb) -> ScatterBound {
    ScatterBound { f: albedo * INV_PI, f_cos: albedo * (INV_PI * cos.max(0.0)) }
}

/// Bound of the lobe of Phong's model about the direction `mirrored`.
fn phong_peak(toward: &Toward, mirrored: Vec3, exponent: f32) -> f32 {
    let cos = toward.cone().max_cos(mirrored).max(0.0);
    (exponent + 2.0) * 0.5 * INV_PI * cos.powf(exponent)
}

/// Bound of Oren-Nayar's model. sin sin' / max(cos, cos') is at most sin / cos; multiplied by cos', it is at most sin.
fn oren_nayar_bound(cos_wo: f32, cos: f32, albedo: Rgb, sigma_sq: f32) -> ScatterBound {
    let ([a, b], sin) = (oren_nayar_factors(sigma_sq), safe_sqrt(1.0 - sqr(cos_wo)));
    let albedo = albedo * INV_PI;
    let f_cos = a * cos + b * sin * (cos / cos_wo).min(1.0);
    ScatterBound { f: albedo * (a + b * sin / cos_wo), f_cos: albedo * f_cos }
}
