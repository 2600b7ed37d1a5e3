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

/// Where the samples of sensors are on the film: each sensor has some pixels above each other. Bands of sensors lie one below the other,
/// so that the film of many sensors is about square: films store square tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorFilm {
    count: usize,
    samples: usize,
    /// Number of sensors in a band.
    width: usize,
}

impl SensorFilm {
    /// Number of samples from which one band does not waste tiles.
    const HIGH: usize = 16;

    /// The film of `count` sensors with `samples` pixels each. Neither may be 0.
    pub fn new(count: usize, samples: usize) -> Self {
        let square = (count * samples).isqrt().next_multiple_of(Self::HIGH);
        let width = if samples < Self::HIGH { square.min(count) } else { count };
        SensorFilm { count, samples, width }
    }

    /// Pixels across and down. The last band may have pixels to spare.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.count.div_ceil(self.width) * self.samples]
    }

    /// The sensor that a pixel belongs to. Spare pixels belong to the last one.
    pub fn sensor_at(&self, [x, y]: [usize; 2]) -> usize {
        (y / self.samples * self.width + x).min(self.count - 1)
    }

    /// The pixels of a sensor, as indices in row order. Spare pixels are left out.
    pub fn pixels_of(&self, sensor: usize) -> impl Iterator<Item = usize> + use<> {
        let SensorFilm { samples, width, .. } = *self;
        let first = sensor / width * samples * width + sensor % width;
        (0..samples).map(move |k| first + k * width)
    }
}

/// Sensors with their film.
#[derive(Clone, Debug)]
pub(super) struct Sensors {
    all: Arc<[Sensor]>,
    film: SensorFilm,
}

impl Sensors {
    fn at(&self, pixel: [usize; 2]) -> &Sensor {
        &self.all[self.film.sensor_at(pixel)]
    }
}

impl Camera {
    /// Sensors in place of a camera, with `samples` pixels each, so that a pass takes as many samples of it. The value of a pixel is the
    /// irradiance there ([`crate::eye::EyeWalk::through_pixel`]). `sensors` must not be empty.
    pub fn of_sensors(sensors: Vec<Sensor>, samples: usize) -> Self {
        let film = SensorFilm::new(sensors.len(), samples);
        Camera {
            size: film.size(),
            half: Vec2::ONE,
            offset: Vec2::ZERO,
            near: 0.0,
            aperture: 0.0,
            focus: 1.0,
            orthographic: false,
            to_world: Affine3A::IDENTITY,
            to_local: Affine3A::IDENTITY,
            pixel_area: PIXEL * PIXEL,
            sensors: Some(Sensors { all: sensors.into(), film }),
        }
    }

    /// The sensors, if they stand in place of the camera.
    pub fn sensors(&self) -> Option<&[Sensor]> {
        self.sensors.as_ref().map(|sensors| &sensors.all[..])
    }

    /// The sensor of a pixel, if sensors stand in place of the camera.
    #[inline]
    pub fn sensor_at(&self, pixel: [usize; 2]) -> Option<&Sensor> {
        self.sensors.as_ref().map(|sensors| sensors.at(pixel))
    }
}

/// A ray of the sensor whose pixel contains `film`. The position within the pixel selects the direction, with the density cos / pi.
pub(super) fn ray(sensors: &Sensors, film: [f32; 2]) -> Ray {
    let [w, h] = sensors.film.size();
    let pixel = [(film[0] as usize).min(w - 1), (film[1] as usize).min(h - 1)];
    let sensor = sensors.at(pixel);
    let u = std::array::from_fn(|k| (film[k] - pixel[k] as f32).clamp(0.0, 1.0));
    let d = Frame::from_normal(sensor.n).to_world(warp::cosine_hemisphere(u));
    Ray::new(sensor.p, d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_of_many_sensors_is_hardly_larger_than_their_samples_and_each_has_its_pixels() {
        for (count, samples) in
            [(1, 256), (3, 256), (4096, 16), (4097, 15), (65_537, 1), (1_000_003, 1)]
        {
            let film = SensorFilm::new(count, samples);
            let [w, h] = film.size();
            let stored = w.next_multiple_of(16) * h.next_multiple_of(16);
            assert!(stored <= 2 * (count * samples).max(4096), "{count} x {samples}: {w} x {h}");
            let mut taken = vec![false; w * h];
            for k in (0..count).step_by(1 + count / 5000) {
                for i in film.pixels_of(k) {
                    assert_eq!(film.sensor_at([i % w, i / w]), k);
                    assert!(!std::mem::replace(&mut taken[i], true), "{count} x {samples}: {i}");
                }
            }
            assert_eq!(film.sensor_at([w - 1, h - 1]), count - 1);
        }
    }
}
