//! A sheet without thickness: both sides are the same, and light is not refracted.

use glam::{Vec2, Vec3};

use super::{Base, Blended, Drawn, facets, hue, mirrored, normal_reflectance};
use crate::bsdf::Transport;
use crate::bsdf::fresnel::{self, reflect};
use crate::bsdf::microfacet::Microfacets;
use crate::material::PrincipledThin;
use crate::math::{INV_PI, Rgb};
use crate::texture::Texture;
use crate::warp;

/// The principled model of a sheet at a point. The side of `wo` is above.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Thin {
    pub(super) base: Base,
    /// Albedo of diffuse transmission.
    pub(super) behind: Rgb,
    /// Fraction of the facets.
    pub(super) specular: f32,
    /// Reflection by facets, without that fraction.
    pub(super) front: Blended,
    /// Colour of the transmission by facets, already multiplied by their fraction.
    pub(super) transmit: Rgb,
    /// Facets for reflection.
    pub(super) facets: Microfacets,
    /// Facets for transmission: narrower for a small index [Burley15, fig. 15].
    pub(super) passing: Microfacets,
}

/// Fractions of the samples.
struct Shares {
    base: f32,
    behind: f32,
    reflect: f32,
    pass: f32,
}

/// Smallest fraction of the facets' samples for either side.
const MIN_SIDE: f32 = 0.25;

impl Thin {
    /// The model for parameters in [0, 1], `diff_trans` in [0, 2].
    pub(crate) fn at(material: &PrincipledThin, uv: Vec2) -> Self {
        let share = |t: &Texture| t.scalar(uv).clamp(0.0, 1.0);
        let color = material.base_color.eval(uv).map(|v| v.clamp(0.0, 1.0));
        let (specular, roughness) = (share(&material.spec_trans), share(&material.roughness));
        let behind = 0.5 * material.diff_trans.scalar(uv).clamp(0.0, 2.0);
        let eta = material.eta.scalar(uv).clamp(0.1, 10.0);
        let (tint, anisotropic) = (share(&material.spec_tint), share(&material.anisotropic));
        let reflected = (1.0 - specular) * (1.0 - behind);
        let sheen_color = Rgb::WHITE.lerp(hue(color), share(&material.sheen_tint));
        Thin {
            base: Base {
                color: color * reflected,
                sheen: sheen_color * (share(&material.sheen) * reflected),
                roughness,
                flatness: share(&material.flatness),
            },
            behind: color * ((1.0 - specular) * behind),
            specular,
            front: Blended {
                eta,
                schlick: tint,
                f0: hue(color) * (tint * normal_reflectance(eta)),
            },
            transmit: color * specular,
            facets: facets(roughness, anisotropic),
            passing: facets((0.65 * eta - 0.35) * roughness, anisotropic),
        }
    }

    /// f without the cosine.
    pub(crate) fn f(&self, wo: Vec3, wi: Vec3, transport: Transport) -> Rgb {
        if wo.z <= 0.0 || wi.z == 0.0 {
            return Rgb::BLACK;
        }
        if wi.z > 0.0 {
            let mut f = self.base.f(wo, wi);
            if self.specular > 0.0 {
                let m = (wo + wi).normalize();
                let shine = self.facets.d(m) * self.facets.g(wo, wi, m) / (4.0 * wo.z * wi.z);
                f += self.front.reflectance(wo.dot(m)) * (self.specular * shine);
            }
            return f;
        }
        let mut f = self.behind * INV_PI;
        if self.specular > 0.0 {
            f += self.passing_f(wo, mirrored(wi), transport);
        }
        f
    }

    /// f of the transmission by facets: reflected to `up` and mirrored to the other side [Burley15, 5.2]. Both
    /// directions are above.
    fn passing_f(&self, wo: Vec3, up: Vec3, transport: Transport) -> Rgb {
        let m = (wo + up).normalize();
        // As in Mitsuba 3, a facet transmits nothing if it faces away from the mirrored direction. That is the
        // direction in which the light arrives.
        let from = if transport == Transport::Radiance { up } else { wo };
        if mirrored(from).dot(m) >= 0.0 {
            return Rgb::BLACK;
        }
        let dielectric = fresnel::dielectric(wo.dot(m), self.front.eta).reflectance;
        let dg = self.passing.d(m) * self.passing.g1_seen(wo) * self.passing.g1_seen(up);
        self.transmit * ((1.0 - dielectric) * dg / (4.0 * wo.z * up.z))
    }

    /// Density per solid angle of [`Thin::sample`].
    pub(crate) fn pdf_w(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wi.z == 0.0 {
            return 0.0;
        }
        let Some(shares) = self.shares(wo) else { return 0.0 };
        let above = wi.z > 0.0;
        let (diffuse, specular, facets) = match above {
            true => (shares.base, shares.reflect, &self.facets),
            false => (shares.behind, shares.pass, &self.passing),
        };
        let up = if above { wi } else { mirrored(wi) };
        let mut pdf_w = diffuse * warp::cosine_hemisphere_pdf(up.z);
        if specular > 0.0 {
            let m = (wo + up).normalize();
            pdf_w += specular * facets.visible_pdf(wo, m) / (4.0 * wo.dot(m));
        }
        pdf_w
    }

    /// Sample a direction.
    pub(crate) fn sample(&self, wo: Vec3, u_choice: f32, u: [f32; 2]) -> Option<Drawn> {
        let Shares { base, behind, reflect: reflected, .. } = self.shares(wo)?;
        if u_choice < base {
            return Some(Drawn::unrefracted(warp::cosine_hemisphere(u)));
        }
        if u_choice < base + behind {
            return Some(Drawn::unrefracted(mirrored(warp::cosine_hemisphere(u))));
        }
        let passes = u_choice >= base + behind + reflected;
        let facets = if passes { &self.passing } else { &self.facets };
        let up = reflect(wo, facets.sample_visible(wo, u));
        // Light that facets send to the wrong side is lost, because other facets shadow it.
        (up.z > 0.0).then(|| Drawn::unrefracted(if passes { mirrored(up) } else { up }))
    }

    /// Sampling probabilities of the lobes; `None` if nothing is scattered.
    fn shares(&self, wo: Vec3) -> Option<Shares> {
        if wo.z <= 0.0 {
            return None;
        }
        let (base, behind) = (self.base.importance(), self.behind.mean());
        let reflected = self.specular * self.front.reflectance(wo.z).mean();
        let dielectric = fresnel::dielectric(wo.z, self.front.eta).reflectance;
        let passed = (1.0 - dielectric) * self.transmit.mean();
        let least = MIN_SIDE * (reflected + passed);
        let (reflected, passed) = (reflected.max(least), passed.max(least));
        let scale = 1.0 / (base + behind + reflected + passed);
        scale.is_finite().then_some(Shares {
            base: base * scale,
            behind: behind * scale,
            reflect: reflected * scale,
            pass: passed * scale,
        })
    }

    /// Width of the narrowest reflection or transmission; 1 if there are no facets.
    pub(crate) fn roughness(&self) -> f32 {
        if self.specular > 0.0 { self.facets.width().min(self.passing.width()) } else { 1.0 }
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
        let reflected = self.front.reflectance(1.0) * self.specular;
        self.base.color + self.behind + self.transmit + reflected
    }

    /// Whether no light passes to the other side.
    pub(crate) fn is_opaque(&self) -> bool {
        self.behind.is_black() && self.transmit.is_black()
    }
}
