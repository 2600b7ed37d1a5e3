//! `lightcuts`: a picture by very many point lights.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use gi_cli::{
    Caustics, Common, Compensation, Program, check_points_file, is_table, parse_bound, parse_pixel,
};
use gi_core::eye::PathLimits;
use lightcuts::cut::{Limits, Rule};
use lightcuts::figures::{Figure, bounds_csv, cuts_csv};
use lightcuts::{Lightcuts, Method, Params, Reconstruction};
use vpl::{LightNumbers, to_csv, to_ply};

/// Lightcuts: all illumination becomes point lights, and every point is lit by a few clusters of them [slides 53-61].
///
/// Few --lights or --vpls show as hard shadows and spots of each. A large --error shows as patches where cuts change; a small
/// --max-cut in the dark and near many lights (at_max_cut in the statistics).
#[derive(Parser)]
#[command(name = "lightcuts", version)]
struct Args {
    #[command(flatten)]
    common: Common,
    /// Error that may be, relative to the whole (Weber's law) [slides 54, 61]; 0 asks every light
    #[arg(long, value_name = "E", default_value_t = Params::default().cut.error, value_parser = parse_share)]
    error: f32,
    /// Of what --error is the error
    #[arg(long, value_enum, default_value_t = RuleFlag::Whole)]
    rule: RuleFlag,
    /// Most clusters of a cut; with --error 0 there is no limit but one given here [default: 1000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_cut: Option<u32>,
    /// Points of lights in a pass, shared out by power; of one kind by name: 4096,sky=1000,sun=64,area=500 [slide 61]
    #[arg(long, value_name = "N[,KIND=N...]", default_value = "4096", value_parser = parse_lights)]
    lights: LightNumbers,
    /// About how many virtual point lights of surfaces a pass has [slide 53]
    #[arg(long, value_name = "N", default_value_t = Params::default().vpls, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    vpls: u32,
    /// All passes have the lights of the first, not each its own
    #[arg(long)]
    fixed_lights: bool,
    /// How direct light is found
    #[arg(long, value_enum, default_value_t = DirectFlag::Vpl)]
    direct: DirectFlag,
    /// Bound of the geometric term cos cos'/d^2 of lights of surfaces, in units of one over the squared scene radius; inf is
    /// none
    #[arg(long, value_name = "B", default_value_t = Params::default().clamp, value_parser = parse_bound)]
    clamp: f32,
    /// What becomes of the light that the bound cuts off
    #[arg(long, value_enum, default_value_t = Compensation::Path)]
    compensation: Compensation,
    /// How light that mirrors and glass focus is found
    #[arg(long, value_enum, default_value_t = Caustics::Photon)]
    caustics: Caustics,
    /// How points are lit
    #[arg(long, value_enum, default_value_t = MethodFlag::Cuts)]
    method: MethodFlag,
    /// Lights drawn at a point by --method stochastic or one
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    samples: u32,
    /// Reconstruction cuts: share cuts over blocks of pixels where they agree
    #[arg(long)]
    reconstruct: bool,
    /// Side of a block, pixels
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=64))]
    block: u32,
    /// Difference between cuts that is interpolated, relative to the whole
    #[arg(long, value_name = "E", default_value_t = 0.01, value_parser = parse_share)]
    agree: f32,
    /// Write the last pass's lights to look at: a point cloud (.ply) or a table (.csv)
    #[arg(long, value_name = "FILE.ply|.csv")]
    lights_out: Option<PathBuf>,
    /// Write the clusters of the cuts of some pixels, bounds and true errors
    #[arg(long, value_name = "FILE.csv")]
    bounds_out: Option<PathBuf>,
    /// Write all cuts of a few lights with their errors [slides 59, 60]
    #[arg(long, value_name = "FILE.csv")]
    cuts_out: Option<PathBuf>,
    /// Pictures of cuts and trees, as OUT.NAME.png and as layers
    #[arg(long, value_enum, value_delimiter = ',')]
    show: Vec<ShowFlag>,
    /// Pixel whose cut --show tree marks [default: the middle]
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel)]
    pixel: Option<[usize; 2]>,
}

