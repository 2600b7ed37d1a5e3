//! A pass of photons: paths from the lights, and what they leave where the eye may gather.

use gi_core::light::Targets;
use gi_core::math::Rgb;
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use gi_core::walk::{LightVertex, LightWalk, Roulette};
use glam::Vec3;
use rayon::prelude::*;

/// Paths that one task walks; their photons are joined in the order of the paths.
const CHUNK: u64 = 4096;

/// Makes the numbers of light paths differ from those of eye paths.
const PHOTONS: u32 = 0x7068_6f74;

/// Light that has reached a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Where, world.
    pub p: Vec3,
    /// What arrived.
    pub arrival: Arrival,
}

/// What arrived with a photon.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arrival {
    /// Power; already divided by the densities of the path and by the number of paths of the pass, and corrected for
    /// shading normals (times |cos| with the shading over |cos| with the geometric normal).
    pub power: Rgb,
    /// Unit direction back to where the light came from.
    pub wi: Vec3,
    /// Geometric normal of what was hit, on the side of `wi`, in 127ths.
    pub(crate) normal: [i8; 3],
    /// The kind of path.
    pub kind: Kind,
    /// Segments from the light to here.
    pub segments: u32,
}

/// Paths from a light to a photon, in the notation of light paths (L light, S delta lobe, D any other).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// L: straight from a light.
    Direct,
    /// L S+: focused by mirrors and glass.
    Caustic,
    /// L .* D .*: scattered by another lobe on the way.
    #[default]
    Indirect,
}

/// Cosine of the largest angle between the normal where light is gathered and that where a photon lies: across a
/// sharper edge it is another surface that was lit.
pub(crate) const SAME_SURFACE: f32 = 0.5;

impl Arrival {
    /// What `vertex` receives of a pass of `paths` paths.
    pub(crate) fn at(vertex: &LightVertex, paths: u32) -> Self {
        let (wi, ng) = (vertex.wo, vertex.surface.ng);
        let cos = wi.dot(ng);
        let share = shading_correction(wi, ng, vertex.surface.ns()) / paths as f32;
        Arrival {
            power: vertex.power * share,
            wi,
            normal: (ng * 127f32.copysign(cos)).to_array().map(|v| v.round() as i8),
            kind: match (vertex.depth, vertex.rough) {
                (0, _) => Kind::Direct,
                (_, 0) => Kind::Caustic,
                _ => Kind::Indirect,
            },
            segments: vertex.depth + 1,
        }
    }

    /// Whether this lit the surface of normal `ng` on the side of `wi`, and not another one that runs into it.
    #[inline]
    pub(crate) fn lights(&self, ng: Vec3) -> bool {
        let normal = Vec3::from_array(self.normal.map(f32::from));
        let cos = normal.dot(ng) * 1f32.copysign(self.wi.dot(ng));
        cos >= SAME_SURFACE * 127.0
    }
}

/// |wi . ns| / |wi . ng|: irradiance is meant with the shading normal, photons land by the geometric one
/// [Veach97, 5.3.2].
#[inline]
fn shading_correction(wi: Vec3, ng: Vec3, ns: Vec3) -> f32 {
    if ns == ng {
        return 1.0;
    }
    let cos = wi.dot(ng).abs();
    if cos > 0.0 { wi.dot(ns).abs() / cos } else { 0.0 }
}

/// What a pass of photons is made with.
pub(crate) struct Emission {
    pub(crate) seed: u32,
    /// Paths a pass.
    pub(crate) paths: u32,
    /// First scattering at which roulette may end a path.
    pub(crate) rr_from: u32,
    /// Most segments from a light to a photon; `None` is unbounded.
    pub(crate) max_segments: Option<u32>,
    /// Whether light straight from lights leaves photons too.
    pub(crate) direct: bool,
    /// Where light from infinity is aimed, if it is.
    pub(crate) targets: Option<Targets>,
}

impl Emission {
    /// Trace the photons of pass `pass`. `gathers` says whether the eye gathers at a vertex.
    pub(crate) fn trace(
        &self,
        scene: &Scene,
        pass: u32,
        gathers: impl Fn(&LightVertex) -> bool + Sync,
    ) -> Vec<Vec<Photon>> {
        let paths = u64::from(self.paths);
        (0..paths.div_ceil(CHUNK) as usize)
            .into_par_iter()
            .with_max_len(1)
            .map(|chunk| {
                let first = chunk as u64 * CHUNK;
                let mut photons = Vec::with_capacity(CHUNK as usize);
                for path in first..(first + CHUNK).min(paths) {
                    self.walk(scene, pass, path as u32, &gathers, &mut photons);
                }
                photons
            })
            .collect()
    }

    /// Walk one path and leave photons.
    fn walk(
        &self,
        scene: &Scene,
        pass: u32,
        path: u32,
        gathers: &impl Fn(&LightVertex) -> bool,
        photons: &mut Vec<Photon>,
    ) {
        // Passes are streams; within one, paths are the points of a sequence.
        let sampler = Sampler::new(self.seed ^ PHOTONS, pass, path);
        let walk = match &self.targets {
            Some(targets) => LightWalk::begin_toward(scene, sampler, targets),
            None => LightWalk::begin(scene, sampler),
        };
        let Some(mut walk) = walk else { return };
        let roulette = Roulette::ByAlbedo { from: self.rr_from };
        while let Some(vertex) = walk.next_vertex() {
            let segments = vertex.depth + 1;
            if self.max_segments.is_some_and(|most| segments > most) {
                return;
            }
            if (self.direct || vertex.depth > 0) && gathers(&vertex) {
                let arrival = Arrival::at(&vertex, self.paths);
                photons.push(Photon { p: vertex.surface.p, arrival });
            }
            let goes_on = match &self.targets {
                Some(targets) => walk.scatter_toward(&vertex, roulette, targets),
                None => walk.scatter(&vertex, roulette),
            };
            if !goes_on {
                return;
            }
        }
    }
}
