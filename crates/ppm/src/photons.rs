//! The photons of a pass: light paths leave a photon wherever the eye may gather.

use gi_core::grid::{Grid, Item};
use gi_core::light::Targets;
use gi_core::math::Rgb;
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use gi_core::walk::{self, LightVertex, LightWalk, PhotonKind, Roulette, walk_in_order};
use glam::Vec3;

/// Number of paths per task. The photons of all tasks are joined in the order of the paths.
const CHUNK: u32 = 4096;

/// Separates the random numbers of light paths from those of eye paths.
const PHOTONS: u32 = 0x7068_6f74;

/// Light that has reached a surface.
pub type Photon = Item<Arrival>;

/// The photons of a pass, for searches.
pub type Photons = Grid<Arrival>;

/// A photon without its position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arrival {
    /// Power, already divided by all densities and by the number of paths, and corrected for shading normals.
    pub power: Rgb,
    /// Unit direction back to where the light came from.
    pub wi: Vec3,
    /// Geometric normal of the surface, on the side of `wi`, times 127.
    pub(crate) normal: [i8; 3],
    /// The kind of path that brought it.
    pub kind: PhotonKind,
    /// Number of segments from the light to here.
    pub segments: u32,
}

/// A photon belongs to the surface of a gather point if the cosine between the normals is at least this. The limit is
/// wide enough for coarse curved meshes, because the radius shrinks.
pub(crate) const SAME_SURFACE: f32 = 0.5;

impl Arrival {
    /// The photon at `vertex` in a pass of `paths` paths.
    pub(crate) fn at(vertex: &LightVertex, paths: u32) -> Self {
        let walk::Photon { n, wi, power, kind, segments, .. } =
            walk::Photon::at(vertex, paths as f32);
        let normal = (n * 127.0).to_array().map(|v| v.round() as i8);
        Arrival { power, wi, normal, kind, segments }
    }

    /// Whether the photon is on the surface with normal `ng`, and not on another surface that intersects it.
    #[inline]
    pub(crate) fn lights(&self, ng: Vec3) -> bool {
        let normal = Vec3::from_array(self.normal.map(f32::from));
        let cos = normal.dot(ng) * 1f32.copysign(self.wi.dot(ng));
        cos >= SAME_SURFACE * 127.0
    }
}

/// How the photons of a pass are traced.
pub(crate) struct Emission {
    pub(crate) seed: u32,
    /// Number of paths per pass.
    pub(crate) paths: u32,
    /// First scattering at which roulette may end a path.
    pub(crate) rr_from: u32,
    /// Maximum number of segments from a light to a photon; `None` is unbounded.
    pub(crate) max_segments: Option<u32>,
    /// Whether direct light leaves photons too.
    pub(crate) direct: bool,
    /// Targets of light from infinity, if it is aimed.
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

    /// Trace one path.
    fn walk(
        &self,
        scene: &Scene,
        pass: u32,
        path: u32,
        gathers: &impl Fn(&LightVertex) -> bool,
        photons: &mut Vec<Photon>,
    ) {
        // Each pass is a stream; within a stream, paths are the points of a sequence.
        let sampler = Sampler::new(self.seed ^ PHOTONS, pass, path);
        let walk = match &self.targets {
            Some(targets) => LightWalk::begin_toward(scene, sampler, targets),
            None => LightWalk::begin(scene, sampler),
        };
        let Some(mut walk) = walk else { return };
        let roulette = Roulette::ByAlbedo { from: self.rr_from };
        while let Some(vertex) = &walk.next_vertex() {
            let segments = vertex.depth + 1;
            if self.max_segments.is_some_and(|most| segments > most) {
                return;
            }
            if (self.direct || vertex.depth > 0) && gathers(vertex) {
                let value = Arrival::at(vertex, self.paths);
                photons.push(Photon { p: vertex.surface.p, value });
            }
            let goes_on = match &self.targets {
                Some(targets) => walk.scatter_toward(vertex, roulette, targets),
                None => walk.scatter(vertex, roulette),
            };
            if !goes_on {
                return;
            }
        }
    }
}
