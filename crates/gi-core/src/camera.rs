//! Cameras: from a point of the picture to a ray, and from a point of the world to the picture.

use glam::{Affine3A, Vec2, Vec3};

/// What a scene says about its camera. Local axes: looks along +z, +y up, **+x to the left** (as Mitsuba).
#[derive(Clone, Debug)]
pub struct CameraSpec {
    /// From camera to world.
    pub to_world: Affine3A,
    /// How points are projected.
    pub projection: Projection,
    /// Pixels across and down.
    pub size: [usize; 2],
    /// Nothing nearer is seen (world units along the axis); 0 sees all.
    pub near: f32,
    /// Shift of the picture's middle, in fractions of its width and height.
    pub principal_point_offset: Vec2,
}

/// How points are projected.
#[derive(Clone, Debug, PartialEq)]
pub enum Projection {
    /// A pinhole, or a lens when `aperture_radius` > 0.
    Perspective {
        /// Full angle of view across the picture's width, radians.
        fov_x: f32,
        /// Radius of the lens, world units.
        aperture_radius: f32,
        /// Distance along the axis of what is sharp, world units.
        focus_distance: f32,
    },
    /// Parallel rays; the picture's width is 2 units of camera space.
    Orthographic,
}

impl CameraSpec {
    /// A pinhole camera at `origin` looking at `target`.
    pub fn look_at(origin: Vec3, target: Vec3, up: Vec3, fov_x: f32, size: [usize; 2]) -> Self {
        let z = (target - origin).normalize();
        let x = up.cross(z).normalize();
        let to_world =
            Affine3A::from_mat3_translation(glam::Mat3::from_cols(x, z.cross(x), z), origin);
        let projection =
            Projection::Perspective { fov_x, aperture_radius: 0.0, focus_distance: 1.0 };
        CameraSpec { to_world, projection, size, near: 0.0, principal_point_offset: Vec2::ZERO }
    }
}
