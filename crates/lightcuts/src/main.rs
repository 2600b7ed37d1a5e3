//! `lightcuts`: renders with very many point lights.

use std::process::ExitCode;

use clap::Parser;
use lightcuts::{Lightcuts, Params};

/// Lightcuts: all light comes from point lights, and each point is lit by a few clusters of them [slides 53-61].
///
/// With few --lights or --vpls, each light shows as a hard shadow or a bright spot. A large --error shows as patches
/// where cuts change. A small --max-cut shows in the dark and near many lights (at_max_cut in the statistics).
///
/// One pass takes up to a minute and a half on two processors. More passes (--spp) smooth edges, and average over new
/// lights.
#[derive(Parser)]
#[command(name = "lightcuts", version)]
struct Program {
    #[command(flatten)]
    args: gi_cli::Args<Params>,
}

impl gi_cli::Program for Program {
    type Params = Params;
    type Technique<'a> = Lightcuts<'a>;

    const PASSES: &str = "1";
    const SOURCE_RAYS: &str = "32";

    fn args(&self) -> &gi_cli::Args<Params> {
        &self.args
    }
}

fn main() -> ExitCode {
    gi_cli::main::<Program>()
}
