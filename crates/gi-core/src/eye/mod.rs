//! The eye walk: paths from the camera, vertex by vertex. Its twin is [`crate::walk::LightWalk`].
//!
//! Each technique writes the loop itself:
//!
//! ```text
//! let mut walk = EyeWalk::through_pixel(&setting, limits, pixel, index);
//! while let Some(v) = &walk.next_vertex() {
//!     walk.add_emitted(v);
//!     if v.wants_estimate() && let Some(estimate) = self.look_up(v) {
//!         walk.add_estimate(v, estimate);
//!     }
//!     walk.add_direct(v);
//!     if !walk.scatter(v) {
//!         break;
//!     }
//! }
//! walk.sample()
//! ```
//!
//! Bind the vertex by reference, as here: moving it costs 4 % of the path tracer's time.
//!
//! A path tracer has no estimate. A technique that knows indirect light (from a cache, a photon map or virtual lights)
//! adds it at a vertex. The path then continues only for the light that the estimate does not cover ([`Covers`]).

mod layers;
mod light;
mod media;
mod remainder;
mod sensor;
mod sources;
mod start;
#[cfg(test)]
mod tests;
mod vertex;

use crate::medium::MediumId;
use glam::Vec3;

use crate::bsdf::{Scatter, Transport};
use crate::film::{Components, Sample, Show};
use crate::light::{LightTree, Vantage};
use crate::math::Rgb;
pub use crate::options::PathLimits;
use crate::options::SurfaceLayers;
use crate::ray::{Hit, Ray};
use crate::sampler::Sampler;
use crate::scene::{Line, Scene};
pub use media::{Beam, Entrance, EyeEvent, EyeMediumVertex};
use remainder::Remainder;
pub use sources::SourceRays;
pub use start::GatherRay;
pub use vertex::{Covers, Estimate, EyeVertex};

/// Largest survival probability s of Russian roulette at a surface on a long path, so that every path ends. If light
/// leaves a white cavity with probability q per scattering, the variance is finite only if 1 - q < s. With 0.95, paths
/// between white cushions had throughputs above 100.
const MAX_SURVIVAL: f32 = 0.99;
/// A path with more segments than this is long.
const LONG: u32 = 32;

/// Survival probability of Russian roulette over the throughput. With the usual 1, few paths survive, and they are bright.
/// Of 1, 2, 3 and 4, the product of time and error was smallest with 3 and 4.
const SPARED: f32 = 3.0;
/// Smallest number of segments after which Russian roulette may end a path that had an estimate. With 2 instead of 5, `irrcache`
/// needed up to 11 % more time for the same error.
const START_AFTER_ESTIMATE: u32 = 5;

/// A path from the camera in progress, and the light that it has found so far.
pub struct EyeWalk<'a> {
    /// The random numbers of this path. Estimates may draw from them too.
    pub sampler: Sampler,
    scene: &'a Scene,
    limits: PathLimits,
    /// The components of light that the picture needs: the walk may skip the others.
    show: Show,
    /// Which surface the layers describe.
    surface_layers: SurfaceLayers,
    /// The next segment.
    ray: Ray,
    /// Product of f cos / pdf over the scatterings so far.
    throughput: Rgb,
    /// Fractions of the throughput that no estimate has accounted for.
    remainder: Remainder,
    /// Chooses lights; without a tree, they are chosen by power.
    light_tree: Option<&'a LightTree>,
    /// The last scattering; `None` at the camera and after delta lobes.
    last: Option<LastScattering<'a>>,
    /// Number of scatterings so far that were not by delta lobes.
    non_delta: u32,
    /// Whether the last scattering was by a delta lobe.
    after_delta: bool,
    /// Product of squared relative indices of refraction. The throughput contains a division by it; Russian roulette
    /// compensates for that.
    eta_sq: f32,
    /// Number of segments, the next one included.
    segments: u32,
    /// Length so far, world units, and at the start of the path.
    length: f32,
    start_length: f32,
    /// Whether media scatter the path ([`EyeWalk::use_media`]).
    knows_media: bool,
    /// The medium that the next segment starts in.
    medium: Option<MediumId>,
    /// The entrance into that medium, if the path has just entered it.
    entered: Option<Entrance>,
    /// What the path has passed straight through.
    line: Line,
    /// Whether light from infinity is invisible on the first segment.
    hides_background: bool,
    /// Whether other rays find the light sources that the camera sees, also over delta lobes.
    leaves_out_sources: bool,
    /// Hit of the next segment if [`EyeWalk::beam_ahead`] has traced it; the inner `None` means that the ray leaves the
    /// scene.
    ahead: Option<Option<Hit>>,
    /// The estimate at the current vertex.
    estimate: Option<Estimate>,
    /// Whether the path had an estimate, at this vertex or an earlier one.
    is_remainder: bool,
    sample: Sample,
    /// Whether the layers that describe a surface (albedo, normal, depth) are filled in.
    is_described: bool,
}

