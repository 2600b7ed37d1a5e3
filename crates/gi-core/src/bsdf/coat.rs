//! A dielectric coat over a diffuse base (plastic): tables of values that depend only on the material.

use glam::{Vec2, Vec3};

use super::Scatter;
use super::fresnel::{self, reflect, reflect_z, refract};
use super::microfacet::Microfacets;
use crate::material::Distribution;
use crate::math::{INV_PI, Rgb, sqr};
use crate::sampler::Sampler;
use crate::warp;

/// Entries of the transmittance table over the cosine.
const TABLE: usize = 64;

/// The coat of a plastic.
#[derive(Clone, Debug)]
pub(crate) struct Coat {
    eta: f32,
    nonlinear: bool,
    /// Fraction of diffuse light from inside that the coat reflects back inside.
    internal_reflectance: f32,
    /// Fraction of diffuse light from outside that enters.
    mean_entering: f32,
    rough: Option<RoughCoat>,
}

#[derive(Clone, Debug)]
struct RoughCoat {
    facets: Microfacets,
    /// Fraction of power that enters from a direction with cosine i / (TABLE - 1).
    transmittance: [f32; TABLE],
    /// For each entry, the largest transmittance up to it.
    most: [f32; TABLE],
}

impl Coat {
    /// Tabulate a coat with relative index `eta`; `roughness` is its distribution and width if it is rough.
    pub(crate) fn new(eta: f32, nonlinear: bool, roughness: Option<(Distribution, f32)>) -> Self {
        let Some((distribution, alpha)) = roughness else {
            let internal_reflectance = fresnel::dielectric_hemispherical(1.0 / eta);
            let mean_entering = 1.0 - fresnel::dielectric_hemispherical(eta);
            return Coat { eta, nonlinear, internal_reflectance, mean_entering, rough: None };
        };
        let facets = Microfacets::new(distribution, Vec2::splat(alpha));
        let cosine = |i: usize| (i as f32 / (TABLE - 1) as f32).max(1e-4);
        let transmittance = std::array::from_fn(|i| transmitted_power(&facets, cosine(i), eta));
        let mut most = transmittance;
        (1..TABLE).for_each(|i| most[i] = most[i].max(most[i - 1]));
        // 2 int R(c) c dc from inside, summed as in Mitsuba: both ends of the table have full weight, which gives 1.5 %
        // less than the integral. Plastics then have Mitsuba's albedo.
        let inside = |i: usize| reflected_power(&facets, cosine(i), 1.0 / eta) * cosine(i);
        let internal_reflectance = 2.0 * (0..TABLE).map(inside).sum::<f32>() / TABLE as f32;
        // 2 int T(c) c dc by the trapezoidal rule.
        let term = |i: usize| {
            let end = if i == 0 || i == TABLE - 1 { 0.5 } else { 1.0 };
            end * transmittance[i] * cosine(i)
        };
        let mean_entering = 2.0 * (0..TABLE).map(term).sum::<f32>() / (TABLE - 1) as f32;
        Coat {
            eta,
            nonlinear,
            internal_reflectance,
            mean_entering,
            rough: Some(RoughCoat { facets, transmittance, most }),
        }
    }

    /// Whether the coat reflects like a mirror.
    pub(crate) fn is_smooth(&self) -> bool {
        self.rough.is_none()
    }

    /// Width of the facets of its reflection; 1 if the reflection is a mirror's.
    pub(crate) fn roughness(&self) -> f32 {
        self.rough.as_ref().map_or(1.0, |rough| rough.facets.width())
    }

    /// f without the cosine, and the density of [`Coat::sample`]; both directions are above.
    #[inline]
    pub(crate) fn f_pdf(&self, wo: Vec3, wi: Vec3, diffuse: Rgb, specular: Rgb) -> (Rgb, f32) {
        let entering = self.entering(wo.z);
        let f = self.base(diffuse) * (INV_PI * entering * self.entering(wi.z));
        let share = specular_share(entering, diffuse, specular);
        let pdf_w = (1.0 - share) * warp::cosine_hemisphere_pdf(wi.z);
        let Some(rough) = &self.rough else { return (f, pdf_w) };
        let m = (wo + wi).normalize();
        let fresnel = fresnel::dielectric(wo.dot(m), self.eta).reflectance;
        let visible = rough.facets.d(m) * rough.facets.g1(wo, m) / (4.0 * wo.z);
        let reflected = fresnel * visible * rough.facets.g1(wi, m) / wi.z;
        (f + specular * reflected, pdf_w + share * visible)
    }

    /// f of the base alone; both directions are above.
    pub(crate) fn base_f(&self, wo: Vec3, wi: Vec3, diffuse: Rgb) -> Rgb {
        self.base(diffuse) * (INV_PI * self.entering(wo.z) * self.entering(wi.z))
    }

    /// pi times the base's f for `wo` above, with the transmittance averaged over the cosine-weighted hemisphere of
    /// incoming directions.
    pub(crate) fn diffuse_albedo(&self, wo: Vec3, diffuse: Rgb) -> Rgb {
        self.base(diffuse) * (self.entering(wo.z) * self.mean_entering)
    }

