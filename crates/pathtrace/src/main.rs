//! `pathtrace`: the reference picture of a scene.

use std::process::ExitCode;

use clap::Parser;
use pathtrace::{Params, PathTracer};

/// Path tracing: the reference that the other techniques are compared with.
///
/// Errors show as noise. Small lamps are found rarely by `--mode path` if mirrors or glass focus their light (caustics).
/// `--mode light` finds that light, but shows nothing that is seen in mirrors or through glass. `--mode bdpt` combines
/// both. `--mode vcm` also merges paths as photon mapping does: it finds all light, and blurs caustics over a radius that
/// shrinks from pass to pass. The other modes are unbiased.
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
