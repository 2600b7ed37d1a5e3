//! How smooth, how diffuse and how opaque a lobe is. Techniques decide by this which estimator a surface gets.

use glam::Vec3;

use super::super::fresnel;
use super::super::models::{oren_nayar_constant, thin_reflectance};
use super::Lobe;
use crate::math::{INV_PI, Rgb};

impl Lobe<'_> {
    /// Transmittance for light that passes straight through, as a factor on shadow rays.
    #[inline]
    pub(crate) fn straight_through(&self, wo: Vec3) -> Rgb {
        match *self {
            Lobe::Null => Rgb::WHITE,
            Lobe::ThinDielectric { eta, transmit, .. } => {
                transmit * (1.0 - thin_reflectance(wo, eta))
            }
            _ => Rgb::BLACK,
        }
    }

    /// Width of the lobe as a microfacet alpha; 1 for lobes that cover the hemisphere, and for delta lobes.
    pub(crate) fn roughness(&self) -> f32 {
        match *self {
            Lobe::RoughConductor { facets, .. } | Lobe::RoughDielectric { facets, .. } => {
                facets.width()
            }
            Lobe::Plastic { coat, .. } => coat.roughness(),
            // The width of the Beckmann lobe with a similar falloff [Walter07].
            Lobe::Phong { specular, exponent, .. } if !specular.is_black() => {
                (2.0 / (exponent + 2.0)).sqrt()
            }
            Lobe::Principled(ref solid) => solid.roughness(),
            Lobe::PrincipledThin(ref thin) => thin.roughness(),
            _ => 1.0,
        }
    }

    /// pi times the diffuse part of f: the part that is the same, or nearly so, for all directions above. Black from
    /// below.
    pub(crate) fn diffuse_albedo(&self, wo: Vec3) -> Rgb {
        match *self {
            _ if wo.z <= 0.0 => Rgb::BLACK,
            Lobe::Diffuse { albedo } => albedo,
            Lobe::OrenNayar { albedo, sigma_sq } => albedo * oren_nayar_constant(sigma_sq),
            Lobe::Plastic { coat, diffuse, .. } => coat.diffuse_albedo(wo, diffuse),
            Lobe::Phong { diffuse, .. } => diffuse,
            Lobe::Principled(ref solid) => solid.diffuse_albedo(wo),
            Lobe::PrincipledThin(ref thin) => thin.diffuse_albedo(wo),
            _ => Rgb::BLACK,
        }
    }

    /// The diffuse part of f, exactly; [`Lobe::diffuse_albedo`] is its approximation.
    pub(crate) fn diffuse_f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        match *self {
            _ if wo.z <= 0.0 || wi.z <= 0.0 => Rgb::BLACK,
            Lobe::Plastic { coat, diffuse, .. } => coat.base_f(wo, wi, diffuse),
            Lobe::Principled(ref solid) => solid.diffuse_f(wo, wi),
            Lobe::PrincipledThin(ref thin) => thin.diffuse_f(wo, wi),
            _ => self.diffuse_albedo(wo) * INV_PI,
        }
    }

    /// The albedo at normal incidence, for the albedo layer.
    pub(crate) fn albedo(&self) -> Rgb {
        match *self {
            Lobe::Diffuse { albedo } | Lobe::OrenNayar { albedo, .. } => albedo,
            Lobe::Conductor { eta, k, tint } | Lobe::RoughConductor { eta, k, tint, .. } => {
                fresnel::conductor(1.0, eta, k) * tint
            }
            Lobe::Dielectric { reflect, transmit, .. }
            | Lobe::RoughDielectric { reflect, transmit, .. }
            | Lobe::ThinDielectric { reflect, transmit, .. } => reflect.zip(transmit, f32::max),
            Lobe::Plastic { coat, diffuse, specular } => diffuse + specular * coat.fresnel(1.0),
            Lobe::Phong { diffuse, specular, .. } => diffuse + specular,
            Lobe::Principled(ref solid) => solid.albedo(),
            Lobe::PrincipledThin(ref thin) => thin.albedo(),
            Lobe::Null => Rgb::BLACK,
        }
    }

    /// Whether sampling chooses between parts of the lobe.
    #[inline]
    pub(crate) fn has_choice(&self) -> bool {
        !matches!(
            self,
            Lobe::Diffuse { .. }
                | Lobe::OrenNayar { .. }
                | Lobe::Conductor { .. }
                | Lobe::RoughConductor { .. }
                | Lobe::Null
        )
    }

    /// Whether `f` is zero everywhere.
    #[inline]
    pub(crate) fn is_delta(&self) -> bool {
        match self {
            Lobe::Conductor { .. }
            | Lobe::Dielectric { .. }
            | Lobe::ThinDielectric { .. }
            | Lobe::Null => true,
            Lobe::Plastic { diffuse, coat, .. } => diffuse.is_black() && coat.is_smooth(),
            _ => false,
        }
    }

    /// Whether no light passes to the other side.
    #[inline]
    pub(crate) fn is_opaque(&self) -> bool {
        match self {
            Lobe::Diffuse { .. }
            | Lobe::OrenNayar { .. }
            | Lobe::Conductor { .. }
            | Lobe::RoughConductor { .. }
            | Lobe::Plastic { .. }
            | Lobe::Phong { .. } => true,
            Lobe::Principled(solid) => solid.is_opaque(),
            Lobe::PrincipledThin(thin) => thin.is_opaque(),
            Lobe::Dielectric { .. }
            | Lobe::RoughDielectric { .. }
            | Lobe::ThinDielectric { .. }
            | Lobe::Null => false,
        }
    }
}
