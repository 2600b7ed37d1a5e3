//! Sensors that measure irradiance, in place of a camera.

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};

use super::Camera;
use crate::math::Frame;
use crate::ray::Ray;
use crate::warp;

/// A point where irradiance is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Its position, world.
    pub p: Vec3,
    /// Unit normal. Light that comes from this side counts.
    pub n: Vec3,
}

/// The angle between neighbouring pixels of a sensor, radians: what a picture of a hemisphere of this many degrees and pixels has.
/// Techniques measure spacings and radii in pixels.
const PIXEL: f32 = std::f32::consts::PI / 180.0;

impl Camera {
    /// Sensors in place of a camera: each has a column of pixels, `samples` of them, so that a pass takes as many samples of it. The
    /// value of a pixel is the irradiance there ([`crate::eye::EyeWalk::through_pixel`]). `sensors` must not be empty.
    pub fn of_sensors(sensors: Vec<Sensor>, samples: usize) -> Self {
        Camera {
            size: [sensors.len(), samples],
            half: Vec2::ONE,
            offset: Vec2::ZERO,
            near: 0.0,
            aperture: 0.0,
            focus: 1.0,
            orthographic: false,
            to_world: Affine3A::IDENTITY,
            to_local: Affine3A::IDENTITY,
            pixel_area: PIXEL * PIXEL,
            sensors: Some(sensors.into()),
        }
    }

    /// The sensors, if they stand in place of the camera.
    pub fn sensors(&self) -> Option<&Arc<[Sensor]>> {
        self.sensors.as_ref()
    }
}

/// A ray of the sensor whose column contains `film`. The position within the pixel selects the direction, with the density cos / pi.
pub(super) fn ray(sensors: &[Sensor], film: [f32; 2]) -> Ray {
    let [x, y] = film;
    let k = (x.max(0.0) as usize).min(sensors.len() - 1);
    let sensor = &sensors[k];
    let u = [x - k as f32, y - y.floor()].map(|v| v.clamp(0.0, 1.0));
    let d = Frame::from_normal(sensor.n).to_world(warp::cosine_hemisphere(u));
    Ray::new(sensor.p, d)
}
