//! The options of irradiance caching.

use std::path::PathBuf;

use clap::Args;
use gi_core::options::{CausticOptions, Parameters, PathLimits, defaults};
use lightcache::control::{ErrorControl, SphereRadius};
use lightcache::options::{CacheFigure, CacheFiles, Gradients, ReachOptions, Weights, accuracy};

/// The options of irradiance caching.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct Params {
    /// How long paths may be.
    #[command(flatten)]
    pub limits: PathLimits,
    /// How light focused by mirrors and glass is found.
    #[command(flatten)]
    pub caustics: CausticOptions,
    /// Number of gather rays per record [slides 7, 12-14]; fewer rays show as blotches
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(8..=10_000_000))]
    pub rays: u32,
    /// Accuracy a, the allowed relative error: a record is used where its weight w > 1/a [slide 11]; smaller values
    /// make more records
    #[arg(long, value_name = "A", default_value_t = 0.1, value_parser = accuracy())]
    pub accuracy: f32,
    /// Number of cache levels; gather rays read the next level, one bounce per level [default: gather rays are full
    /// paths]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8))]
    pub bounces: Option<u32>,
    /// How the error of a record is estimated
    #[arg(long, value_enum, default_value_t = ErrorControl::HessianOcclusion)]
    pub error: ErrorControl,
    /// Which distance to its surroundings is the radius of the split sphere [slide 9]
    #[arg(long, value_enum, default_value_t = SphereRadius::Harmonic)]
    pub radius: SphereRadius,
    /// Where records are valid.
    #[command(flatten)]
    pub reach: ReachOptions,
    /// Gradients that interpolation uses [slides 12, 14]
    #[arg(long, value_enum, default_value_t = Gradients::Both)]
    pub gradients: Gradients,
    /// How records are weighted
    #[arg(long, value_enum, default_value_t = Weights::Smooth)]
    pub weights: Weights,
    /// Files of the cache.
    #[command(flatten)]
    pub files: CacheFiles,
    /// Pictures of the cache to draw, separated by commas; each becomes OUT.NAME.png and layers of the EXR
    #[arg(long = "show", value_name = "SHOW", value_enum, value_delimiter = ',')]
    pub figures: Vec<CacheFigure>,
}

impl Default for Params {
    fn default() -> Self {
        defaults()
    }
}

impl Params {
    /// Number of cache levels.
    pub(crate) fn levels(&self) -> usize {
        self.bounces.unwrap_or(1).max(1) as usize
    }

    /// Whether the records of cache `level` contain the light of a vertex after `segments` segments. With `max_depth`,
    /// a record is valid only at the depth it was created for, and the last vertex of a path has no indirect light.
    pub(crate) fn covers_depth(&self, segments: u32, level: usize) -> bool {
        match self.limits.max_depth {
            None => true,
            Some(_) => segments == 1 + level as u32 && self.limits.goes_on(segments + 1),
        }
    }
}

impl Parameters for Params {
    fn check(&self) -> Result<(), String> {
        self.reach.check()
    }

    fn max_depth(&self) -> Option<u32> {
        self.limits.max_depth
    }

    fn finds_focused_light(&self, _: bool) -> bool {
        self.caustics.by_photons()
    }

    fn outputs(&self) -> Vec<PathBuf> {
        self.files.outputs()
    }
}
