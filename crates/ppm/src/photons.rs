//! A pass of photons: paths from the lights, and what they leave where the eye may gather.

use gi_core::light::Targets;
use gi_core::math::Rgb;
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use gi_core::walk::{self, LightVertex, LightWalk, PhotonKind, Roulette, walk_in_order};
use glam::Vec3;

/// Paths that one task walks; their photons are joined in the order of the paths.
const CHUNK: u32 = 4096;

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
    /// What the path has met.
    pub kind: PhotonKind,
    /// Segments from the light to here.
    pub segments: u32,
}

/// Cosine of the largest angle between the normal where light is gathered and that where a photon lies: across a
/// sharper edge it is another surface that was lit.
pub(crate) const SAME_SURFACE: f32 = 0.5;

impl Arrival {
    /// What `vertex` receives of a pass of `paths` paths.
    pub(crate) fn at(vertex: &LightVertex, paths: u32) -> Self {
        let walk::Photon { n, wi, power, kind, segments, .. } =
            walk::Photon::at(vertex, paths as f32);
        let normal = (n * 127.0).to_array().map(|v| v.round() as i8);
        Arrival { power, wi, normal, kind, segments }
    }

    /// Whether this lit the surface of normal `ng` on the side of `wi`, and not another one that runs into it.
    #[inline]
    pub(crate) fn lights(&self, ng: Vec3) -> bool {
        let normal = Vec3::from_array(self.normal.map(f32::from));
        let cos = normal.dot(ng) * 1f32.copysign(self.wi.dot(ng));
        cos >= SAME_SURFACE * 127.0
    }
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
        walk_in_order(self.paths, CHUNK, |path, photons| {
            self.walk(scene, pass, path, &gathers, photons);
        })
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
