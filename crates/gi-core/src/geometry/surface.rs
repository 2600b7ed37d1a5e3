use glam::{Vec2, Vec3};

use crate::math::Frame;

/// A point of a surface, as a ray met it.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Position, world; on the primitive as exactly as floats allow, not on the ray.
    pub p: Vec3,
    /// Unit geometric normal, on the side of the shading normal.
    pub ng: Vec3,
    /// Shading frame: its `n` is the shading normal.
    pub frame: Frame,
    /// Texture coordinates.
    pub uv: Vec2,
    /// Which shape, see [`crate::scene::Scene::shapes`].
    pub shape: u32,
    /// Which primitive, counted through all shapes.
    pub prim: u32,
    /// What [`crate::ray::Hit`] said; kept for derivatives.
    pub(crate) barycentric: Vec2,
    /// Which instance the shape was met in.
    pub(crate) instance: u32,
}

impl Surface {
    /// The shading normal.
    #[inline]
    pub fn ns(&self) -> Vec3 {
        self.frame.n
    }
}

/// Derivatives of a surface's position by its texture coordinates, world units.
#[derive(Clone, Copy, Debug)]
pub struct Tangents {
    /// By u.
    pub dpdu: Vec3,
    /// By v.
    pub dpdv: Vec3,
}
