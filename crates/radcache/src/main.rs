//! `radcache`: a picture by radiance caching.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use gi_cli::{
    Caustics, Common, Program, check_points_file, check_spacings, is_table, parse_accuracy,
    parse_spacing, read_input,
};
use gi_core::eye::PathLimits;
use lightcache::export::{to_csv, to_ply};
use radcache::figures::Show;
use radcache::file::SavedCache;
use radcache::sh::{Basis, MAX_ORDER, Window};
use radcache::{Mode, Params, RadianceCaching};

/// Radiance caching: indirect light of diffuse and rough glossy surfaces from few records [slides 15-20].
///
/// Diffuse surfaces have records of irradiance, as irrcache. Glossy lobes of at least --min-roughness have records of
/// radiance in spherical harmonics, good for every view. Sharper lobes, caustics and direct light are path-traced.
/// Biased: a low --order blurs reflections and rings round bright ones.
#[derive(Parser)]
#[command(name = "radcache", version)]
struct Args {
    #[command(flatten)]
    common: Common,
    /// How light that mirrors and glass focus is found
    #[arg(long, value_enum, default_value_t = Caustics::Photon)]
    caustics: Caustics,
    /// Rays that an irradiance record gathers: fewer are noisier (blotches)
    #[arg(long, value_name = "N", default_value_t = Params::default().rays, value_parser = clap::value_parser!(u32).range(8..=10_000_000))]
    rays: u32,
    /// Rays that a radiance record gathers: narrow lobes average over fewer of them
    #[arg(long, value_name = "N", default_value_t = Params::default().glossy_rays, value_parser = clap::value_parser!(u32).range(8..=10_000_000))]
    glossy_rays: u32,
    /// Accuracy a of irradiance records, the relative error allowed [slide 11]; smaller makes more records
    #[arg(long, value_name = "A", default_value_t = Params::default().accuracy, value_parser = parse_accuracy)]
    accuracy: f32,
    /// Accuracy a of radiance records: as share of the harmonic mean distance [slides 9, 11]
    #[arg(long, value_name = "A", default_value_t = Params::default().glossy_accuracy, value_parser = parse_accuracy)]
    glossy_accuracy: f32,
    /// Bands of the basis, n^2 functions [slide 18]; 0: each material's own, which leave out 5 % of its energy
    #[arg(long, value_name = "N", default_value_t = Params::default().order, value_parser = clap::value_parser!(u32).range(0..=MAX_ORDER as i64))]
    order: u32,
    /// Functions that incoming light is expanded in
    #[arg(long, value_enum, default_value_t = BasisFlag::Sh)]
    basis: BasisFlag,
    /// Fading of bands toward the order, against ringing
    #[arg(long, value_enum, default_value_t = WindowFlag::None)]
    window: WindowFlag,
    /// What glossy surfaces make of the light
    #[arg(long, value_enum, default_value_t = ModeFlag::Sh)]
    mode: ModeFlag,
    /// Glossy lobes at least this rough (alpha of their facets) have records, narrower ones are path-traced
    #[arg(long, value_name = "ALPHA", default_value_t = Params::default().min_roughness, value_parser = parse_roughness)]
    min_roughness: f32,
    /// Smallest radius of a record in pixels; 0 sets no limit
    #[arg(long, value_name = "PIXELS", default_value_t = Params::default().min_spacing, value_parser = parse_spacing)]
    min_spacing: f32,
    /// Largest radius of a record in pixels; 0 sets no limit
    #[arg(long, value_name = "PIXELS", default_value_t = Params::default().max_spacing, value_parser = parse_spacing)]
    max_spacing: f32,
    /// Let radii of neighbouring records differ by more than their distance allows
    #[arg(long)]
    no_neighbour_clamping: bool,
    /// Do not look for walls between a record and where it is used: light leaks under thin ones
    #[arg(long)]
    no_leak_guard: bool,
    /// Interpolate without gradients [slide 12]
    #[arg(long)]
    no_gradients: bool,
    /// Begin with a cache that --cache-out wrote: another view of the scene [slide 17], another run
    #[arg(long, value_name = "FILE")]
    cache_in: Option<PathBuf>,
    /// Write the cache
    #[arg(long, value_name = "FILE")]
    cache_out: Option<PathBuf>,
    /// Write the irradiance records to look at: a point cloud (.ply) or a table (.csv)
    #[arg(long, value_name = "FILE.ply|.csv")]
    records_out: Option<PathBuf>,
    /// Pictures of the caches and of the basis, as OUT.NAME.png and as layers
    #[arg(long, value_enum, value_delimiter = ',')]
    show: Vec<ShowFlag>,
}

