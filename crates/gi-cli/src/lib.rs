//! What every program shares: flags, budget, progress, saving, statistics. A program brings its technique and
//! its own knobs, as a [`Program`]; its `main` is [`main`].
//!
//! Exit status: 0, 1 (something failed on the way), 2 (bad usage or input).
#![forbid(unsafe_code)]

mod budget;
mod checkpoint;
mod common;
mod passes;
mod presets;
mod progress;
mod run;
mod save;
mod values;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use gi_core::technique::Technique;

pub use budget::{Budget, parse_time};
pub use common::{Common, Component};
pub use values::{
    Caustics, Compensation, check_points_file, check_spacings, is_table, parse_accuracy,
    parse_bound, parse_pixel, parse_spacing,
};

/// A program: its command line, and what it makes of it.
pub trait Program: Parser {
    /// The technique's parameters.
    type Params;
    /// The technique.
    type Technique<'a>: Technique<'a, Params = Self::Params>;

    /// The flags that all programs have.
    fn common(&self) -> &Common;

    /// The technique's parameters, from its flags.
    ///
    /// # Errors
    /// One line about flags, or files they name, that cannot be used.
    fn params(&self) -> Result<Self::Params, String>;

    /// Whether light is absorbed and scattered by the scene's media.
    fn knows_media(&self) -> bool {
        false
    }

    /// Whether light that mirrors and glass focus is found from the lights, so that it needs no luck.
    fn finds_focused_light(&self) -> bool {
        false
    }

    /// Files that the flags ask for besides the picture. They are found to be writable before the work, and
    /// written after it.
    fn outputs(&self) -> Vec<PathBuf> {
        Vec::new()
    }

    /// What one of [`Program::outputs`] is to hold.
    fn export(&self, _technique: &Self::Technique<'_>, path: &Path) -> Vec<u8> {
        unreachable!("{} was not asked for", path.display())
    }
}

/// Why a run ended without a picture.
#[derive(Debug)]
enum Failure {
    /// The command line or the scene is wrong.
    Input(String),
    /// Something else did not work.
    Other(String),
}

/// Read a file that a flag names.
///
/// # Errors
/// One line with the file's name and the cause.
pub fn read_input(path: &Path) -> Result<Vec<u8>, String> {
    let cannot = |why: &dyn std::fmt::Display| format!("cannot read {}: {why}", path.display());
    // Devices may go on for ever.
    if !path.metadata().map_err(|e| cannot(&e))?.is_file() {
        return Err(cannot(&"it is no file"));
    }
    std::fs::read(path).map_err(|e| cannot(&e))
}

/// Run a program.
pub fn main<P: Program>() -> ExitCode {
    let arguments: Vec<String> = match std::env::args_os().map(|a| a.into_string()).collect() {
        Ok(arguments) => arguments,
        Err(bad) => {
            eprintln!("error: the argument {bad:?} is not valid UTF-8");
            return ExitCode::from(2);
        }
    };
    match run::run::<P>(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Input(text)) => {
            eprintln!("{}", text.trim_end());
            ExitCode::from(2)
        }
        Err(Failure::Other(text)) => {
            eprintln!("error: {text}");
            ExitCode::from(1)
        }
    }
}

/// Parse a command line in which a later flag wins over an earlier one; `--help` and usage errors end the process
/// as clap would.
fn parse<P: Program>(arguments: &[String]) -> P {
    let command = P::command().args_override_self(true);
    let matches = command.get_matches_from(arguments);
    P::from_arg_matches(&matches).unwrap_or_else(|e| e.exit())
}
