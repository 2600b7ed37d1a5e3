//! How light scatters at a point of a surface: a material with its textures read and its normals bent.
//!
//! Directions are unit, in world space, and point away from the surface: `wo` toward where the path came from,
//! `wi` toward where it goes on. `f` is the BSDF without the cosine; `f_cos` has the cosine of `wi` with the
//! shading normal in it. (A blend may join lobes whose normals were bent differently, so there is no
//! one cosine to multiply afterwards; walks use `f_cos`.)

mod bend;
mod bound;
mod broad;
mod coat;
mod component;
mod fresnel;
mod glossy;
mod lobe;
mod microfacet;
mod prepared;
mod principled;
mod resolve;

use glam::Vec3;

use crate::math::{Rgb, sqr};
pub use bound::{ScatterBound, Toward};
pub(crate) use coat::Coat;
use component::{Component, Way};
pub use fresnel::dielectric_hemispherical;
pub use glossy::{GlossyLobe, Kind, LobeView};
use lobe::Lobe;
pub(crate) use prepared::{PreparedMaterial, check_children, component_count};

/// Which way a path runs. Refraction squeezes radiance but not power [Veach97, 5.2].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transport {
    /// Paths from the eye carry importance backwards: radiance is what is scaled.
    Radiance,
    /// Paths from a light.
    Power,
}

impl Transport {
    /// Factor on refraction into a medium whose index is `eta` times the one that `wo` is in.
    #[inline]
    fn refraction(self, eta: f32) -> f32 {
        match self {
            Transport::Radiance => 1.0 / sqr(eta),
            Transport::Power => 1.0,
        }
    }
}

/// A drawn direction.
#[derive(Clone, Copy, Debug)]
pub struct Scatter {
    /// Where the path goes on.
    pub wi: Vec3,
    /// f times cosine over density.
    pub weight: Rgb,
    /// Density per solid angle; for delta lobes the probability of having chosen this one.
    pub pdf_w: f32,
    /// Whether the direction is one of finitely many: no other way of sampling can find it.
    pub delta: bool,
    /// Whether the path passed straight through as if nothing were there.
    pub null: bool,
    /// Index of the medium entered over that of the medium left; 1 unless refracted.
    pub eta: f32,
}

impl Scatter {
    #[inline]
    fn rough(wi: Vec3, weight: Rgb, pdf_w: f32) -> Self {
        Scatter { wi, weight, pdf_w, delta: false, null: false, eta: 1.0 }
    }

    #[inline]
    fn delta(wi: Vec3, weight: Rgb, probability: f32) -> Self {
        Scatter { wi, weight, pdf_w: probability, delta: true, null: false, eta: 1.0 }
    }
}

/// The diffuse part of a BSDF for one `wo`: what irradiance alone answers for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffusePart {
    /// Its albedo: pi times its f, or the mean of that over the cosine-weighted hemisphere.
    pub albedo: Rgb,
    /// Unit normal that its cosine is taken with, on the side of `wo`.
    pub normal: Vec3,
}

/// Most lobes that a material may blend; deeper ones are refused when the scene is made.
pub const MAX_COMPONENTS: usize = 6;

/// (whole - part) / whole, nothing where they differ by rounding only.
#[inline]
fn share_left(whole: f32, part: f32) -> f32 {
    let left = if whole > 0.0 { 1.0 - part / whole } else { 0.0 };
    if left < 1e-5 { 0.0 } else { left }
}

/// The BSDF at a point. Made by [`crate::scene::Scene::bsdf`].
#[derive(Clone, Debug)]
pub struct Bsdf<'a> {
    parts: Parts<'a>,
    way: Way,
}

