//! The options of progressive photon mapping.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use gi_core::options::{Parameters, PathLimits, defaults, number, pixel, rr_depth};

/// How the radius of a pixel changes from pass to pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Progressive photon mapping: hit points are found once, and each has its own statistics (Hachisuka08)
    Ppm,
    /// Stochastic: each pass finds new hit points, and each pixel has its own statistics; depth of field and glossy
    /// reflections are correct (Hachisuka09)
    Sppm,
    /// Probabilistic: one radius for the picture, which depends only on the number of the pass (Knaus11)
    Ppa,
    /// Each pixel has a radius that balances its noise and its bias (Kaplanyan13)
    Adaptive,
}

/// A map of the statistics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Figure {
    /// Radius R as a fraction of the scene's radius, logarithmic
    Radius,
    /// Number of photons N, logarithmic
    Photons,
    /// Estimated noise and bias of the luminance, logarithmic
    Error,
}

/// The options of progressive photon mapping.
#[derive(Args, Clone, Debug, PartialEq)]
#[command(arg(rr_depth()))]
pub struct Params {
    /// How the radius of a pixel changes from pass to pass
    #[arg(long, value_enum, default_value_t = Method::Sppm)]
    pub method: Method,
    /// Fraction of a pass's photons that is kept [slide 42]: with 1 the radius stays the same, smaller values shrink it
    /// faster
    #[arg(long, value_name = "SHARE", default_value_t = 0.7, value_parser = number("a fraction above 0, at most 1", |a: &f64| *a > 0.0 && *a <= 1.0))]
    pub alpha: f64,
    /// Number of light paths per pass; 0 takes as many as the picture has pixels, and at least 65,536 with --points
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub photons: u32,
    /// Initial radius as a fraction of the scene's radius; 0 derives it from --initial-photons
    #[arg(long, value_name = "R", default_value_t = 0.0, value_parser = number("a fraction of the scene's radius, at most 1; 0 is automatic", |r: &f32| (0.0..=1.0).contains(r)))]
    pub initial_radius: f32,
    /// Number of photons of a pilot pass within the initial radius; more photons give less noise and more blur
    #[arg(long, value_name = "K", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    pub initial_photons: u32,
    // The default is this rough because a disc contains few photons, and hardly any of them arrives within a sharper
    // lobe. Few materials have exactly this roughness.
    /// Minimum roughness (microfacet alpha) of the sharpest lobe where photons are gathered; rays follow sharper lobes
    #[arg(long, value_name = "ALPHA", default_value_t = 0.35, value_parser = number("a roughness, 0 or more", |a: &f32| *a >= 0.0))]
    pub min_roughness: f32,
    /// Number of hit points per pixel, with --method ppm
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub hit_points: u32,
    /// Find direct light by photons too, as in the original method, instead of sampling the lights; it is then blurred
    #[arg(long)]
    pub direct_by_photons: bool,
    /// How long paths may be, counting the light path and the eye path together.
    #[command(flatten)]
    pub limits: PathLimits,
    /// Number of scatterings after which Russian roulette may end a light path
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub photon_rr_depth: u32,
    /// Stop when the estimated relative error, sqrt(mean of (noise^2 + bias^2) / radiance^2), is below this; 0 never
    /// stops early
    #[arg(long, value_name = "E", default_value_t = 0.0, value_parser = number("an error, 0 or more", |e: &f64| *e >= 0.0))]
    pub stop_at_error: f64,
    /// Maps of the statistics to draw, separated by commas; each becomes OUT.WHAT.png and layers of the EXR
    #[arg(long = "show", value_enum, value_delimiter = ',', value_name = "WHAT")]
    pub figures: Vec<Figure>,
    /// Pixel whose R, N, M and estimate are written to --trace-out after every pass [slides 40 to 42]; give the option
    /// once per pixel
    #[arg(long = "trace-pixel", value_name = "X,Y", value_parser = pixel, requires = "trace_out")]
    pub trace_pixels: Vec<[usize; 2]>,
    /// File for the values at --trace-pixel
    #[arg(long, value_name = "FILE.csv", requires = "trace_pixels")]
    pub trace_out: Option<PathBuf>,
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
        true
    }

    fn outputs(&self) -> Vec<PathBuf> {
        self.trace_out.iter().cloned().collect()
    }
}
