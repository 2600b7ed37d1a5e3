//! Lightcuts [slides 53-61, Walter05]: all illumination becomes point lights, thousands to millions of them. Each point
//! is illuminated by a few clusters of these lights, chosen for the point so that the error of no cluster is visible.
//!
//! | | |
//! |---|---|
//! | estimate | L(x) = sum over the clusters C of a cut of f(x) G(x, y) V(x, y) power(C), where y is the representative light of C. Passes, each with lights of its own, are averaged |
//! | refinement | start with the roots of the trees; split the cluster with the largest error bound until that bound is below `--error` times the estimate of L(x) [slides 57-60] |
//! | `--error` | allowed error, as a fraction of the point's radiance: Weber's law |
//! | `--rule` | what `--error` bounds: `cluster` (default), each cluster alone, as in the lecture; `whole`, for 99 of 100 points also the sum |
//! | `--max-cut` | maximum number of clusters in a cut (no maximum with `--error 0`) |
//! | `--lights` | number of points on area lights, sky and sun, distributed by power |
//! | `--vpls` | approximate number of virtual point lights for indirect light |
//! | `--fixed-lights` | all passes use the lights of the first pass; the error from too few lights stays |
//! | `--clamp`, `--compensation` | upper bound of the geometry term of indirect lights, and paths for the light that it cuts off, as in instant radiosity |
//! | `--caustics` | `photon`: light focused by mirrors and glass is read from photons, blurred over discs that shrink with the passes; `path` |
//! | `--method` | `cuts`; `multidimensional`: one cut per pixel for `--gather` camera paths \[Walter06\]; `all`: every light; `stochastic`, `one`: lights sampled from the same trees, without bias \[Yuksel19, Conty18\]; `learned`: paths with light samples chosen by what earlier passes have learned \[Vevoda18\] |
//! | in media | media attenuate and scatter paths from the eye and from the lights. Cuts illuminate the first scattering of a camera path that is not by a mirror or clear glass: on a surface by all lights, in a medium by those on light sources. Paths find all other light, caustics too |
//! | `--reconstruct` | cuts only at the corners of blocks of pixels, interpolated where they agree [Walter05, 5] |
//! | bias | each cluster's error is at most `--error` times the total; the errors of many clusters partly cancel. None with `--error 0`, except the blur of caustics |
//! | how it fails | few or near lights show individually. In dark places, where 2 % is little light, and with `whole` and many lights, cuts reach `--max-cut` (statistics: `at_max_cut`) |
//! | sources | \[Walter05\], \[Keller97\], \[Kollig04\] |
//!
//! Read next: `cut.rs` (the cut and its heap), `light.rs` (split, representative, estimate), `bound.rs` (the error
//! bound), `tree.rs` and `cluster.rs` (the light trees), `sources.rs` (the point lights), `paths.rs` (the eye paths),
//! `reconstruct.rs`, `sample.rs`, `learned.rs`, `multidimensional/mod.rs`.

#![forbid(unsafe_code)]

pub mod bound;
pub mod cluster;
pub mod cut;
pub mod figures;
pub mod gain;
mod learned;
pub mod light;
mod multidimensional;
mod params;
mod paths;
mod picture;
pub mod reconstruct;
pub mod record;
pub mod sample;
mod sources;
mod squares;
mod tally;
#[cfg(test)]
mod test_scenes;
pub mod tree;
mod view;

use std::path::Path;

use gi_core::caustics::FocusedLight;
use gi_core::film::Film;
use gi_core::filter::FilterPlaces;
use gi_core::medium::MediumId;
use gi_core::options::Parameters;
use gi_core::technique::{Picture, Setting, Technique};
use vpl::{Pilot, Prepared};

use cut::{Cut, Limits, Lit, MAX_GROWTH};
use figures::{CutOfPixel, Subject};
use learned::Learned;
use light::{At, Lights};
use picture::Blocks;
use reconstruct::{Corners, Sample};
use record::Record;
use sources::PassLights;
use tally::Tally;
use tree::NodeId;
use view::View;

pub use params::{Method, Params, Reconstruction};

