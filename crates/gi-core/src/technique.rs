//! The one shape of every technique: prepare once, then passes.

use crate::medium::MediumId;
use std::path::Path;

use crate::camera::Camera;
use crate::film::{Film, Show};
use crate::math::Rgb;
use crate::scene::Scene;

/// Where a technique works and with which numbers.
#[derive(Clone, Copy)]
pub struct Setting<'a> {
    /// The world.
    pub scene: &'a Scene,
    /// Identity of the world: its shapes, materials and lights, not the camera. What was saved of one world
    /// is of no use in another.
    pub world: u64,
    /// The eye.
    pub camera: &'a Camera,
    /// Seed of every random number.
    pub seed: u32,
    /// What the picture shows: a technique may leave out what nobody will see.
    pub show: Show,
}

impl Setting<'_> {
    /// The medium that the camera stands in: one for all pixels, even if its lens reaches through a boundary.
    pub fn camera_medium(&self) -> Option<MediumId> {
        let [w, h] = self.camera.size();
        let ray = self.camera.ray([0.5 * w as f32, 0.5 * h as f32], [0.5; 2]);
        self.scene.medium_at(ray.at(ray.tmin), ray.d)
    }
}

/// A technique of global illumination. After any number of passes the film holds a valid picture, and passes
/// are independent of one another but for what `prepare` and earlier passes left in `self`.
pub trait Technique<'a>: Sized {
    /// The technique's own knobs.
    type Params;

    /// Do what is done once: fill caches, build maps.
    ///
    /// # Errors
    /// One line about what the user gave and what cannot be used here: a cache of another scene, say.
    fn prepare(setting: Setting<'a>, params: &Self::Params) -> Result<Self, String>;

    /// Make pass number `index` and add it to the film.
    fn pass(&mut self, index: u32, film: &mut Film);

    /// Whether further passes are not worth their time, by what the technique's parameters say.
    fn is_done(&self) -> bool {
        false
    }

    /// Whether a pass is the same whatever passes were made before: ranges of passes can then be made apart, and merged.
    fn passes_are_independent(&self) -> bool {
        true
    }

    /// What passes have left in `self`, so that another run can go on from there; the film is saved by itself. `None` where
    /// that cannot be done.
    fn save_state(&self) -> Option<Vec<u8>> {
        None
    }

    /// Go on from what [`Technique::save_state`] gave.
    ///
    /// # Errors
    /// One line: the state is of other parameters, or damaged.
    fn restore(&mut self, _state: &[u8]) -> Result<(), String> {
        Err("this program cannot go on from a checkpoint".into())
    }

    /// What is worth knowing about the run so far, as names and numbers.
    fn statistics(&self) -> Vec<(String, f64)> {
        Vec::new()
    }

    /// Which kinds of light path the estimator can reach, for the picture's metadata.
    fn reach(&self) -> String;

    /// Pictures that the technique draws of itself, as its parameters ask for.
    fn pictures(&self, _film: &Film) -> Vec<Picture> {
        Vec::new()
    }

    /// The contents of a file that the parameters ask for, see [`crate::options::Parameters::outputs`].
    fn export(&self, path: &Path) -> Vec<u8> {
        unreachable!("the parameters do not ask for {}", path.display())
    }
}

/// A picture that a technique draws of itself: layers of the EXR, and a PNG of its own.
#[derive(Clone, Debug)]
pub struct Picture {
    /// One lower-case word or several joined by hyphens: `OUT.name.png`, and layers `Name.*`.
    pub name: String,
    /// Channels of the layer: what the picture shows, as numbers in row order. None keeps the view itself.
    pub channels: Vec<(String, Vec<f32>)>,
    /// What the PNG shows, linear, in row order.
    pub view: Vec<Rgb>,
}
