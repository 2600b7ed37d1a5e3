//! `ppm`: progressive photon mapping.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use gi_cli::{Common, Program, parse_pixel};
use gi_core::eye::PathLimits;
use ppm::{Method, Params, Ppm, Shown};

/// Progressive photon mapping: photons in passes, gathered within a radius that shrinks.
///
/// Finds what path tracing cannot: light through glass onto what is seen through glass. A pass traces photons, then every
/// pixel gathers them. What it does badly shows as blur that goes away with the passes, and as blotches where few photons
/// come. Photons are gathered at the first surface that is rough enough; mirrors, glass and sharp gloss are followed.
#[derive(Parser)]
#[command(name = "ppm", version)]
struct Args {
    #[command(flatten)]
    common: Common,
    /// How the radius comes about
    #[arg(long, value_enum, default_value_t = MethodFlag::Sppm)]
    method: MethodFlag,
    /// Share of a pass's photons that stay [slide 42], above 0, at most 1: 1 keeps the radius, less shrinks it faster
    #[arg(long, value_name = "SHARE", default_value_t = Params::default().alpha)]
    alpha: f64,
    /// Light paths a pass; 0: as many as pixels
    #[arg(long, value_name = "N", default_value_t = Params::default().photons)]
    photons: u32,
    /// Radius to begin with, in scene radii; 0: automatic, see --initial-photons
    #[arg(long, value_name = "R", default_value_t = Params::default().initial_radius)]
    initial_radius: f32,
    /// Photons of a pilot pass that a pixel's disc holds to begin with; more is smoother and blurs more
    #[arg(long, value_name = "K", default_value_t = Params::default().initial_photons, value_parser = clap::value_parser!(u32).range(1..))]
    initial_photons: u32,
    /// Alpha of the sharpest lobe at which photons are gathered; sharper lobes are followed by rays
    #[arg(long, value_name = "ALPHA", default_value_t = Params::default().min_roughness)]
    min_roughness: f32,
    /// Eye paths of a pixel whose ends are its hit points, with --method ppm
    #[arg(long, value_name = "N", default_value_t = Params::default().hit_points, value_parser = clap::value_parser!(u32).range(1..))]
    hit_points: u32,
    /// Gather light that comes straight from lights too, instead of sampling it: as the original, and blurred
    #[arg(long)]
    direct_by_photons: bool,
    /// Segments after which Russian roulette may end an eye path
    #[arg(long, value_name = "N", default_value_t = PathLimits::default().rr_depth)]
    rr_depth: u32,
    /// First scattering at which Russian roulette may end a light path
    #[arg(long, value_name = "N", default_value_t = Params::default().photon_rr_depth)]
    photon_rr_depth: u32,
    /// End when the estimated error is below this: the root of the mean of noise and bias squared over radiance squared; 0: never
    #[arg(long, value_name = "E", default_value_t = Params::default().stop_at_error)]
    stop_at_error: f64,
    /// Draw a map of the statistics as well: OUT.WHAT.png, and layers
    #[arg(long, value_enum, value_name = "WHAT")]
    show: Vec<ShowFlag>,
    /// Write R, N, M and the estimate of this pixel after every pass to --trace-out [slides 40 to 42]
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel, requires = "trace_out")]
    trace_pixel: Vec<[usize; 2]>,
    /// Where the traced pixels go
    #[arg(long, value_name = "FILE.csv", requires = "trace_pixel")]
    trace_out: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum MethodFlag {
    /// Progressive: hit points are found once, each with statistics of its own
    Ppm,
    /// Stochastic: a pixel looks anew in every pass and shares its statistics; blurs by lens and gloss are right
    Sppm,
    /// Probabilistic: one radius, a function of the number of the pass alone
    Ppa,
    /// A radius for every pixel that balances its noise against its bias
    Adaptive,
}

#[derive(Clone, Copy, ValueEnum)]
enum ShowFlag {
    /// R in scene radii, logarithmic
    Radius,
    /// N, logarithmic
    Photons,
    /// Estimated noise and bias, logarithmic
    Error,
}

impl Program for Args {
    type Params = Params;
    type Technique<'a> = Ppm<'a>;

    fn common(&self) -> &Common {
        &self.common
    }

    fn finds_focused_light(&self) -> bool {
        true
    }

    fn params(&self) -> Result<Params, String> {
        let method = match self.method {
            MethodFlag::Ppm => Method::Ppm,
            MethodFlag::Sppm => Method::Sppm,
            MethodFlag::Ppa => Method::Ppa,
            MethodFlag::Adaptive => Method::Adaptive,
        };
        let show = self.show.iter().map(|what| match what {
            ShowFlag::Radius => Shown::Radius,
            ShowFlag::Photons => Shown::Photons,
            ShowFlag::Error => Shown::Error,
        });
        Ok(Params {
            method,
            alpha: self.alpha,
            photons: self.photons,
            initial_radius: self.initial_radius,
            initial_photons: self.initial_photons,
            min_roughness: self.min_roughness,
            hit_points: self.hit_points,
            direct_by_photons: self.direct_by_photons,
            limits: PathLimits { max_depth: self.common.max_depth(), rr_depth: self.rr_depth },
            photon_rr_depth: self.photon_rr_depth,
            stop_at_error: self.stop_at_error,
            show: show.collect(),
            trace_pixels: self.trace_pixel.clone(),
        })
    }

    fn outputs(&self) -> Vec<PathBuf> {
        self.trace_out.clone().into_iter().collect()
    }

    fn export(&self, technique: &Ppm, _: &Path) -> Vec<u8> {
        technique.traces_csv().into_bytes()
    }
}

fn main() -> ExitCode {
    gi_cli::main::<Args>()
}
