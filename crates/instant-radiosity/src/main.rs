//! `instant-radiosity`: a picture by virtual point lights.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use gi_cli::{
    Caustics, Common, Compensation, Program, check_points_file, is_table, parse_bound, parse_pixel,
};
use gi_core::eye::PathLimits;
use instant_radiosity::figures::Figure;
use instant_radiosity::{InstantRadiosity, Params};
use vpl::{Termination, to_csv, to_ply};

/// Instant radiosity: indirect light from virtual point lights, passes averaged as in an accumulation buffer [slides 47-52].
///
/// Few --vpls and passes show as hard shadows of each light; without --clamp, as bright spots where a light is near.
/// With --clamp and no compensation, corners are too dark; how much light that costs is in the statistics (energy_cut).
#[derive(Parser)]
#[command(name = "instant-radiosity", version)]
struct Args {
    #[command(flatten)]
    common: Common,
    /// About how many virtual point lights a pass has [slides 49-52]
    #[arg(long, value_name = "N", default_value_t = Params::default().vpls, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    vpls: u32,
    /// When light paths end
    #[arg(long, value_enum, default_value_t = TerminationFlag::Roulette)]
    termination: TerminationFlag,
    /// Bound of the geometric term cos cos'/d^2, in units of one over the squared scene radius; inf is none
    #[arg(long, value_name = "B", default_value_t = Params::default().clamp, value_parser = parse_bound)]
    clamp: f32,
    /// What becomes of the light that the bound cuts off
    #[arg(long, value_enum, default_value_t = Compensation::Path)]
    compensation: Compensation,
    /// How light that mirrors and glass focus is found
    #[arg(long, value_enum, default_value_t = Caustics::Photon)]
    caustics: Caustics,
    /// Let the bound grow with the passes k = 0, 1, ...: clamp (k+1)^R; 0 keeps it
    #[arg(long, value_name = "R", default_value_t = Params::default().relaxation, value_parser = parse_exponent)]
    relaxation: f32,
    /// Lights are spheres that just overlap instead of points: no bound, and blurred
    #[arg(long)]
    vsl: bool,
    /// Directions in which a sphere's light is added up
    #[arg(long, value_name = "N", default_value_t = Params::default().vsl_samples, value_parser = clap::value_parser!(u32).range(1..=1024))]
    vsl_samples: u32,
    /// How direct light is found
    #[arg(long, value_enum, default_value_t = DirectFlag::Sample)]
    direct: DirectFlag,
    /// Write the last pass's lights to look at: a point cloud (.ply) or a table (.csv)
    #[arg(long, value_name = "FILE.ply|.csv")]
    vpls_out: Option<PathBuf>,
    /// Pictures of the lights, as OUT.NAME.png and as layers
    #[arg(long, value_enum, value_delimiter = ',')]
    show: Vec<ShowFlag>,
    /// Pixel whose connections --show connections draws [default: the middle]
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel)]
    pixel: Option<[usize; 2]>,
}

#[derive(Clone, Copy, ValueEnum)]
enum TerminationFlag {
    /// Fractional absorption: of N paths the first N rho^j go on after j scatterings (Keller's)
    Fractional,
    /// Russian roulette by what surfaces reflect
    Roulette,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum DirectFlag {
    /// By sampling lights
    Sample,
    /// By points of lights as virtual point lights [slides 47, 48]
    Vpl,
}

#[derive(Clone, Copy, ValueEnum)]
enum ShowFlag {
    /// Where the lights are, those of direct light dark, of many scatterings bright [slide 49]
    Vpls,
    /// Shadow rays from a pixel to all lights, those that meet something in red [slide 50]
    Connections,
}

fn parse_exponent(text: &str) -> Result<f32, String> {
    let wrong = "expected a number from 0 to 2";
    text.parse().ok().filter(|r| (0.0..=2.0).contains(r)).ok_or_else(|| wrong.into())
}

impl Program for Args {
    type Params = Params;
    type Technique<'a> = InstantRadiosity<'a>;

    fn common(&self) -> &Common {
        &self.common
    }

    fn finds_focused_light(&self) -> bool {
        self.caustics == Caustics::Photon
    }

    fn params(&self) -> Result<Params, String> {
        check_points_file("--vpls-out", &self.vpls_out)?;
        Ok(Params {
            limits: PathLimits { max_depth: self.common.max_depth(), ..PathLimits::default() },
            vpls: self.vpls,
            termination: match self.termination {
                TerminationFlag::Fractional => Termination::Fractional,
                TerminationFlag::Roulette => Termination::Roulette,
            },
            clamp: self.clamp,
            compensation: self.compensation == Compensation::Path,
            caustic_photons: self.caustics == Caustics::Photon,
            relaxation: self.relaxation,
            vsl: self.vsl,
            vsl_samples: self.vsl_samples,
            direct_by_vpls: self.direct == DirectFlag::Vpl,
            figures: self.show.iter().map(|f| f.figure(self.pixel)).collect(),
        })
    }

    fn outputs(&self) -> Vec<PathBuf> {
        self.vpls_out.iter().cloned().collect()
    }

    fn export(&self, technique: &InstantRadiosity<'_>, path: &Path) -> Vec<u8> {
        let lights = &technique.vpls().lights;
        let origin = technique.origin();
        if is_table(path) { to_csv(lights, origin).into_bytes() } else { to_ply(lights, origin) }
    }
}

impl ShowFlag {
    fn figure(self, pixel: Option<[usize; 2]>) -> Figure {
        match self {
            ShowFlag::Vpls => Figure::Vpls,
            ShowFlag::Connections => Figure::Connections { pixel },
        }
    }
}

fn main() -> ExitCode {
    gi_cli::main::<Args>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_flags_the_parameters_are_the_librarys_defaults() {
        let args = Args::parse_from(["instant-radiosity", "scene.xml"]);
        assert_eq!(args.params(), Ok(Params::default()));
    }
}
