//! The BSDF at a surface point: a material with its textures evaluated and its normals bent.
//!
//! Directions are unit, in world space, and point away from the surface: `wo` toward where the path came from, `wi`
//! toward where it continues. `f` is the BSDF without the cosine; `f_cos` includes the cosine of `wi` with the shading
//! normal. Walks use `f_cos`, because a blend may join lobes with different normals and then has no single cosine.

mod bend;
mod bound;
mod broad;
mod coat;
mod component;
mod diffuse;
mod fresnel;
mod glossy;
mod lobe;
mod microfacet;
mod models;
mod prepared;
mod principled;
mod resolve;
mod toward;

use glam::Vec3;

use crate::light::Facing;
use crate::math::{Frame, INV_PI, Rgb, sqr};
use crate::warp;
pub use bound::ScatterBound;
pub(crate) use coat::Coat;
use component::{Component, Way};
pub use diffuse::DiffusePart;
pub use fresnel::dielectric_hemispherical;
pub use glossy::{GlossyLobe, Kind, LobeView};
use lobe::Lobe;
pub(crate) use prepared::{PreparedMaterial, check_children, component_counts};
pub use toward::Toward;

/// The direction of a path. Refraction scales radiance, but not power [Veach97, 5.2].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transport {
    /// Paths from the camera: radiance is scaled.
    Radiance,
    /// Paths from a light.
    Power,
}

impl Transport {
    /// The other direction.
    pub fn reversed(self) -> Self {
        match self {
            Transport::Radiance => Transport::Power,
            Transport::Power => Transport::Radiance,
        }
    }

