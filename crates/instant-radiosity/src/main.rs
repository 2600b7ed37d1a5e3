//! `instant-radiosity`: a picture by virtual point lights.

use std::process::ExitCode;

use clap::Parser;
use instant_radiosity::{InstantRadiosity, Params};

/// Instant radiosity: indirect light from virtual point lights, averaged over passes as in an accumulation buffer
/// [slides 47-52].
///
/// With few --vpls and few passes, each light casts a visible hard shadow. Without --clamp, a light shows as a bright
/// spot on surfaces near it. With --clamp but without --compensation, corners are too dark; energy_cut in the
/// statistics is the lost share.
#[derive(Parser)]
#[command(name = "instant-radiosity", version)]
struct Program {
    #[command(flatten)]
    args: gi_cli::Args<Params>,
}

impl gi_cli::Program for Program {
    type Params = Params;
    type Technique<'a> = InstantRadiosity<'a>;
    const PASSES: &str = "16";

    fn args(&self) -> &gi_cli::Args<Params> {
        &self.args
    }
}

fn main() -> ExitCode {
    gi_cli::main::<Program>()
}
