//! Techniques side by side: runs their programs on one scene, or takes finished pictures, and says how far each is
//! from a reference: in numbers, maps, plots, on one page.
//!
//! | | |
//! |---|---|
//! | runs | each program as its user would run it, one after the other, at equal time or equal passes |
//! | time | from before preparing to after the last pass; reading the scene and building its tree are apart |
//! | reference | pictures that are given, or two halves that a program makes with seeds of their own and that are kept: their difference tells the reference's noise |
//! | errors | [`gi_stats::metrics`], [`gi_stats::flip`]; pixels that are not finite are counted and left out |
//! | bias, variance | from several seeds, [`gi_stats::split`] |
//! | error against time | from runs of half the time, a quarter, and so on; slopes by least squares in logarithms |
//! | what it leaves | a folder: `index.html`, which needs nothing else, and the pictures and statistics of the runs |
//! | sources | \[Andersson20\], \[Andersson21\] |
#![forbid(unsafe_code)]
// They panic when nobody reads them.
#![warn(clippy::print_stdout, clippy::print_stderr)]

mod child;
mod measure;
mod page;
mod picture;
mod plan;
mod planes;
mod plot;
mod programs;
mod reference;
mod report;
mod subject;
mod subjects;
mod text;

use std::path::{Path, PathBuf};
use std::time::Duration;

pub use child::stop;
pub use measure::{Entry, Errors, Rung};
pub use picture::{Picture, is_picture};
pub use plan::{Run, plan};
pub use programs::{Finished, Programs, Stats};
pub use report::Report;
pub use text::command_line;

/// Why there is no comparison.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// What was given cannot be compared.
    Input(String),
    /// Something else did not work.
    Other(String),
}

/// How much a run may spend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// Time for preparing and passes.
    Time(Duration),
    /// A number of passes.
    Passes(u32),
}

impl Budget {
    /// The flag that gives it to a program.
    pub fn flag(self) -> [String; 2] {
        match self {
            Budget::Time(time) => ["--time".into(), format!("{}s", time.as_secs_f64())],
            Budget::Passes(n) => ["--spp".into(), n.to_string()],
        }
    }

    /// This many times as much.
    pub fn times(self, factor: f64) -> Budget {
        match self {
            Budget::Time(time) => Budget::Time(time.mul_f64(factor)),
            Budget::Passes(n) => Budget::Passes((f64::from(n) * factor).round().max(1.0) as u32),
        }
    }
}

/// Runs to make.
#[derive(Clone, Debug)]
pub struct Series {
    /// Scene file.
    pub scene: PathBuf,
    /// What runs.
    pub runs: Vec<Run>,
    /// What each may spend.
    pub budget: Budget,
    /// Independent seeds of each run; bias and variance are told apart from two on.
    pub seeds: u32,
    /// The first of them.
    pub seed: u32,
    /// Budgets in all: the whole, half of it, a quarter...
    pub ladder: u32,
    /// Flags that all runs get, the reference too.
    pub flags: Vec<String>,
}

/// What is compared.
#[derive(Clone, Debug)]
pub enum Subjects {
    /// Finished pictures: `FILE` or `FILE#LAYER`.
    Files(Vec<String>),
    /// Runs to make.
    Series(Series),
}

/// What it is compared with.
#[derive(Clone, Debug)]
pub enum Truth {
    /// Finished pictures: the mean of them.
    Files(Vec<String>),
    /// Two runs of a program, with half the budget each, kept in the folder and used again while it fits.
    Run(Run, Budget),
}

/// A comparison to make.
#[derive(Clone, Debug)]
pub struct Request {
    /// What is compared.
    pub subjects: Subjects,
    /// What it is compared with.
    pub truth: Truth,
    /// Layer of all pictures, where a file does not name its own; the radiance without.
    pub layer: Option<String>,
    /// Folder for all that is written.
    pub folder: PathBuf,
    /// File for the numbers besides the page.
    pub json: Option<PathBuf>,
    /// The programs.
    pub programs: Programs,
    /// The command line, for the page.
    pub command: String,
    /// What is to be said beside the results.
    pub remarks: Vec<String>,
    /// Whether to keep silent about what is going on.
    pub quiet: bool,
}

impl Request {
    /// The files that it names.
    fn inputs(&self) -> Vec<PathBuf> {
        let pictures = |names: &[String]| names.iter().map(|n| picture::file(n)).collect();
        let mut all: Vec<PathBuf> = match &self.subjects {
            Subjects::Files(names) => pictures(names),
            Subjects::Series(series) => vec![series.scene.clone()],
        };
        if let Truth::Files(names) = &self.truth {
            all.extend(pictures(names));
        }
        all
    }
}

/// Make a comparison and write its page.
///
/// # Errors
/// What cannot be compared, run, read or written; then no page is written.
pub fn compare(request: &Request) -> Result<Report, Failure> {
    let made = !request.folder.exists();
    let done = try_to_compare(request);
    if done.is_err() && made {
        let _ = std::fs::remove_dir(&request.folder); // only an empty folder goes
    }
    done
}

fn try_to_compare(request: &Request) -> Result<Report, Failure> {
    text::check_writable(&request.folder, request.json.as_deref())?;
    if let Some(json) = &request.json {
        let mut taken = request.inputs();
        taken.push(request.folder.join("index.html"));
        if taken.iter().any(|t| gi_core::files::is_same(t, json)) {
            return Err(Failure::Input(format!(
                "error: --json {} would overwrite another of the comparison's files",
                show(json)
            )));
        }
    }
    let report = match &request.subjects {
        Subjects::Files(files) => subjects::files(request, files)?,
        Subjects::Series(series) => subjects::series(request, series)?,
    };
    let page = page::page(&report)?;
    text::write(&request.folder.join("index.html"), page.as_bytes())?;
    if let Some(path) = &request.json {
        text::write(path, format!("{:#}\n", report.json()).as_bytes())?;
    }
    Ok(report)
}

/// A path as it is shown.
fn show(path: &Path) -> String {
    path.display().to_string()
}
