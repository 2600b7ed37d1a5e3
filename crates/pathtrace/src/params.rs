//! The options of path tracing.

use clap::{Args, ValueEnum};
use gi_core::options::{Parameters, PathLimits, defaults, rr_depth};

/// Where paths start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Mode {
    /// At the eye; light sampling at each vertex is combined with BSDF sampling by the power heuristic
    Path,
    /// The same, with absorption and scattering in participating media
    #[value(name = "volpath")]
    VolPath,
    /// At the lights; each vertex, on a surface or in a medium, is connected to the eye
    Light,
}

/// The options of path tracing.
#[derive(Args, Clone, Copy, Debug, PartialEq, Eq)]
#[command(arg(rr_depth()))]
pub struct Params {
    /// Where paths start
    #[arg(long, value_enum, default_value_t = Mode::Path)]
    pub mode: Mode,
    /// How long paths may be.
    #[command(flatten)]
    pub limits: PathLimits,
}

impl Default for Params {
    fn default() -> Self {
        defaults()
    }
}

impl Parameters for Params {
    fn max_depth(&self) -> Option<u32> {
        self.limits.max_depth
    }

    fn simulates_media(&self) -> bool {
        matches!(self.mode, Mode::VolPath | Mode::Light)
    }

    fn finds_focused_light(&self) -> bool {
        self.mode == Mode::Light
    }
}
