use crate::medium::MediumId;
use glam::{Affine3A, Vec3};

use super::Mesh;
use crate::math::{Bounds, Frame};
use crate::texture::Texture;

/// What a shape is made of, in world space.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// Triangles. Rectangles and cubes are meshes too: shared edges then stay watertight.
    Mesh(Mesh),
    /// A full sphere, its normal pointing outward.
    Sphere {
        /// Middle, world.
        center: Vec3,
        /// Radius, world.
        radius: f32,
        /// Orientation of the texture coordinates: u runs round `n`, v from +n (0) to -n (1).
        axes: Frame,
    },
    /// All `center + a du + b dv` with a^2 + b^2 <= 1 (an ellipse where `du`, `dv` differ); normal du x dv.
    Disk {
        /// Middle, world.
        center: Vec3,
        /// First half axis.
        du: Vec3,
        /// Second half axis.
        dv: Vec3,
    },
    /// The side of a cylinder without caps, its normal pointing away from the axis.
    Cylinder {
        /// Middle of one end.
        p0: Vec3,
        /// Middle of the other end.
        p1: Vec3,
        /// Radius, world.
        radius: f32,
    },
}

impl Geometry {
    /// The box round the shape.
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

    /// How many primitives the shape puts into the tree: one a triangle, one for every other kind.
    pub fn primitive_count(&self) -> usize {
        match self {
            Geometry::Mesh(mesh) => mesh.triangles.len(),
            _ => 1,
        }
    }
}

/// A piece of geometry with its material and what it emits.
#[derive(Clone, Debug)]
pub struct Shape {
    /// The scene file's name for it, or what kind it is; for messages.
    pub name: String,
    /// Points and normals.
    pub geometry: Geometry,
    /// Index into [`crate::scene::SceneParts::materials`].
    pub material: usize,
    /// Emitted radiance on the side of the normal, if this is an area light.
    pub emission: Option<Texture>,
    /// Index into [`crate::scene::SceneParts::media`] of what lies against the normal.
    pub interior: Option<MediumId>,
    /// Index into [`crate::scene::SceneParts::media`] of what lies on the side of the normal.
    pub exterior: Option<MediumId>,
    /// Turn all normals round.
    pub flip_normals: bool,
}

impl Shape {
    /// A shape that emits nothing and parts no media.
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

    /// Whether media may differ on its two sides.
    #[inline]
    pub fn is_boundary(&self) -> bool {
        self.interior.is_some() || self.exterior.is_some()
    }
}

/// A copy of a group of shapes somewhere else.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Index into [`crate::scene::SceneParts::groups`].
    pub group: usize,
    /// From the group's space to the world.
    pub to_world: Affine3A,
}
