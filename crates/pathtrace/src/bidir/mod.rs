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
//! Every way finds a path with its own density; `weight.rs` weights them so that the sum is unbiased.

mod eye;
mod light_paths;
mod vertex;
mod weight;

use gi_core::eye::PathLimits;
use gi_core::film::Film;
use gi_core::medium::MediumId;
use gi_core::technique::Setting;

use crate::params::Heuristic;
use light_paths::LightPaths;
use weight::Ways;

/// What all paths of a pass share.
pub(crate) struct Bidirectional<'a> {
    pub(crate) setting: Setting<'a>,
    pub(crate) limits: PathLimits,
    /// The medium around the camera.
    pub(crate) camera_medium: Option<MediumId>,
    pub(crate) ways: Ways,
}

impl<'a> Bidirectional<'a> {
    /// One light path per pixel.
    pub(crate) fn new(setting: Setting<'a>, limits: PathLimits, heuristic: Heuristic) -> Self {
        let [w, h] = setting.camera.size();
        let ways = Ways { heuristic, light_paths: (w * h) as f32, merges: 0.0 };
        Bidirectional { setting, limits, camera_medium: setting.camera_medium(), ways }
    }

    /// Trace the light paths, then a path from the eye per pixel.
    pub(crate) fn pass(&self, index: u32, film: &mut Film) {
        let paths = LightPaths::trace(self, index, film.filter());
        let splats = paths.splats(self, film.size().iter().product());
        film.add_pass_and_splats(&splats, |pixel| self.sample(pixel, index, &paths));
    }
}
