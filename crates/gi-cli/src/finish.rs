//! The end of a run: everything that was asked for is written.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use gi_core::film::Film;
use gi_core::image_io::Layers;
use gi_core::technique::Technique;

use crate::Failure;
use crate::passes::{Making, passes};
use crate::progress::span;
use crate::record::{About, SoFar, add_layers, mean};
use crate::save::{Output, save_bytes};
use crate::say::say;

/// The film's layers, with what they say about themselves.
pub(crate) fn layers(about: &About, film: &Film, so_far: &SoFar) -> Layers {
    Layers { metadata: about.metadata(so_far), ..film.layers() }
}

/// A run whose passes are made.
pub(crate) struct Finished<'a> {
    pub(crate) about: &'a About<'a>,
    pub(crate) so_far: &'a SoFar,
    pub(crate) film: &'a Film,
    pub(crate) output: &'a Output,
}

impl Finished<'_> {
    /// Write everything that was asked for, the picture first. What fails keeps nothing else from being written.
    pub(crate) fn save<'t>(
        &self,
        technique: &impl Technique<'t>,
        files: &[PathBuf],
        making: Option<Making>,
    ) -> Result<(), Failure> {
        let (clock, common) = (Instant::now(), self.about.common);
        let mut failures = Vec::new();
        let pictures = technique.pictures(self.film);
        let mut layers = layers(self.about, self.film, self.so_far);
        pictures.iter().for_each(|picture| add_layers(&mut layers, picture));
        failures.extend(self.output.save(&layers, self.so_far.passes).err());
        drop(layers);
        for picture in &pictures {
            failures.extend(self.output.save_view(picture, self.film.size()).err());
        }
        for path in files {
            failures.extend(save_bytes(path, &technique.export(path)).err());
        }
        if let Some(mut making) = making {
            failures.extend(making.end(technique, self.film).err());
        }
        if let Some(path) = &common.stats {
            let mean = match self.output.sensors() {
                Some(sensors) => sensors.mean(self.film),
                None => mean(self.film),
            };
            let json = self.about.statistics(self.so_far, mean, clock.elapsed());
            failures.extend(save_bytes(path, format!("{json:#}\n").as_bytes()).err());
        }
        if !common.quiet {
            self.say_times(clock.elapsed());
        }
        match failures.len() {
            0 => Ok(()),
            _ => {
                let texts: Vec<&str> = failures.iter().map(Failure::text).collect();
                Err(Failure::Other(texts.join("\nerror: ")))
            }
        }
    }

    fn say_times(&self, save: Duration) {
        let About { load, build, prepare, .. } = *self.about;
        let render = self.so_far.render;
        let [load, build, prepare, render, save, total] =
            [load, build, prepare, render, save, load + build + prepare + render + save].map(span);
        say(format!(
            "{}: {} in {total}: scene read in {load}, tree built in {build}, prepared in {prepare}, \
             rendered in {render}, saved in {save}",
            self.output.path().display(),
            passes(self.so_far.passes)
        ));
    }
}
