//! The light walk in media.

use crate::medium::MediumId;
use glam::Vec3;

use super::{
    EMISSION_DIMENSIONS, LightVertex, LightWalk, PhotonKind, Roulette, SCATTER_DIMENSIONS,
    VERTEX_DIMENSIONS,
};
use crate::math::Rgb;
use crate::medium::Flight;
use crate::ray::Ray;

/// The next event of a light path in media.
#[expect(
    clippy::large_enum_variant,
    reason = "one at a time, on the stack; hot loops allocate nothing"
)]
pub enum LightEvent<'a> {
    /// A surface.
    Surface(LightVertex<'a>),
    /// A point of a medium that scatters the path.
    Medium(MediumVertex),
}

impl LightEvent<'_> {
    /// Its position.
    pub fn p(&self) -> Vec3 {
        match self {
            LightEvent::Surface(v) => v.surface.p,
            LightEvent::Medium(v) => v.p,
        }
    }

    /// Number of scatterings before. Passing straight through a surface is not one.
    pub fn depth(&self) -> u32 {
        match self {
            LightEvent::Surface(v) => v.depth,
            LightEvent::Medium(v) => v.depth,
        }
    }

    /// The kind of path before this event.
    pub fn kind(&self) -> PhotonKind {
        PhotonKind::after(self.depth(), self.non_delta())
    }

    /// Number of scatterings before that were not by delta lobes.
    pub fn non_delta(&self) -> u32 {
        match self {
            LightEvent::Surface(v) => v.non_delta,
            LightEvent::Medium(v) => v.non_delta,
        }
    }
}

/// A point of a medium where light is scattered.
#[derive(Clone, Copy, Debug)]
pub struct MediumVertex {
    /// The point.
    pub p: Vec3,
    /// Unit direction back to where the light came from.
    pub wo: Vec3,
    /// The medium.
    pub medium: MediumId,
    /// Power that is scattered here, without the absorbed part. It is divided by all densities, but not by the number
    /// of paths. Summed over all paths, and per volume, these powers are sigma_s times radiance integrated over
    /// directions.
    pub power: Rgb,
    /// Number of scatterings before this point. Passing straight through a surface is not one.
    pub depth: u32,
    /// Number of scatterings before this point that were not by delta lobes. Those in media count.
    pub non_delta: u32,
    /// Whether the last scattering, if any, was by a delta lobe.
    pub after_delta: bool,
    /// Fraction of the power that is scattered.
    left: Rgb,
}

impl<'a> LightWalk<'a> {
    /// Let the media of the scene, if it has any, attenuate and scatter the path. Walk it with [`LightWalk::next_event`].
    #[inline]
    pub fn use_media(&mut self) {
        self.media = self.scene.has_media();
        self.medium = self.scene.medium_round_light(self.emission.light as usize);
    }

    /// Follow the path to the next surface, or to the point where a medium scatters it. In a scene with media, the
    /// technique may use one sampler dimension less per vertex.
    #[inline]
    pub fn next_event(&mut self) -> Option<LightEvent<'a>> {
        if self.media {
            return self.next_event_in_media();
        }
        let found = self.next_hit()?;
        Some(LightEvent::Surface(self.vertex(&found)))
    }

    fn next_event_in_media(&mut self) -> Option<LightEvent<'a>> {
        if self.power.is_black() {
            return None;
        }
        self.sampler.jump_to(EMISSION_DIMENSIONS + self.met * VERTEX_DIMENSIONS);
        let u = self.sampler.next_2d();
        let Some(index) = self.medium else {
            let found = self.intersect(f32::INFINITY)?;
            return Some(LightEvent::Surface(self.vertex(&found)));
        };
        // No surface beyond the point of scattering is needed.
        let medium = self.scene.medium(index);
        let t = medium.distance(self.power, u);
        let met = self.intersect(t);
        let reach = met.as_ref().map_or(f32::INFINITY, |(_, hit)| hit.t);
        let line = (self.ray.o, self.ray.d);
        match (medium.flight_along(line, (t, reach), self.power, u), met) {
            (Flight::Scattered { t, weight }, _) => {
                let (p, wo, power) = (self.ray.at(t), -self.ray.d, self.power * weight);
                let LightWalk { depth, non_delta, after_delta, .. } = *self;
                let (medium, left) = (index, weight);
                let vertex =
                    MediumVertex { p, wo, medium, power, depth, non_delta, after_delta, left };
                Some(LightEvent::Medium(vertex))
            }
            (Flight::Passed { weight }, Some(found)) => {
                self.power *= weight;
                Some(LightEvent::Surface(self.vertex(&found)))
            }
            (Flight::Passed { .. }, None) => None,
        }
    }

    /// Sample the direction in which the path continues from a point of a medium. Returns whether it continues.
    pub fn scatter_within(&mut self, vertex: &MediumVertex, roulette: Roulette) -> bool {
        let next = EMISSION_DIMENSIONS + (self.met + 1) * VERTEX_DIMENSIONS;
        self.sampler.jump_to(next - SCATTER_DIMENSIONS);
        self.met += 1;
        let ([u_roulette, _], u) = (self.sampler.next_2d(), self.sampler.next_2d());
        let survival = roulette.survival(u_roulette, vertex.left, vertex.depth);
        let Some(survival) = survival else { return false };
        self.depth += 1;
        self.non_delta += 1;
        self.after_delta = false;
        let phase = &self.scene.medium(vertex.medium).phase;
        let wi = phase.sample(vertex.wo, u);
        // A phase function equals its own density.
        self.pdf_w = Some(phase.eval(vertex.wo, wi));
        self.power = vertex.power / survival;
        self.line.turn();
        self.ray = Ray::new(vertex.p, wi);
        self.left = None;
        !self.power.is_black()
    }
}