/// A scattering that was not by a delta lobe.
#[derive(Clone, Copy)]
struct LastScattering<'a> {
    at: Vantage<'a>,
    /// Density per solid angle of the sampled direction.
    pdf_w: f32,
}

impl<'a> EyeWalk<'a> {
    /// Follow the path to the next surface. If it leaves the scene, add light from infinity and return `None`. A medium
    /// on the way only attenuates the path.
    #[inline(always)]
    pub fn next_vertex(&mut self) -> Option<EyeVertex<'a>> {
        let hit = match self.ahead.take() {
            Some(hit) => hit,
            None => self.scene.closest_on(&mut self.line, &self.ray, self.ray.tmax),
        };
        self.attenuate(hit);
        self.arrive(hit)
    }

    /// The end of the segment: a surface, or infinity.
    #[inline(always)]
    fn arrive(&mut self, hit: Option<Hit>) -> Option<EyeVertex<'a>> {
        let Some(hit) = hit else {
            self.add_background();
            return None;
        };
        let before = self.length;
        self.length += hit.t;
        let surface = self.scene.surface(&self.ray, &hit);
        let wo = -self.ray.d;
        let mut bsdf = self.scene.bsdf(&surface, wo, Transport::Radiance);
        if !self.is_described {
            self.describe(&surface, &bsdf, hit.t, before);
        }
        self.estimate = None;
        let remainder = self.remainder.at(&surface, wo, &mut bsdf, &mut self.sampler);
        Some(EyeVertex {
            surface,
            wo,
            bsdf,
            segments: self.segments,
            non_delta: self.non_delta,
            length: self.length,
            medium: self.medium,
            throughput: self.throughput * remainder,
            remainder,
            is_last: !self.limits.goes_on(self.segments),
        })
    }

    /// Sample the direction in which the path continues. Returns whether it continues.
    #[inline(always)]
    pub fn scatter(&mut self, v: &EyeVertex<'a>) -> bool {
        let sampled = self.sample_direction(v);
        sampled.is_some_and(|(scatter, u)| self.follow(v, &scatter, u).is_some())
    }

    /// Sample the direction in which the path may continue from `v`: the first half of [`EyeWalk::scatter`]. Also returns the random
    /// number that [`EyeWalk::follow`] needs for Russian roulette.
    #[inline(always)]
    pub fn sample_direction(&mut self, v: &EyeVertex<'a>) -> Option<(Scatter, f32)> {
        // After the last segment, only light that passes straight through counts.
        if v.is_last && v.bsdf.straight_through(v.wo).is_black() || self.covers_all(v) {
            return None;
        }
        // Numbers that nothing uses are skipped: a draw costs as much as evaluating a diffuse surface.
        let u_lobe = self.sampler.next_1d_if(v.bsdf.has_choice());
        let u = self.sampler.next_2d();
        let u_roulette = self.sampler.next_1d_if(self.segments + 1 > self.roulette_start());
        let scatter = v.bsdf.sample(v.wo, u_lobe, u)?;
        (!v.is_last || scatter.null).then_some((scatter, u_roulette))
    }

    /// Continue in the direction of `scatter`: the second half of [`EyeWalk::scatter`]. Returns the probability with which the path
    /// survived Russian roulette. Returns `None` if the path has ended, because of roulette or because it carries no light.
    #[inline(always)]
    pub fn follow(&mut self, v: &EyeVertex<'a>, scatter: &Scatter, u_roulette: f32) -> Option<f32> {
        self.throughput *= scatter.weight;
        if !scatter.null {
            self.turn(v, scatter);
        } else if !self.line.cross() {
            return None;
        }
        if self.is_done() {
            return None;
        }
        let survival = self.survives(MAX_SURVIVAL, u_roulette)?;
        self.enter(&v.surface, scatter);
        self.ray = self.scene.spawn(&v.surface, scatter.wi);
        Some(survival)
    }

    /// Continue straight through the surface at `v`, with the fraction of the light that it lets pass. Returns whether
    /// any light passes. Uses no random numbers.
    pub fn pass_straight(&mut self, v: &EyeVertex<'a>) -> bool {
        let d = -v.wo;
        self.throughput *= v.bsdf.straight_through(v.wo);
        if self.knows_media {
            self.medium = self.scene.medium_toward(&v.surface, d, self.medium);
        }
        self.ray = self.scene.spawn(&v.surface, d);
        !self.throughput.is_black()
    }

    /// Whether the estimate covers all light that `v` scatters.
    #[inline]
    fn covers_all(&self, v: &EyeVertex) -> bool {
        matches!(
            self.estimate,
            Some(Estimate { covers: Covers::Diffuse(_), direct: Some(_), caustic: Some(_), .. })
        ) && v.bsdf.is_diffuse()
    }

    /// The path changes its direction at `v`.
    #[inline(always)]
    fn turn(&mut self, v: &EyeVertex<'a>, scatter: &Scatter) {
        self.line.turn();
        self.segments += 1;
        self.after_delta = scatter.delta;
        self.eta_sq *= scatter.eta * scatter.eta;
        self.last = None;
        if scatter.delta {
            self.remainder.after_delta();
        } else {
            self.throughput *= v.remainder;
            self.non_delta += 1;
            self.last = Some(LastScattering { at: self.vantage(v), pdf_w: scatter.pdf_w });
            self.remainder.after_scattering(self.estimate.as_ref(), v, scatter.wi);
        }
    }

    /// Number of segments after which Russian roulette may end the path.
    #[inline(always)]
    fn roulette_start(&self) -> u32 {
        if self.is_remainder {
            self.limits.rr_depth.max(START_AFTER_ESTIMATE)
        } else {
            self.limits.rr_depth
        }
    }

    /// Russian roulette by the throughput T, without the factor from refraction: the survival probability is [`SPARED`] T. On
    /// a long path it is at most `most`. After an estimate, it is T and at most `most`. Returns the probability if the path survives.
    #[inline(always)]
    fn survives(&mut self, most: f32, u: f32) -> Option<f32> {
        let mut survival = 1.0;
        if self.segments > self.roulette_start() {
            let (spared, most) = match self.segments {
                _ if self.is_remainder => (1.0, most),
                0..=LONG => (SPARED, 1.0),
                _ => (SPARED, most),
            };
            survival = (spared * self.throughput.max() * self.eta_sq).min(most);
        }
        self.throughput = self.throughput / survival;
        (u < survival).then_some(survival)
    }

    /// Whether the picture needs none of the light that the path can still find.
    #[inline(always)]
    fn is_done(&self) -> bool {
        self.throughput.is_black()
            || (self.remainder.is_black() && !self.after_delta)
            || match self.show {
                Show::All => false,
                Show::Direct | Show::Caustic => self.non_delta > 1,
                Show::Indirect => self.non_delta == 1 && self.remainder.indirect.is_black(),
            }
    }

    /// Set the throughput and the light that the path has found. Returns the light that it had found before.
    pub fn restart(&mut self, throughput: Rgb, found: Components) -> Components {
        self.throughput = throughput;
        std::mem::replace(&mut self.sample.radiance, found)
    }

    /// Fraction of the radiance along the next segment that reaches the picture.
    pub fn throughput(&self) -> Rgb {
        self.throughput
    }

    /// The unit direction of the next segment, and the density per solid angle with which the last scattering sampled it; `None` at
    /// the camera and after a delta lobe. Passing straight through a surface is no scattering.
    pub fn turned(&self) -> (Vec3, Option<f32>) {
        (self.ray.d, self.last.map(|last| last.pdf_w))
    }

    /// The ray of the next segment.
    pub fn segment(&self) -> &Ray {
        &self.ray
    }

    /// Number of segments, the next one included. Passing straight through a surface does not change it.
    pub fn segments(&self) -> u32 {
        self.segments
    }

    /// Number of scatterings so far that were not by delta lobes.
    pub fn non_delta(&self) -> u32 {
        self.non_delta
    }

    /// The light that the path has found, and the layers that describe a surface.
    #[inline(always)]
    pub fn sample(self) -> Sample {
        self.sample
    }
}
