//! The principled model [Burley12, Burley15], with the parameters and conventions of Mitsuba 3.
//!
//! `solid` is the surface of a body, and `thin` a sheet without thickness. Both have the diffuse `base`, and facets
//! whose Fresnel term blends that of a dielectric with a tinted Schlick term.

mod base;
mod bound;
mod clearcoat;
mod solid;
mod thin;

use glam::{Vec2, Vec3};

use super::fresnel;
use super::microfacet::Microfacets;
use crate::material::Distribution;
use crate::math::{Rgb, sqr};
use base::Base;
use clearcoat::Clearcoat;
pub(crate) use solid::Solid;
pub(crate) use thin::Thin;

/// Smallest width of the facets, as in Mitsuba.
const MIN_ALPHA: f32 = 1e-3;

/// A sampled direction whose weight is still to be computed, and the index of the medium entered over that of the
/// medium left.
pub(crate) struct Drawn {
    pub(crate) wi: Vec3,
    pub(crate) eta: f32,
}

impl Drawn {
    fn unrefracted(wi: Vec3) -> Self {
        Drawn { wi, eta: 1.0 }
    }
}

/// Widths of the facets along both tangents [Burley12, 5.4].
pub(super) fn facets(roughness: f32, anisotropic: f32) -> Microfacets {
    let aspect = (1.0 - 0.9 * anisotropic).sqrt();
    let alpha = Vec2::new(sqr(roughness) / aspect, sqr(roughness) * aspect);
    Microfacets::new(Distribution::Ggx, alpha.max(Vec2::splat(MIN_ALPHA)))
}

/// A vector mirrored at the plane of the surface.
#[inline]
pub(super) fn mirrored(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}

/// Schlick's weight (1 - cos)^5 of grazing reflection.
#[inline]
fn schlick_weight(cos: f32) -> f32 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    sqr(sqr(m)) * m
}

/// The hue of a colour: the colour scaled to luminance one; white for black.
fn hue(color: Rgb) -> Rgb {
    let luminance = color.luminance();
    if luminance > 0.0 { color * (1.0 / luminance) } else { Rgb::WHITE }
}

/// Reflectance at normal incidence for a relative index.
fn normal_reflectance(eta: f32) -> f32 {
    sqr((eta - 1.0) / (eta + 1.0))
}

/// The Fresnel term of a dielectric, blended with Schlick's.
#[derive(Clone, Copy, Debug)]
struct Blended {
    /// Index inside over index outside.
    eta: f32,
    /// Fraction of Schlick's term.
    schlick: f32,
    /// Schlick's reflectance at normal incidence, already multiplied by that fraction.
    f0: Rgb,
}

impl Blended {
    /// Reflectance of a facet that is hit from outside at this cosine.
    #[inline]
    fn reflectance(&self, cos: f32) -> Rgb {
        let interface = fresnel::dielectric(cos, self.eta);
        let dielectric = (1.0 - self.schlick) * interface.reflectance;
        if self.schlick == 0.0 {
            return Rgb::grey(dielectric);
        }
        // Toward the thinner medium, the angle of the refracted direction is used.
        let w = schlick_weight(if self.eta > 1.0 { cos } else { interface.cos_t.abs() });
        Rgb::grey(dielectric + self.schlick * w) + self.f0 * (1.0 - w)
    }

    /// Upper bound of the reflectance for cosines from `cos` to 1.
    fn bound(&self, cos: f32) -> Rgb {
        // The dielectric's reflectance rises toward grazing angles. Schlick's goes from `f0` to its value at `cos`.
        let dielectric = (1.0 - self.schlick) * fresnel::dielectric(cos, self.eta).reflectance;
        (self.reflectance(cos) - Rgb::grey(dielectric)).zip(self.f0, f32::max)
            + Rgb::grey(dielectric)
    }
}
