//! The options of lightcuts.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use gi_core::files::points_file;
use gi_core::options::{CausticOptions, Parameters, PathLimits, defaults, number, pixel};
use vpl::{BoundOptions, Direct, LightNumbers};

/// What `--error` bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Rule {
    /// The error of each cluster alone, as in the lecture [slide 61] (Walter05); the errors of many clusters add up to
    /// more
    Cluster,
    /// The error of each cluster, and for about 99 of 100 points the error of all clusters together
    Whole,
}

/// How a point is lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// By a cut
    Cuts,
    /// Many points at once: one cut per pixel, of pairs of a cluster of lights and a cluster of the points that --gather
    /// camera paths reach: multidimensional lightcuts (Walter06)
    Multidimensional,
    /// By every light: brute force
    All,
    /// By one light sampled from each of --samples clusters: stochastic lightcuts (Yuksel19)
    Stochastic,
    /// By --samples lights sampled from the trees by importance (Conty18)
    One,
    /// By paths instead of virtual lights; each vertex samples a light, chosen by what earlier passes have learned about
    /// the visibility of clusters of lights (Vevoda18)
    Learned,
}

/// A picture of cuts and trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Figure {
    /// Number of clusters in the cut of each pixel, from few (dark) to many (bright) [slide 61]
    CutSize,
    /// Bounds of clusters' errors (vertical) against the true errors (horizontal), logarithmic
    Bounds,
    /// Lights over the picture, coloured by cluster, at four levels of the trees [slides 55, 56]
    Clusters,
    /// Upper branches of the first tree, with the cut of the pixel --pixel [slides 57, 58]
    Tree,
    /// All cuts of a few lights: the picture with each cut, and its error [slides 59, 60]
    Cuts,
}

/// Maximum number of clusters in a cut if `--max-cut` does not set it and `--error` is not 0.
const MAX_CUT: u32 = 1000;

/// When the refinement of a cut ends.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest allowed error, as a fraction of the point's radiance (Weber's law) [slides 54, 61]; 0 uses every light
    #[arg(long, value_name = "E", default_value_t = 0.02, value_parser = fraction())]
    pub error: f32,
    /// What --error bounds
    #[arg(long, value_enum, default_value_t = Rule::Cluster)]
    pub rule: Rule,
    /// Maximum number of clusters, or of pairs of clusters, in a cut [default: 1000, or no maximum with --error 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub max_cut: Option<u32>,
}

impl Limits {
    /// The maximum number of clusters in a cut. Using every light means having no maximum.
    #[inline]
    pub fn max_clusters(&self) -> u32 {
        self.max_cut.unwrap_or(if self.error == 0.0 { u32::MAX } else { MAX_CUT })
    }
}

/// Reconstruction cuts.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
pub struct Reconstruction {
    /// Compute cuts only at the corners of blocks of pixels, and interpolate where they agree: reconstruction cuts
    #[arg(long)]
    pub reconstruct: bool,
    /// Side length of a block in pixels
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub block: u32,
    /// Largest difference between cuts that is interpolated, as a fraction of the point's radiance
    #[arg(long, value_name = "E", default_value_t = 0.01, value_parser = fraction())]
    pub agree: f32,
}

impl Reconstruction {
    /// Reconstruction with blocks of the usual side and the usual tolerance.
    pub fn on() -> Self {
        Reconstruction { reconstruct: true, ..defaults() }
    }
}

/// The options of lightcuts.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct Params {
    /// How long paths may be.
    #[command(flatten)]
    pub limits: PathLimits,
    /// When the refinement of a cut ends.
    #[command(flatten)]
    pub cut: Limits,
    /// Number of point lights on light sources per pass, distributed by power; numbers for single kinds can follow:
    /// 4096,sky=1000,sun=64,area=500 [slide 61]
    #[arg(long, value_name = "N[,KIND=N...]", default_value_t = LIGHTS, value_parser = parse_lights)]
    pub lights: LightNumbers,
    /// Approximate number of virtual point lights on surfaces per pass [slide 53]
    #[arg(long, value_name = "N", default_value_t = 16_384, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    pub vpls: u32,
    /// Use the lights of the first pass in all passes, instead of new lights in each pass
    #[arg(long)]
    pub fixed_lights: bool,
    /// How direct light is found
    #[arg(long, value_enum, default_value_t = Direct::Vpl)]
    pub direct: Direct,
    /// The bound on bright spots near lights.
    #[command(flatten)]
    pub bound: BoundOptions,
    /// How light focused by mirrors and glass is found.
    #[command(flatten)]
    pub caustics: CausticOptions,
    /// How points are lit
    #[arg(long, value_enum, default_value_t = Method::Cuts)]
    pub method: Method,
    /// Number of lights sampled per point by --method stochastic or one
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub samples: u32,
    /// Number of camera paths per pixel and pass that share a cut, with --method multidimensional
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub gather: u32,
    /// Reconstruction cuts.
    #[command(flatten)]
    pub reconstruction: Reconstruction,
    /// Write the lights of the last pass as a point cloud (.ply) or a table (.csv)
    #[arg(long, value_name = "FILE.ply|.csv", value_parser = points_file)]
    pub lights_out: Option<PathBuf>,
    /// Write the clusters in the cuts of some pixels, with their error bounds and true errors
    #[arg(long, value_name = "FILE.csv")]
    pub bounds_out: Option<PathBuf>,
    /// Write all cuts of a few lights, with their errors [slides 59, 60]
    #[arg(long, value_name = "FILE.csv")]
    pub cuts_out: Option<PathBuf>,
    /// Write the nodes of the light trees, and which of them are in the cut of --pixel [slides 55 to 58]
    #[arg(long, value_name = "FILE.csv")]
    pub tree_out: Option<PathBuf>,
    /// Pictures of cuts and trees to draw, separated by commas; each becomes OUT.NAME.png and layers of the EXR
    #[arg(long = "show", value_name = "SHOW", value_enum, value_delimiter = ',')]
    pub figures: Vec<Figure>,
    /// Pixel whose cut --show tree and --tree-out mark [default: the middle of the picture]
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pub pixel: Option<[usize; 2]>,
}

