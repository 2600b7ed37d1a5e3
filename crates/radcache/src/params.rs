//! The options of radiance caching.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use gi_core::options::{CausticOptions, Parameters, PathLimits, defaults, number};
use lightcache::Weights;
use lightcache::control::{ErrorControl, SphereRadius};
use lightcache::options::{CacheFiles, ReachOptions, accuracy};

/// Largest order of the basis.
pub const MAX_ORDER: usize = 16;

/// How glossy surfaces reflect the light of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Mode {
    /// Dot product of the BRDF and the light in the basis [slide 18]
    Sh,
    /// The naive product of directional reflectance and irradiance, rho_hd(w) E / pi [slide 15]
    RhoE,
}

/// Basis in which a record's light is expanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Basis {
    /// Spherical harmonics
    Sh,
    /// Hemispherical harmonics (Gautron04): waste nothing below the horizon, but cannot be rotated to a tilted surface
    Hsh,
}

/// Window that damps the high bands, against ringing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Window {
    /// No window
    None,
    /// Raised cosine: least ringing, most blur
    Hanning,
    /// Sinc: between the other two
    Lanczos,
}

/// A picture of the caches and of the basis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Figure {
    /// Positions of the records of each kind, coloured by radius from small (dark) to large (bright) [slide 13]
    Records,
    /// Functions of the basis up to l = 4 as lobes: blue where positive, orange where negative [slide 18]
    Basis,
    /// The first tabulated BRDF (black) and its approximations of orders 1 to 10 (blue, orange where negative) [slide
    /// 18]
    Brdf,
    /// Directions sampled for that BRDF, by the cosine and by the BRDF itself [slide 19]
    Samples,
}

/// The options of radiance caching.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct Params {
    /// How long paths may be.
    #[command(flatten)]
    pub limits: PathLimits,
    /// How light focused by mirrors and glass is found.
    #[command(flatten)]
    pub caustics: CausticOptions,
    /// Number of gather rays per irradiance record; fewer rays show as blotches
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(8..=10_000_000))]
    pub rays: u32,
    /// Number of gather rays per radiance record; a narrow lobe averages over only some of them
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(8..=10_000_000))]
    pub glossy_rays: u32,
    /// Accuracy a of irradiance records, the allowed relative error [slide 11]; smaller values make more records
    #[arg(long, value_name = "A", default_value_t = 0.1, value_parser = accuracy())]
    pub accuracy: f32,
    /// Accuracy a of radiance records, as a fraction of the harmonic mean distance [slides 9, 11]
    #[arg(long, value_name = "A", default_value_t = 0.1, value_parser = accuracy())]
    pub glossy_accuracy: f32,
    /// Order n of the basis, which then has n^2 functions [slide 18]; 0 lets each material choose an order that misses
    /// 5 % of its energy
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(0..=MAX_ORDER as i64))]
    pub order: u32,
    /// Basis in which incoming light is expanded
    #[arg(long, value_enum, default_value_t = Basis::Sh)]
    pub basis: Basis,
    /// Window that damps the high bands of the basis, against ringing
    #[arg(long, value_enum, default_value_t = Window::None)]
    pub window: Window,
    /// How glossy surfaces reflect the light of a record
    #[arg(long, value_enum, default_value_t = Mode::Sh)]
    pub mode: Mode,
    /// Minimum roughness (microfacet alpha) of glossy lobes that use records; sharper lobes are path-traced
    #[arg(long, value_name = "ALPHA", default_value_t = 0.2, value_parser = number("a roughness, 0 or more; above 1 leaves all glossy lobes to paths", |a: &f32| *a >= 0.0 && a.is_finite()))]
    pub min_roughness: f32,
    /// How the error of irradiance records is estimated; there is no command-line option for it.
    #[arg(skip = ErrorControl::HessianOcclusion)]
    pub error: ErrorControl,
    /// The same for radiance records.
    #[arg(skip = ErrorControl::Bounded)]
    pub glossy_error: ErrorControl,
    /// Which distance is the radius of the split sphere; there is no command-line option for it.
    #[arg(skip = SphereRadius::Harmonic)]
    pub radius: SphereRadius,
    /// Where records are valid.
    #[command(flatten)]
    pub reach: ReachOptions,
    /// Interpolate without gradients [slide 12]
    #[arg(long = "no-gradients", action = clap::ArgAction::SetFalse)]
    pub gradients: bool,
    /// How records are weighted; there is no command-line option for it.
    #[arg(skip = Weights::Smooth)]
    pub weights: Weights,
    /// Files of the caches.
    #[command(flatten)]
    pub files: CacheFiles,
    /// Pictures of the caches and of the basis to draw, separated by commas; each becomes OUT.NAME.png and layers of
    /// the EXR
    #[arg(long = "show", value_name = "SHOW", value_enum, value_delimiter = ',')]
    pub figures: Vec<Figure>,
}

impl Default for Params {
    fn default() -> Self {
        defaults()
    }
}

impl Params {
    /// Whether records contain the light of a vertex after `segments` segments. With `max_depth`, a record is valid
    /// only at the depth it was created for, and the last vertex of a path has no indirect light.
    pub(crate) fn covers_depth(&self, segments: u32) -> bool {
        match self.limits.max_depth {
            None => true,
            Some(_) => segments == 1 && self.limits.goes_on(2),
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
