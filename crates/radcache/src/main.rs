//! `radcache`: a picture by radiance caching.

use std::process::ExitCode;

use clap::Parser;
use radcache::{Params, RadianceCaching};

/// Radiance caching: indirect light of diffuse and rough glossy surfaces, interpolated from a few records [slides
/// 15-20].
///
/// Diffuse surfaces use irradiance records, as in irrcache. Glossy lobes with a roughness of at least --min-roughness
/// use records of radiance in spherical harmonics, which serve every view. Sharper lobes and direct light are
/// path-traced. The picture is biased: with a low --order, reflections blur, and bright ones show rings.
#[derive(Parser)]
#[command(name = "radcache", version)]
struct Program {
    #[command(flatten)]
    args: gi_cli::Args<Params>,
}

impl gi_cli::Program for Program {
    type Params = Params;
    type Technique<'a> = RadianceCaching<'a>;
    const PASSES: &str = "16";

    fn args(&self) -> &gi_cli::Args<Params> {
        &self.args
    }
}

fn main() -> ExitCode {
    gi_cli::main::<Program>()
}
