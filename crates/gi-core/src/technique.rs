//! The interface of every technique: prepare once, then make passes.

use crate::medium::MediumId;
use std::path::Path;

use crate::bytes::Reader;
use crate::camera::Camera;
use crate::canvas::Legend;
use crate::film::{Film, Show};
use crate::math::Rgb;
use crate::options::SurfaceLayers;
use crate::scene::Scene;

/// The scene, the camera and the seed that a technique works with.
#[derive(Clone, Copy)]
pub struct Setting<'a> {
    /// The world.
    pub scene: &'a Scene,
    /// Hash of the shapes, materials and lights, without the camera. A saved cache or map is valid only for the same
    /// hash.
    pub world: u64,
    /// The eye.
    pub camera: &'a Camera,
    /// Seed of every random number.
    pub seed: u32,
    /// The light that the picture shows. A technique may skip the rest.
    pub show: Show,
    /// Which surface the layers Albedo, N and Z describe.
    pub surface_layers: SurfaceLayers,
    /// Number of [`crate::eye::SourceRays`] per pixel and pass. If there are any, paths leave out the light sources that the camera
    /// sees.
    pub source_rays: u32,
}

impl Setting<'_> {
    /// Whether paths leave out the light sources that the camera sees. The irradiance sensors of `--points` do not look at light sources.
    #[inline]
    pub fn leaves_out_sources(&self) -> bool {
        self.source_rays > 0 && self.camera.sensors().is_none()
    }

    /// The medium around the camera: the same for all pixels, even if the lens extends across a boundary.
    pub fn camera_medium(&self) -> Option<MediumId> {
        let [w, h] = self.camera.size();
        let ray = self.camera.ray([0.5 * w as f32, 0.5 * h as f32], [0.5; 2]);
        self.scene.medium_at(ray.at(ray.tmin), ray.d)
    }
}

/// A technique of global illumination. After any number of passes, the film contains a valid picture. A pass depends
/// only on the state of `self` after `prepare` and earlier passes.
pub trait Technique<'a>: Send + Sized {
    /// The technique's parameters.
    type Params;

    /// Work that is done once: fill caches, build maps.
    ///
    /// # Errors
    /// A message of one line about user input that cannot be used here, such as a cache of another scene.
    fn prepare(setting: Setting<'a>, params: &Self::Params) -> Result<Self, String>;

    /// Make pass number `index` and add it to the film.
    fn pass(&mut self, index: u32, film: &mut Film);

    /// Make again what pass `index` left in `self`, such as its virtual lights, because another process has made the passes of
    /// `film`. Statistics, pictures and files describe it.
    fn recall(&mut self, _index: u32, _film: &Film) {}

    /// Whether the technique's own stopping criterion is met.
    fn is_done(&self) -> bool {
        false
    }

    /// Whether a pass does not depend on earlier passes. Ranges of passes can then be rendered separately and merged.
    fn passes_are_independent(&self) -> bool {
        true
    }

    /// A hash of what [`Technique::prepare`] has made and the passes read: records, photons. Runs whose passes are added up must
    /// have the same. 0 if it follows from the scene, the seed and the parameters, and costs little to make again.
    fn prepared(&self) -> u64 {
        0
    }

    /// The state of `self` after the passes so far, for a checkpoint, in addition to what `prepare` makes. The film is saved
    /// separately.
    fn save_state(&self) -> Vec<u8> {
        Vec::new()
    }

    /// Continue from the state of [`Technique::save_state`]. Counts are added to those that `self` has, so that merged runs count
    /// the passes of all.
    ///
    /// # Errors
    /// A message of one line: the state cannot be used here, or is damaged.
    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        Reader::new(state).end()
    }

    /// Add the state of another run, whose passes are added to the film. No pass is made afterwards.
    ///
    /// # Errors
    /// As [`Technique::restore`].
    fn merge_state(&mut self, state: &[u8]) -> Result<(), String> {
        self.restore(state)
    }

    /// Statistics of the run so far, as names and numbers.
    fn statistics(&self) -> Vec<(String, f64)> {
        Vec::new()
    }

    /// The kinds of light path that the estimator can find, for the picture's metadata.
    fn reach(&self) -> String;

    /// The technique's own pictures that the parameters request.
    fn pictures(&self, _film: &Film) -> Vec<Picture> {
        Vec::new()
    }

    /// The contents of a file that the parameters request, see [`crate::options::Parameters::outputs`].
    fn export(&self, path: &Path) -> Vec<u8> {
        unreachable!("the parameters do not request {}", path.display())
    }
}

/// A picture that a technique draws: layers of the EXR, and a PNG.
#[derive(Clone, Debug)]
pub struct Picture {
    /// One lower-case word or several joined by hyphens: `OUT.name.png`, and layers `Name.*`.
    pub name: String,
    /// Channels of the layer, in row order. If there are none, the layer contains the display image.
    pub channels: Vec<(String, Vec<f32>)>,
    /// Content of the PNG, linear, in row order.
    pub view: Vec<Rgb>,
    /// What the colours mean; drawn below the content of the PNG.
    pub legend: Option<Legend>,
}