/// Refine a cut [slides 57-60]: replace the cluster with the largest error by its children, until no error is visible
/// or the cut has the maximum number of clusters.
pub fn refine<'a>(
    lights: &Lights<'_, 'a>,
    at: &At<'_, '_, 'a>,
    limits: &Limits,
    cut: &mut Cut,
    record: &mut Option<&mut Record>,
) {
    let max_clusters = limits.max_clusters() as usize;
    while !cut.is_good(limits) && cut.clusters.len() + MAX_GROWTH <= max_clusters {
        let Some(worst) = cut.heap.pop() else { return };
        // The low bits of an entry are the index of the cluster.
        lights.split(at, cut, worst as u32, record);
    }
}

/// Choose the cut of a point: refine the cut of all roots. `record` stores the cut for reconstruction.
pub fn choose<'a>(
    lights: &Lights<'_, 'a>,
    at: &At<'_, '_, 'a>,
    limits: &Limits,
    cut: &mut Cut,
    record: &mut Option<&mut Record>,
) {
    let trees = &lights.forest.trees;
    if let Some(record) = record {
        record.begin(trees.len());
    }
    for (t, _) in trees.iter().enumerate().filter(|(_, tree)| at.counts(tree)) {
        let root = NodeId { tree: t as u32, node: 0 };
        lights.add(at, cut, root, root.tree, record);
    }
    refine(lights, at, limits, cut, record);
}

/// Illuminate a point by its cut [slide 61].
pub fn light_by_cut<'a>(lights: &Lights<'_, 'a>, at: &At<'_, '_, 'a>, limits: &Limits) -> Lit {
    Cut::with_empty(|cut| {
        choose(lights, at, limits, cut, &mut None);
        lights.add_up(cut, limits)
    })
}

/// Choose the cut of a point and record it for reconstruction.
fn record_cut<'a>(lights: &Lights<'_, 'a>, at: &At<'_, '_, 'a>, limits: &Limits) -> Sample {
    let (mut record, mut cut) = (Record::default(), Cut::default());
    choose(lights, at, limits, &mut cut, &mut Some(&mut record));
    let lit = lights.add_up(&mut cut, limits);
    Sample::new(lights, at, record, &lit)
}

/// Illuminate a point by a reconstruction cut: interpolate where the samples agree up to `agree`, and refine the rest.
fn reconstruct<'a>(
    lights: &Lights<'_, 'a>,
    at: &At<'_, '_, 'a>,
    corners: &Corners,
    limits: &Limits,
    agree: f32,
) -> Lit {
    let mut found = lights.interpolate(at, corners, agree);
    refine(lights, at, limits, &mut found.cut, &mut None);
    let refined = lights.add_up(&mut found.cut, limits);
    found.with(refined)
}

/// Lightcuts.
pub struct Lightcuts<'a> {
    setting: Setting<'a>,
    params: Params,
    pilot: Pilot,
    lights: PassLights,
    focused: FocusedLight,
    tally: Tally,
    /// The medium around the camera, if media are simulated.
    camera_medium: Option<MediumId>,
    /// For `--method learned`, which needs no virtual lights.
    learned: Option<Learned>,
}

