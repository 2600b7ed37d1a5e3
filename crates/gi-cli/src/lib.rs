//! What every program shares: flags, budget, progress, signals, previews, saving, statistics. A program states its name, its description and
//! its technique as a [`Program`]; its `main` is [`main`].
//!
//! Exit status: 0, 1 (something failed on the way), 2 (bad usage or input), 128 + the number of the signal that stopped the run.
#![forbid(unsafe_code)]
// They panic when nobody reads them.
#![warn(clippy::print_stdout, clippy::print_stderr)]

mod budget;
mod checkpoint;
mod common;
mod display;
mod finish;
mod help;
mod identity;
mod inspect;
mod merge;
mod passes;
mod paths;
mod presets;
mod preview;
mod progress;
mod record;
mod run;
mod save;
mod say;
mod sensors;
mod serve;
mod stop;
mod views;
mod warnings;

use std::process::ExitCode;

use clap::Parser;
use gi_core::options::Parameters;
use gi_core::technique::Technique;

pub use budget::{Budget, parse_time};
pub use common::Common;
pub use help::generate;
pub use identity::VERSION;
pub use say::{print, say};
pub use serve::Address;
pub use stop::{Signal, on_signal, send};

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

    /// Default number of passes. Two processors should make them in less than two minutes for a picture of 512 x 512.
    const PASSES: &str = "64";
    /// Default number of rays per pixel and pass that look for light sources in view.
    const SOURCE_RAYS: &str = "0";

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

impl Failure {
    /// What went wrong.
    fn text(&self) -> &str {
        match self {
            Failure::Input(text) | Failure::Other(text) => text,
        }
    }
}

/// Run a program.
pub fn main<P: Program>() -> ExitCode {
    let arguments: Vec<String> = match std::env::args_os().map(|a| a.into_string()).collect() {
        Ok(arguments) => arguments,
        Err(bad) => {
            say(format!("error: the argument {bad:?} is not valid UTF-8"));
            return ExitCode::from(2);
        }
    };
    if let [_, flag, what] = &arguments[..]
        && flag == help::GENERATE
    {
        return generate(command::<P>(), what);
    }
    match run::run::<P>(&arguments) {
        Ok(None) => ExitCode::SUCCESS,
        Ok(Some(signal)) => ExitCode::from(signal.exit_status()),
        Err(Failure::Input(text)) => {
            say(text.trim_end());
            ExitCode::from(2)
        }
        Err(Failure::Other(text)) => {
            say(format!("error: {text}"));
            ExitCode::from(1)
        }
    }
}

/// The command line of a program.
fn command<P: Program>() -> clap::Command {
    let arranged = help::arranged(P::command()).args_override_self(true);
    let by_default = |value| move |arg: clap::Arg| arg.required(false).default_value(value);
    let arranged = arranged.mut_arg("spp", by_default(P::PASSES));
    arranged.mut_arg("source_rays", by_default(P::SOURCE_RAYS)).version(VERSION)
}

/// Parse a command line in which a later flag wins over an earlier one; `--help` and usage errors end the process
/// as clap would.
fn parse<P: Program>(arguments: &[String]) -> (P, clap::ArgMatches) {
    let matches = command::<P>().get_matches_from(arguments);
    (P::from_arg_matches(&matches).unwrap_or_else(|e| e.exit()), matches)
}
