//! Bidirectional path tracing [Veach97, 10]: a path from the eye and one from a light are connected in all ways.
//!
//! With s vertices on the light's side and t on the eye's:
//!
//! | | |
//! |---|---|
//! | s = 0 | the path from the eye hits a light |
//! | s = 1 | a light is sampled |
//! | s > 1, t > 1 | a vertex of the eye is connected with one of the light path |
//! | t = 1 | a vertex of the light path is connected with the camera, and lights another pixel |
//!
//! With merging (VCM \[Georgiev12\]), the end of a path from the eye and the vertices of all light paths within a radius count as one
//! point, as in photon mapping. Merging needs no connecting segment, so it also finds caustics that are seen in mirrors and through
//! glass. The radius shrinks with the passes, and the blur with it.
//!
//! Every way finds a path with its own density; `weight.rs` weights them so that the sum is unbiased, apart from the blur.

mod camera;
mod eye;
mod light_paths;
mod plan;
pub(crate) mod strategies;
mod trail;
mod vertex;
mod weight;

use gi_core::eye::PathLimits;
use gi_core::film::Film;
use gi_core::filter::FilterTable;
use gi_core::grid::{Grid, probabilistic_radius};
use gi_core::medium::MediumId;
use gi_core::sampler::Sampler;
use gi_core::technique::Setting;

use crate::params::Params;
use light_paths::{LightPaths, Photon};
pub(crate) use plan::Plan;
use strategies::Pyramid;
use weight::Ways;

/// Number of light paths per task.
const CHUNK: u32 = 4096;

/// What all paths of a pass share.
pub(crate) struct Bidirectional<'a> {
    pub(crate) setting: Setting<'a>,
    pub(crate) limits: PathLimits,
    /// The medium around the camera.
    pub(crate) camera_medium: Option<MediumId>,
    pub(crate) ways: Ways,
    /// Number of light paths.
    pub(crate) light_paths: u32,
    /// Radius of merging, world units.
    pub(crate) radius: f32,
}

/// The light paths of a pass, and their photons if there is merging.
pub(crate) struct PassPaths {
    light: LightPaths,
    photons: Option<Grid<Photon>>,
}

impl PassPaths {
    /// Number of vertices that are kept, and the memory of vertices and photons in bytes.
    fn memory(&self) -> (u64, u64) {
        let (vertices, bytes) = self.light.memory();
        (vertices, bytes + self.photons.as_ref().map_or(0, Grid::memory_bytes) as u64)
    }
}

impl<'a> Bidirectional<'a> {
    /// Paths of pass `index`.
    pub(crate) fn new(setting: Setting<'a>, params: &Params, plan: Plan, index: u32) -> Self {
        let shrunk = probabilistic_radius(index, f64::from(params.alpha)) as f32;
        let radius = plan.radius * shrunk;
        let light_paths = plan.light_paths;
        let merges = std::f32::consts::PI * radius * radius * light_paths as f32;
        let ways = Ways { heuristic: params.heuristic, light_paths: light_paths as f32, merges };
        let camera_medium = setting.camera_medium();
        let limits = params.limits;
        Bidirectional { setting, limits, camera_medium, ways, light_paths, radius }
    }

    /// Trace the light paths, then a path from the eye per pixel. `pyramid` shows what each way finds. Returns the number of light
    /// vertices that were kept, and the memory of vertices and photons in bytes.
    pub(crate) fn pass(
        &self,
        index: u32,
        film: &mut Film,
        pyramid: Option<&mut Pyramid>,
    ) -> (u64, u64) {
        let paths = self.trace(index, film.filter());
        let splats = paths.light.splats(self, film.size().iter().product());
        film.bring(splats);
        match pyramid {
            None => film.add_pass(|pixel| self.sample(pixel, index, &paths, &mut |_| ())),
            Some(pyramid) => pyramid.pass((self, index), film, &paths),
        }
        paths.memory()
    }

    /// Number of light vertices that a pass keeps, and the memory of vertices and photons in bytes.
    pub(crate) fn kept(&self, index: u32, film: &Film) -> (u64, u64) {
        self.trace(index, film.filter()).memory()
    }

    /// Trace the light paths of a pass.
    pub(crate) fn trace(&self, index: u32, filter: &FilterTable) -> PassPaths {
        let light = LightPaths::trace(self, index, filter);
        let photons = (self.radius > 0.0).then(|| light.grid(self.radius));
        PassPaths { light, photons }
    }
}

/// Random numbers of a light path. Each pass is a stream; within a stream, paths are the points of a sequence.
fn light_sampler(setting: &Setting, pass: u32, path: u32) -> Sampler {
    Sampler::new(setting.seed ^ 0x6264_7074, pass, path)
}

#[cfg(test)]
mod tests;
