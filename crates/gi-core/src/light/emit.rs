//! Where light paths begin.

use std::f32::consts::PI;

use glam::Vec3;

use super::table::spot_fade;
use super::{EmitterPoint, Light, Lights};
use crate::math::{Frame, Rgb};
use crate::warp;

/// The start of a light path.
#[derive(Clone, Copy, Debug)]
pub struct Emission {
    /// Which light.
    pub light: u32,
    /// Where the path leaves: on the light, or outside of the scene for lights at infinity.
    pub p: Vec3,
    /// Unit geometric normal at `p`; the direction itself for lights that are no surfaces.
    pub ng: Vec3,
    /// Unit direction in which the path leaves.
    pub d: Vec3,
    /// Power that the path carries: emitted radiance times cosine, already divided by all densities
    /// (choice of the light included), not by the number of paths.
    pub power: Rgb,
}

impl Lights {
    /// Begin a light path: `u_light` chooses the light, `u_p` the point on it, `u_d` the direction.
    pub(crate) fn emit(
        &self,
        u_light: f32,
        u_p: [f32; 2],
        u_d: [f32; 2],
        emission: impl Fn(u32, u32, &EmitterPoint) -> Rgb,
    ) -> Option<Emission> {
        let (light, probability, _) = self.choose(u_light)?;
        let start = |p, ng, d, power: Rgb| {
            Some(Emission { light: light as u32, p, ng, d, power: power / probability })
        };
        match &self.all()[light] {
            Light::Area { emitter, shape, primitive } => {
                let point = emitter.sample_area(u_p);
                let d = Frame::from_normal(point.normal).to_world(warp::cosine_hemisphere(u_d));
                let power = emission(*shape, *primitive, &point) * (PI * emitter.area());
                start(point.p, point.normal, d, power)
            }
            Light::Point { position, intensity } => {
                let d = warp::sphere(u_d);
                start(*position, d, d, *intensity * (4.0 * PI))
            }
            Light::Spot { position, frame, intensity, cutoff, beam } => {
                let one_minus_cos = 1.0 - cutoff.cos();
                let local = warp::cone(u_d, one_minus_cos);
                let d = frame.to_world(local);
                let fade = spot_fade(local.z, *cutoff, *beam);
                start(*position, d, d, *intensity * (fade / warp::cone_pdf(one_minus_cos)))
            }
            Light::Directional { frame, irradiance } => {
                let (p, area) = self.outside(frame.n, u_p);
                start(p, frame.n, frame.n, *irradiance * area)
            }
            Light::Constant { radiance } => {
                let d = warp::sphere(u_d);
                let (p, area) = self.outside(d, u_p);
                start(p, d, d, *radiance * (area / warp::sphere_pdf()))
            }
            Light::Environment(map) => {
                let (toward, pdf_w) = map.sample(u_d)?;
                let (p, area) = self.outside(-toward, u_p);
                start(p, -toward, -toward, map.radiance(toward) * (area / pdf_w))
            }
            Light::DistantDisc { frame, one_minus_cos, radiance } => {
                let d = -frame.to_world(warp::cone(u_d, *one_minus_cos));
                let (p, area) = self.outside(d, u_p);
                start(p, d, d, *radiance * (area / warp::cone_pdf(*one_minus_cos)))
            }
        }
    }

    /// A point of the disc through which light along `d` enters the scene's sphere, and the disc's area.
    fn outside(&self, d: Vec3, u: [f32; 2]) -> (Vec3, f32) {
        let (center, radius) = self.sphere;
        let frame = Frame::from_normal(d);
        let q = warp::disk(u) * radius;
        (center - d * radius + frame.s * q.x + frame.t * q.y, PI * radius * radius)
    }
}