#[derive(Clone, Copy, ValueEnum)]
enum BasisFlag {
    /// Spherical harmonics
    Sh,
    /// Hemispherical harmonics: no light is lost below the horizon, but they cannot be tilted
    Hsh,
}

#[derive(Clone, Copy, ValueEnum)]
enum WindowFlag {
    /// None
    None,
    /// Raised cosine: smooth, blurred
    Hanning,
    /// Sinc: between the two
    Lanczos,
}

#[derive(Clone, Copy, ValueEnum)]
enum ModeFlag {
    /// Dot product of BRDF and light in the basis [slide 18]
    Sh,
    /// The naive product of directional albedo and irradiance [slide 15]
    RhoE,
}

#[derive(Clone, Copy, ValueEnum)]
enum ShowFlag {
    /// Where records of each kind are, coloured by their radius, small dark to large bright
    Records,
    /// The basis to l = 4, positive green, negative red [slide 18]
    Basis,
    /// The first tabulated BRDF (black) and its approximations of orders 1 to 10 (blue, negative red) [slide 18]
    Brdf,
    /// Directions drawn for that BRDF, by cosine and by itself [slide 19]
    Samples,
}

fn parse_roughness(text: &str) -> Result<f32, String> {
    let wrong = "expected a roughness, 0 or more; above 1 leaves all glossy lobes to paths";
    text.parse().ok().filter(|a: &f32| *a >= 0.0 && a.is_finite()).ok_or_else(|| wrong.into())
}

impl Program for Args {
    type Params = Params;
    type Technique<'a> = RadianceCaching<'a>;

    fn common(&self) -> &Common {
        &self.common
    }

    fn finds_focused_light(&self) -> bool {
        self.caustics == Caustics::Photon
    }

    fn params(&self) -> Result<Params, String> {
        check_points_file("--records-out", &self.records_out)?;
        check_spacings(self.min_spacing, self.max_spacing)?;
        Ok(Params {
            caustic_photons: self.caustics == Caustics::Photon,
            limits: PathLimits { max_depth: self.common.max_depth(), ..PathLimits::default() },
            rays: self.rays,
            glossy_rays: self.glossy_rays,
            accuracy: self.accuracy,
            glossy_accuracy: self.glossy_accuracy,
            order: self.order,
            basis: match self.basis {
                BasisFlag::Sh => Basis::Sh,
                BasisFlag::Hsh => Basis::Hsh,
            },
            window: match self.window {
                WindowFlag::None => Window::None,
                WindowFlag::Hanning => Window::Hanning,
                WindowFlag::Lanczos => Window::Lanczos,
            },
            mode: match self.mode {
                ModeFlag::Sh => Mode::Sh,
                ModeFlag::RhoE => Mode::RhoE,
            },
            min_roughness: self.min_roughness,
            min_spacing: self.min_spacing,
            max_spacing: self.max_spacing,
            neighbour_clamping: !self.no_neighbour_clamping,
            leak_guard: !self.no_leak_guard,
            gradients: !self.no_gradients,
            cache: self.cache_in.as_deref().map(read_cache).transpose()?,
            figures: self.show.iter().map(|f| f.figure()).collect(),
            ..Params::default()
        })
    }

    fn outputs(&self) -> Vec<PathBuf> {
        self.cache_out.iter().chain(&self.records_out).cloned().collect()
    }

    fn export(&self, technique: &RadianceCaching<'_>, path: &Path) -> Vec<u8> {
        if self.cache_out.as_deref() == Some(path) {
            return technique.saved().to_bytes();
        }
        let records = technique.irradiance_records();
        let origin = technique.origin();
        if is_table(path) { to_csv(records, origin).into_bytes() } else { to_ply(records, origin) }
    }
}

impl ShowFlag {
    fn figure(self) -> Show {
        match self {
            ShowFlag::Records => Show::Records,
            ShowFlag::Basis => Show::Basis,
            ShowFlag::Brdf => Show::Brdf,
            ShowFlag::Samples => Show::Samples,
        }
    }
}

fn read_cache(path: &Path) -> Result<SavedCache, String> {
    SavedCache::from_bytes(&read_input(path)?)
        .map_err(|e| format!("cannot use {}: {e}", path.display()))
}

fn main() -> ExitCode {
    gi_cli::main::<Args>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_flags_the_parameters_are_the_librarys_defaults() {
        let args = Args::parse_from(["radcache", "scene.xml"]);
        assert_eq!(args.params(), Ok(Params::default()));
    }
}
