//! Samples of lights, seen from a point.

use glam::Vec3;

use super::{EmitterPoint, Light, Lights};
use crate::math::Rgb;
use crate::warp;

/// Light that arrives at a point from a sampled light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction toward the light.
    pub wi: Vec3,
    /// Position of the light; `None` at infinity.
    pub p: Option<Vec3>,
    /// Radiance that arrives if nothing is in between. For point and directional lights: irradiance on a plane
    /// perpendicular to `wi`.
    pub radiance: Rgb,
    /// Density per solid angle, including the probability of the light; for point and directional lights, the
    /// probability alone.
    pub pdf_w: f32,
    /// Whether other sampling strategies cannot find this light.
    pub delta: bool,
    /// The emitting primitive and its shape, if the light is a surface.
    pub primitive: Option<[u32; 2]>,
    /// Index of the light.
    pub light: u32,
    /// Unit geometric normal at `p` if the light is a surface, else the direction in which the light travels.
    pub ng: Vec3,
    /// Index of an environment map whose radiance is not yet looked up: it is still a factor on `radiance`.
    pub(crate) map: Option<u32>,
}

impl LightSample {
    /// Light that arrives at `p` from a point with this intensity; none at the point itself.
    #[inline]
    fn of_point(light: u32, p: Vec3, position: Vec3, intensity: Rgb) -> Option<Self> {
        let to = position - p;
        let distance_sq = to.length_squared();
        let wi = to / distance_sq.sqrt();
        (distance_sq > 0.0).then(|| LightSample {
            wi,
            p: Some(position),
            radiance: intensity / distance_sq,
            pdf_w: 1.0,
            delta: true,
            primitive: None,
            light,
            ng: -wi,
            map: None,
        })
    }
}

impl Lights {
    /// Factor on the radiance of a light sample that is not yet looked up: see [`LightSample::map`].
    #[inline]
    pub(crate) fn looked_up(&self, sample: &LightSample) -> Rgb {
        match sample.map.map(|k| &self.all()[k as usize]) {
            Some(Light::Environment(map)) => map.radiance(sample.wi),
            _ => Rgb::WHITE,
        }
    }

    /// Light that arrives at `p` from light `light`; its density per solid angle does not include the probability of
    /// the light. `emission` evaluates a shape's radiance at a point of one of its primitives. Environment maps are not
    /// looked up.
    #[inline]
    pub(crate) fn sample_light(
        &self,
        light: usize,
        p: Vec3,
        u: [f32; 2],
        emission: impl Fn(u32, u32, &EmitterPoint) -> Rgb,
    ) -> Option<LightSample> {
        let index = light as u32;
        let distant = |wi: Vec3, radiance, pdf_w| {
            let (delta, primitive, light, map) = (false, None, index, None);
            let ng = -wi;
            Some(LightSample { wi, p: None, radiance, pdf_w, delta, primitive, light, ng, map })
        };
        match &self.all()[light] {
            Light::Area { emitter, shape, primitive } => {
                let (point, pdf_w) = emitter.sample_from(p, u)?;
                let wi = (point.p - p).try_normalize()?;
                let radiance = emission(*shape, *primitive, &point);
                let primitive = Some([*shape, *primitive]);
                let (p, ng, delta, map) = (Some(point.p), point.normal, false, None);
                let light = index;
                Some(LightSample { wi, p, radiance, pdf_w, delta, primitive, light, ng, map })
            }
            Light::Point { position, intensity } => {
                LightSample::of_point(index, p, *position, *intensity)
            }
            Light::Spot { position, intensity, .. } => {
                let d = (p - *position).normalize_or_zero();
                let intensity = *intensity * self.all()[light].spot_fade(d);
                LightSample::of_point(index, p, *position, intensity)
            }
            Light::Directional { frame, irradiance } => Some(LightSample {
                wi: -frame.n,
                p: None,
                radiance: *irradiance,
                pdf_w: 1.0,
                delta: true,
                primitive: None,
                light: index,
                ng: frame.n,
                map: None,
            }),
            Light::Constant { radiance } => distant(warp::sphere(u), *radiance, warp::sphere_pdf()),
            Light::Environment(map) => {
                let (wi, pdf_w) = map.sample(u)?;
                let sample = distant(wi, Rgb::WHITE, pdf_w)?;
                Some(LightSample { map: Some(light as u32), ..sample })
            }
            Light::DistantDisc { frame, one_minus_cos, radiance } => {
                let wi = frame.to_world(warp::cone(u, *one_minus_cos));
                distant(wi, *radiance, warp::cone_pdf(*one_minus_cos))
            }
        }
    }
}
