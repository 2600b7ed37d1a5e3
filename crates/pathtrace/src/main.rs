//! `pathtrace`: the reference picture of a scene.

use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use gi_cli::{Common, Program};
use gi_core::eye::PathLimits;
use pathtrace::{Mode, Params, PathTracer};

/// Path tracing: the truth that the other techniques are compared with.
///
/// Every estimate is unbiased; what it does badly shows as noise. `--mode path` is slow where small lights are focused
/// by mirrors and glass (caustics); `--mode light` finds those, but nothing that is seen through mirrors and glass.
#[derive(Parser)]
#[command(name = "pathtrace", version)]
struct Args {
    #[command(flatten)]
    common: Common,
    /// Which end paths begin at
    #[arg(long, value_enum, default_value_t = ModeFlag::Path)]
    mode: ModeFlag,
    /// Segments after which Russian roulette may end a path
    #[arg(long, value_name = "N", default_value_t = PathLimits::default().rr_depth)]
    rr_depth: u32,
}

#[derive(Clone, Copy, ValueEnum)]
enum ModeFlag {
    /// From the eye, light sampled at each vertex, both weighted by the power heuristic
    Path,
    /// The same, absorbed and scattered by participating media
    Volpath,
    /// From the lights, each vertex connected to the eye, through participating media too
    Light,
}

impl Program for Args {
    type Params = Params;
    type Technique<'a> = PathTracer<'a>;

    fn common(&self) -> &Common {
        &self.common
    }

    fn knows_media(&self) -> bool {
        matches!(self.mode, ModeFlag::Volpath | ModeFlag::Light)
    }

    fn finds_focused_light(&self) -> bool {
        matches!(self.mode, ModeFlag::Light)
    }

    fn params(&self) -> Result<Params, String> {
        let mode = match self.mode {
            ModeFlag::Path => Mode::Path,
            ModeFlag::Volpath => Mode::VolPath,
            ModeFlag::Light => Mode::Light,
        };
        let limits = PathLimits { max_depth: self.common.max_depth(), rr_depth: self.rr_depth };
        Ok(Params { mode, limits })
    }
}

fn main() -> ExitCode {
    gi_cli::main::<Args>()
}
