//! The parameters of a sun and a sky.

use gi_core::math::Rgb;
use glam::{Affine3A, Vec3};

/// The parameters of a `sun`, `sky` or `sunsky`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SunSky {
    pub(crate) turbidity: f32,
    pub(crate) albedo: Rgb,
    /// Direction toward the sun, world space.
    pub(crate) sun_direction: Vec3,
    /// Factor on the sun's radiance; zero without a sun.
    pub(crate) sun_scale: f32,
    /// Factor on the sky's radiance; zero without a sky.
    pub(crate) sky_scale: f32,
    /// Angular radius of the sun, radians.
    pub(crate) angular_radius: f32,
    /// From (south, west, up) to the world.
    pub(crate) to_world: Affine3A,
    /// Whether the horizon's radiance continues below the horizon.
    pub(crate) extend: bool,
}
