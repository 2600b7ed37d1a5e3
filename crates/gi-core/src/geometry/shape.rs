use crate::medium::MediumId;
use glam::{Affine3A, Vec3};

use super::Mesh;
use crate::math::{Bounds, Frame};
use crate::texture::Texture;

/// The geometry of a shape, in world space.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// Triangles. Rectangles and cubes are meshes too: shared edges then stay watertight.
    Mesh(Mesh),
    /// A full sphere, its normal pointing outward.
    Sphere {
        /// Centre, world.
        center: Vec3,
        /// Radius, world.
        radius: f32,
        /// Orientation of the texture coordinates: u goes around `n`, v from +n (0) to -n (1).
        axes: Frame,
    },
    /// All points `center + a du + b dv` with a^2 + b^2 <= 1 (an ellipse if `du` and `dv` differ in length); the normal
    /// is du x dv.
    Disk {
        /// Centre, world.
        center: Vec3,
        /// First half axis.
        du: Vec3,
        /// Second half axis.
        dv: Vec3,
    },
    /// The side of a cylinder without caps, its normal pointing away from the axis.
    Cylinder {
        /// Centre of one end.
        p0: Vec3,
        /// Centre of the other end.
        p1: Vec3,
        /// Radius, world.
        radius: f32,
    },
}

impl Geometry {
    /// The bounding box of the shape.
    pub fn bounds(&self) -> Bounds {
        match self {
            Geometry::Mesh(mesh) => mesh.bounds(),
            Geometry::Sphere { center, radius, .. } => {
                Bounds { min: *center - Vec3::splat(*radius), max: *center + Vec3::splat(*radius) }
            }
            Geometry::Disk { center, du, dv } => {
                let reach = (*du * *du + *dv * *dv).map(f32::sqrt);
                Bounds { min: *center - reach, max: *center + reach }
            }
            Geometry::Cylinder { p0, p1, radius } => {
                let axis = (*p1 - *p0).normalize_or_zero();
                let reach = (Vec3::ONE - axis * axis).max(Vec3::ZERO).map(f32::sqrt) * *radius;
                Bounds::of([*p0 - reach, *p0 + reach, *p1 - reach, *p1 + reach])
            }
        }
    }

    /// Number of primitives of the shape in the tree: one per triangle, one for every other kind.
    pub fn primitive_count(&self) -> usize {
        match self {
            Geometry::Mesh(mesh) => mesh.triangles.len(),
            _ => 1,
        }
    }
}

/// A piece of geometry with its material and its emission.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Its name in the scene file, or its kind; for messages.
    pub name: String,
    /// Its geometry.
    pub geometry: Geometry,
    /// Index into [`crate::scene::SceneParts::materials`].
    pub material: usize,
    /// Emitted radiance on the side of the normal, if this is an area light.
    pub emission: Option<Texture>,
    /// Index into [`crate::scene::SceneParts::media`] of the medium on the side opposite to the normal.
    pub interior: Option<MediumId>,
    /// Index into [`crate::scene::SceneParts::media`] of the medium on the side of the normal.
    pub exterior: Option<MediumId>,
    /// Whether all normals are flipped.
    pub flip_normals: bool,
}

impl Shape {
    /// A shape that emits no light and separates no media.
    pub fn new(name: impl Into<String>, geometry: Geometry, material: usize) -> Self {
        let name = name.into();
        Shape {
            name,
            geometry,
            material,
            emission: None,
            interior: None,
            exterior: None,
            flip_normals: false,
        }
    }

    /// Whether the media on its two sides may differ.
    #[inline]
    pub fn is_boundary(&self) -> bool {
        self.interior.is_some() || self.exterior.is_some()
    }
}

/// A transformed copy of a group of shapes.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Index into [`crate::scene::SceneParts::groups`].
    pub group: usize,
    /// From the group's space to the world.
    pub to_world: Affine3A,
}
