//! The kinds of light. Each method is one match over all of them.

use std::f32::consts::PI;

use glam::{Mat3, Vec3};

use super::{Emitter, Environment, LightSource, Slide};
use crate::geometry::Shape;
use crate::math::{Frame, Rgb, one_minus_cos, sqr};
use crate::warp;

/// A light, prepared for sampling.
#[derive(Clone, Debug)]
pub enum Light {
    /// A primitive of a shape.
    Area {
        /// Its geometry.
        emitter: Emitter,
        /// Index of the shape whose emission it has.
        shape: u32,
        /// Index of the primitive in the shape.
        primitive: u32,
    },
    /// A point.
    Point {
        /// Position.
        position: Vec3,
        /// Power per steradian.
        intensity: Rgb,
    },
    /// A cone of light from a point.
    Spot {
        /// Position.
        position: Vec3,
        /// Frame whose normal is the axis.
        frame: Frame,
        /// Power per steradian inside the beam.
        intensity: Rgb,
        /// Half angle of the cone, radians.
        cutoff: f32,
        /// Half angle of full intensity, radians.
        beam: f32,
        /// The picture in front of it.
        slide: Option<Box<Slide>>,
    },
    /// Parallel light.
    Directional {
        /// Frame whose normal is the direction in which the light travels.
        frame: Frame,
        /// Irradiance on a plane perpendicular to it.
        irradiance: Rgb,
    },
    /// The same radiance from all directions.
    Constant {
        /// Radiance.
        radiance: Rgb,
    },
    /// A picture at infinity.
    Environment(Box<Environment>),
    /// A disc at infinity.
    DistantDisc {
        /// Frame whose normal points to its centre.
        frame: Frame,
        /// 1 - cos of its angular radius.
        one_minus_cos: f32,
        /// Radiance.
        radiance: Rgb,
    },
}

impl Light {
    pub(super) fn from_source(source: LightSource) -> Self {
        match source {
            LightSource::Point { position, intensity } => Light::Point { position, intensity },
            LightSource::Spot { position, direction, intensity, cutoff, beam } => Light::Spot {
                position,
                frame: Frame::from_normal(direction),
                intensity,
                cutoff,
                beam,
                slide: None,
            },
            LightSource::Projector { position, axes, intensity, cutoff, beam, picture, window } => {
                Light::Spot {
                    position,
                    frame: Frame::from_normal(axes[2].normalize_or(Vec3::Z)),
                    intensity,
                    cutoff,
                    beam,
                    slide: Some(Box::new(Slide::new(picture, axes, cutoff, window))),
                }
            }
            LightSource::Directional { direction, irradiance } => {
                Light::Directional { frame: Frame::from_normal(direction), irradiance }
            }
            LightSource::Constant { radiance } => Light::Constant { radiance },
            LightSource::Environment { image, scale, to_world } => {
                // Only the rotation of the map matters: light at infinity has no scale.
                let m = Mat3::from(to_world.matrix3);
                let rotation = Mat3::from_cols(
                    m.x_axis.normalize(),
                    m.y_axis.normalize(),
                    m.z_axis.normalize(),
                );
                Light::Environment(Box::new(Environment::new(image, scale, rotation)))
            }
            LightSource::DistantDisc { direction, angular_radius, radiance } => {
                let one_minus_cos = one_minus_cos(angular_radius);
                Light::DistantDisc { frame: Frame::from_normal(direction), one_minus_cos, radiance }
            }
        }
    }

    /// Whether the light is at infinity and visible to rays that leave the scene.
    pub(super) fn is_distant(&self) -> bool {
        matches!(self, Light::Constant { .. } | Light::Environment(_) | Light::DistantDisc { .. })
    }

    /// Whether its light comes from outside the scene.
    pub fn is_infinite(&self) -> bool {
        self.is_distant() || matches!(self, Light::Directional { .. })
    }

    /// Radiance of a light at infinity from direction `d`, and the density per solid angle of sampling that direction.
    #[inline]
    pub(crate) fn escaped(&self, d: Vec3) -> (Rgb, f32) {
        match self {
            Light::Constant { radiance } => (*radiance, warp::sphere_pdf()),
            Light::Environment(map) => (map.radiance(d), map.pdf_w(d)),
            // Compute 1 - cos as half the squared distance of unit vectors, which is accurate for a narrow disc.
            Light::DistantDisc { frame, one_minus_cos, radiance }
                if 0.5 * d.distance_squared(frame.n) <= *one_minus_cos =>
            {
                (*radiance, warp::cone_pdf(*one_minus_cos))
            }
            _ => (Rgb::BLACK, 0.0),
        }
    }

    /// Intensity of a spot within its beam, averaged over its picture, as luminance; 0 for other lights.
    pub(super) fn mean_intensity(&self) -> f32 {
        let Light::Spot { intensity, cutoff, beam, slide, .. } = self else { return 0.0 };
        let mean = |slide: &Slide| slide.mean(spot_angle(*cutoff, *beam));
        (*intensity * slide.as_deref().map_or(Rgb::WHITE, mean)).luminance()
    }

    /// Emitted power as luminance; for lights at infinity, the power that falls on the scene's bounding sphere.
    pub(super) fn power(&self, shapes: &[Shape], scene_radius: f32) -> f32 {
        let disc = PI * sqr(scene_radius);
        match self {
            Light::Area { emitter, shape, .. } => {
                let radiance =
                    shapes[*shape as usize].emission.as_ref().map_or(Rgb::BLACK, |e| e.mean());
                PI * emitter.area() * radiance.luminance().max(0.0)
            }
            Light::Point { intensity, .. } => 4.0 * PI * intensity.luminance(),
            Light::Spot { cutoff, beam, .. } => spot_angle(*cutoff, *beam) * self.mean_intensity(),
            Light::Directional { irradiance, .. } => disc * irradiance.luminance(),
            Light::Constant { radiance } => disc * 4.0 * PI * radiance.luminance(),
            Light::Environment(map) => disc * map.flux(),
            Light::DistantDisc { one_minus_cos, radiance, .. } => {
                disc * 2.0 * PI * one_minus_cos * radiance.luminance()
            }
        }
    }
}

/// The solid angle over which a spot of full intensity would emit the same power.
fn spot_angle(cutoff: f32, beam: f32) -> f32 {
    PI * (one_minus_cos(cutoff) + one_minus_cos(beam))
}

/// Full inside the beam, then linear in the angle to zero at the cutoff.
#[inline]
pub(super) fn spot_fade(d: Vec3, axis: Vec3, cutoff: f32, beam: f32) -> f32 {
    // The angle between unit vectors by their distance, which is exact for narrow spots too.
    let angle = 2.0 * (0.5 * d.distance(axis)).min(1.0).asin();
    if angle <= beam {
        1.0
    } else if angle >= cutoff {
        0.0
    } else {
        (cutoff - angle) / (cutoff - beam)
    }
}
