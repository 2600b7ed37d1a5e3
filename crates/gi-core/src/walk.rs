//! The light walk: paths from the lights, vertex by vertex. Its twin is [`crate::eye::EyeWalk`]. Light tracing, photon
//! maps, progressive photon mapping and virtual point lights all use it.

use crate::medium::MediumId;
use glam::Vec3;

use crate::bsdf::{Bsdf, Scatter, Transport};
use crate::geometry::Surface;
use crate::light::{Emission, Targets};
use crate::math::Rgb;
use crate::ray::{Hit, Ray};
use crate::sampler::Sampler;
use crate::scene::{Line, Scene};
pub use focused::{Focused, focused};
pub use media::{LightEvent, MediumVertex};
pub use photon::{Photon, PhotonKind, shading_correction, walk_in_order};
pub use projection::{ProjectionMap, Start, Trial};

mod focused;
mod media;
mod photon;
mod projection;
mod toward;

/// A surface point that light has reached.
pub struct LightVertex<'a> {
    /// The point.
    pub surface: Surface,
    /// Unit direction back to where the light came from.
    pub wo: Vec3,
    /// How the light scatters here ([`Transport::Power`]).
    pub bsdf: Bsdf<'a>,
    /// Power that arrives, before this surface absorbs light. It is divided by all densities, but not by the number of
    /// paths.
    pub power: Rgb,
    /// Number of scatterings before this point. Passing straight through a surface is not one.
    pub depth: u32,
    /// Number of scatterings before this point that were not by delta lobes.
    pub non_delta: u32,
    /// Whether the last scattering, if any, was by a delta lobe.
    pub after_delta: bool,
    /// The medium that the path came through.
    pub medium: Option<MediumId>,
}

/// A light path in progress.
pub struct LightWalk<'a> {
    scene: &'a Scene,
    sampler: Sampler,
    emission: Emission,
    ray: Ray,
    /// What the path has passed straight through.
    line: Line,
    /// The flat primitive that the ray leaves.
    left: Option<u32>,
    power: Rgb,
    /// Number of surface points hit so far, including straight passes. Each has its own sampler dimensions.
    met: u32,
    depth: u32,
    non_delta: u32,
    after_delta: bool,
    /// Density per solid angle of the last scattering; `None` after delta lobes and at the light.
    pdf_w: Option<f32>,
    /// Whether media attenuate and scatter the path, and the medium that it is in.
    media: bool,
    medium: Option<MediumId>,
}

/// Sampler dimensions of emission, of a vertex, and of its scattering alone.
const EMISSION_DIMENSIONS: u32 = 3;
const VERTEX_DIMENSIONS: u32 = 8;
const SCATTER_DIMENSIONS: u32 = 2;

impl<'a> LightWalk<'a> {
    /// Begin a path at a light; `None` if the scene emits no light.
    pub fn begin(scene: &'a Scene, mut sampler: Sampler) -> Option<Self> {
        let (u_light, u_p, u_d) = (sampler.next_1d(), sampler.next_2d(), sampler.next_2d());
        Some(Self::follow(scene, sampler, scene.emit(u_light, u_p, u_d)?))
    }

    /// Begin a path that can hit a target. Paths that cannot are never sampled; powers are unbiased for those that can.
    pub fn begin_toward(scene: &'a Scene, mut sampler: Sampler, targets: &Targets) -> Option<Self> {
        let (u_light, u_p, u_d) = (sampler.next_1d(), sampler.next_2d(), sampler.next_2d());
        Some(Self::follow(scene, sampler, scene.emit_toward(targets, u_light, u_p, u_d)?))
    }

    fn follow(scene: &'a Scene, sampler: Sampler, emission: Emission) -> Self {
        let o = scene.tree().offset_origin(emission.p, emission.ng, emission.d);
        let ray = Ray::new(o, emission.d);
        let power = emission.power;
        LightWalk {
            scene,
            sampler,
            emission,
            ray,
            line: Line::default(),
            left: scene.flat_light(emission.light),
            power,
            met: 0,
            depth: 0,
            non_delta: 0,
            after_delta: false,
            pdf_w: None,
            media: false,
            medium: None,
        }
    }

    /// The start of the path.
    pub fn emission(&self) -> &Emission {
        &self.emission
    }

    /// The unit direction of the next segment, and the density per solid angle with which the last scattering sampled it; `None` at
    /// the light and after a delta lobe. Passing straight through a surface is no scattering.
    pub fn turned(&self) -> (Vec3, Option<f32>) {
        (self.ray.d, self.pdf_w)
    }

    /// Number of scatterings so far. Passing straight through a surface is not one.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Number of scatterings so far that were not by delta lobes.
    pub fn non_delta(&self) -> u32 {
        self.non_delta
    }

    /// The medium that the path is in, for walks through media.
    pub fn medium(&self) -> Option<MediumId> {
        self.medium
    }

