use glam::{Vec2, Vec3};

use crate::math::Frame;

/// A point of a surface that was hit by a ray.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Position, world; computed on the primitive, not on the ray, which is more accurate.
    pub p: Vec3,
    /// Unit geometric normal, on the side of the shading normal.
    pub ng: Vec3,
    /// Shading frame: its `n` is the shading normal.
    pub frame: Frame,
    /// Texture coordinates.
    pub uv: Vec2,
    /// Index of the shape, see [`crate::scene::Scene::shapes`].
    pub shape: u32,
    /// Index of the primitive, counted through all shapes.
    pub prim: u32,
    /// The parameters u and v of [`crate::ray::Hit`]; needed for derivatives.
    pub(crate) barycentric: Vec2,
    /// Index of the instance that contains the shape.
    pub(crate) instance: u32,
}

impl Surface {
    /// The shading normal.
    #[inline]
    pub fn ns(&self) -> Vec3 {
        self.frame.n
    }
}

/// Derivatives of a surface's position with respect to its texture coordinates, world units.
#[derive(Clone, Copy, Debug)]
pub struct Tangents {
    /// With respect to u.
    pub dpdu: Vec3,
    /// With respect to v.
    pub dpdv: Vec3,
}