impl<'a> Technique<'a> for Lightcuts<'a> {
    type Params = Params;

    fn prepare(setting: Setting<'a>, params: &Params) -> Result<Self, String> {
        let Setting { scene, camera, seed, .. } = setting;
        let in_media = View { setting: &setting, params }.is_in_media();
        let pilot = Pilot::of(scene, seed, in_media);
        let [w, h] = camera.size();
        let learned = (params.method == Method::Learned).then(|| Learned::new(&setting));
        // Photons of focused light do not know media.
        let by_photons = params.finds_focused_light(scene.has_media());
        let pixels = if by_photons { w * h } else { 0 };
        let focused = FocusedLight::new(scene, seed, pixels);
        let mut technique = Lightcuts {
            setting,
            params: params.clone(),
            pilot,
            lights: PassLights::default(),
            focused,
            tally: Tally::default(),
            camera_medium: if in_media { setting.camera_medium() } else { None },
            learned,
        };
        if technique.learned.is_none() {
            technique.make_lights_and_trees(0);
        }
        Ok(technique)
    }

    /// Make lights and trees, and illuminate one sample per pixel by cuts.
    fn pass(&mut self, index: u32, film: &mut Film) {
        if let Some(learned) = &mut self.learned {
            return learned.pass(&self.setting, self.params.limits, index, film);
        }
        self.make_light_of_pass(index);
        let prepared = Prepared::new(&self.lights.vpls, self.setting.scene);
        let lights = self.lights(&prepared);
        if self.params.method == Method::Multidimensional {
            return self.add_pass_by_pairs(&lights, index, film);
        }
        let Reconstruction { reconstruct, block, .. } = self.params.reconstruction;
        if reconstruct {
            let blocks = Blocks::of_pass(&self.setting, block, index);
            let take = |film| self.sample_corner(&lights, film);
            let light = |pixel, corners: picture::FindCorners<'_, '_>| {
                self.sample_pixel(&lights, pixel, index, corners)
            };
            return picture::add_pass(&blocks, film, take, light);
        }
        film.add_pass(|pixel| self.sample_pixel(&lights, pixel, index, |_| None));
    }

    fn recall(&mut self, index: u32, _: &Film) {
        if self.learned.is_none() {
            self.make_light_of_pass(index);
        }
    }

    fn passes_are_independent(&self) -> bool {
        self.learned.is_none()
    }

    fn save_state(&self) -> Vec<u8> {
        self.learned.as_ref().map_or_else(|| self.tally.save(), Learned::save)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        match &mut self.learned {
            Some(learned) => learned.restore(state),
            None => self.tally.restore(state),
        }
    }

    fn statistics(&self) -> Vec<(String, f64)> {
        if let Some(learned) = &self.learned {
            return learned.statistics();
        }
        self.tally.statistics(&self.focused, &self.lights.vpls, &self.lights.forest)
    }

    fn reach(&self) -> String {
        self.params.reach()
    }

    fn pictures(&self, film: &Film) -> Vec<Picture> {
        let prepared = Prepared::new(&self.lights.vpls, self.setting.scene);
        let lights = self.lights(&prepared);
        let places = FilterPlaces::new(film.filter().filter());
        let cut_of_pixel = |pixel: [usize; 2]| self.cut_of_pixel(&lights, &places, pixel);
        let of_pixels = self.params.method == Method::Multidimensional;
        let cut_of_pixel: Option<CutOfPixel> = of_pixels.then_some(&cut_of_pixel);
        let subject = Subject { view: self.view(), lights: &lights, choose, cut_of_pixel };
        self.params.figures.iter().flat_map(|f| f.draw(&subject, film)).collect()
    }

    fn export(&self, path: &Path) -> Vec<u8> {
        let prepared = Prepared::new(&self.lights.vpls, self.setting.scene);
        let lights = self.lights(&prepared);
        let subject = Subject { view: self.view(), lights: &lights, choose, cut_of_pixel: None };
        figures::file(&subject, path)
    }
}

impl<'a> Lightcuts<'a> {
    /// Make the lights of a pass, and build their trees.
    fn make_lights_and_trees(&mut self, index: u32) {
        self.lights = PassLights::make(&self.setting, &self.params, self.pilot, index);
        self.tally.built(&self.lights.vpls, self.lights.building);
    }

    /// Make the lights of a pass with their trees, and the photons of light over mirrors and glass.
    fn make_light_of_pass(&mut self, index: u32) {
        if index != self.lights.pass && !self.params.fixed_lights {
            self.make_lights_and_trees(index);
        }
        self.focused.shoot(self.setting.scene, self.setting.seed, index);
    }

    /// Lights and trees, prepared to illuminate points.
    fn lights<'l>(&'l self, prepared: &'l Prepared<'l, 'a>) -> Lights<'l, 'a> {
        Lights { scene: self.setting.scene, prepared, forest: &self.lights.forest }
    }

    fn view(&self) -> View<'_, 'a> {
        View { setting: &self.setting, params: &self.params }
    }
}
