//! What every program shares: flags, budget, progress, saving, statistics. A program states its name, its description and
//! its technique as a [`Program`]; its `main` is [`main`].
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

use std::process::ExitCode;

use clap::Parser;
use gi_core::options::Parameters;
use gi_core::technique::Technique;

pub use budget::{Budget, parse_time};
pub use common::Common;

/// A command line: the flags that all programs have, and the parameters of a technique.
#[derive(clap::Args, Clone, Debug)]
#[group(skip)]
pub struct Args<P: clap::Args> {
    /// The flags that all programs have.
    #[command(flatten)]
    pub common: Common,
    /// The technique's own flags.
    #[command(flatten)]
    pub params: P,
}

/// A program: a parser with the program's name and description, and the technique that it runs.
pub trait Program: Parser {
    /// The technique's parameters.
    type Params: Parameters;
    /// The technique.
    type Technique<'a>: Technique<'a, Params = Self::Params>;

    /// What was parsed.
    fn args(&self) -> &Args<Self::Params>;
}

/// Why a run ended without a picture.
#[derive(Debug)]
enum Failure {
    /// The command line or the scene is wrong.
    Input(String),
    /// Something else did not work.
    Other(String),
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
