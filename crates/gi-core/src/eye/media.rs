//! The eye walk in participating media [slide 34].

use crate::medium::MediumId;
use glam::Vec3;

use super::{EyeVertex, EyeWalk, LastScattering, Remainder};
use crate::bsdf::Scatter;
use crate::film::Components;
use crate::geometry::Surface;
use crate::light::Vantage;
use crate::math::Rgb;
use crate::medium::Flight;
use crate::nee::direct_light_within;
use crate::ray::{Hit, Ray};

/// Largest survival probability of Russian roulette in media. Media scatter light hundreds of times: with the limit of
/// surfaces, a path that survives five hundred scatterings by chance would get the weight of a hundred paths.
const MAX_SURVIVAL_WITHIN: f32 = 0.999;

/// The next event of a path in media.
#[expect(
    clippy::large_enum_variant,
    reason = "one at a time, on the stack; hot loops allocate nothing"
)]
pub enum EyeEvent<'a> {
    /// A surface.
    Surface(EyeVertex<'a>),
    /// A point of a medium that scatters the path.
    Medium(EyeMediumVertex),
}

/// A point of a medium that scatters a path from the camera.
#[derive(Clone, Copy, Debug)]
pub struct EyeMediumVertex {
    /// The point.
    pub p: Vec3,
    /// Unit direction back along the path.
    pub wo: Vec3,
    /// The medium.
    pub medium: MediumId,
    /// Fraction of the scattering here that no estimate has accounted for.
    remainder: Rgb,
    u_phase: [f32; 2],
    u_roulette: f32,
}

/// The part of a path's next segment that is inside a medium.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// The ray, starting at the near end; unit direction.
    pub ray: Ray,
    /// Distance to its far end, world units; may be infinite.
    pub reach: f32,
    /// The medium.
    pub medium: MediumId,
    /// The entrance into the medium. `None` if the path begins in it, or was reflected or scattered inside.
    pub entered: Option<Entrance>,
    /// Number of segments from the camera, this one included.
    pub segments: u32,
    /// Number of scatterings before that were not by delta lobes.
    pub non_delta: u32,
    /// Contribution to the sample of one unit of estimated radiance.
    pub throughput: Rgb,
}

/// The point where a path has entered a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entrance {
    /// The boundary's primitive.
    pub prim: u32,
    /// Index of refraction inside over outside of the boundary; 1 without refraction.
    pub eta: f32,
}

/// A distance that was sampled before the end of the segment is known.
struct FreeFlight {
    /// World units; infinite if the end is needed for it.
    t: f32,
    u: [f32; 2],
    remainder: Rgb,
    u_phase: [f32; 2],
    u_roulette: f32,
}

impl<'a> EyeWalk<'a> {
    /// Let media attenuate and scatter the path. `medium` is the one in which it starts
    /// ([`crate::technique::Setting::camera_medium`]).
    #[inline]
    pub fn use_media(&mut self, medium: Option<MediumId>) {
        self.knows_media = true;
        self.medium = medium;
    }