/// Nearly all materials are one lobe. Blends are on the heap, so that a vertex is small and cheap to move.
#[derive(Clone, Debug)]
enum Parts<'a> {
    One(Component<'a>),
    Blend { components: Box<[Component<'a>]>, total: f32 },
}

impl<'a> Bsdf<'a> {
    #[inline]
    fn components(&self) -> &[Component<'a>] {
        match &self.parts {
            Parts::One(component) => std::slice::from_ref(component),
            Parts::Blend { components, .. } => components,
        }
    }

    /// f(wo, wi) times |cos| of `wi` with the shading normal. Delta lobes are not in it. For [`Transport::Power`], where
    /// light arrives along `wo`, f times |cos(wo, ns) cos(wi, ng) / cos(wo, ng)|: power is counted by the geometric normal
    /// [Veach97, 5.3.2].
    #[inline]
    pub fn f_cos(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.components().iter().map(|c| c.f_cos(wo, wi, self.way)).sum()
    }

    /// f(wo, wi) without the cosine, as density estimates want it: where a map bends the normal, [`Bsdf::f_cos`] over the
    /// cosine with the unbent one. Delta lobes are not in it.
    #[inline]
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.components().iter().map(|c| c.f(wo, wi, self.way)).sum()
    }

    /// Density per solid angle with which [`Bsdf::sample`] returns `wi`, delta lobes apart.
    #[inline]
    pub fn pdf_w(&self, wo: Vec3, wi: Vec3) -> f32 {
        match &self.parts {
            Parts::One(c) => c.pdf_w(wo, wi, self.way),
            Parts::Blend { total, .. } => {
                self.components().iter().map(|c| c.pdf_w(wo, wi, self.way)).sum::<f32>() / total
            }
        }
    }

    /// [`Bsdf::f_cos`] and [`Bsdf::pdf_w`] at once.
    #[inline]
    pub fn f_cos_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        match &self.parts {
            Parts::One(c) if c.bend.is_none() => c.f_cos_pdf(wo, wi, self.way),
            _ => (self.f_cos(wo, wi), self.pdf_w(wo, wi)),
        }
    }

    /// Whether [`Bsdf::sample`] has something to choose between; its `u_choice` is not looked at otherwise.
    #[inline]
    pub fn has_choice(&self) -> bool {
        match &self.parts {
            Parts::One(c) => c.bend.is_some() || c.lobe.has_choice(),
            Parts::Blend { .. } => true,
        }
    }

    /// Draw where a path goes on; `None` where it ends. `u_choice` chooses between lobes, `u` within one.
    #[inline]
    pub fn sample(&self, wo: Vec3, u_choice: f32, u: [f32; 2]) -> Option<Scatter> {
        match &self.parts {
            Parts::One(c) => {
                let mut s = c.sample(wo, u_choice, u, self.way)?;
                s.weight *= c.weight;
                Some(s)
            }
            Parts::Blend { total, .. } => self.sample_blend(wo, u_choice, u, *total),
        }
    }

    fn sample_blend(&self, wo: Vec3, u_choice: f32, u: [f32; 2], total: f32) -> Option<Scatter> {
        let mut rest = u_choice * total;
        let components = self.components();
        let chosen = components.iter().find(|c| {
            let here = rest < c.weight;
            if !here {
                rest -= c.weight;
            }
            here
        });
        let c = chosen.or(components.last())?;
        let u_within = (rest / c.weight).clamp(0.0, 1.0 - f32::EPSILON);
        let mut s = c.sample(wo, u_within, u, self.way)?;
        if s.delta {
            s.weight *= total;
            s.pdf_w *= c.weight / total;
            return Some(s);
        }
        let (f_cos, pdf_w) = self.f_cos_pdf(wo, s.wi);
        (pdf_w > 0.0).then(|| Scatter { eta: s.eta, ..Scatter::rough(s.wi, f_cos / pdf_w, pdf_w) })
    }

    /// What passes straight through, as a factor on shadow rays (masks, `null`, panes).
    pub fn straight_through(&self, wo: Vec3) -> Rgb {
        self.components()
            .iter()
            .map(|c| c.lobe.straight_through(c.frame.to_local(wo)) * c.weight)
            .sum()
    }

    /// Whether every lobe is a delta lobe, so that light sampling finds nothing.
    pub fn is_delta(&self) -> bool {
        self.components().iter().all(|c| c.lobe.is_delta())
    }

    /// Whether the Lambertian part is all that there is, and its normal is not bent.
    pub fn is_diffuse(&self) -> bool {
        matches!(
            self.parts,
            Parts::One(Component { lobe: Lobe::Diffuse { .. }, bend: None, part: None, .. })
        )
    }

    /// The normal above which both directions must lie for light to pass between them; `None` where it may pass otherwise.
    #[inline]
    pub fn opaque_normal(&self) -> Option<Vec3> {
        match &self.parts {
            // On light paths a bent normal may be flipped, which is known only with the direction to the eye.
            Parts::One(c) if c.bend.is_some() && self.way.transport == Transport::Power => None,
            Parts::One(c) if c.lobe.is_opaque() => Some(c.frame.n),
            _ => None,
        }
    }

    /// Whether nothing passes to the other side.
    pub fn is_opaque(&self) -> bool {
        self.components().iter().all(|c| c.lobe.is_opaque())
    }

    /// Width of the narrowest lobe that is no delta lobe: alpha of its facets, 1 for diffuse ones.
    pub fn roughness(&self) -> f32 {
        self.components().iter().map(|c| c.lobe.roughness()).fold(1.0, f32::min)
    }

    /// The diffuse part, `None` where there is none: all of a diffuse surface, the base of a plastic with the mean of
    /// what its coat lets in, what is constant in other lobes. Of a blend whose normals differ, those alike the first.
    pub fn diffuse_part(&self, wo: Vec3) -> Option<DiffusePart> {
        let mut part: Option<DiffusePart> = None;
        for c in self.components() {
            let local = c.frame.to_local(wo);
            let albedo = c.lobe.diffuse_albedo(local) * (c.weight * c.mean_unshadowed());
            if albedo.is_black() || c.bend.is_some_and(|b| !b.is_seen(&c.frame, wo)) {
                continue;
            }
            let normal = c.frame.n;
            match &mut part {
                None => part = Some(DiffusePart { albedo, normal }),
                Some(part) if part.normal == normal => part.albedo += albedo,
                Some(_) => {}
            }
        }
        part
    }

    /// The share of [`Bsdf::f_cos`] that [`Bsdf::diffuse_part`] does not stand for. The base of a plastic counts as stood for,
    /// though its coat lets in a little more from above and less from the side than the mean.
    pub fn beside_diffuse(&self, part: &DiffusePart, wo: Vec3, wi: Vec3) -> Rgb {
        let diffuse = |c: &Component| {
            let unshadowed = c.bend.map_or(1.0, |b| b.unshadowed(&c.frame, wo, wi));
            let (wo, wi) = (c.frame.to_local(wo), c.frame.to_local(wi));
            c.lobe.diffuse_f(wo, wi) * (wi.z.max(0.0) * c.weight * unshadowed)
        };
        let alike = self.components().iter().filter(|c| c.frame.n == part.normal);
        let diffuse: Rgb = alike.map(diffuse).sum();
        self.f_cos(wo, wi).zip(diffuse, share_left)
    }

    /// [`Bsdf::diffuse_part`] of a surface that is Lambertian and nothing else, its normal not bent.
    #[inline]
    pub fn diffuse_only(&self, wo: Vec3) -> Option<DiffusePart> {
        match &self.parts {
            Parts::One(Component {
                lobe: Lobe::Diffuse { albedo },
                weight,
                frame,
                bend: None,
                part: None,
                ..
            }) => {
                let lit = wo.dot(frame.n) > 0.0;
                let albedo = if lit { *albedo * *weight } else { Rgb::BLACK };
                Some(DiffusePart { albedo, normal: frame.n })
            }
            _ => None,
        }
    }

    /// The albedo of a surface that is Lambertian and nothing else; black from behind.
    #[inline]
    pub fn lambertian(&self, wo: Vec3) -> Option<Rgb> {
        self.diffuse_only(wo).map(|part| part.albedo)
    }

    /// A fast estimate of the reflected share of light from `wo`, for the albedo layer: exact for Lambert,
    /// the colour of the reflection elsewhere.
    pub fn albedo_hint(&self, wo: Vec3) -> Rgb {
        self.components().iter().map(|c| c.lobe.albedo_hint(c.frame.to_local(wo)) * c.weight).sum()
    }
}
