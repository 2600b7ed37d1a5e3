//! The surface of a body: base, facets that reflect and refract, and clearcoat.

use glam::Vec3;

use super::{Base, Blended, Clearcoat, Drawn, facets, hue, normal_reflectance};
use crate::bsdf::Transport;
use crate::bsdf::fresnel::{self, reflect, refract};
use crate::bsdf::microfacet::Microfacets;
use crate::bsdf::models::{generalized_half, rough_dielectric_f};
use crate::material::Principled;
use crate::math::{Rgb, sqr};
use crate::warp;

/// The principled model at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solid {
    pub(super) base: Base,
    /// Reflection by facets, outside.
    pub(super) front: Blended,
    /// Fraction of glass. The reflection by facets inside is this times the dielectric's reflectance.
    pub(super) glass: f32,
    /// Colour of refracted light, already multiplied by the fraction of glass.
    pub(super) transmit: Rgb,
    pub(super) facets: Microfacets,
    pub(super) coat: Clearcoat,
}

/// Fractions of the samples.
struct Shares {
    base: f32,
    coat: f32,
    facets: f32,
}

/// Smallest fraction of samples for the facets: their reflection is strong at grazing angles, even if it is weak
/// elsewhere.
const MIN_FACETS: f32 = 0.25;

impl Solid {
    /// The model for parameters in [0, 1].
    pub(crate) fn at(material: &Principled, uv: glam::Vec2) -> Self {
        let share = |t: &crate::texture::Texture| t.scalar(uv).clamp(0.0, 1.0);
        let color = material.base_color.eval(uv).map(|v| v.clamp(0.0, 1.0));
        let (metallic, trans) = (share(&material.metallic), share(&material.spec_trans));
        let roughness = share(&material.roughness);
        let (dielectric, glass) = (1.0 - metallic, (1.0 - metallic) * trans);
        let tint = dielectric * share(&material.spec_tint);
        let sheen_color = Rgb::WHITE.lerp(hue(color), share(&material.sheen_tint));
        Solid {
            base: Base {
                color: color * (dielectric * (1.0 - trans)),
                sheen: sheen_color * (share(&material.sheen) * dielectric),
                roughness,
                flatness: share(&material.flatness),
            },
            front: Blended {
                eta: material.eta,
                schlick: metallic + tint,
                f0: color * metallic + hue(color) * (tint * normal_reflectance(material.eta)),
            },
            glass,
            // Light passes two surfaces of a body; together they have its colour [Burley15, 2].
            transmit: color.map(f32::sqrt) * glass,
            facets: facets(roughness, share(&material.anisotropic)),
            coat: Clearcoat::new(share(&material.clearcoat), share(&material.clearcoat_gloss)),
        }
    }

    /// f without the cosine.
    pub(crate) fn f(&self, wo: Vec3, wi: Vec3, transport: Transport) -> Rgb {
        if wo.z > 0.0 && wi.z > 0.0 {
            let m = (wo + wi).normalize();
            let shine = self.facets.d(m) * self.facets.g(wo, wi, m) / (4.0 * wo.z * wi.z);
            return self.base.f(wo, wi)
                + self.front.reflectance(wo.dot(m)) * shine
                + Rgb::grey(self.coat.f(wo, wi, m, self.front.eta));
        }
        if self.glass == 0.0 {
            return Rgb::BLACK;
        }
        let inside = Rgb::grey(self.glass);
        rough_dielectric_f(wo, wi, self.front.eta, inside, self.transmit, &self.facets, transport)
    }

    /// Density per solid angle of [`Solid::sample`].
    pub(crate) fn pdf_w(&self, wo: Vec3, wi: Vec3) -> f32 {
        let Some(shares) = self.shares(wo) else { return 0.0 };
        let Some((m, eta)) = generalized_half(wo, wi, self.front.eta) else { return 0.0 };
        let reflected = self.reflected_share(wo, m);
        let visible = shares.facets * self.facets.visible_pdf(wo * 1f32.copysign(wo.z), m);
        let (o, i) = (wo.dot(m), wi.dot(m));
        if wo.z * wi.z < 0.0 {
            return visible * (1.0 - reflected) * sqr(eta) * i.abs() / sqr(o + eta * i);
        }
        let mut pdf_w = visible * reflected / (4.0 * i.abs());
        if wo.z > 0.0 {
            pdf_w += shares.base * warp::cosine_hemisphere_pdf(wi.z);
            if shares.coat > 0.0 {
                pdf_w += shares.coat * self.coat.pdf_w(wo, m);
            }
        }
        pdf_w
    }