    /// pi times the base's f, without the transmittances of the two directions.
    fn base(&self, diffuse: Rgb) -> Rgb {
        let thrown_back =
            |albedo: f32| if self.nonlinear { albedo } else { 1.0 } * self.internal_reflectance;
        diffuse.map(|albedo| albedo / ((1.0 - thrown_back(albedo)) * sqr(self.eta)))
    }

    /// Upper bound of the base's f for `wi` with cosines up to `cos`.
    #[inline]
    pub(crate) fn base_bound(&self, wo: Vec3, cos: f32, diffuse: Rgb) -> Rgb {
        let entering = match &self.rough {
            None => self.entering(cos.max(0.0)),
            Some(rough) => {
                let i = (cos.clamp(0.0, 1.0) * (TABLE - 1) as f32).ceil() as usize;
                rough.most[i.min(TABLE - 1)]
            }
        };
        self.base(diffuse) * (INV_PI * self.entering(wo.z) * entering)
    }

    /// Facets of a rough coat.
    #[inline]
    pub(crate) fn facets(&self) -> Option<&Microfacets> {
        self.rough.as_ref().map(|r| &r.facets)
    }

    /// Reflectance of the coat at this cosine.
    #[inline]
    pub(crate) fn fresnel(&self, cos: f32) -> f32 {
        fresnel::dielectric(cos, self.eta).reflectance
    }

    /// Sample a direction for `wo` above. A mirror reflection is returned with its weight; other directions still need
    /// theirs.
    pub(crate) fn sample(
        &self,
        wo: Vec3,
        u_choice: f32,
        u: [f32; 2],
        diffuse: Rgb,
        specular: Rgb,
    ) -> Result<Scatter, Vec3> {
        let share = specular_share(self.entering(wo.z), diffuse, specular);
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

    /// Fraction of power that enters the base from a direction above with this cosine.
    fn entering(&self, cos: f32) -> f32 {
        let Some(rough) = &self.rough else {
            return 1.0 - fresnel::dielectric(cos, self.eta).reflectance;
        };
        let x = cos.clamp(0.0, 1.0) * (TABLE - 1) as f32;
        let i = (x as usize).min(TABLE - 2);
        let f = x - i as f32;
        rough.transmittance[i] * (1.0 - f) + rough.transmittance[i + 1] * f
    }
}

/// Fraction of samples for the coat's reflection, if this fraction of power enters the base.
#[inline]
fn specular_share(entering: f32, diffuse: Rgb, specular: Rgb) -> f32 {
    let (s, d) = ((1.0 - entering) * specular.mean(), entering * diffuse.mean());
    if s + d > 0.0 { s / (s + d) } else { 0.0 }
}

/// Fraction of power that a rough interface reflects from a direction with this cosine: the mean of F(wo.m) G1(wi) over
/// visible facets. `eta` is the index behind the interface over the index in front.
fn reflected_power(facets: &Microfacets, cos: f32, eta: f32) -> f32 {
    mean_over_facets(facets, cos, |wo, m| {
        let wi = reflect(wo, m);
        if wi.z <= 0.0 {
            0.0
        } else {
            fresnel::dielectric(wo.dot(m), eta).reflectance * facets.g1(wi, m)
        }
    })
}

/// Fraction of power that it transmits: the mean of (1 - F(wo.m)) G1(wi). The sum of both is below 1, because facets
/// shadow each other.
fn transmitted_power(facets: &Microfacets, cos: f32, eta: f32) -> f32 {
    mean_over_facets(facets, cos, |wo, m| {
        let interface = fresnel::dielectric(wo.dot(m), eta);
        let wi = refract(wo, m, interface);
        if wi.z >= 0.0 { 0.0 } else { (1.0 - interface.reflectance) * facets.g1(wi, m) }
    })
}

/// Mean of `value(wo, m)` over the facets that a direction with this cosine sees.
fn mean_over_facets(facets: &Microfacets, cos: f32, value: impl Fn(Vec3, Vec3) -> f32) -> f32 {
    const POINTS: u32 = 2048; // of a (0,2)-sequence: accurate to 0.1 %
    let wo = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let term = |i: u32| value(wo, facets.sample_visible(wo, Sampler::new(0, 0, i).next_2d()));
    (0..POINTS).map(term).sum::<f32>() / POINTS as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflected_power_agrees_with_an_independent_quadrature() {
        // Alpha 0.15 (GGX) and 0.3 (Beckmann), index 1.5, at cosines 0, 20/63 and 40/63 from outside, 40/63 from
        // inside.
        let expected = [
            (Distribution::Ggx, 0.15, [0.2749, 0.1361, 0.0576, 0.8127]),
            (Distribution::Beckmann, 0.3, [0.2986, 0.1203, 0.0589, 0.7224]),
        ];
        for (distribution, alpha, values) in expected {
            let facets = Microfacets::new(distribution, Vec2::splat(alpha));
            let cases =
                [(1e-6, 1.5), (20.0 / 63.0, 1.5), (40.0 / 63.0, 1.5), (40.0 / 63.0, 1.0 / 1.5)];
            for ((cos, eta), value) in cases.into_iter().zip(values) {
                let found = reflected_power(&facets, cos, eta);
                assert!(
                    (found - value).abs() < 4e-3 * value,
                    "{distribution:?}, {cos}, {eta}: {found} is not {value}"
                );
            }
        }
    }
}
