//! A scattering lobe in its own frame: its value, its density and its samples. All materials become one or more lobes.
//! Each method is one match over all lobes. `kind.rs` tells how smooth, how diffuse and how opaque a lobe is.

mod kind;

use glam::Vec3;

use super::coat::Coat;
use super::fresnel::{self, reflect, reflect_z};
use super::microfacet::Microfacets;
use super::models::{
    oren_nayar, phong_share, rough_dielectric_f, rough_dielectric_pdf, sample_dielectric,
    sample_phong, sample_rough_dielectric, thin_reflectance,
};
use super::principled::{Drawn, Solid, Thin};
use super::{Scatter, Transport};
use crate::math::{INV_PI, Rgb};
use crate::warp;

/// A lobe with its parameters read from the textures. Directions are local, z along the normal.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Lobe<'a> {
    Diffuse {
        albedo: Rgb,
    },
    OrenNayar {
        albedo: Rgb,
        sigma_sq: f32,
    },
    Conductor {
        eta: Rgb,
        k: Rgb,
        tint: Rgb,
    },
    RoughConductor {
        eta: Rgb,
        k: Rgb,
        tint: Rgb,
        facets: Microfacets,
    },
    Dielectric {
        eta: f32,
        reflect: Rgb,
        transmit: Rgb,
    },
    RoughDielectric {
        eta: f32,
        reflect: Rgb,
        transmit: Rgb,
        facets: Microfacets,
    },
    ThinDielectric {
        eta: f32,
        reflect: Rgb,
        transmit: Rgb,
    },
    Plastic {
        coat: &'a Coat,
        diffuse: Rgb,
        specular: Rgb,
    },
    Phong {
        diffuse: Rgb,
        specular: Rgb,
        exponent: f32,
    },
    Principled(Solid),
    /// A thin sheet. Its frame is flipped to the side of `wo`.
    PrincipledThin(Thin),
    Null,
}

