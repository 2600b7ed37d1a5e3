//! The options of photon mapping.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use gi_core::files::points_file;
use gi_core::options::{Parameters, PathLimits, defaults, number, pixel};

/// Where the photon maps are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Gather {
    /// At the first surface, for all light [slides 29, 30]
    None,
    /// At the first surface, except for direct light, which is found by sampling the lights
    Direct,
    /// At the second diffuse surface; only caustics are read at the first [slide 31]
    Final,
}

/// How light inside translucent solids is found [slide 34].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Subsurface {
    /// By photons in the medium
    Photons,
    /// By diffusion of the photons that enter: smooth, but too dark where a solid is thin; --max-depth counts the way through the solid as two segments
    Dipole,
}

/// Weight of a photon by its distance from the centre of the estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kernel {
    /// All photons weigh the same, and the k-th counts nothing
    Box,
    /// Falls linearly with the distance (Jensen01)
    Cone,
    /// Jensen's Gaussian (Pavicic90, Jensen01)
    Gaussian,
    /// Falls with the squared distance, to zero at the edge: least mean squared error (Silverman86)
    Epanechnikov,
    /// Epanechnikov squared, smooth at the edge (Silverman86)
    Simpson,
    /// The formula of the slide: all k photons weigh the same, which is too bright by the factor k / (k - 1)
    Lecture,
}

/// How photons are stored in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Layout {
    /// The lecture's left-balanced tree in one array
    Jensen,
    /// A tree with leaves of 32 photons; positions are stored apart from the other data
    Fast,
}

/// A picture of the photon maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Figure {
    /// The first 200 photon paths [slide 22]
    Paths,
    /// Photons of each map as dots; photons in media show through glass [slides 23, 26, 34]
    Photons,
    /// Cells of the tree over the global map [slide 25]
    Cells,
    /// Caustic photons and gather rays used at the pixel --probe, or at the middle of the picture [slides 27, 28]
    Gathering,
}

/// The options of photon mapping.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct Params {
    /// How long paths may be.
    #[command(flatten)]
    pub limits: PathLimits,
    /// Number of photons to store in the global map [slide 26]; more photons give less blur
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = at_least_1())]
    pub photons: usize,
    /// Number of photons to store in the caustic map [slide 26]; with 0, paths from the eye find caustics
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    pub caustic_photons: usize,
    /// Number of photons to store in participating media [slide 34]; 0 ignores media
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    pub volume_photons: usize,
    /// Number of neighbours that set the radius of a photon in a medium; more neighbours give less noise and more blur
    #[arg(long, value_name = "K", default_value_t = 20, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=1000))]
    pub volume_lookup: usize,
    /// How light inside translucent solids is found [slide 34]
    #[arg(long, value_enum, default_value_t = Subsurface::Photons)]
    pub subsurface: Subsurface,
    /// Number of photons per estimate [slide 24]; more photons give less noise and more blur
    #[arg(long, value_name = "K", default_value_t = 50, value_parser = at_least_1())]
    pub lookup: usize,
    /// Maximum radius of an estimate, as a fraction of the scene's radius; 0 chooses it automatically
    #[arg(long, value_name = "R", default_value_t = 0.0, value_parser = number("a fraction of the scene's radius, 0 or more", |r: &f32| *r >= 0.0 && r.is_finite()))]
    pub max_radius: f32,
    /// Weight of a photon by its distance from the centre of the estimate [slide 24]
    #[arg(long, value_enum, default_value_t = Kernel::Epanechnikov)]
    pub kernel: Kernel,
    /// Where the photon maps are read [slides 27-31]
    #[arg(long, value_enum, default_value_t = Gather::Final)]
    pub gather: Gather,
    /// Number of final-gather rays per point and pass [slide 31]
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub gather_rays: u32,
    /// Fraction of the final-gather rays that are guided to where photons came from [slide 31]
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = number("a fraction from 0 to below 1", |g: &f32| (0.0..1.0).contains(g)))]
    pub guided: f32,
    /// Pictures of the maps to draw, separated by commas; each becomes OUT.NAME.png and layers of the EXR
    #[arg(long = "show", value_enum, value_delimiter = ',', value_name = "WHAT")]
    pub figures: Vec<Figure>,
    /// Write the photon maps to a file for --map-in
    #[arg(long, value_name = "FILE")]
    pub map_out: Option<PathBuf>,
    /// Read photon maps written by --map-out instead of tracing photons, for example for another view of the same scene
    #[arg(long, value_name = "FILE")]
    pub map_in: Option<PathBuf>,
    /// Write all photons, with the names of their maps and kinds, as a point cloud (.ply) or a table (.csv)
    #[arg(long, value_name = "FILE", value_parser = points_file)]
    pub photons_out: Option<PathBuf>,
    /// Write the estimate at the pixel --probe for growing numbers of photons [slide 24]
    #[arg(long, value_name = "FILE.csv", requires = "probe")]
    pub probe_out: Option<PathBuf>,
    /// Pixel that --probe-out and --show gathering examine
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pub probe: Option<[usize; 2]>,
    /// How photons are stored in memory [slide 25]; the picture is the same
    #[arg(long = "photon-layout", value_name = "PHOTON_LAYOUT", value_enum, default_value_t = Layout::Fast)]
    pub layout: Layout,
}

fn at_least_1() -> impl Fn(&str) -> Result<usize, String> + Clone + Send + Sync + 'static {
    number("a whole number, at least 1", |n| *n >= 1)
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
        self.volume_photons > 0
    }

    fn finds_focused_light(&self, _: bool) -> bool {
        self.caustic_photons > 0
    }

    fn outputs(&self) -> Vec<PathBuf> {
        [&self.map_out, &self.photons_out, &self.probe_out].into_iter().flatten().cloned().collect()
    }
}
