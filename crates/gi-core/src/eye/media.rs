//! The eye walk in media.

use glam::Vec3;

use super::{Beam, EyePath, MAX_SURVIVAL_WITHIN, Prefix, Supplier};
use crate::camera::Camera;
use crate::film::Components;
use crate::geometry::Surface;
use crate::medium::Flight;
use crate::nee::direct_light_within;
use crate::ray::Ray;
use crate::sampler::Sampler;

/// What became of a path in a medium.
pub(super) enum Crossing {
    /// It goes on behind the medium.
    Passed,
    /// It was scattered in the medium, and goes on along a ray from there.
    Scattered(Ray),
    /// It has ended.
    Ended,
}

impl<'a> EyePath<'a> {
    /// The medium that a camera stands in. (One for all pixels: lenses that reach through a boundary are not looked at.)
    pub fn medium_round(&self, camera: &Camera) -> Option<usize> {
        let [w, h] = camera.size();
        let ray = camera.ray([0.5 * w as f32, 0.5 * h as f32], [0.5; 2]);
        self.scene.medium_at(ray.at(ray.tmin), ray.d)
    }

    /// Take in which medium the path comes into where it leaves `surface` along `d`.
    #[inline]
    pub(super) fn enter(&self, surface: &Surface, d: Vec3, prefix: &mut Prefix) {
        let medium = self.scene.medium_toward(surface, d, prefix.medium);
        prefix.entered = (medium != prefix.medium).then_some(surface.prim);
        prefix.medium = medium;
    }

    /// Cross the medium that the path is in, up to the distance `reach` along `ray`, or be scattered in it.
    #[inline]
    pub(super) fn cross<S: Supplier<'a>>(
        &self,
        ray: &Ray,
        reach: f32,
        prefix: &mut Prefix,
        sampler: &mut Sampler,
        supplier: &mut S,
        out: &mut Components,
    ) -> Crossing {
        let Some(index) = prefix.medium else { return Crossing::Passed };
        // The eye sees nothing before its near plane, media neither.
        let (near, reach) = (ray.tmin, reach - ray.tmin);
        let ray = &Ray { o: ray.at(near), tmin: 0.0, ..*ray };
        let medium = self.scene.medium(index);
        // What is scattered in the last segment has none left to go on with, and what is answered for is only dimmed.
        let ends = !self.limits.goes_on(prefix.segments);
        if ends || medium.only_absorbs() {
            prefix.throughput *= medium.transmittance(reach);
            return Crossing::Passed;
        }
        let here = prefix.unanswered_within(sampler);
        if here.is_black() {
            prefix.throughput *= medium.transmittance(reach);
            return Crossing::Passed;
        }
        // Ask the technique.
        let throughput = prefix.throughput * here;
        let Prefix { segments, rough, entered, eta_sq, .. } = *prefix;
        let beam = Beam { ray, reach, medium: index, entered, eta_sq, segments, rough, throughput };
        if let Some(found) = supplier.beam(&beam, sampler) {
            *out.of_path(rough + 1, false) += throughput * found.direct;
            *out.of_path(rough + 1, true) += throughput * found.caustic;
            *out.of_path(rough + 2, false) += throughput * found.indirect;
            prefix.throughput *= medium.transmittance(reach);
            return Crossing::Passed;
        }
        // Choose how far the path flies. What was answered for passes only.
        let (u_flight, u_phase, u_roulette) =
            (sampler.next_2d(), sampler.next_2d(), sampler.next_1d());
        match medium.fly(reach, prefix.throughput, u_flight) {
            Flight::Passed { weight } => {
                prefix.throughput *= weight;
                Crossing::Passed
            }
            Flight::Scattered { t, weight } => {
                prefix.throughput *= weight;
                prefix.length += near + t;
                let (p, wo) = (ray.at(t), -ray.d);
                // Sample a light.
                if self.wants_direct(prefix) {
                    let direct = direct_light_within(self.scene, index, p, wo, sampler);
                    *out.of_path(rough + 1, false) += prefix.throughput * here * direct;
                } else {
                    sampler.skip();
                }
                // Choose the next direction.
                let wi = medium.phase.sample(wo, u_phase);
                prefix.scatter_within(p, medium.phase.eval(wo, wi), here);
                if self.is_done(prefix) || !self.survives(prefix, MAX_SURVIVAL_WITHIN, u_roulette) {
                    return Crossing::Ended;
                }
                Crossing::Scattered(Ray::new(p, wi))
            }
        }
    }
}
