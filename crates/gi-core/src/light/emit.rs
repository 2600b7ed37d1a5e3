//! The start of light paths.

use std::f32::consts::PI;

use glam::Vec3;

use super::kind::spot_fade;
use super::{EmitterPoint, Light, Lights};
use crate::math::{Frame, Rgb, one_minus_cos};
use crate::warp;

/// The start of a light path.
#[derive(Clone, Copy, Debug)]
pub struct Emission {
    /// Index of the light.
    pub light: u32,
    /// The start of the path: on the light, or outside the scene for lights at infinity.
    pub p: Vec3,
    /// Unit geometric normal at `p`; the direction itself for lights without a surface.
    pub ng: Vec3,
    /// Unit direction in which the path leaves.
    pub d: Vec3,
    /// Power of the path: emitted radiance times cosine. It is divided by all densities, including the probability of
    /// the light, but not by the number of paths.
    pub power: Rgb,
    /// The start of the path as a point light.
    pub source: PointSource,
    /// Density per solid angle of `d`, the probability of the light included, if the light is at infinity and has
    /// extent.
    pub(super) distant_pdf_w: Option<f32>,
}

/// The start of a light path as a light without extent, as the lecture's accumulation buffer uses it [slide 47]. All
/// values are divided by the densities of the light and of the point on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointSource {
    /// A point of a surface: the intensity is this times the cosine at the surface.
    Oriented(Rgb),
    /// A point with the same intensity in all directions.
    Omni(Rgb),
    /// A spot: the intensity on its axis, without its picture; see [`Light::spot_fade`].
    Spot(Rgb),
    /// Parallel light along [`Emission::d`]: irradiance on a plane perpendicular to it.
    Directional(Rgb),
}

impl Light {
    /// Intensity of a spot along the unit vector `d` relative to its full intensity, coloured by its picture; 1 for
    /// other lights.
    pub fn spot_fade(&self, d: Vec3) -> Rgb {
        match self {
            Light::Spot { frame, cutoff, beam, slide, .. } => {
                let fade = spot_fade(d, frame.n, *cutoff, *beam);
                match slide {
                    Some(slide) if fade > 0.0 => slide.along(d) * fade,
                    _ => Rgb::grey(fade),
                }
            }
            _ => Rgb::WHITE,
        }
    }
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
        self.emit_from((light, probability), u_p, u_d, emission)
    }

    /// Begin a light path at a light that was chosen with this probability.
    pub(crate) fn emit_from(
        &self,
        (light, probability): (usize, f32),
        u_p: [f32; 2],
        u_d: [f32; 2],
        emission: impl Fn(u32, u32, &EmitterPoint) -> Rgb,
    ) -> Option<Emission> {
        let start = |p, ng, d, power: Rgb, source: fn(Rgb) -> PointSource, seen: Rgb| {
            let (light, power) = (light as u32, power / probability);
            let source = source(seen / probability);
            Some(Emission { light, p, ng, d, power, source, distant_pdf_w: None })
        };
        let distant = |d, pdf_w: f32, radiance: Rgb| {
            let (p, area) = self.outside(d, u_p);
            let seen = radiance / pdf_w;
            let start = start(p, d, d, seen * area, PointSource::Directional, seen)?;
            Some(Emission { distant_pdf_w: Some(probability * pdf_w), ..start })
        };
        match &self.all()[light] {
            Light::Area { emitter, shape, primitive } => {
                let point = emitter.sample_area(u_p);
                let d = Frame::from_normal(point.normal).to_world(warp::cosine_hemisphere(u_d));
                let seen = emission(*shape, *primitive, &point) * emitter.area();
                start(point.p, point.normal, d, seen * PI, PointSource::Oriented, seen)
            }
            Light::Point { position, intensity } => {
                let d = warp::sphere(u_d);
                start(*position, d, d, *intensity * (4.0 * PI), PointSource::Omni, *intensity)
            }
            Light::Spot { position, frame, intensity, cutoff, .. } => {
                let one_minus_cos = one_minus_cos(*cutoff);
                let d = frame.to_world(warp::cone(u_d, one_minus_cos));
                let fade = self.all()[light].spot_fade(d);
                let power = *intensity * fade * (1.0 / warp::cone_pdf(one_minus_cos));
                start(*position, d, d, power, PointSource::Spot, *intensity)
            }
            Light::Directional { frame, irradiance } => {
                let (p, area) = self.outside(frame.n, u_p);
                let source = PointSource::Directional;
                start(p, frame.n, frame.n, *irradiance * area, source, *irradiance)
            }
            Light::Constant { radiance } => {
                distant(warp::sphere(u_d), warp::sphere_pdf(), *radiance)
            }
            Light::Environment(map) => {
                let (toward, pdf_w) = map.sample(u_d)?;
                distant(-toward, pdf_w, map.radiance(toward))
            }
            Light::DistantDisc { frame, one_minus_cos, radiance } => {
                let d = -frame.to_world(warp::cone(u_d, *one_minus_cos));
                distant(d, warp::cone_pdf(*one_minus_cos), *radiance)
            }
        }
    }

    /// Sample a point of the disc through which light along `d` enters the scene's bounding sphere; also returns the
    /// area of the disc.
    fn outside(&self, d: Vec3, u: [f32; 2]) -> (Vec3, f32) {
        let (center, radius) = self.sphere;
        let frame = Frame::from_normal(d);
        let q = warp::disk(u) * radius;
        (center - d * radius + frame.s * q.x + frame.t * q.y, PI * radius * radius)
    }

    /// The point on the line through `q` where light along `d` enters the scene's bounding sphere, or the nearest point
    /// if it misses the sphere.
    pub(super) fn entrance(&self, q: Vec3, d: Vec3) -> Vec3 {
        let (center, radius) = self.sphere;
        q + d * ((center - q).dot(d) - radius)
    }
}
