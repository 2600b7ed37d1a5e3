//! The one shape of every technique: prepare once, then passes.

use crate::medium::MediumId;
use std::path::Path;

use crate::camera::Camera;
use crate::film::{Film, Show};
use crate::math::Rgb;
use crate::options::SurfaceLayers;
use crate::scene::Scene;

/// The scene, the camera and the seed that a technique works with.
#[derive(Clone, Copy)]
pub struct Setting<'a> {
    /// The world.
    pub scene: &'a Scene,
    /// Hash of the shapes, materials and lights, without the camera. A saved cache or map is valid only for the same hash.
    pub world: u64,
    /// The eye.
    pub camera: &'a Camera,
    /// Seed of every random number.
    pub seed: u32,
    /// Which light the picture shows. A technique may skip the rest.
    pub show: Show,
    /// Which surface the layers Albedo, N and Z describe.
    pub surface_layers: SurfaceLayers,
}

impl Setting<'_> {
    /// The medium that the camera stands in: one for all pixels, even if its lens reaches through a boundary.
    pub fn camera_medium(&self) -> Option<MediumId> {
        let [w, h] = self.camera.size();
        let ray = self.camera.ray([0.5 * w as f32, 0.5 * h as f32], [0.5; 2]);
        self.scene.medium_at(ray.at(ray.tmin), ray.d)
    }
}

/// A technique of global illumination. After any number of passes the film holds a valid picture. A pass depends only on what
/// `prepare` and earlier passes left in `self`.
pub trait Technique<'a>: Sized {
    /// The technique's parameters.
    type Params;

    /// Work that is done once: fill caches, build maps.
    ///
    /// # Errors
    /// One line about what the user gave and what cannot be used here: a cache of another scene, say.
    fn prepare(setting: Setting<'a>, params: &Self::Params) -> Result<Self, String>;

    /// Make pass number `index` and add it to the film.
    fn pass(&mut self, index: u32, film: &mut Film);

    /// Whether the technique's own stopping criterion is met.
    fn is_done(&self) -> bool {
        false
    }

    /// Whether a pass does not depend on earlier passes. Ranges of passes can then be rendered apart and merged.
    fn passes_are_independent(&self) -> bool {
        true
    }

    /// The state that passes have left in `self`, for a checkpoint. The film is saved separately. `None` if the technique does not
    /// support checkpoints.
    fn save_state(&self) -> Option<Vec<u8>> {
        None
    }

    /// Continue from the state of [`Technique::save_state`].
    ///
    /// # Errors
    /// One line: the state belongs to other parameters, or is damaged.
    fn restore(&mut self, _state: &[u8]) -> Result<(), String> {
        Err("this program cannot go on from a checkpoint".into())
    }

    /// Statistics of the run so far, as names and numbers.
    fn statistics(&self) -> Vec<(String, f64)> {
        Vec::new()
    }

    /// Which kinds of light path the estimator can find, for the picture's metadata.
    fn reach(&self) -> String;

    /// Technique pictures that the parameters ask for.
    fn pictures(&self, _film: &Film) -> Vec<Picture> {
        Vec::new()
    }

    /// The contents of a file that the parameters ask for, see [`crate::options::Parameters::outputs`].
    fn export(&self, path: &Path) -> Vec<u8> {
        unreachable!("the parameters do not ask for {}", path.display())
    }
}

/// A technique picture: layers of the EXR, and a PNG.
#[derive(Clone, Debug)]
pub struct Picture {
    /// One lower-case word or several joined by hyphens: `OUT.name.png`, and layers `Name.*`.
    pub name: String,
    /// Channels of the layer, in row order. If there are none, the layer holds the view.
    pub channels: Vec<(String, Vec<f32>)>,
    /// What the PNG shows, linear, in row order.
    pub view: Vec<Rgb>,
}
