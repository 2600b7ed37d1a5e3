//! Path tracing whose light samples are chosen by what earlier passes have learned: which clusters of lights reach which
//! part of the scene \[Vevoda18\]. No virtual lights are made. The light tree, the regression and the choice are in
//! [`gi_core::light::LightTree`].

use gi_core::bytes::{Reader, Writer};
use gi_core::eye::{EyeWalk, PathLimits};
use gi_core::film::Film;
use gi_core::light::LightTree;
use gi_core::technique::Setting;

/// The light tree that learns.
pub(crate) struct Learned {
    tree: LightTree,
}

/// Number of passes that are learned from. What they have shown is used after each power of two: in between, equal random
/// numbers choose equal lights, and the samples of a pixel stay stratified.
const LEARNED: u32 = 256;

impl Learned {
    /// Nothing is known yet.
    pub(crate) fn new(setting: &Setting) -> Self {
        Learned { tree: setting.scene.learning_light_tree() }
    }

    /// One path per pixel. What is learned is used in later passes.
    pub(crate) fn pass(
        &mut self,
        setting: &Setting,
        limits: PathLimits,
        index: u32,
        film: &mut Film,
    ) {
        let learns = index < LEARNED;
        self.tree.learn_from_samples(learns);
        let tree = &self.tree;
        film.add_pass(|pixel| {
            let mut walk = EyeWalk::through_pixel(setting, limits, pixel, index);
            walk.choose_lights_by(Some(tree));
            while let Some(v) = &walk.next_vertex() {
                walk.add_emitted(v);
                walk.add_direct(v);
                if !walk.scatter(v) {
                    break;
                }
            }
            walk.sample()
        });
        if learns && (index + 1).is_power_of_two() {
            self.tree.update();
        }
    }

    /// What was learned, for a checkpoint.
    pub(crate) fn save(&self) -> Vec<u8> {
        let mut w = Writer::default();
        self.tree.save(&mut w);
        w.into_bytes()
    }

    /// Add what was learned before. Shards of a run learn independently, from seeds of their own.
    pub(crate) fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        let mut r = Reader::new(state);
        self.tree.restore(&mut r)?;
        r.end()
    }

    pub(crate) fn statistics(&self) -> Vec<(String, f64)> {
        let numbers = [
            ("learned_regions", self.tree.regions() as f64),
            ("tree_bytes", self.tree.memory_bytes() as f64),
        ];
        numbers.map(|(name, value)| (name.to_string(), value)).to_vec()
    }
}
