//! Densities at the light's end of a path, for multiple importance sampling of paths that are sampled from both ends.

use std::f32::consts::PI;

use glam::Vec3;

use super::{Emission, Light, LightSample, Lights};
use crate::math::{one_minus_cos, sqr};
use crate::warp;

/// The densities with which the ways to find a path sample a point of a light. z is the next vertex of the path. The measure of the
/// point is area for surfaces, solid angle for lights at infinity, and a count for lights without extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightEnd {
    /// A light path begins at this point and reaches z: density of the point, times density per area at z perpendicular
    /// to the segment.
    pub emit: f32,
    /// [`crate::scene::Scene::sample_light`] at z samples this point: density of the point.
    pub direct: f32,
    /// Factor from a density per solid angle at z to the measure of the point; 0 if paths from the eye cannot hit the light.
    pub reach: f32,
}

/// Smallest cosine at a light. Light along its surface would have no density.
const MIN_COS: f32 = 1e-6;

impl Lights {
    /// The point `y` of light `light`, where light leaves along the unit vector `d` toward z. `ng` is the unit geometric
    /// normal at `y` if the light is a surface.
    pub fn end(&self, light: usize, [y, ng]: [Vec3; 2], d: Vec3, z: Vec3) -> LightEnd {
        let probability = self.probability(light);
        let distance_sq = y.distance_squared(z);
        let point = |pdf_w: f32| LightEnd {
            emit: probability * pdf_w / distance_sq,
            direct: probability,
            reach: 0.0,
        };
        match &self.all()[light] {
            Light::Area { emitter, .. } => {
                let cos = ng.dot(d).max(MIN_COS);
                let reach = cos / distance_sq;
                LightEnd {
                    emit: probability / emitter.area() * cos / PI / distance_sq,
                    direct: probability * emitter.pdf_w(z, y, ng) * reach,
                    reach,
                }
            }
            Light::Point { .. } => point(warp::sphere_pdf()),
            Light::Spot { cutoff, .. } => point(warp::cone_pdf(one_minus_cos(*cutoff))),
            Light::Directional { .. } => {
                LightEnd { emit: probability * self.disc_pdf(), direct: probability, reach: 0.0 }
            }
            distant => self.end_at_infinity(probability * distant.escaped(-d).1),
        }
    }

    /// The point of a light sample that was taken at `z`.
    pub fn end_of_sample(&self, sample: &LightSample, z: Vec3) -> LightEnd {
        let y = match sample.p {
            None if !sample.delta => return self.end_at_infinity(sample.pdf_w),
            None => z,
            Some(y) => y,
        };
        let end = self.end(sample.light as usize, [y, sample.ng], -sample.wi, z);
        // The density of the sample itself: rounding may put the point off the light, where a lookup returns 0.
        LightEnd { direct: if sample.delta { end.direct } else { sample.pdf_w * end.reach }, ..end }
    }

    /// The start of a light path whose first vertex after the light is `z`.
    pub fn end_of_emission(&self, start: &Emission, z: Vec3) -> LightEnd {
        // The density of the sample itself: rounding may put the direction off the light, where a lookup returns 0.
        match start.distant_pdf_w {
            Some(pdf_w) => self.end_at_infinity(pdf_w),
            None => self.end(start.light as usize, [start.p, start.ng], start.d, z),
        }
    }

    /// A point at infinity that light sampling chooses with this density per solid angle.
    pub fn end_at_infinity(&self, pdf_w: f32) -> LightEnd {
        LightEnd { emit: pdf_w * self.disc_pdf(), direct: pdf_w, reach: 1.0 }
    }

    /// Density per area with which light from infinity enters the scene's bounding sphere.
    fn disc_pdf(&self) -> f32 {
        1.0 / (PI * sqr(self.sphere().1))
    }
}
