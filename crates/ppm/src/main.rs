//! `ppm`: renders by progressive photon mapping.

use std::process::ExitCode;

use clap::Parser;
use ppm::{Params, Ppm};

/// Progressive photon mapping: passes of photons, gathered within a radius that shrinks from pass to pass [slides
/// 35-46].
///
/// It finds light that path tracing cannot find: light through glass onto a surface that is seen through glass. Each pass
/// traces photons. Then every pixel gathers them at the first surface that is rough enough; rays follow mirrors, glass
/// and sharp gloss. Errors show as blur, which disappears with more passes, and as blotches where few photons arrive.
#[derive(Parser)]
#[command(name = "ppm", version)]
struct Program {
    #[command(flatten)]
    args: gi_cli::Args<Params>,
}

impl gi_cli::Program for Program {
    type Params = Params;
    type Technique<'a> = Ppm<'a>;

    fn args(&self) -> &gi_cli::Args<Params> {
        &self.args
    }
}

fn main() -> ExitCode {
    gi_cli::main::<Program>()
}