impl Default for Params {
    fn default() -> Self {
        defaults()
    }
}

impl Params {
    /// Which light paths the estimator can reach, in words.
    pub(crate) fn reach(&self) -> String {
        if self.method == Method::Learned {
            return "all paths that path tracing reaches".into();
        }
        let direct = if self.direct == Direct::Vpl { "direct and indirect" } else { "indirect" };
        let cut = if self.bound.loses_light() {
            "; bounded geometric terms cut light off in corners (biased)"
        } else {
            ""
        };
        format!("all paths that path tracing reaches, {direct} light from point lights{cut}")
    }
}

impl Parameters for Params {
    fn check(&self) -> Result<(), String> {
        if self.reconstruction.reconstruct && self.method != Method::Cuts {
            return Err(
                "--reconstruct interpolates cuts, so it works with --method cuts only".into()
            );
        }
        if self.method == Method::Learned && !(self.figures.is_empty() && self.outputs().is_empty())
        {
            return Err("--show and the tables of lights, bounds, cuts and trees describe virtual lights, and --method learned \
                        makes none: use another method"
                .into());
        }
        let of_points = |f: &Figure| matches!(f, Figure::Bounds | Figure::Tree | Figure::Cuts);
        if self.method == Method::Multidimensional
            && (self.figures.iter().any(of_points)
                || [&self.bounds_out, &self.cuts_out, &self.tree_out]
                    .iter()
                    .any(|out| out.is_some()))
        {
            return Err("--show bounds, tree and cuts, --bounds-out, --cuts-out and --tree-out describe the cuts of points, and --method \
                        multidimensional makes cuts of pixels: use --method cuts, or --show cut-size or clusters"
                .into());
        }
        Ok(())
    }

    fn max_depth(&self) -> Option<u32> {
        self.limits.max_depth
    }

    fn simulates_media(&self) -> bool {
        self.method != Method::Learned && !self.reconstruction.reconstruct
    }

    fn finds_focused_light(&self, has_media: bool) -> bool {
        let in_media = has_media && self.simulates_media();
        self.caustics.by_photons() && self.method != Method::Learned && !in_media
    }

    fn outputs(&self) -> Vec<PathBuf> {
        [&self.lights_out, &self.bounds_out, &self.cuts_out, &self.tree_out]
            .into_iter()
            .flatten()
            .cloned()
            .collect()
    }
}

/// Point lights on light sources if `--lights` does not set their number.
const LIGHTS: LightNumbers = LightNumbers { total: 4096, area: None, sky: None, sun: None };

/// Maximum number of point lights.
const MOST_LIGHTS: u32 = 100_000_000;

fn parse_lights(text: &str) -> Result<LightNumbers, String> {
    let mut numbers = LIGHTS;
    for part in text.split(',') {
        let (kind, number) = part.split_once('=').unwrap_or(("", part));
        let number = number.trim().parse().ok().filter(|n| (1..=MOST_LIGHTS).contains(n));
        let number = number.ok_or_else(|| format!("expected numbers from 1 to {MOST_LIGHTS}"))?;
        match kind.trim() {
            "" => numbers.total = number,
            "area" => numbers.area = Some(number),
            "sky" => numbers.sky = Some(number),
            "sun" => numbers.sun = Some(number),
            other => {
                return Err(format!("there is no kind of light {other:?}: use area, sky or sun"));
            }
        }
    }
    Ok(numbers)
}

fn fraction() -> impl Fn(&str) -> Result<f32, String> + Clone + Send + Sync + 'static {
    number("a number from 0 to 1", |e| (0.0..=1.0).contains(e))
}

#[cfg(test)]
mod tests {
    use clap::{Command, FromArgMatches};

    use super::*;

    #[test]
    fn only_a_given_maximum_limits_a_cut_without_error() {
        let most = |flags: &[&str]| {
            let command = Limits::augment_args(Command::new("test").no_binary_name(true));
            let matches = command.try_get_matches_from(flags).expect("flags");
            Limits::from_arg_matches(&matches).expect("limits").max_clusters()
        };
        assert_eq!(most(&["--error", "0"]), u32::MAX);
        assert_eq!(most(&["--error", "0", "--max-cut", "50"]), 50);
        assert_eq!(most(&["--error", "0.01"]), MAX_CUT);
    }

    #[test]
    fn numbers_of_lights_by_kind() {
        let numbers = LightNumbers { total: 100, area: None, sky: Some(7), sun: Some(2) };
        assert_eq!(parse_lights("sky=7,100, sun=2"), Ok(numbers));
        assert_eq!(parse_lights(&numbers.to_string()), Ok(numbers));
        assert!(["", "0", "moon=3", "sky=", "sky=-1"].iter().all(|t| parse_lights(t).is_err()));
    }
}