#[derive(Clone, Copy, ValueEnum)]
enum RuleFlag {
    /// Of each cluster alone, as the lecture has it: errors of many add up to more
    Cluster,
    /// Of each cluster, and of the whole for about 99 of 100 points
    Whole,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum DirectFlag {
    /// By sampling lights
    Sample,
    /// By points of lights as point lights
    Vpl,
}

#[derive(Clone, Copy, ValueEnum)]
enum MethodFlag {
    /// By a cut
    Cuts,
    /// By all lights, one by one: brute force
    All,
    /// By a light drawn from each of --samples clusters: stochastic lightcuts
    Stochastic,
    /// By --samples lights drawn from the trees by importance
    One,
}

#[derive(Clone, Copy, ValueEnum)]
enum ShowFlag {
    /// Clusters in the cut of each pixel, dark few, bright many [slide 61]
    CutSize,
    /// True errors of clusters (across) and their bounds (up), in decades: above the line bounds hold
    Bounds,
    /// Lights over the picture, coloured by cluster, at four levels [slides 55, 56]
    Clusters,
    /// The first tree's upper branches, and the cut of a pixel [slides 57, 58]
    Tree,
    /// All cuts of a few lights [slides 59, 60]
    Cuts,
}

/// Most clusters of a cut where nobody says it: to ask every light is to have no limit.
fn most_clusters(error: f32) -> u32 {
    if error == 0.0 { u32::MAX } else { Params::default().cut.max_cut }
}

fn parse_share(text: &str) -> Result<f32, String> {
    let wrong = "expected a number from 0 to 1";
    text.parse().ok().filter(|e| (0.0..=1.0).contains(e)).ok_or_else(|| wrong.into())
}

/// Most points of lights.
const MOST_LIGHTS: u32 = 100_000_000;

fn parse_lights(text: &str) -> Result<LightNumbers, String> {
    let mut numbers = Params::default().lights;
    for part in text.split(',') {
        let (kind, number) = part.split_once('=').unwrap_or(("", part));
        let number = number.trim().parse().ok().filter(|n| (1..=MOST_LIGHTS).contains(n));
        let number = number.ok_or_else(|| format!("expected numbers from 1 to {MOST_LIGHTS}"))?;
        match kind.trim() {
            "" => numbers.total = number,
            "area" => numbers.area = Some(number),
            "sky" => numbers.sky = Some(number),
            "sun" => numbers.sun = Some(number),
            other => return Err(format!("no kind of light is called {other:?}: area, sky or sun")),
        }
    }
    Ok(numbers)
}

impl Program for Args {
    type Params = Params;
    type Technique<'a> = Lightcuts<'a>;

    fn common(&self) -> &Common {
        &self.common
    }

    fn finds_focused_light(&self) -> bool {
        self.caustics == Caustics::Photon
    }

    fn params(&self) -> Result<Params, String> {
        let reconstruction =
            self.reconstruct.then_some(Reconstruction { block: self.block, agree: self.agree });
        if self.reconstruct && !matches!(self.method, MethodFlag::Cuts) {
            return Err("--reconstruct shares cuts: it goes with --method cuts only".into());
        }
        check_points_file("--lights-out", &self.lights_out)?;
        Ok(Params {
            limits: PathLimits { max_depth: self.common.max_depth(), ..PathLimits::default() },
            cut: Limits {
                error: self.error,
                rule: match self.rule {
                    RuleFlag::Cluster => Rule::Cluster,
                    RuleFlag::Whole => Rule::Whole,
                },
                max_cut: self.max_cut.unwrap_or_else(|| most_clusters(self.error)),
            },
            lights: self.lights,
            direct_by_points: self.direct == DirectFlag::Vpl,
            vpls: self.vpls,
            fixed_lights: self.fixed_lights,
            clamp: self.clamp,
            compensation: self.compensation == Compensation::Path,
            caustic_photons: self.caustics == Caustics::Photon,
            method: match self.method {
                MethodFlag::Cuts => Method::Cuts,
                MethodFlag::All => Method::All,
                MethodFlag::Stochastic => Method::Stochastic(self.samples),
                MethodFlag::One => Method::Some(self.samples),
            },
            reconstruction,
            figures: self.show.iter().map(|f| f.figure(self.pixel)).collect(),
        })
    }

    fn outputs(&self) -> Vec<PathBuf> {
        [&self.lights_out, &self.bounds_out, &self.cuts_out]
            .into_iter()
            .flatten()
            .cloned()
            .collect()
    }

    fn export(&self, technique: &Lightcuts<'_>, path: &Path) -> Vec<u8> {
        if self.bounds_out.as_deref() == Some(path) {
            return bounds_csv(technique).into_bytes();
        }
        if self.cuts_out.as_deref() == Some(path) {
            return cuts_csv(technique).into_bytes();
        }
        let lights = &technique.vpls().lights;
        let origin = technique.origin();
        if is_table(path) { to_csv(lights, origin).into_bytes() } else { to_ply(lights, origin) }
    }
}

impl ShowFlag {
    fn figure(self, pixel: Option<[usize; 2]>) -> Figure {
        match self {
            ShowFlag::CutSize => Figure::CutSize,
            ShowFlag::Bounds => Figure::Bounds,
            ShowFlag::Clusters => Figure::Clusters,
            ShowFlag::Tree => Figure::Tree { pixel },
            ShowFlag::Cuts => Figure::Cuts,
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
        let args = Args::parse_from(["lightcuts", "scene.xml"]);
        assert_eq!(args.params(), Ok(Params::default()));
    }

    #[test]
    fn without_error_nothing_limits_a_cut_but_what_is_asked_for() {
        let most = |flags: &[&str]| {
            let args = Args::parse_from([&["lightcuts", "scene.xml"], flags].concat());
            args.params().map(|p| p.cut.max_cut)
        };
        assert_eq!(most(&["--error", "0"]), Ok(u32::MAX));
        assert_eq!(most(&["--error", "0", "--max-cut", "50"]), Ok(50));
        assert_eq!(most(&["--error", "0.01"]), Ok(1000));
    }

    #[test]
    fn numbers_of_lights_by_kind() {
        let numbers = LightNumbers { total: 100, area: None, sky: Some(7), sun: Some(2) };
        assert_eq!(parse_lights("sky=7,100, sun=2"), Ok(numbers));
        assert!(["", "0", "moon=3", "sky=", "sky=-1"].iter().all(|t| parse_lights(t).is_err()));
    }
}
