//! Cameras: map a point of the picture to a ray, and a point of the world to the picture.

mod sensor;

use glam::{Affine3A, Vec2, Vec3};

use crate::math::sqr;
use crate::ray::Ray;
use crate::warp;
pub use sensor::{Sensor, SensorFilm};

/// A camera as the scene describes it. Local axes: it looks along +z, +y is up, **+x is to the left** (as in Mitsuba).
#[derive(Clone, Debug)]
pub struct CameraSpec {
    /// From camera to world.
    pub to_world: Affine3A,
    /// How points are projected.
    pub projection: Projection,
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Objects nearer than this are invisible (world units along the axis); 0 for no limit.
    pub near: f32,
    /// Offset of the picture's centre, in fractions of its width and height.
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
        /// Distance of the sharp plane along the axis, world units.
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

/// A camera prepared for rendering.
#[derive(Clone, Debug)]
pub struct Camera {
    size: [usize; 2],
    /// Half the picture's extent on the plane z = 1 (perspective) or in camera units (orthographic).
    half: Vec2,
    offset: Vec2,
    near: f32,
    /// Radius of the lens in camera units; 0 for a pinhole.
    aperture: f32,
    focus: f32,
    orthographic: bool,
    to_world: Affine3A,
    to_local: Affine3A,
    /// Area of a pixel on the film plane: at z = 1 for perspective, in world units for orthographic cameras.
    pixel_area: f32,
    /// If there are any, each pixel measures the irradiance of one of them, and nothing is projected.
    sensors: Option<sensor::Sensors>,
}

/// The connection of a point of the world with the camera.
#[derive(Clone, Copy, Debug)]
pub struct Connection {
    /// Position on the film, in pixels from the top left corner.
    pub film: [f32; 2],
    /// Unit direction from the point to the camera.
    pub wi: Vec3,
    /// The end of the connection: the start of the camera's ray through the point, which is on the lens if `near` is 0.
    pub end: Vec3,
    /// Factor from the power that leaves the point toward the camera per solid angle (times the cosine at the point) to
    /// the radiance of a pixel, if all of this power falls on that pixel.
    pub importance: f32,
}

impl Camera {
    /// Prepare a camera.
    pub fn new(spec: &CameraSpec) -> Self {
        let [w, h] = spec.size.map(|n| n as f32);
        let (half_x, aperture, focus, orthographic) = match spec.projection {
            Projection::Perspective { fov_x, aperture_radius, focus_distance } => {
                ((0.5 * fov_x).tan(), aperture_radius, focus_distance, false)
            }
            Projection::Orthographic => (1.0, 0.0, 1.0, true),
        };
        let half = Vec2::new(half_x, half_x * h / w);
        let m = spec.to_world.matrix3;
        let stretch = if orthographic { m.x_axis.cross(m.y_axis).length() } else { 1.0 };
        Camera {
            size: spec.size,
            half,
            offset: spec.principal_point_offset,
            near: spec.near,
            aperture,
            focus,
            orthographic,
            to_world: spec.to_world,
            to_local: spec.to_world.inverse(),
            pixel_area: 4.0 * half.x * half.y * stretch / (w * h),
            sensors: None,
        }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// The numbers that define the camera, apart from the picture's size and from [`Camera::sensors`].
    pub fn numbers(&self) -> Vec<f32> {
        let Camera { half, offset, near, aperture, focus, orthographic, to_world, .. } = self;
        let lens = [half.x, half.y, offset.x, offset.y, *near, *aperture, *focus];
        let kind = f32::from(u8::from(*orthographic));
        lens.into_iter().chain([kind]).chain(to_world.to_cols_array()).collect()
    }

    /// Whether the camera has a lens, so that [`Camera::ray`] uses its second argument.
    pub fn has_lens(&self) -> bool {
        self.aperture > 0.0
    }

    /// The ray with unit direction through the position `film` (pixels from the top left corner) and the point of the
    /// lens that `u` selects. For sensors: a ray of the sensor of this pixel, with the density cos / pi.
    #[inline(always)]
    pub fn ray(&self, film: [f32; 2], u: [f32; 2]) -> Ray {
        if let Some(sensors) = &self.sensors {
            return sensor::ray(sensors, film);
        }
        let p = self.film_to_plane(Vec2::from_array(film));
        let (o, d) = if self.orthographic {
            (p.extend(0.0), Vec3::Z)
        } else if self.aperture > 0.0 {
            let o = (warp::disk(u) * self.aperture).extend(0.0);
            (o, p.extend(1.0) * self.focus - o)
        } else {
            (Vec3::ZERO, p.extend(1.0))
        };
        // Parameters are world lengths along the unit direction.
        let axis_speed = d.z / d.length();
        let d = self.to_world.transform_vector3(d).normalize();
        Ray { tmin: self.near / axis_speed, ..Ray::new(self.to_world.transform_point3(o), d) }
    }

    /// Connect the world point `p` with the camera through the point of the lens that `u` selects. `None` if it is more
    /// than `margin` pixels outside the picture, or if sensors stand in place of the camera.
    pub fn connect(&self, p: Vec3, u: [f32; 2], margin: f32) -> Option<Connection> {
        if self.sensors.is_some() {
            return None;
        }
        let local = self.to_local.transform_point3(p);
        if local.z <= self.near.max(0.0) {
            return None;
        }
        if self.orthographic {
            let film = self.plane_to_film(local.truncate(), margin)?;
            let wi = -self.to_world.transform_vector3(Vec3::Z).normalize();
            let end = self.to_world.transform_point3(local.with_z(self.near));
            return Some(Connection { film, wi, end, importance: 1.0 / self.pixel_area });
        }
        let lens = if self.aperture > 0.0 {
            (warp::disk(u) * self.aperture).extend(0.0)
        } else {
            Vec3::ZERO
        };
        // The intersection of the ray from the lens through p with the sharp plane gives the position on the film.
        let d = local - lens;
        let sharp = lens + d * (self.focus / d.z);
        let film = self.plane_to_film(sharp.truncate() / self.focus, margin)?;
        let end = self.to_world.transform_point3(lens + d * (self.near / d.z));
        let to = self.to_world.transform_point3(lens) - p;
        let distance_sq = to.length_squared();
        let cos = d.z / d.length();
        // A pixel covers the solid angle pixel_area cos^3; the point covers 1 / d^2.
        let importance = 1.0 / (self.pixel_area * cos * sqr(cos) * distance_sq);
        Some(Connection { film, wi: to / distance_sq.sqrt(), end, importance })
    }

    /// [`Connection::importance`] of a point at this distance (world) along a ray of the camera with unit direction `d`. It is also
    /// the density with which rays through one pixel reach the point, per area perpendicular to the ray.
    pub fn importance(&self, d: Vec3, distance: f32) -> f32 {
        if self.orthographic {
            return 1.0 / self.pixel_area;
        }
        let d = self.to_local.transform_vector3(d);
        let cos = d.z / d.length();
        1.0 / (self.pixel_area * cos * sqr(cos) * sqr(distance))
    }

    /// Width of the part of a surface that a pixel covers, if the surface faces the camera, relative to its distance.
    /// For orthographic cameras, the distance counts as 1 (world).
    pub fn pixel_width(&self) -> f32 {
        self.pixel_area.sqrt()
    }

    /// Width (world) of what the central pixel covers at a distance (world) along the axis, if it faces the camera.
    pub fn pixel_width_at(&self, distance: f32) -> f32 {
        if self.sensors.is_some() {
            return self.pixel_width() * distance;
        }
        let [x, y] = self.size.map(|n| 0.5 * n as f32);
        let (a, b) = (self.ray([x - 0.5, y], [0.5; 2]), self.ray([x + 0.5, y], [0.5; 2]));
        (a.o - b.o + (a.d - b.d) * distance).length()
    }

    /// From the film to the plane z = 1: x to the left, y up.
    #[inline]
    fn film_to_plane(&self, film: Vec2) -> Vec2 {
        let [w, h] = self.size.map(|n| n as f32);
        let f = film / Vec2::new(w, h) + self.offset;
        (Vec2::ONE - f * 2.0) * self.half
    }

    #[inline]
    fn plane_to_film(&self, p: Vec2, margin: f32) -> Option<[f32; 2]> {
        let size = Vec2::from_array(self.size.map(|n| n as f32));
        let film = ((Vec2::ONE - p / self.half) * 0.5 - self.offset) * size;
        let inside = film.cmpge(Vec2::splat(-margin)).all() && film.cmplt(size + margin).all();
        inside.then_some(film.to_array())
    }
}

#[cfg(test)]
mod tests;
