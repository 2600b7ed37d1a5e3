//! Rays and hits.

use glam::Vec3;

pub use crate::offset::ShadowRays;

/// A ray segment o + t d for t in (tmin, tmax), in world units of |d|. `d` need not be unit.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Ray {
    /// Origin.
    pub o: Vec3,
    /// Hits at or before this parameter are ignored.
    pub tmin: f32,
    /// Direction.
    pub d: Vec3,
    /// Hits beyond this parameter are ignored.
    pub tmax: f32,
}

impl Ray {
    /// An unbounded ray.
    #[inline]
    pub fn new(o: Vec3, d: Vec3) -> Self {
        Ray { o, tmin: 0.0, d, tmax: f32::INFINITY }
    }

    /// The point at parameter `t`.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.o + self.d * t
    }
}

/// The point where a ray hit a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// Ray parameter.
    pub t: f32,
    /// For triangles the barycentric weight of the second vertex; solids define their own.
    pub u: f32,
    /// For triangles the barycentric weight of the third vertex; solids define their own.
    pub v: f32,
    /// Identifier of the primitive, as given when the tree was built.
    pub prim: u32,
    /// The instance that contains the primitive, or [`Hit::NO_INSTANCE`] for the scene's own primitives.
    pub instance: u32,
}

impl Hit {
    /// Value of [`Hit::instance`] outside all instances.
    pub const NO_INSTANCE: u32 = u32::MAX;
}