    /// Factor on refraction into a medium whose index is `eta` times that of the medium of `wo`.
    #[inline]
    fn refraction(self, eta: f32) -> f32 {
        match self {
            Transport::Radiance => 1.0 / sqr(eta),
            Transport::Power => 1.0,
        }
    }
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct Scatter {
    /// Direction in which the path continues.
    pub wi: Vec3,
    /// f times the cosine, divided by the density.
    pub weight: Rgb,
    /// Density per solid angle; for delta lobes, the probability of choosing this lobe.
    pub pdf_w: f32,
    /// Whether it comes from a delta lobe, so that other sampling strategies cannot find it.
    pub delta: bool,
    /// Whether the path passed straight through the surface.
    pub null: bool,
    /// Index of the medium entered over that of the medium left; 1 without refraction.
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

/// Maximum number of lobes of a material. Building the scene fails if there are more.
pub const MAX_COMPONENTS: usize = 6;

/// The BSDF at a point. Made by [`crate::scene::Scene::bsdf`].
#[derive(Clone, Debug)]
pub struct Bsdf<'a> {
    parts: Parts<'a>,
    way: Way,
}

/// Nearly all materials have one lobe. Blends are stored on the heap, so that a vertex is small and cheap to move.
#[derive(Clone, Debug)]
enum Parts<'a> {
    One(Component<'a>),
    Blend { components: Box<[Component<'a>]>, total: f32 },
}

impl<'a> Bsdf<'a> {
    /// A Lambertian surface that no material describes, on paths from the eye.
    pub(crate) fn of_lambertian(albedo: Rgb, frame: Frame) -> Self {
        let parts =
            Parts::One(Component { lobe: Lobe::Diffuse { albedo }, frame, ..Component::EMPTY });
        Bsdf { parts, way: Way { transport: Transport::Radiance, ng: frame.n } }
    }

    #[inline]
    fn components(&self) -> &[Component<'a>] {
        match &self.parts {
            Parts::One(component) => std::slice::from_ref(component),
            Parts::Blend { components, .. } => components,
        }
    }

    /// f(wo, wi) times |cos| of `wi` with the shading normal, without delta lobes. For [`Transport::Power`], where
    /// light arrives along `wo`: f times |cos(wo, ns) cos(wi, ng) / cos(wo, ng)|, because power is measured with the
    /// geometric normal [Veach97, 5.3.2].
    #[inline]
    pub fn f_cos(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.components().iter().map(|c| c.f_cos(wo, wi, self.way)).sum()
    }

    /// f(wo, wi) without the cosine and without delta lobes, for density estimates. With a bent normal: [`Bsdf::f_cos`]
    /// divided by the cosine with the unbent normal.
    #[inline]
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.components().iter().map(|c| c.f(wo, wi, self.way)).sum()
    }

    /// Density per solid angle with which [`Bsdf::sample`] returns `wi`, without delta lobes.
    #[inline]
    pub fn pdf_w(&self, wo: Vec3, wi: Vec3) -> f32 {
        match &self.parts {
            Parts::One(c) => c.pdf_w(wo, wi, self.way),
            Parts::Blend { total, .. } => {
                self.components().iter().map(|c| c.pdf_w(wo, wi, self.way)).sum::<f32>() / total
            }
        }
    }

    /// The density with which [`Bsdf::sample`] returns `wo` for a path that comes from `wi`, if it does not take the BSDF as seen
    /// from there: `None` for surfaces that look different from `wi`, or that the direction of transport changes.
    #[inline]
    pub fn turned_pdf_w(&self, wo: Vec3, wi: Vec3) -> Option<f32> {
        let simple = self.components().iter().all(|c| c.bend.is_none() && c.lobe.is_opaque());
        simple.then(|| self.pdf_w(wi, wo))
    }

    /// The albedo and the frame of the commonest BSDF, seen from the eye: a diffuse lobe without changes. It needs
    /// neither local directions nor the tests for other lobes.
    #[inline]
    fn plain_diffuse(&self) -> Option<(Rgb, &Frame)> {
        match &self.parts {
            Parts::One(Component {
                lobe: Lobe::Diffuse { albedo },
                frame,
                weight: 1.0,
                bend: None,
                part: None,
                ..
            }) if self.way.transport == Transport::Radiance => Some((*albedo, frame)),
            _ => None,
        }
    }

    /// [`Bsdf::f_cos`] and [`Bsdf::pdf_w`] together.
    #[inline]
    pub fn f_cos_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if let Some((albedo, frame)) = self.plain_diffuse() {
            let above = wo.dot(frame.n) > 0.0;
            let pdf_w = if above { warp::cosine_hemisphere_pdf(wi.dot(frame.n)) } else { 0.0 };
            return (albedo * pdf_w, pdf_w);
        }
        match &self.parts {
            Parts::One(c) if c.bend.is_none() => c.f_cos_pdf(wo, wi, self.way),
            _ => (self.f_cos(wo, wi), self.pdf_w(wo, wi)),
        }
    }

    /// Whether [`Bsdf::sample`] uses its `u_choice`.
    #[inline]
    pub fn has_choice(&self) -> bool {
        match &self.parts {
            Parts::One(c) => c.bend.is_some() || c.lobe.has_choice(),
            Parts::Blend { .. } => true,
        }
    }

    /// Sample a direction; `None` if the path is absorbed. `u_choice` chooses the lobe, `u` the direction.
    #[inline(always)]
    pub fn sample(&self, wo: Vec3, u_choice: f32, u: [f32; 2]) -> Option<Scatter> {
        if let Some((albedo, frame)) = self.plain_diffuse() {
            let wi = warp::cosine_hemisphere(u);
            let scatters = wo.dot(frame.n) > 0.0 && wi.z > 0.0;
            return scatters.then(|| Scatter::rough(frame.to_world(wi), albedo, wi.z * INV_PI));
        }
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

    /// Transmittance for light that passes straight through: a factor on shadow rays (masks, `null`, panes).
    pub fn straight_through(&self, wo: Vec3) -> Rgb {
        self.components()
            .iter()
            .map(|c| c.lobe.straight_through(c.frame.to_local(wo)) * c.weight)
            .sum()
    }

    /// Whether every lobe is a delta lobe, so that sampling lights is useless.
    pub fn is_delta(&self) -> bool {
        self.components().iter().all(|c| c.lobe.is_delta())
    }

    /// Whether the BSDF is Lambertian only, and its normal is not bent.
    pub fn is_diffuse(&self) -> bool {
        matches!(
            self.parts,
            Parts::One(Component { lobe: Lobe::Diffuse { .. }, bend: None, part: None, .. })
        )
    }

    /// Whether a normal is bent. It may then be flipped toward the direction that the BSDF was made for. Otherwise only the side of the
    /// surface that this direction is on matters.
    #[inline]
    pub fn is_bent(&self) -> bool {
        self.components().iter().any(|c| c.bend.is_some())
    }

    /// Whether the normals of all lobes equal those of `other`, which describes the same point.
    pub fn has_normals_of(&self, other: &Bsdf) -> bool {
        let mut pairs = self.components().iter().zip(other.components());
        pairs.all(|(a, b)| a.frame.n == b.frame.n)
    }

    /// The normal of an opaque surface: f is zero unless both directions are on its side. `None` if there is none.
    #[inline]
    pub fn opaque_normal(&self) -> Option<Vec3> {
        match &self.parts {
            // On light paths, a bent normal may be flipped, but this is known only once the direction to the eye is
            // known.
            Parts::One(c) if c.bend.is_some() && self.way.transport == Transport::Power => None,
            Parts::One(c) if c.lobe.is_opaque() => Some(c.frame.n),
            _ => None,
        }
    }

    /// The directions from which light is scattered toward the eye, delta lobes aside. For paths from the eye.
    pub fn facing(&self) -> Facing {
        let mut lobes = self.components().iter().filter(|c| !c.lobe.is_delta());
        let Some(first) = lobes.next() else { return Facing::Any };
        let (n, mut is_opaque) = (first.frame.n, first.lobe.is_opaque());
        for c in lobes {
            if c.frame.n != n {
                return Facing::Any;
            }
            is_opaque &= c.lobe.is_opaque();
        }
        if is_opaque { Facing::Side(n) } else { Facing::Both(n) }
    }

    /// Whether no light passes to the other side.
    pub fn is_opaque(&self) -> bool {
        self.components().iter().all(|c| c.lobe.is_opaque())
    }

    /// Roughness (microfacet alpha) of the narrowest lobe that is not a delta lobe; 1 for diffuse lobes.
    pub fn roughness(&self) -> f32 {
        self.components().iter().map(|c| c.lobe.roughness()).fold(1.0, f32::min)
    }

    /// A fast estimate of the albedo, for the albedo layer: exact for Lambertian surfaces, the reflectance at normal
    /// incidence for others. It lies in [0, 1] and does not depend on the direction of view, as denoisers expect.
    pub fn albedo(&self) -> Rgb {
        let all: Rgb = self.components().iter().map(|c| c.lobe.albedo() * c.weight).sum();
        all.map(|v| v.clamp(0.0, 1.0))
    }
}