    /// Power that leaves the last vertex. It is divided by all densities, but not by the number of paths.
    pub fn power(&self) -> Rgb {
        self.power
    }

    /// The sampler, for random numbers that a technique needs at a vertex, for example a lens point. It may use at most
    /// six dimensions per vertex.
    pub fn sampler(&mut self) -> &mut Sampler {
        &mut self.sampler
    }

    /// Follow the path to the next surface.
    #[inline]
    pub fn next_vertex(&mut self) -> Option<LightVertex<'a>> {
        let found = self.next_hit()?;
        Some(self.vertex(&found))
    }

    /// The hit of the next segment, without regard to media, and the ray that found it.
    #[inline]
    fn next_hit(&mut self) -> Option<(Ray, Hit)> {
        if self.power.is_black() {
            return None;
        }
        self.sampler.jump_to(EMISSION_DIMENSIONS + self.met * VERTEX_DIMENSIONS);
        self.intersect(f32::INFINITY)
    }

    /// The first hit of the next segment before `tmax`, and the ray that found it.
    #[inline]
    fn intersect(&mut self, tmax: f32) -> Option<(Ray, Hit)> {
        self.scene.intersect_behind(&mut self.line, self.ray, self.left, tmax)
    }

    /// The vertex at a hit.
    #[inline(always)]
    fn vertex(&self, (ray, hit): &(Ray, Hit)) -> LightVertex<'a> {
        let surface = self.scene.surface(ray, hit);
        let wo = -self.ray.d;
        let bsdf = self.scene.bsdf(&surface, wo, Transport::Power);
        let LightWalk { power, depth, non_delta, after_delta, medium, .. } = *self;
        LightVertex { surface, wo, bsdf, power, depth, non_delta, after_delta, medium }
    }

    /// Sample the direction in which the path continues from a vertex of [`LightWalk::next_vertex`]. Returns whether it
    /// continues.
    pub fn scatter(&mut self, vertex: &LightVertex<'a>, roulette: Roulette) -> bool {
        self.sampler
            .jump_to(EMISSION_DIMENSIONS + (self.met + 1) * VERTEX_DIMENSIONS - SCATTER_DIMENSIONS);
        self.met += 1;
        let ([u_choice, u_roulette], u) = (self.sampler.next_2d(), self.sampler.next_2d());
        let Some(s) = vertex.bsdf.sample(vertex.wo, u_choice, u) else { return false };
        self.leave(vertex, &s, roulette, u_roulette)
    }

    /// Continue in the direction of `s`.
    #[inline]
    fn leave(
        &mut self,
        vertex: &LightVertex<'a>,
        s: &Scatter,
        roulette: Roulette,
        u_roulette: f32,
    ) -> bool {
        let surface = &vertex.surface;
        let mut factor = s.weight;
        // Passing straight through is not a scattering.
        if s.null {
            if !self.line.cross() {
                return false;
            }
        } else {
            self.line.turn();
            let survival = roulette.survival(u_roulette, factor, vertex.depth);
            let Some(survival) = survival else { return false };
            factor = factor / survival;
            self.depth += 1;
            self.non_delta += u32::from(!s.delta);
            self.after_delta = s.delta;
            self.pdf_w = (!s.delta).then_some(s.pdf_w);
        }
        if self.media {
            self.medium = self.scene.medium_toward(surface, s.wi, self.medium);
        }
        self.power = vertex.power * factor;
        self.ray = self.scene.spawn(surface, s.wi);
        self.left = self.scene.flat_at(surface);
        !self.power.is_black()
    }
}

/// When a light path may end early.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Roulette {
    /// Never.
    Off,
    /// With the probability that the surface absorbs the light: powers stay nearly equal \[Jensen01\]. Very long paths
    /// may end even without absorption.
    ByAlbedo {
        /// The first scattering that may end the path; 1 is the very first.
        from: u32,
    },
    /// The caller has decided, with a known survival probability.
    Decided {
        /// Whether this path continues.
        survives: bool,
        /// Survival probability, above 0.
        survival: f32,
    },
}

/// From this depth on, roulette also ends paths that nothing absorbs. Otherwise a path that total reflection traps in
/// glass would never end.
const LONG: u32 = 1000;
/// Largest survival probability at a scattering of a long path.
const MAX_SURVIVAL: f32 = 0.999;

impl Roulette {
    /// Survival probability at a scattering that keeps `factor` of the power; `None` if the path ends.
    #[inline]
    fn survival(self, u: f32, factor: Rgb, depth: u32) -> Option<f32> {
        let (survives, survival) = match self {
            Roulette::ByAlbedo { from } if depth + 1 >= from => {
                let survival = factor.max().min(if depth < LONG { 1.0 } else { MAX_SURVIVAL });
                (u < survival, survival)
            }
            Roulette::Decided { survives, survival } => (survives, survival),
            Roulette::Off | Roulette::ByAlbedo { .. } => (true, 1.0),
        };
        survives.then_some(survival)
    }
}

#[cfg(test)]
mod tests;
