//! The one shape of every technique: prepare once, then passes.

use crate::camera::Camera;
use crate::film::Film;
use crate::scene::Scene;

/// Where a technique works and with which numbers.
#[derive(Clone, Copy)]
pub struct Setting<'a> {
    /// The world.
    pub scene: &'a Scene,
    /// The eye.
    pub camera: &'a Camera,
    /// Seed of every random number.
    pub seed: u32,
}

/// A technique of global illumination. After any number of passes the film holds a valid picture, and passes
/// are independent of one another but for what `prepare` and earlier passes left in `self`.
pub trait Technique<'a>: Sized {
    /// The technique's own knobs.
    type Params;

    /// Do what is done once: fill caches, build maps.
    fn prepare(setting: Setting<'a>, params: &Self::Params) -> Self;

    /// Make pass number `index` and add it to the film.
    fn pass(&mut self, index: u32, film: &mut Film);

    /// What is worth knowing about the run so far, as names and numbers.
    fn statistics(&self) -> Vec<(String, f64)> {
        Vec::new()
    }

    /// Which kinds of light path the estimator can reach, for the picture's metadata.
    fn reach(&self) -> String;
}
