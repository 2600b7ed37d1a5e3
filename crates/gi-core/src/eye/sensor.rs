//! Eye paths that begin at a sensor of irradiance.

use std::f32::consts::PI;

use glam::Vec2;

use super::{EyeVertex, EyeWalk, PathLimits};
use crate::bsdf::Bsdf;
use crate::camera::Sensor;
use crate::geometry::Surface;
use crate::math::{Frame, Rgb};
use crate::ray::Ray;
use crate::sampler::Sampler;
use crate::technique::Setting;

impl<'a> EyeWalk<'a> {
    /// A path that measures the irradiance E of a sensor, which needs no surface there. The walk looks at a white Lambertian surface,
    /// whose radiance is E / pi. It samples a light there, then samples the next direction with the density cos / pi. Light that the
    /// first vertex scatters is indirect light of the sensor. `max_depth` counts the segment from the eye to the sensor as one.
    pub(super) fn at_sensor(
        setting: &Setting<'a>,
        limits: PathLimits,
        sensor: &Sensor,
        sampler: Sampler,
    ) -> Self {
        let mut walk = Self::new(setting.scene, limits, Ray::new(sensor.p, -sensor.n), sampler);
        walk.show = setting.show;
        walk.surface_layers = setting.surface_layers;
        walk.throughput = Rgb::grey(PI);
        let v = walk.vertex_of(sensor);
        walk.add_direct(&v);
        if !walk.scatter(&v) {
            // The path ends here: what it still meets counts for nothing.
            walk.throughput = Rgb::BLACK;
        }
        walk
    }

    /// A white surface in place of a sensor, seen from straight above.
    fn vertex_of(&self, sensor: &Sensor) -> EyeVertex<'a> {
        let frame = Frame::from_normal(sensor.n);
        let surface = Surface {
            p: sensor.p,
            ng: sensor.n,
            frame,
            uv: Vec2::ZERO,
            // It belongs to no shape. Only media ask for the shape, and scenes with media have no sensors.
            shape: u32::MAX,
            prim: u32::MAX,
            barycentric: Vec2::ZERO,
            instance: u32::MAX,
        };
        EyeVertex {
            surface,
            wo: sensor.n,
            bsdf: Bsdf::of_lambertian(Rgb::WHITE, frame),
            segments: self.segments,
            non_delta: 0,
            length: 0.0,
            medium: None,
            throughput: self.throughput,
            remainder: Rgb::WHITE,
            is_last: !self.limits.goes_on(self.segments),
        }
    }
}
