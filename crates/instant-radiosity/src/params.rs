//! The options of instant radiosity.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use gi_core::files::points_file;
use gi_core::options::{CausticOptions, Parameters, PathLimits, defaults, number, pixel};
use vpl::{BoundOptions, Direct, Termination};

/// A picture of the lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Figure {
    /// Positions of the lights: white on light sources, others from bright (1 segment) to dark (4 or more) [slide 49]
    Vpls,
    /// Shadow rays from a pixel to all lights: green if unoccluded, orange if occluded [slide 50]
    Connections,
}

/// The options of instant radiosity.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct Params {
    /// How long paths may be.
    #[command(flatten)]
    pub limits: PathLimits,
    /// Approximate number of virtual point lights per pass [slides 49-52]
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    pub vpls: u32,
    /// When light paths end
    #[arg(long, value_enum, default_value_t = Termination::Roulette)]
    pub termination: Termination,
    /// The bound on bright spots near lights.
    #[command(flatten)]
    pub bound: BoundOptions,
    /// How light focused by mirrors and glass is found.
    #[command(flatten)]
    pub caustics: CausticOptions,
    /// Let the bound grow with the passes k = 0, 1, ...: it is then clamp (k + 1)^R; 0 keeps it constant
    #[arg(long, value_name = "R", default_value_t = 0.0, value_parser = number("a number from 0 to 2", |r: &f32| (0.0..=2.0).contains(r)))]
    pub relaxation: f32,
    /// Use spheres that just overlap as lights instead of points: needs no bound, but blurs
    #[arg(long)]
    pub vsl: bool,
    /// Number of directions over which the light of a sphere is integrated
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub vsl_samples: u32,
    /// How direct light is found
    #[arg(long, value_enum, default_value_t = Direct::Sample)]
    pub direct: Direct,
    /// Write the lights of the last pass as a point cloud (.ply) or a table (.csv)
    #[arg(long, value_name = "FILE.ply|.csv", value_parser = points_file)]
    pub vpls_out: Option<PathBuf>,
    /// Pictures of the lights to draw, separated by commas; each becomes OUT.NAME.png and layers of the EXR
    #[arg(long = "show", value_name = "SHOW", value_enum, value_delimiter = ',')]
    pub figures: Vec<Figure>,
    /// Pixel whose connections --show connections draws [default: the middle of the picture]
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pub pixel: Option<[usize; 2]>,
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

    fn finds_focused_light(&self, _: bool) -> bool {
        self.caustics.by_photons()
    }

    fn outputs(&self) -> Vec<PathBuf> {
        self.vpls_out.iter().cloned().collect()
    }
}
