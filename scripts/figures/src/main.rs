//! Tools that the figures' recipes (`scripts/figures.mk`) need in addition to the programs: tables of errors, curves,
//! maps of differences, and a page with all figures.
//!
//! All tools use only files that the programs wrote. The same files give the same output, byte for byte.
#![forbid(unsafe_code)]

mod cuts;
mod data;
mod deck;
mod difference;
mod expr;
mod figure;
mod flow;
mod index;
mod inset;
mod measure;
mod picture;
mod plot;
mod strip;
mod svg;
mod table;
mod tree;
mod view;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Draw tables, curves and pages of the lecture's figures from the programs' output.
#[derive(Parser)]
#[command(name = "figures", version)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write the errors of pictures against a reference as a table: x, seconds, pass_seconds, relmse, rmse, ratio_r, ratio_g, ratio_b, noise, bias
    Measure(measure::Args),
    /// Draw curves from the columns of tables
    Plot(plot::Args),
    /// Draw where a picture is too bright or too dark, in false colours with a legend
    Difference(difference::Args),
    /// Write the display image of a picture or of one of its layers
    View(view::Args),
    /// Join pictures to a strip, with a name and a time below each
    Strip(strip::Args),
    /// Draw the steps of a program, with numbers from a real run
    Flow(flow::Args),
    /// Draw the cuts of a few lights: for each its picture, its tree and its errors
    Cuts(cuts::Args),
    /// Draw a light tree with the cut of a pixel
    Tree(tree::Args),
    /// Check the panels and the claims of one figure, and write its figure.json
    Figure(figure::Args),
    /// Write all figures to one self-contained page
    Index(index::Args),
    /// Write all figures as slides, one per page, to one self-contained page
    Deck(index::Args),
    /// Write the first panel of each figure as a small picture, for a contact sheet
    Thumbs(index::ThumbArgs),
}

/// A file with a name: `NAME=FILE`.
#[derive(Clone, Debug)]
pub(crate) struct Named {
    pub(crate) name: String,
    pub(crate) file: PathBuf,
}

impl std::str::FromStr for Named {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // Split at the last `=`: names may contain it, our files do not.
        let (name, file) = text.rsplit_once('=').ok_or("expected NAME=FILE")?;
        Ok(Named { name: name.into(), file: file.into() })
    }
}

fn main() -> ExitCode {
    let done = match Args::parse().command {
        Command::Measure(args) => measure::run(&args),
        Command::Plot(args) => plot::run(&args),
        Command::Difference(args) => difference::run(&args),
        Command::View(args) => view::run(&args),
        Command::Strip(args) => strip::run(&args),
        Command::Flow(args) => flow::run(&args),
        Command::Cuts(args) => cuts::run(&args),
        Command::Tree(args) => tree::run(&args),
        Command::Figure(args) => figure::run(&args),
        Command::Index(args) => index::run(&args),
        Command::Deck(args) => deck::run(&args),
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
