//! What the figures' recipes (`scripts/figures.mk`) need besides the programs: errors of pictures as a table, curves, maps of
//! differences, and one figure after the other on a page.
//!
//! Everything is drawn from files that the programs wrote. The same files make the same bytes.
#![forbid(unsafe_code)]

mod difference;
mod figure;
mod flow;
mod index;
mod measure;
mod picture;
mod plot;
mod svg;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Tables, curves and pages of the lecture's figures, from what the programs wrote.
#[derive(Parser)]
#[command(name = "figures", version)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Errors of pictures against a reference, as a table: x, seconds, relmse, rmse, ratio_r, ratio_g, ratio_b
    Measure(measure::Args),
    /// Curves from the columns of tables
    Plot(plot::Args),
    /// Where a picture is too bright or too dark, in false colours with a legend
    Difference(difference::Args),
    /// The steps of a program, with numbers of a real run
    Flow(flow::Args),
    /// One figure: its panels checked, and its sidecar figure.json written
    Figure(figure::Args),
    /// All figures on one self-contained page
    Index(index::Args),
    /// The first panel of every figure, small, for a contact sheet
    Thumbs(index::ThumbArgs),
}

/// A file with a name before it: `NAME=FILE`.
#[derive(Clone, Debug)]
pub(crate) struct Named {
    pub(crate) name: String,
    pub(crate) file: PathBuf,
}

impl std::str::FromStr for Named {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // The last sign: names may hold one, files of ours do not.
        let (name, file) = text.rsplit_once('=').ok_or("expected NAME=FILE")?;
        Ok(Named { name: name.into(), file: file.into() })
    }
}

fn main() -> ExitCode {
    let done = match Args::parse().command {
        Command::Measure(args) => measure::run(&args),
        Command::Plot(args) => plot::run(&args),
        Command::Difference(args) => difference::run(&args),
        Command::Flow(args) => flow::run(&args),
        Command::Figure(args) => figure::run(&args),
        Command::Index(args) => index::run(&args),
        Command::Thumbs(args) => index::thumbs(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("figures: {error:#}");
            ExitCode::FAILURE
        }
    }
}
