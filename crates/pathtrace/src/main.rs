//! `pathtrace`: the reference picture of a scene.

use std::process::ExitCode;

use clap::Parser;
use pathtrace::{Params, PathTracer};

/// Path tracing: the reference that the other techniques are compared with.
///
/// Every estimate is unbiased, so errors show as noise. `--mode path` is slow where mirrors and glass focus the light
/// of small lights (caustics). `--mode light` finds such light, but shows nothing that the eye sees through mirrors or
/// glass. `--mode bdpt` joins both, and `--mode vcm` also merges paths as photon maps do: it finds all light, with a blur that
/// shrinks from pass to pass.
#[derive(Parser)]
#[command(name = "pathtrace", version)]
struct Program {
    #[command(flatten)]
    args: gi_cli::Args<Params>,
}

impl gi_cli::Program for Program {
    type Params = Params;
    type Technique<'a> = PathTracer<'a>;

    fn args(&self) -> &gi_cli::Args<Params> {
        &self.args
    }
}

fn main() -> ExitCode {
    gi_cli::main::<Program>()
}