    /// Sample a direction.
    pub(crate) fn sample(&self, wo: Vec3, u_choice: f32, u: [f32; 2]) -> Option<Drawn> {
        let shares = self.shares(wo)?;
        if u_choice < shares.base {
            return Some(Drawn::unrefracted(warp::cosine_hemisphere(u)));
        }
        if u_choice < shares.base + shares.coat {
            return self.coat.sample(wo, u).map(Drawn::unrefracted);
        }
        let u_facet = (u_choice - shares.base - shares.coat) / shares.facets;
        let m = self.facets.sample_visible(wo * 1f32.copysign(wo.z), u);
        // Light that facets send to the wrong side is lost, because other facets shadow it.
        if u_facet < self.reflected_share(wo, m) {
            let wi = reflect(wo, m);
            return (wi.z * wo.z > 0.0).then(|| Drawn::unrefracted(wi));
        }
        let interface = fresnel::dielectric(wo.dot(m), self.front.eta);
        let wi = refract(wo, m, interface);
        (wi.z * wo.z < 0.0).then_some(Drawn { wi, eta: interface.eta })
    }

    /// Probability of sampling reflection at facet `m`.
    fn reflected_share(&self, wo: Vec3, m: Vec3) -> f32 {
        if self.glass == 0.0 {
            return 1.0;
        }
        let cos = wo.dot(m);
        let dielectric = fresnel::dielectric(cos, self.front.eta).reflectance;
        let reflected = match wo.z > 0.0 {
            true => self.front.reflectance(cos.max(0.0)).mean(),
            false => self.glass * dielectric,
        };
        let refracted = (1.0 - dielectric) * self.transmit.mean();
        let sum = reflected + refracted;
        if sum > 0.0 { reflected / sum } else { 1.0 }
    }

    /// Sampling probabilities of the lobes; `None` if nothing is scattered.
    fn shares(&self, wo: Vec3) -> Option<Shares> {
        if wo.z <= 0.0 {
            let only_facets = Shares { base: 0.0, coat: 0.0, facets: 1.0 };
            return (wo.z < 0.0 && self.glass > 0.0).then_some(only_facets);
        }
        let base = self.base.importance();
        let coat = self.coat.importance(wo, self.front.eta);
        let reflected = self.front.reflectance(wo.z).mean();
        let dielectric = fresnel::dielectric(wo.z, self.front.eta).reflectance;
        let facets = reflected + (1.0 - dielectric) * self.transmit.mean();
        let facets = facets.max(MIN_FACETS * (facets + base + coat)).max(f32::MIN_POSITIVE);
        let scale = 1.0 / (base + coat + facets);
        Some(Shares { base: base * scale, coat: coat * scale, facets: facets * scale })
    }

    /// Width of the narrowest reflection.
    pub(crate) fn roughness(&self) -> f32 {
        self.facets.width().min(self.coat.width())
    }

    /// pi times the mean of [`Self::diffuse_f`] over the hemisphere, `wo` above.
    pub(crate) fn diffuse_albedo(&self, wo: Vec3) -> Rgb {
        self.base.mean_albedo(wo)
    }

    /// f of the diffuse part, whose radiance depends on irradiance only. Both directions are above.
    pub(crate) fn diffuse_f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.base.diffuse_f(wo, wi)
    }

    /// Estimate of the albedo at normal incidence, transmission included.
    pub(crate) fn albedo(&self) -> Rgb {
        self.base.color + self.front.reflectance(1.0) + self.transmit
    }

    /// Whether no light passes to the other side.
    pub(crate) fn is_opaque(&self) -> bool {
        self.glass == 0.0
    }
}
