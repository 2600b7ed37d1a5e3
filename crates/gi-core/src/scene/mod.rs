//! The scene: the contents of a file ([`SceneParts`]), prepared for rendering ([`Scene`]).

mod build;
mod focusing;
mod lighting;
mod media;
mod media_check;
mod parts;
mod primitives;
mod recentre;
mod straight;
mod surface;
mod winding;

use gi_bvh::Bvh;
use glam::{Affine3A, Mat3, Vec3};

use crate::bsdf::{Bsdf, PreparedMaterial, Transport};
use crate::geometry::{Shape, Surface};
use crate::light::Lights;
use crate::math::Bounds;
use crate::medium::Medium;
use crate::ray::{Hit, Ray};
pub use build::SceneError;
pub use parts::SceneParts;
use primitives::Primitives;
pub(crate) use straight::Line;
pub use straight::MOST_CROSSINGS;

/// A scene prepared for rendering. It never changes.
pub struct Scene {
    shapes: Vec<Shape>,
    primitives: Primitives,
    instances: Vec<PreparedInstance>,
    /// Range of shapes of each group.
    group_shapes: Vec<std::ops::Range<usize>>,
    materials: Vec<PreparedMaterial>,
    media: Vec<Medium>,
    lights: Lights,
    tree: Bvh,
    bounds: Bounds,
    hides_emitters: bool,
    origin: Vec3,
    /// Whether any surface lets light pass straight through, so that shadow rays must evaluate what they hit.
    has_null: bool,
    /// Whether any shape is the boundary of a medium.
    has_media: bool,
    /// Whether the density of any medium varies.
    has_varying_media: bool,
    /// The medium around each light; empty if the scene has no media.
    light_media: Vec<Option<crate::medium::MediumId>>,
}

/// An instance, prepared for surface points.
struct PreparedInstance {
    group: usize,
    to_world: Affine3A,
    to_local: Affine3A,
    normal_to_world: Mat3,
}

impl Scene {
    /// All shapes. Those of groups come after the others.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Number of a shape's first primitive, as in [`Surface::prim`]. Primitives are counted through all shapes.
    pub fn first_primitive(&self, shape: usize) -> u32 {
        self.primitives.first[shape]
    }

    /// Whether a material refracts light and none passes straight through it.
    pub fn refracts(&self, material: usize) -> bool {
        self.materials[material].refracts
    }

    /// All lights.
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// All media.
    pub fn media(&self) -> &[Medium] {
        &self.media
    }

    /// Whether the camera sees no light source directly, see [`SceneParts::hides_emitters`].
    #[inline]
    pub fn hides_emitters(&self) -> bool {
        self.hides_emitters
    }

    /// The part of a ray of the camera that is behind all lamps in front of the first other surface.
    #[cold]
    pub(crate) fn behind_lamps(&self, mut ray: Ray) -> Ray {
        while let Some(hit) = self.tree.closest(&ray) {
            let shape = self.primitives.all[hit.prim as usize].shape;
            if self.shapes[shape as usize].emission.is_none() {
                break;
            }
            ray = self.tree.beyond(&ray, hit.t);
        }
        ray
    }

    /// The tree that rays are traced in.
    pub fn tree(&self) -> &Bvh {
        &self.tree
    }

    /// All materials, prepared.
    pub(crate) fn prepared_materials(&self) -> &[PreparedMaterial] {
        &self.materials
    }

    /// The scene's own origin in the coordinates of its file, see [`SceneParts::recentre`].
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// The bounding box of all surfaces.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Radius of the scene's bounding sphere: the unit of relative lengths.
    pub fn radius(&self) -> f32 {
        0.5 * self.bounds.extent().length()
    }

    /// The first hit along a ray. [`Scene::surface`] turns it into a surface point.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.tree.closest(ray)
    }

    /// The first surface point along a ray, and the ray parameter there.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<(Surface, f32)> {
        let hit = self.tree.closest(ray)?;
        Some((self.surface(ray, &hit), hit.t))
    }

    /// The first hit before `tmax` along a ray that continues `line` and leaves the flat primitive `left`. The ray cannot hit that
    /// primitive again, but rounding makes it seem so for slivers. Also returns the ray that found the hit.
    #[inline]
    pub(crate) fn intersect_behind(
        &self,
        line: &mut Line,
        mut ray: Ray,
        left: Option<u32>,
        tmax: f32,
    ) -> Option<(Ray, Hit)> {
        let mut hit = self.closest_on(line, &ray, tmax)?;
        while Some(hit.prim) == left {
            ray = self.tree.beyond(&ray, hit.t);
            hit = self.closest_on(line, &ray, tmax)?;
        }
        Some((ray, hit))
    }

    /// The ray that leaves `surface` along `d`. Its origin is offset from the surface.
    #[inline]
    pub fn spawn(&self, surface: &Surface, d: Vec3) -> Ray {
        Ray::new(self.tree.offset_origin(surface.p, surface.ng, d), d)
    }

    /// The BSDF at `surface`, for a path that came from `wo`.
    #[inline]
    pub fn bsdf(&self, surface: &Surface, wo: Vec3, transport: Transport) -> Bsdf<'_> {
        let id = self.shapes[surface.shape as usize].material;
        Bsdf::resolve(&self.materials, id, surface, &|| self.tangents(surface), wo, transport)
    }

    /// Density per solid angle with which a path from the other end of the scene, which comes along `wi`, continues along `wo`.
    /// `bsdf` is that of the path with the direction `transport` from `wo` to `wi`.
    #[inline]
    pub fn reverse_pdf_w(
        &self,
        (surface, bsdf): (&Surface, &Bsdf),
        transport: Transport,
        wo: Vec3,
        wi: Vec3,
    ) -> f32 {
        bsdf.turned_pdf_w(wo, wi)
            .unwrap_or_else(|| self.bsdf(surface, wi, transport.reversed()).pdf_w(wi, wo))
    }
}