    /// Follow the path to the next surface, or to the point where a medium scatters it.
    #[inline(always)]
    pub fn next_event(&mut self) -> Option<EyeEvent<'a>> {
        let flight = self.draw_flight();
        // Trace only up to the point of scattering, unless a surface is still needed for its layers.
        let tmax = flight
            .as_ref()
            .filter(|_| self.is_described)
            .map_or(self.ray.tmax, |f| f.t.min(self.ray.tmax));
        let hit = self.scene.closest_on(&mut self.line, &self.ray, tmax);
        let (Some(index), Some(flight)) = (self.medium, flight) else {
            self.attenuate(hit);
            return self.arrive(hit).map(EyeEvent::Surface);
        };
        let reach = self.reach(hit);
        let ray = self.behind_near_plane();
        let (line, ends) = ((ray.o, ray.d), (flight.t, reach));
        match self.scene.medium(index).flight_along(line, ends, self.throughput, flight.u) {
            Flight::Passed { weight } => {
                self.throughput *= weight;
                self.arrive(hit).map(EyeEvent::Surface)
            }
            Flight::Scattered { t, weight } => {
                if let (Some(hit), false) = (hit, self.is_described) {
                    self.describe_ahead(hit);
                }
                self.is_described = true;
                self.throughput *= weight;
                self.length += self.ray.tmin + t;
                let (p, wo) = (ray.at(t), -ray.d);
                let FreeFlight { remainder, u_phase, u_roulette, .. } = flight;
                let medium = index;
                let v = EyeMediumVertex { p, wo, medium, remainder, u_phase, u_roulette };
                Some(EyeEvent::Medium(v))
            }
        }
    }

    /// Next-event estimation in a medium: sample a light, and add the light that `v` scatters.
    #[inline]
    pub fn add_direct_within(&mut self, v: &EyeMediumVertex) {
        if !self.wants_direct() {
            return self.sampler.skip();
        }
        let at = Vantage::new(self.light_tree, v.p);
        let direct = direct_light_within(self.scene, v.medium, &at, v.wo, &mut self.sampler);
        self.add_estimate_within(v, direct);
    }

    /// The factor by which radiance that the medium scatters at `v` toward the eye counts in the sample.
    pub fn throughput_within(&self, v: &EyeMediumVertex) -> Rgb {
        self.throughput * v.remainder
    }

    /// Add an estimate of the light that a medium scatters at `v` straight from light sources, instead of
    /// [`EyeWalk::add_direct_within`]. Continue with [`EyeWalk::scatter_within_after_estimate`].
    pub fn add_estimate_within(&mut self, v: &EyeMediumVertex, direct: Rgb) {
        let radiance = self.throughput_within(v) * direct;
        *self.sample.radiance.of_path(self.non_delta + 1, false) += radiance;
    }

    /// [`EyeWalk::scatter_within`] after an estimate: the path leaves out light straight from light sources.
    pub fn scatter_within_after_estimate(&mut self, v: &EyeMediumVertex) -> bool {
        let goes_on = self.scatter_within(v);
        self.remainder = Remainder::WITHOUT_DIRECT;
        goes_on
    }

    /// Sample the direction in which the path continues from a point of a medium. Returns whether it continues.
    #[inline]
    pub fn scatter_within(&mut self, v: &EyeMediumVertex) -> bool {
        let phase = &self.scene.medium(v.medium).phase;
        let wi = phase.sample(v.wo, v.u_phase);
        self.throughput *= v.remainder;
        self.segments += 1;
        self.non_delta += 1;
        (self.after_delta, self.entered) = (false, None);
        let at = Vantage::new(self.light_tree, v.p);
        // A phase function equals its own density.
        self.last = Some(LastScattering { at, pdf_w: phase.eval(v.wo, wi) });
        self.remainder = Remainder::ALL;
        self.line.turn();
        self.ray = Ray::new(v.p, wi);
        !self.is_done() && self.survives(MAX_SURVIVAL_WITHIN, v.u_roulette).is_some()
    }

    /// For techniques that estimate the light in media: the part of the next segment that is inside a medium, unless an
    /// estimate already accounts for the light that is scattered there. The next [`EyeWalk::next_vertex`] then only
    /// attenuates the path.
    #[inline]
    pub fn beam_ahead(&mut self) -> Option<Beam> {
        let medium = self.medium?;
        let hit = self.scene.closest_on(&mut self.line, &self.ray, self.ray.tmax);
        self.ahead = Some(hit);
        let remainder = self.scattered_within()?;
        Some(Beam {
            ray: self.behind_near_plane(),
            reach: self.reach(hit),
            medium,
            entered: self.entered,
            segments: self.segments,
            non_delta: self.non_delta,
            throughput: self.throughput * remainder,
        })
    }

    /// Add an estimate of all light that a medium scatters back along a beam.
    #[inline]
    pub fn add_beam(&mut self, beam: &Beam, found: Components) {
        let radiance = &mut self.sample.radiance;
        *radiance.of_path(beam.non_delta + 1, false) += beam.throughput * found.direct;
        *radiance.of_path(beam.non_delta + 1, true) += beam.throughput * found.caustic;
        *radiance.of_path(beam.non_delta + 2, false) += beam.throughput * found.indirect;
    }

    /// Attenuate the path by the medium on its next segment, which ends at `hit`.
    #[inline(always)]
    pub(super) fn attenuate(&mut self, hit: Option<Hit>) {
        if let Some(index) = self.medium {
            let (ray, reach) = (self.behind_near_plane(), self.reach(hit));
            let mut random = self.scene.tracking(&mut self.sampler);
            let medium = self.scene.medium(index);
            self.throughput *= medium.transmittance_along(ray.o, ray.d, reach, &mut random);
        }
    }

    /// Store the medium that the path enters at `surface`.
    #[inline(always)]
    pub(super) fn enter(&mut self, surface: &Surface, scatter: &Scatter) {
        if self.knows_media {
            let medium = self.scene.medium_toward(surface, scatter.wi, self.medium);
            let entrance = Entrance { prim: surface.prim, eta: scatter.eta };
            self.entered = (medium != self.medium).then_some(entrance);
            self.medium = medium;
        }
    }

    /// The next segment, starting at the near plane: the camera does not see media in front of it.
    #[inline]
    fn behind_near_plane(&self) -> Ray {
        Ray { o: self.ray.at(self.ray.tmin), tmin: 0.0, ..self.ray }
    }

    /// Length of that ray if the segment ends at `hit`.
    #[inline]
    fn reach(&self, hit: Option<Hit>) -> f32 {
        hit.map_or(f32::INFINITY, |hit| hit.t) - self.ray.tmin
    }

    /// Fraction of the light scattered on the next segment that no estimate has accounted for. `None` if the medium
    /// only attenuates the path.
    #[inline]
    fn scattered_within(&mut self) -> Option<Rgb> {
        let medium = self.scene.medium(self.medium?);
        // Light scattered on the last segment would need one more segment.
        if !self.limits.goes_on(self.segments) || medium.only_absorbs() {
            return None;
        }
        Some(self.remainder.within(&mut self.sampler)).filter(|left| !left.is_black())
    }

    /// Sample the distance that the path travels in its medium without surfaces. `None` if the medium only attenuates
    /// the path.
    #[inline]
    fn draw_flight(&mut self) -> Option<FreeFlight> {
        let remainder = self.scattered_within()?;
        let (u, u_phase, u_roulette) =
            (self.sampler.next_2d(), self.sampler.next_2d(), self.sampler.next_1d());
        let t = self.scene.medium(self.medium?).distance(self.throughput, u);
        Some(FreeFlight { t, u, remainder, u_phase, u_roulette })
    }
}
