//! The eye walk in media.

use super::{Beam, Entrance, EyePath, MAX_SURVIVAL_WITHIN, Prefix, Supplier};
use crate::bsdf::Scatter;
use crate::camera::Camera;
use crate::film::Components;
use crate::geometry::Surface;
use crate::math::Rgb;
use crate::medium::{Flight, Medium};
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

/// A flight in a medium whose end is not known yet.
pub(super) struct TakeOff {
    /// How far it goes where nothing is in its way, world units.
    pub(super) t: f32,
    /// Share of what is scattered that nobody has answered for.
    here: Rgb,
    u_phase: [f32; 2],
    u_roulette: f32,
}

impl TakeOff {
    #[inline]
    fn draw(medium: &Medium, throughput: Rgb, here: Rgb, sampler: &mut Sampler) -> Self {
        let (u_flight, u_phase, u_roulette) =
            (sampler.next_2d(), sampler.next_2d(), sampler.next_1d());
        TakeOff { t: medium.distance(throughput, u_flight), here, u_phase, u_roulette }
    }
}

impl<'a> EyePath<'a> {
    /// The medium that a camera stands in. (One for all pixels: lenses that reach through a boundary are not looked at.)
    pub fn medium_round(&self, camera: &Camera) -> Option<usize> {
        let [w, h] = camera.size();
        let ray = camera.ray([0.5 * w as f32, 0.5 * h as f32], [0.5; 2]);
        self.scene.medium_at(ray.at(ray.tmin), ray.d)
    }

    /// Take in which medium the path comes into where `surface` scatters it.
    #[inline]
    pub(super) fn enter(&self, surface: &Surface, scatter: &Scatter, prefix: &mut Prefix) {
        let medium = self.scene.medium_toward(surface, scatter.wi, prefix.medium);
        let entrance = Entrance { prim: surface.prim, eta: scatter.eta };
        prefix.entered = (medium != prefix.medium).then_some(entrance);
        prefix.medium = medium;
    }

    /// How much of what the path's medium scatters in the next segment nobody has answered for; `None` where it is only dimmed.
    #[inline]
    fn scattered(&self, prefix: &Prefix, sampler: &mut Sampler) -> Option<Rgb> {
        // What is scattered in the last segment has none left to go on with, and what is answered for is only dimmed.
        let ends = !self.limits.goes_on(prefix.segments);
        if ends || self.scene.medium(prefix.medium?).only_absorbs() {
            return None;
        }
        Some(prefix.unanswered_within(sampler)).filter(|here| !here.is_black())
    }

    /// Draw how far the path flies in its medium if nothing is in its way; `None` where it is only dimmed.
    #[inline]
    pub(super) fn take_off(&self, prefix: &Prefix, sampler: &mut Sampler) -> Option<TakeOff> {
        let here = self.scattered(prefix, sampler)?;
        Some(TakeOff::draw(self.scene.medium(prefix.medium?), prefix.throughput, here, sampler))
    }

    /// Cross the medium that the path is in, up to the distance `reach` along `ray`, or be scattered in it: where the
    /// flight says, if one has been drawn.
    #[inline]
    pub(super) fn cross<S: Supplier<'a>>(
        &self,
        (ray, reach, flight): (&Ray, f32, Option<TakeOff>),
        prefix: &mut Prefix,
        sampler: &mut Sampler,
        supplier: &mut S,
        out: &mut Components,
    ) -> Crossing {
        let Some(index) = prefix.medium else { return Crossing::Passed };
        let medium = self.scene.medium(index);
        // The eye sees nothing before its near plane, media neither.
        let (near, reach) = (ray.tmin, reach - ray.tmin);
        let ray = &Ray { o: ray.at(near), tmin: 0.0, ..*ray };
        let flight = if S::BEAMS {
            self.ask((ray, reach, index), prefix, sampler, supplier, out)
        } else {
            flight
        };
        let Some(TakeOff { t, here, u_phase, u_roulette }) = flight else {
            prefix.throughput *= medium.transmittance(reach);
            return Crossing::Passed;
        };
        // What was answered for passes only.
        let rough = prefix.rough;
        match medium.flight(t, reach, prefix.throughput) {
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

    /// Ask the technique for what a medium scatters along a beam; draw a flight if it does not answer.
    fn ask<S: Supplier<'a>>(
        &self,
        (ray, reach, medium): (&Ray, f32, usize),
        prefix: &Prefix,
        sampler: &mut Sampler,
        supplier: &mut S,
        out: &mut Components,
    ) -> Option<TakeOff> {
        let here = self.scattered(prefix, sampler)?;
        let throughput = prefix.throughput * here;
        let Prefix { segments, rough, entered, .. } = *prefix;
        let beam = Beam { ray, reach, medium, entered, segments, rough, throughput };
        let Some(found) = supplier.beam(&beam, sampler) else {
            return Some(TakeOff::draw(
                self.scene.medium(medium),
                prefix.throughput,
                here,
                sampler,
            ));
        };
        *out.of_path(rough + 1, false) += throughput * found.direct;
        *out.of_path(rough + 1, true) += throughput * found.caustic;
        *out.of_path(rough + 2, false) += throughput * found.indirect;
        None
    }
}
