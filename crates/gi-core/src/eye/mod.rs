//! The one eye walk: paths from the eye, to their end or to where a technique answers for the rest.
//!
//! A path tracer answers for nothing. Where a technique knows the light that surfaces throw on each other (from a
//! cache, a photon map, virtual lights), it supplies that at a vertex, and the path goes on only for what
//! is left: light that comes straight from a light or through mirrors and glass, and lobes that it did not answer for.

mod light;
mod media;
mod prefix;
mod supply;

use crate::bsdf::Transport;
use crate::camera::Camera;
use crate::film::{Sample, Show};
pub use crate::options::PathLimits;
use crate::ray::{Hit, Ray};
use crate::sampler::Sampler;
use crate::scene::Scene;
use light::add_supplied;
use media::Crossing;
use prefix::Prefix;
use supply::OnSurfaces;
pub use supply::{Answered, Beam, Entrance, EyeVertex, InMedia, Supplied, Supplier, nothing};

/// Russian roulette lets at least one path in twenty end at a surface, so that no path is endless.
const MAX_SURVIVAL: f32 = 0.95;
/// In media, which scatter light hundreds of times before they let it go, one in a thousand: a path that survived a hundred
/// times by chance would weigh as much as a hundred others.
const MAX_SURVIVAL_WITHIN: f32 = 0.999;

/// Paths from the eye.
#[derive(Clone, Copy)]
pub struct EyePath<'a> {
    /// The world.
    pub scene: &'a Scene,
    /// How long they may be.
    pub limits: PathLimits,
    /// What of their light is asked for: the rest may be left out.
    pub show: Show,
}

impl<'a> EyePath<'a> {
    /// One path through a pixel: sample `index` of the picture that `seed` makes. `supply` is asked at every vertex
    /// that scatters by other than delta lobes and has segments left.
    #[inline]
    pub fn sample_pixel(
        &self,
        camera: &Camera,
        seed: u32,
        [x, y]: [usize; 2],
        index: u32,
        supply: &mut impl FnMut(&EyeVertex<'_, 'a>, &mut Sampler) -> Option<Supplied>,
    ) -> Sample {
        self.through_pixel(camera, seed, [x, y], index, (&mut OnSurfaces(supply), None))
    }

    /// The same by a supplier, which may know media; `medium` is what the camera stands in (see
    /// [`EyePath::medium_round`]).
    #[inline]
    pub fn sample_pixel_by(
        &self,
        camera: &Camera,
        medium: Option<usize>,
        seed: u32,
        pixel: [usize; 2],
        index: u32,
        supplier: &mut impl Supplier<'a>,
    ) -> Sample {
        self.through_pixel(camera, seed, pixel, index, (supplier, medium))
    }

