//! A dielectric coat over a diffuse base (plastic): what depends on the material alone, tabulated once.

use glam::{Vec2, Vec3};

use super::Scatter;
use super::fresnel::{self, reflect, reflect_z};
use super::microfacet::Microfacets;
use crate::material::Distribution;
use crate::math::{INV_PI, Rgb, sqr};
use crate::warp;

/// Entries of the transmittance table over the cosine.
const TABLE: usize = 64;

/// The coat of a plastic.
#[derive(Clone, Debug)]
pub(crate) struct Coat {
    eta: f32,
    nonlinear: bool,
    /// Share of diffuse light from inside that the coat throws back.
    internal_reflectance: f32,
    rough: Option<RoughCoat>,
}

#[derive(Clone, Debug)]
struct RoughCoat {
    facets: Microfacets,
    /// Power that enters from a direction with cosine i / (TABLE - 1).
    transmittance: [f32; TABLE],
}

impl Coat {
    /// Tabulate a coat of relative index `eta`; `roughness` is its distribution and width, if rough.
    pub(crate) fn new(eta: f32, nonlinear: bool, roughness: Option<(Distribution, f32)>) -> Self {
        let Some((distribution, alpha)) = roughness else {
            let internal_reflectance = fresnel::dielectric_hemispherical(1.0 / eta);
            return Coat { eta, nonlinear, internal_reflectance, rough: None };
        };
        let facets = Microfacets::new(distribution, Vec2::splat(alpha));
        let cosine = |i: usize| (i as f32 / (TABLE - 1) as f32).max(1e-4);
        let transmittance = std::array::from_fn(|i| 1.0 - reflected_power(&facets, cosine(i), eta));
        // 2 int R(c) c dc from inside, by the midpoint rule.
        let inside = |i: usize| {
            let c = (i as f32 + 0.5) / TABLE as f32;
            reflected_power(&facets, c, 1.0 / eta) * c
        };
        let internal_reflectance = 2.0 * (0..TABLE).map(inside).sum::<f32>() / TABLE as f32;
        Coat {
            eta,
            nonlinear,
            internal_reflectance,
            rough: Some(RoughCoat { facets, transmittance }),
        }
    }

    /// Whether the coat reflects like a mirror.
    pub(crate) fn is_smooth(&self) -> bool {
        self.rough.is_none()
    }

    /// f without the cosine, both directions above.
    pub(crate) fn f(&self, wo: Vec3, wi: Vec3, diffuse: Rgb, specular: Rgb) -> Rgb {
        let thrown_back =
            |albedo: f32| if self.nonlinear { albedo } else { 1.0 } * self.internal_reflectance;
        let base = diffuse.map(|albedo| albedo / (1.0 - thrown_back(albedo)));
        let f = base * (INV_PI * self.entering(wo.z) * self.entering(wi.z) / sqr(self.eta));
        let Some(rough) = &self.rough else { return f };
        let m = (wo + wi).normalize();
        let fresnel = fresnel::dielectric(wo.dot(m), self.eta).reflectance;
        f + specular
            * (fresnel * rough.facets.d(m) * rough.facets.g(wo, wi, m) / (4.0 * wo.z * wi.z))
    }

    /// Density of [`Coat::sample`], both directions above.
    pub(crate) fn pdf_w(&self, wo: Vec3, wi: Vec3, diffuse: Rgb, specular: Rgb) -> f32 {
        let share = self.specular_share(wo, diffuse, specular);
        let base = (1.0 - share) * warp::cosine_hemisphere_pdf(wi.z);
        let Some(rough) = &self.rough else { return base };
        let m = (wo + wi).normalize();
        base + share * rough.facets.d(m) * rough.facets.g1(wo, m) / (4.0 * wo.z)
    }

    /// Draw a direction for `wo` above: a finished mirror reflection, or one still to be weighed.
    pub(crate) fn sample(
        &self,
        wo: Vec3,
        u_choice: f32,
        u: [f32; 2],
        diffuse: Rgb,
        specular: Rgb,
    ) -> Result<Scatter, Vec3> {
        let share = self.specular_share(wo, diffuse, specular);
        if u_choice >= share {
            return Err(warp::cosine_hemisphere(u));
        }
        match &self.rough {
            Some(rough) => Err(reflect(wo, rough.facets.sample_visible(wo, u))),
            None => {
                let fresnel = fresnel::dielectric(wo.z, self.eta).reflectance;
                Ok(Scatter::delta(reflect_z(wo), specular * (fresnel / share), share))
            }
        }
    }

    /// Power that enters the base from a direction above with this cosine.
    fn entering(&self, cos: f32) -> f32 {
        let Some(rough) = &self.rough else {
            return 1.0 - fresnel::dielectric(cos, self.eta).reflectance;
        };
        let x = cos.clamp(0.0, 1.0) * (TABLE - 1) as f32;
        let i = (x as usize).min(TABLE - 2);
        let f = x - i as f32;
        rough.transmittance[i] * (1.0 - f) + rough.transmittance[i + 1] * f
    }

    /// Share of samples that go to the coat's reflection.
    fn specular_share(&self, wo: Vec3, diffuse: Rgb, specular: Rgb) -> f32 {
        let entering = self.entering(wo.z);
        let (s, d) = ((1.0 - entering) * specular.mean(), entering * diffuse.mean());
        if s + d > 0.0 { s / (s + d) } else { 0.0 }
    }
}

/// Power that a rough interface reflects from a direction with this cosine, on the side where the index
/// behind over the index in front is `eta`: the mean of F(wo.m) G1(wi) over visible facets.
fn reflected_power(facets: &Microfacets, cos: f32, eta: f32) -> f32 {
    const N: usize = 24;
    let wo = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let term = |i: usize| {
        let u = [((i % N) as f32 + 0.5) / N as f32, ((i / N) as f32 + 0.5) / N as f32];
        let m = facets.sample_visible(wo, u);
        let wi = reflect(wo, m);
        if wi.z <= 0.0 {
            0.0
        } else {
            fresnel::dielectric(wo.dot(m), eta).reflectance * facets.g1(wi, m)
        }
    };
    (0..N * N).map(term).sum::<f32>() / (N * N) as f32
}
