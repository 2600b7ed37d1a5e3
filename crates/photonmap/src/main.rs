//! `photonmap`: a picture by photon mapping.

use std::process::ExitCode;

use clap::Parser;
use photonmap::{Params, PhotonMapping};

/// Photon mapping: photons traced from the lights, density estimates, final gathering [slides 21-34].
///
/// Errors show as blur: caustics are soft, and light leaks between surfaces that are close to each other. With too few
/// photons, they show as blotches. More photons give a sharper picture, more photons per estimate (--lookup) a smoother one.
#[derive(Parser)]
#[command(name = "photonmap", version)]
struct Program {
    #[command(flatten)]
    args: gi_cli::Args<Params>,
}

impl gi_cli::Program for Program {
    type Params = Params;
    type Technique<'a> = PhotonMapping<'a>;
    const PASSES: &str = "16";

    fn args(&self) -> &gi_cli::Args<Params> {
        &self.args
    }
}

fn main() -> ExitCode {
    gi_cli::main::<Program>()
}
