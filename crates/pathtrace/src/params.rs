//! The options of path tracing.

use clap::{Args, ValueEnum};
use gi_core::options::{Parameters, PathLimits, defaults, number, rr_depth};

use crate::reuse::LARGEST_GROUP;

/// Where paths start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Mode {
    /// At the eye; light sampling at each vertex is combined with BSDF sampling by the power heuristic
    Path,
    /// The same, with absorption and scattering in participating media, whose density may vary
    #[value(name = "volpath")]
    VolPath,
    /// At the lights; each vertex, on a surface or in a medium, is connected to the eye
    Light,
    /// At both ends: every vertex of one path is connected with every vertex of the other
    Bdpt,
    /// The same, and vertices near each other are merged as in photon mapping; the blur shrinks with the passes
    Vcm,
}

/// A picture of the technique.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Figure {
    /// For paths of up to 5 segments: what each way to connect them finds, weighted and not. With s vertices on the light's side
    /// and t on the eye's, the pictures are sStT and sStT-unweighted
    Strategies,
}

/// How light sampling chooses a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightSelection {
    /// By the tree if the scene has many lights, else by power
    Auto,
    /// In proportion to power: the same at all points
    Power,
    /// By a tree of all lights: in proportion to an estimate of the light that arrives at the point (Conty18)
    Tree,
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
#[derive(Args, Clone, Debug, PartialEq)]
#[command(arg(rr_depth()))]
pub struct Params {
    /// Where paths start
    #[arg(long, value_enum, default_value_t = Mode::Path)]
    pub mode: Mode,
    /// path, volpath: how light sampling chooses a light
    #[arg(long, value_enum, default_value_t = LightSelection::Auto, value_name = "HOW")]
    pub light_selection: LightSelection,
    /// path: number of nearby pixels that share their paths, at most 16 (Bekaert02). With 8, single pixels have less
    /// noise after the same time. But neighbours have similar noise: the picture looks blotchy
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=i64::from(LARGEST_GROUP)))]
    pub reuse: u32,
    /// bdpt, vcm: weights of the ways to find a path [Veach97, 9.2]
    #[arg(long, value_enum, default_value_t = Heuristic::Power)]
    pub heuristic: Heuristic,
    /// vcm: radius of the first pass within which vertices are merged, in scene radii; 0 is automatic: 0.6 of
    /// a pixel's width on the surfaces that are seen, at most 0.012 scene radii
    #[arg(long, value_name = "R", default_value_t = 0.0, value_parser = number("a radius below 1; 0 is automatic", |r: &f32| (0.0..1.0).contains(r)))]
    pub radius: f32,
    /// vcm: how fast the radius shrinks: r^2 of a pass is (i + alpha) / (i + 1) times that of the pass before [Knaus11, 20]
    #[arg(long, value_name = "ALPHA", default_value_t = 0.75, value_parser = number("a number above 0, up to 1", |a: &f32| *a > 0.0 && *a <= 1.0))]
    pub alpha: f32,
    /// bdpt, vcm: number of vertices of light paths that a pass may keep, about; 176 bytes each. Where one light path per pixel
    /// would need more, there are fewer paths
    #[arg(long, value_name = "N", default_value_t = 16_000_000, value_parser = number("a number from 1000 to 4000000000", |n: &u32| (1000..=4_000_000_000).contains(n)))]
    pub light_vertices: u32,
    /// bdpt, vcm: pictures to draw; each becomes OUT.WHAT.png and layers of the EXR
    #[arg(long = "show", value_enum, value_delimiter = ',', value_name = "WHAT")]
    pub figures: Vec<Figure>,
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
    fn check(&self) -> Result<(), String> {
        let connects = matches!(self.mode, Mode::Bdpt | Mode::Vcm);
        let from_eye = matches!(self.mode, Mode::Path | Mode::VolPath);
        if self.light_selection == LightSelection::Tree && !from_eye {
            return Err(
                "--light-selection tree: only --mode path and --mode volpath use the tree".into()
            );
        }
        if self.reuse > 1 && self.mode != Mode::Path {
            return Err("--reuse: only --mode path reuses paths".into());
        }
        if self.figures.is_empty() || connects {
            return Ok(());
        }
        Err("--show strategies: only --mode bdpt and --mode vcm connect paths".into())
    }

    fn max_depth(&self) -> Option<u32> {
        self.limits.max_depth
    }

    fn simulates_media(&self) -> bool {
        !matches!(self.mode, Mode::Path)
    }

    fn can_leave_out_sources(&self) -> bool {
        // Pictures of the strategies show the sources too.
        self.mode != Mode::Light && self.figures.is_empty()
    }

    fn simulates_varying_media(&self) -> bool {
        matches!(self.mode, Mode::VolPath | Mode::Light)
    }

    fn finds_focused_light(&self, _: bool) -> bool {
        matches!(self.mode, Mode::Light | Mode::Bdpt | Mode::Vcm)
    }
}
