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
    /// At both ends: every vertex of one path is connected with every vertex of the other
    Bdpt,
}

/// How the ways to find a path are weighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Heuristic {
    /// In proportion to their densities
    Balance,
    /// In proportion to the squares of their densities
    Power,
}

/// The options of path tracing.
#[derive(Args, Clone, Copy, Debug, PartialEq, Eq)]
#[command(arg(rr_depth()))]
pub struct Params {
    /// Where paths start
    #[arg(long, value_enum, default_value_t = Mode::Path)]
    pub mode: Mode,
    /// bdpt: weights of the ways to find a path [Veach97, 9.2]
    #[arg(long, value_enum, default_value_t = Heuristic::Power)]
    pub heuristic: Heuristic,
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
        !matches!(self.mode, Mode::Path)
    }

    fn finds_focused_light(&self) -> bool {
        matches!(self.mode, Mode::Light | Mode::Bdpt)
    }
}