impl Lobe<'_> {
    /// f without the cosine; zero for delta lobes and on the wrong side.
    #[inline]
    pub(crate) fn f(&self, wo: Vec3, wi: Vec3, transport: Transport) -> Rgb {
        let above = wo.z > 0.0 && wi.z > 0.0;
        match *self {
            Lobe::Diffuse { albedo } if above => albedo * INV_PI,
            Lobe::OrenNayar { albedo, sigma_sq } if above => {
                albedo * (oren_nayar(wo, wi, sigma_sq) * INV_PI)
            }
            Lobe::RoughConductor { .. } => self.f_pdf(wo, wi, transport).0,
            Lobe::RoughDielectric { eta, reflect, transmit, facets } => {
                rough_dielectric_f(wo, wi, eta, reflect, transmit, &facets, transport)
            }
            Lobe::Plastic { coat, diffuse, specular } if above => {
                coat.f_pdf(wo, wi, diffuse, specular).0
            }
            Lobe::Phong { diffuse, specular, exponent } if above => {
                let lobe =
                    (exponent + 2.0) * 0.5 * INV_PI * reflect_z(wo).dot(wi).max(0.0).powf(exponent);
                diffuse * INV_PI + specular * lobe
            }
            Lobe::Principled(ref solid) => solid.f(wo, wi, transport),
            Lobe::PrincipledThin(ref thin) => thin.f(wo, wi, transport),
            _ => Rgb::BLACK,
        }
    }

    /// [`Lobe::f`] and [`Lobe::pdf_w`] together. Lobes with facets compute most of both only once.
    #[inline]
    pub(crate) fn f_pdf(&self, wo: Vec3, wi: Vec3, transport: Transport) -> (Rgb, f32) {
        match *self {
            Lobe::Diffuse { .. } => (self.f(wo, wi, transport), self.pdf_w(wo, wi)),
            _ if self.is_opaque() && (wo.z <= 0.0 || wi.z <= 0.0) => (Rgb::BLACK, 0.0),
            Lobe::RoughConductor { eta, k, tint, facets } => {
                let m = (wo + wi).normalize();
                let visible = facets.d(m) * facets.g1(wo, m) / (4.0 * wo.z);
                let fresnel = fresnel::conductor(wi.dot(m).clamp(0.0, 1.0), eta, k);
                (fresnel * tint * (visible * facets.g1(wi, m) / wi.z), visible)
            }
            Lobe::Plastic { coat, diffuse, specular } => coat.f_pdf(wo, wi, diffuse, specular),
            _ => (self.f(wo, wi, transport), self.pdf_w(wo, wi)),
        }
    }

    /// Density per solid angle with which [`Lobe::sample`] returns `wi`; zero for delta lobes.
    #[inline]
    pub(crate) fn pdf_w(&self, wo: Vec3, wi: Vec3) -> f32 {
        let above = wo.z > 0.0 && wi.z > 0.0;
        match *self {
            Lobe::Diffuse { .. } | Lobe::OrenNayar { .. } if above => {
                warp::cosine_hemisphere_pdf(wi.z)
            }
            Lobe::RoughConductor { facets, .. } if above => {
                let m = (wo + wi).normalize();
                facets.d(m) * facets.g1(wo, m) / (4.0 * wo.z)
            }
            Lobe::RoughDielectric { eta, facets, .. } => rough_dielectric_pdf(wo, wi, eta, &facets),
            Lobe::Plastic { coat, diffuse, specular } if above => {
                coat.f_pdf(wo, wi, diffuse, specular).1
            }
            Lobe::Phong { diffuse, specular, exponent } if above => {
                let share = phong_share(diffuse, specular);
                let lobe =
                    (exponent + 1.0) * 0.5 * INV_PI * reflect_z(wo).dot(wi).max(0.0).powf(exponent);
                share * lobe + (1.0 - share) * warp::cosine_hemisphere_pdf(wi.z)
            }
            Lobe::Principled(ref solid) => solid.pdf_w(wo, wi),
            Lobe::PrincipledThin(ref thin) => thin.pdf_w(wo, wi),
            _ => 0.0,
        }
    }

    /// Sample a direction. `u_choice` chooses between the parts of a lobe, `u` the direction within a part.
    #[inline]
    pub(crate) fn sample(
        &self,
        wo: Vec3,
        u_choice: f32,
        u: [f32; 2],
        transport: Transport,
    ) -> Option<Scatter> {
        match *self {
            Lobe::Diffuse { albedo } => {
                let wi = warp::cosine_hemisphere(u);
                (wo.z > 0.0 && wi.z > 0.0).then(|| Scatter::rough(wi, albedo, wi.z * INV_PI))
            }
            Lobe::Conductor { eta, k, tint } => (wo.z > 0.0).then(|| {
                Scatter::delta(reflect_z(wo), fresnel::conductor(wo.z.min(1.0), eta, k) * tint, 1.0)
            }),
            Lobe::RoughConductor { facets, .. } => {
                let wi = reflect(wo, facets.sample_visible(wo * 1f32.copysign(wo.z), u));
                self.weighted(wo, wi, transport)
            }
            Lobe::Dielectric { eta, reflect, transmit } => {
                sample_dielectric(wo, u_choice, eta, reflect, transmit, transport)
            }
            Lobe::RoughDielectric { eta, facets, .. } => {
                let drawn = sample_rough_dielectric(wo, u_choice, u, eta, &facets)?;
                self.weighted_drawn(wo, drawn, transport)
            }
            Lobe::ThinDielectric { eta, reflect, transmit } => {
                let r = thin_reflectance(wo, eta);
                Some(if u_choice < r {
                    Scatter::delta(reflect_z(wo), reflect, r)
                } else {
                    Scatter { null: true, ..Scatter::delta(-wo, transmit, 1.0 - r) }
                })
            }
            Lobe::Plastic { coat, diffuse, specular } => {
                match (wo.z > 0.0).then(|| coat.sample(wo, u_choice, u, diffuse, specular))? {
                    Ok(delta) => Some(delta),
                    Err(wi) => self.weighted(wo, wi, transport),
                }
            }
            Lobe::OrenNayar { .. } => self.weighted(wo, warp::cosine_hemisphere(u), transport),
            Lobe::Phong { diffuse, specular, exponent } => {
                let in_lobe = u_choice < phong_share(diffuse, specular);
                let wi = if in_lobe {
                    sample_phong(wo, u, exponent)
                } else {
                    warp::cosine_hemisphere(u)
                };
                self.weighted(wo, wi, transport)
            }
            Lobe::Principled(ref solid) => {
                self.weighted_drawn(wo, solid.sample(wo, u_choice, u)?, transport)
            }
            Lobe::PrincipledThin(ref thin) => {
                self.weighted_drawn(wo, thin.sample(wo, u_choice, u)?, transport)
            }
            Lobe::Null => Some(Scatter { null: true, ..Scatter::delta(-wo, Rgb::WHITE, 1.0) }),
        }
    }

    /// Compute the weight of a direction that was sampled with density [`Lobe::pdf_w`].
    #[inline]
    fn weighted(&self, wo: Vec3, wi: Vec3, transport: Transport) -> Option<Scatter> {
        let (f, pdf_w) = self.f_pdf(wo, wi, transport);
        (pdf_w > 0.0).then(|| Scatter::rough(wi, f * (wi.z.abs() / pdf_w), pdf_w))
    }

    /// The same for a direction that may be refracted.
    fn weighted_drawn(&self, wo: Vec3, drawn: Drawn, transport: Transport) -> Option<Scatter> {
        let scatter = self.weighted(wo, drawn.wi, transport)?;
        Some(Scatter { eta: drawn.eta, ..scatter })
    }
}
