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
pub(crate) mod strategies;
mod trail;
mod vertex;
mod weight;

use gi_core::eye::PathLimits;
use gi_core::film::Film;
use gi_core::filter::FilterTable;
use gi_core::grid::{Grid, probabilistic_radius};
use gi_core::medium::MediumId;
use gi_core::technique::Setting;

use crate::params::{Mode, Params};
use light_paths::{LightPaths, VertexId};
use weight::Ways;

/// What all paths of a pass share.
pub(crate) struct Bidirectional<'a> {
    pub(crate) setting: Setting<'a>,
    pub(crate) limits: PathLimits,
    /// The medium around the camera.
    pub(crate) camera_medium: Option<MediumId>,
    pub(crate) ways: Ways,
    /// Radius of merging, world units.
    pub(crate) radius: f32,
}

/// The light paths of a pass, and their vertices in a grid if there is merging.
pub(crate) struct PassPaths {
    light: LightPaths,
    grid: Option<Grid<VertexId>>,
}

impl<'a> Bidirectional<'a> {
    /// Paths of pass `index`, with one light path per pixel.
    pub(crate) fn new(setting: Setting<'a>, params: &Params, index: u32) -> Self {
        let [w, h] = setting.camera.size();
        let light_paths = (w * h) as f32;
        let (mut radius, mut merges) = (0.0, 0.0);
        if params.mode == Mode::Vcm {
            let shrunk = probabilistic_radius(index, f64::from(params.alpha)) as f32;
            radius = params.radius * setting.scene.radius() * shrunk;
            merges = std::f32::consts::PI * radius * radius * light_paths;
        }
        let ways = Ways { heuristic: params.heuristic, light_paths, merges };
        let camera_medium = setting.camera_medium();
        Bidirectional { setting, limits: params.limits, camera_medium, ways, radius }
    }

    /// Trace the light paths, then a path from the eye per pixel. Returns the number of vertices of light paths that were kept, and
    /// the memory that they need in bytes.
    pub(crate) fn pass(&self, index: u32, film: &mut Film) -> (u64, u64) {
        let paths = self.trace(index, film.filter());
        let splats = paths.light.splats(self, film.size().iter().product());
        film.add_pass_and_splats(&splats, |pixel| self.sample(pixel, index, &paths));
        paths.light.memory()
    }

    /// Trace the light paths of a pass.
    pub(crate) fn trace(&self, index: u32, filter: &FilterTable) -> PassPaths {
        let light = LightPaths::trace(self, index, filter);
        let grid = (self.radius > 0.0).then(|| light.grid(self.radius));
        PassPaths { light, grid }
    }
}

#[cfg(test)]
mod tests;