    #[inline]
    fn through_pixel(
        &self,
        camera: &Camera,
        seed: u32,
        [x, y]: [usize; 2],
        index: u32,
        (supplier, medium): (&mut impl Supplier<'a>, Option<usize>),
    ) -> Sample {
        let stream = (y * camera.size()[0] + x) as u32;
        let mut sampler = Sampler::new(seed, stream, index);
        let [u, v] = sampler.next_2d();
        let lens = if camera.has_lens() { sampler.next_2d() } else { [0.5; 2] };
        let ray = camera.ray([x as f32 + u, y as f32 + v], lens);
        let mut sample = Sample { offset: [u - 0.5, v - 0.5], ..Sample::default() };
        let prefix = Prefix { medium, ..Prefix::EYE };
        self.follow(ray, prefix, &mut sampler, supplier, &mut sample);
        sample
    }

    /// Light along a ray that leaves a surface, of which the path had `segments` segments with this one and `length`
    /// world units without it: only light that was scattered by other than delta lobes on its way counts, and stands in
    /// [`crate::film::Components::indirect`] of the sample; its depth is the distance to the first surface.
    #[inline]
    pub fn gather(
        &self,
        ray: Ray,
        (segments, length): (u32, f32),
        sampler: &mut Sampler,
        supply: &mut impl FnMut(&EyeVertex<'_, 'a>, &mut Sampler) -> Option<Supplied>,
    ) -> Sample {
        self.gather_by(ray, None, (segments, length), sampler, &mut OnSurfaces(supply))
    }

    /// The same by a supplier, which may know media, along a ray that starts in `medium`.
    #[inline]
    pub fn gather_by(
        &self,
        ray: Ray,
        medium: Option<usize>,
        (segments, length): (u32, f32),
        sampler: &mut Sampler,
        supplier: &mut impl Supplier<'a>,
    ) -> Sample {
        let mut sample = Sample::default();
        let prefix = Prefix { rough: 1, segments, length, medium, ..Prefix::EYE };
        let path = EyePath { show: Show::Indirect, ..*self };
        path.follow(ray, prefix, sampler, supplier, &mut sample);
        sample
    }

    /// Follow a path and add up the light that it finds.
    #[inline]
    fn follow<S: Supplier<'a>>(
        &self,
        mut ray: Ray,
        mut prefix: Prefix,
        sampler: &mut Sampler,
        supplier: &mut S,
        out: &mut Sample,
    ) {
        let scene = self.scene;
        let mut seen = false;
        loop {
            // Draw how far the path may fly in a medium: what lies beyond need not be looked for, but to describe what is seen.
            let flight = if S::MEDIA && !S::BEAMS { self.take_off(&prefix, sampler) } else { None };
            let tmax = flight.as_ref().filter(|_| seen).map_or(ray.tmax, |f| f.t);
            // Intersect.
            let hit = scene.closest(&Ray { tmax, ..ray });
            // Cross the medium in between, or be scattered by it.
            if S::MEDIA && prefix.medium.is_some() {
                let way = (&ray, hit.map_or(f32::INFINITY, |h| h.t), flight);
                match self.cross(way, &mut prefix, sampler, supplier, &mut out.radiance) {
                    Crossing::Passed => {}
                    Crossing::Ended => return,
                    Crossing::Scattered(next) => {
                        if let (Some(hit), false) = (hit, seen) {
                            self.describe(&ray, &hit, out);
                        }
                        seen = true;
                        ray = next;
                        continue;
                    }
                }
            }
            let Some(hit) = hit else {
                self.add_background(ray.d, &prefix, &mut out.radiance);
                return;
            };
            prefix.length += hit.t;
            let surface = scene.surface(&ray, &hit);
            let wo = -ray.d;
            let mut bsdf = scene.bsdf(&surface, wo, Transport::Radiance);
            if !seen {
                (out.albedo, out.normal, out.depth) = (bsdf.albedo_hint(wo), surface.ns(), hit.t);
                seen = true;
            }
            // Add the light of an emitter.
            self.add_emitted(&surface, wo, &prefix, &mut out.radiance);
            // At the last segment only what passes straight through goes on: it meets nothing here.
            let ends = !self.limits.goes_on(prefix.segments);
            if ends && bsdf.straight_through(wo).is_black() {
                return;
            }
            // Ask the technique, for what nobody has answered for.
            let rough = !bsdf.is_delta();
            let here = prefix.unanswered_at(&surface, wo, &mut bsdf, sampler);
            let mut supplied = None;
            if rough && !ends && !here.is_black() {
                let vertex = prefix.vertex(&surface, wo, &bsdf, here);
                supplied = supplier.vertex(&vertex, sampler);
                add_supplied(supplied.as_ref(), &prefix, here, &mut out.radiance);
            }
            // Sample a light, for what was not answered for.
            if !ends && let Some(left) = self.left_for_lights(&bsdf, supplied.as_ref()) {
                let to = (&prefix, here);
                self.add_direct::<S>(&surface, &left, wo, to, sampler, &mut out.radiance);
            }
            // Choose the next direction.
            let (u_choice, u, u_roulette) =
                (sampler.next_1d(), sampler.next_2d(), sampler.next_1d());
            let Some(scatter) = bsdf.sample(wo, u_choice, u) else { return };
            if ends && !scatter.null {
                return;
            }
            if !scatter.null {
                prefix.scatter(&surface, &bsdf, wo, &scatter, supplied.as_ref(), here);
            } else {
                prefix.throughput *= scatter.weight;
            }
            if self.is_done(&prefix) || !self.survives(&mut prefix, MAX_SURVIVAL, u_roulette) {
                return;
            }
            if S::MEDIA {
                self.enter(&surface, &scatter, &mut prefix);
            }
            ray = scene.spawn(&surface, scatter.wi);
        }
    }

    /// Note what the first surface is like.
    fn describe(&self, ray: &Ray, hit: &Hit, out: &mut Sample) {
        let surface = self.scene.surface(ray, hit);
        let bsdf = self.scene.bsdf(&surface, -ray.d, Transport::Radiance);
        (out.albedo, out.normal, out.depth) = (bsdf.albedo_hint(-ray.d), surface.ns(), hit.t);
    }

    /// Play Russian roulette with what is left, the squeezing by refraction undone; the path survives with a probability of at
    /// most `most`.
    #[inline]
    fn survives(&self, prefix: &mut Prefix, most: f32, u: f32) -> bool {
        let mut survival = 1.0;
        if prefix.segments > self.limits.rr_depth {
            survival = (prefix.throughput.max() * prefix.eta_sq).min(most);
        }
        prefix.throughput = prefix.throughput / survival;
        u < survival
    }

    /// Whether nothing that the path can still find is asked for.
    #[inline]
    fn is_done(&self, prefix: &Prefix) -> bool {
        // Whatever lies ahead has been answered for.
        let all_answered = prefix.unanswered.is_black()
            && prefix.direct_left.is_black()
            && prefix.caustic_left.is_black()
            && !prefix.after_delta;
        prefix.throughput.is_black()
            || all_answered
            || match self.show {
                Show::All => false,
                Show::Direct | Show::Caustic => prefix.rough > 1,
                Show::Indirect => prefix.rough == 1 && prefix.unanswered.is_black(),
            }
    }
}
