//! Compares techniques: runs their programs on one scene, or reads finished pictures, and measures how far each is from
//! a reference. The results are numbers, error maps and plots on one page.
//!
//! | | |
//! |---|---|
//! | runs | each program as its user would run it, one after the other, with equal time or equal passes |
//! | time | preparation and all passes; reading the scene and building its tree are not included |
//! | reference | given pictures, or two halves made by a program with separate seeds and kept; their difference estimates the reference's noise |
//! | errors | [`gi_stats::metrics`], [`gi_stats::flip`]; pixels that are not finite are counted and excluded |
//! | bias, variance | from several seeds, [`gi_stats::split`] |
//! | error against time | from runs with half the time, a quarter, and so on; slopes by least squares in logarithms |
//! | output | a folder: `index.html`, which needs no other file, and the pictures and statistics of the runs |
//! | sources | \[Andersson20\], \[Andersson21\] |
#![forbid(unsafe_code)]
// These macros panic when the reading end of the output is closed.
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

/// Why a comparison failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The given pictures, scene or flags cannot be compared.
    Input(String),
    /// Something else failed.
    Other(String),
}

/// The budget of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// Time for preparation and passes.
    Time(Duration),
    /// A number of passes.
    Passes(u32),
}

impl Budget {
    /// The program's flag for this budget.
    pub fn flag(self) -> [String; 2] {
        match self {
            Budget::Time(time) => ["--time".into(), format!("{}s", time.as_secs_f64())],
            Budget::Passes(n) => ["--spp".into(), n.to_string()],
        }
    }

    /// This budget multiplied by `factor`.
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
    /// The runs.
    pub runs: Vec<Run>,
    /// The budget of each run.
    pub budget: Budget,
    /// Number of independent seeds per run; with two or more, bias and variance are measured.
    pub seeds: u32,
    /// The first seed.
    pub seed: u32,
    /// Number of budgets: the whole, half of it, a quarter...
    pub ladder: u32,
    /// Flags for all runs, including the reference.
    pub flags: Vec<String>,
}

/// What to compare.
#[derive(Clone, Debug)]
pub enum Subjects {
    /// Finished pictures: `FILE` or `FILE#LAYER`.
    Files(Vec<String>),
    /// Runs to make.
    Series(Series),
}

/// What to compare with.
#[derive(Clone, Debug)]
pub enum Truth {
    /// Finished pictures; their mean is the reference.
    Files(Vec<String>),
    /// Two runs of a program with half the budget each. They are kept in the folder and reused while they match.
    Run(Run, Budget),
}

/// A request for a comparison.
#[derive(Clone, Debug)]
pub struct Request {
    /// What to compare.
    pub subjects: Subjects,
    /// What to compare with.
    pub truth: Truth,
    /// Layer of all pictures whose file name does not select one; `None` means the radiance.
    pub layer: Option<String>,
    /// Folder for all output.
    pub folder: PathBuf,
    /// File to write the numbers to, in addition to the page.
    pub json: Option<PathBuf>,
    /// The programs.
    pub programs: Programs,
    /// The command line, for the page.
    pub command: String,
    /// Remarks to print with the results.
    pub remarks: Vec<String>,
    /// Whether to suppress progress messages.
    pub quiet: bool,
}

impl Request {
    /// The input files of the request.
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

/// Run a comparison and write its page.
///
/// # Errors
/// Input that cannot be compared, runs that fail, and files that cannot be read or written. No page is written then.
pub fn compare(request: &Request) -> Result<Report, Failure> {
    let made = !request.folder.exists();
    let done = try_to_compare(request);
    if done.is_err() && made {
        let _ = std::fs::remove_dir(&request.folder); // removes the folder only if it is empty
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

/// A path as text for messages.
fn show(path: &Path) -> String {
    path.display().to_string()
}
