//! `irrcache`: a picture by irradiance caching.

use std::process::ExitCode;

use clap::Parser;
use irrcache::{IrradianceCaching, Params};

/// Irradiance caching: indirect light of diffuse surfaces, interpolated from a few records of irradiance [slides 5-14].
///
/// The picture is smooth where path tracing is noisy, but biased: with too few --rays it has blotches, and with a coarse
/// --accuracy it lacks indirect shadows. Glossy lobes and direct light are path-traced.
#[derive(Parser)]
#[command(name = "irrcache", version)]
struct Program {
    #[command(flatten)]
    args: gi_cli::Args<Params>,
}

impl gi_cli::Program for Program {
    type Params = Params;
    type Technique<'a> = IrradianceCaching<'a>;
    const PASSES: &str = "16";

    fn args(&self) -> &gi_cli::Args<Params> {
        &self.args
    }
}

fn main() -> ExitCode {
    gi_cli::main::<Program>()
}
