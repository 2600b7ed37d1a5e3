//! Which files a run writes, and the check that none of them is one that it reads, or another one that it writes.

use std::path::{Path, PathBuf};

use clap::{ArgMatches, Command};
use gi_core::files;

use crate::save::{Output, cannot_write};
use crate::{Common, Failure};

/// A file with what it is to the run.
pub(crate) struct Named {
    path: PathBuf,
    what: String,
}

impl Named {
    pub(crate) fn new(path: &Path, what: impl Into<String>) -> Self {
        Named { path: path.to_path_buf(), what: what.into() }
    }
}

/// The files of a run.
pub(crate) struct Files {
    /// What it reads.
    inputs: Vec<Named>,
    /// What it writes.
    outputs: Vec<Named>,
    /// The picture, if the technique draws pictures that are written beside it: `STEM.NAME.png`.
    beside: Option<PathBuf>,
}

impl Files {
    /// The files that a command line names. `matches` is what `command` parsed, `of_technique` what the technique writes.
    pub(crate) fn of(
        common: &Common,
        output: &Output,
        (command, matches): (&Command, &ArgMatches),
        of_technique: &[PathBuf],
    ) -> Self {
        let mut inputs = vec![Named::new(&common.scene, "the scene")];
        inputs.extend(common.points.iter().map(|path| Named::new(path, "the file of --points")));
        inputs.extend(common.merge.iter().map(|path| Named::new(path, "a file of --merge")));
        inputs.extend(read_by_technique(matches));
        let mut outputs = vec![Named::new(output.path(), "the output")];
        outputs.extend(output.view().map(|path| Named::new(&path, "the picture's view")));
        outputs.extend(common.stats.iter().map(|path| Named::new(path, "the file of --stats")));
        let checkpoint = common.checkpoint.iter();
        outputs.extend(checkpoint.map(|path| Named::new(path, "the file of --checkpoint")));
        let others = of_technique.iter();
        outputs.extend(others.map(|path| Named::new(path, "another of the run's files")));
        let show = command.get_arguments().find(|flag| flag.get_long() == Some("show"));
        let draws = show.is_some_and(|show| matches.contains_id(show.get_id().as_str()));
        Files { inputs, outputs, beside: draws.then(|| output.path().to_path_buf()) }
    }

    /// Add files that the scene reads.
    pub(crate) fn read_by_scene(&mut self, files: &[PathBuf]) {
        self.inputs
            .extend(files.iter().map(|path| Named::new(path, "a file that the scene reads")));
    }

    /// Check that nothing is overwritten that is needed, and that every file can be written.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        for (k, output) in self.outputs.iter().enumerate() {
            let mut others = self.inputs.iter().chain(&self.outputs[..k]);
            if let Some(other) = others.find(|other| files::is_same(&output.path, &other.path)) {
                return Err(clash(&output.path, other));
            }
            files::refuse_special(&output.path).map_err(|e| refused(&output.path, &e))?;
            files::check_writable(&output.path).map_err(|e| cannot_write(&output.path, e))?;
        }
        let Some(picture) = &self.beside else { return Ok(()) };
        let mut all = self.inputs.iter().chain(&self.outputs);
        match all.find(|other| is_view(picture, &other.path)) {
            Some(other) => Err(clash(&picture.with_extension("NAME.png"), other)),
            None => Ok(()),
        }
    }
}

/// Check that an export overwrites neither the scene nor a special file. What else the scene reads, the export checks.
pub(crate) fn check_export(scene: &Path, out: &Path) -> Result<(), Failure> {
    if files::is_same(scene, out) {
        return Err(clash(out, &Named::new(scene, "the scene")));
    }
    files::refuse_special(out).map_err(|e| refused(out, &e))
}

fn clash(path: &Path, other: &Named) -> Failure {
    let (path, what, other) = (path.display(), &other.what, other.path.display());
    Failure::Input(format!("error: {path} would overwrite {what}, {other}: choose another name"))
}

fn refused(path: &Path, cause: &std::io::Error) -> Failure {
    let text = format!("error: cannot write {}: {cause}; choose another name", path.display());
    Failure::Input(text)
}

/// The files that the technique's flags read: those flags are named `--x-in`.
fn read_by_technique(matches: &ArgMatches) -> Vec<Named> {
    let flags = matches.ids().filter(|id| id.as_str().ends_with("_in"));
    let values = flags.filter_map(|id| {
        let flag = format!("the file of --{}", id.as_str().replace('_', "-"));
        let values = matches.try_get_raw(id.as_str()).ok().flatten()?;
        Some(values.map(move |path| Named::new(Path::new(path), flag.clone())))
    });
    values.flatten().collect()
}

/// Whether a file may be the view of a technique's picture beside `picture`: `STEM.NAME.png`, NAME of lower-case words,
/// digits and hyphens.
fn is_view(picture: &Path, file: &Path) -> bool {
    let name = |path: &Path| path.file_name().map(|n| n.to_string_lossy().into_owned());
    let stem = picture.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let view = name(file).and_then(|name| {
        let middle = name.strip_prefix(&stem)?.strip_prefix('.')?.strip_suffix(".png")?;
        let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        (!middle.is_empty() && middle.chars().all(is_word)).then(|| picture.with_file_name(&name))
    });
    view.is_some_and(|view| files::is_same(&view, file))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_beside_the_picture_are_known_by_their_names() {
        let folder = gi_tests::program::Folder::make();
        std::fs::create_dir(folder.at("a")).expect("a folder");
        let at = |name: &str| PathBuf::from(folder.at(name));
        let is = |file: &str| is_view(&at("a/out.exr"), &at(file));
        assert!(is("a/out.records.png") && is("a/./out.cut-2.png") && is("a/../a/out.tree.png"));
        let others = ["a/out.png", "out.records.png", "a/out.Records.png", "a/other.records.png"];
        assert!(others.iter().all(|file| !is(file)));
    }
}
