//! `irrcache`: a picture by irradiance caching.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use gi_cli::{
    Caustics, Common, Program, check_points_file, check_spacings, is_table, parse_accuracy,
    parse_spacing, read_input,
};
use gi_core::eye::PathLimits;
use irrcache::file::SavedCache;
use irrcache::{IrradianceCaching, Params};
use lightcache::Weights;
use lightcache::control::{ErrorControl, SphereRadius};
use lightcache::export::{to_csv, to_ply};
use lightcache::figures::Figure;
use lightcache::record::Gradients;

/// Irradiance caching: indirect light of diffuse surfaces from few records of irradiance [slides 5-14].
///
/// Smooth where a path tracer is noisy, and biased: too few --rays show as blotches, too coarse an --accuracy as
/// indirect shadows that are missing. Glossy lobes, caustics and direct light are path-traced.
#[derive(Parser)]
#[command(name = "irrcache", version)]
struct Args {
    #[command(flatten)]
    common: Common,
    /// How light that mirrors and glass focus is found
    #[arg(long, value_enum, default_value_t = Caustics::Photon)]
    caustics: Caustics,
    /// Rays that a record gathers [slides 7, 12-14]: fewer are noisier (blotches)
    #[arg(long, value_name = "N", default_value_t = Params::default().rays, value_parser = clap::value_parser!(u32).range(8..=10_000_000))]
    rays: u32,
    /// Accuracy a, the relative error allowed: records count where w > 1/a [slide 11]; smaller makes more records
    #[arg(long, value_name = "A", default_value_t = Params::default().accuracy, value_parser = parse_accuracy)]
    accuracy: f32,
    /// Levels of caches that gather rays end in, each one bounce more; without it they go on as paths of all bounces
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8))]
    bounces: Option<u32>,
    /// How the error of a record is estimated
    #[arg(long, value_enum, default_value_t = ErrorFlag::HessianOcclusion)]
    error: ErrorFlag,
    /// Length of the surroundings that the split sphere takes as its radius [slide 9]
    #[arg(long, value_enum, default_value_t = RadiusFlag::Harmonic)]
    radius: RadiusFlag,
    /// Smallest radius of a record in pixels, but with --error split-sphere; 0 sets no limit
    #[arg(long, value_name = "PIXELS", default_value_t = Params::default().min_spacing, value_parser = parse_spacing)]
    min_spacing: f32,
    /// Largest radius of a record in pixels, but with --error split-sphere; 0 sets no limit
    #[arg(long, value_name = "PIXELS", default_value_t = Params::default().max_spacing, value_parser = parse_spacing)]
    max_spacing: f32,
    /// Let radii of neighbouring records differ by more than their distance allows
    #[arg(long)]
    no_neighbour_clamping: bool,
    /// Do not look for walls between a record and where it is used: light leaks under thin ones
    #[arg(long)]
    no_leak_guard: bool,
    /// Gradients that interpolation follows [slides 12, 14]
    #[arg(long, value_enum, default_value_t = GradientsFlag::Both)]
    gradients: GradientsFlag,
    /// How records are weighed
    #[arg(long, value_enum, default_value_t = WeightsFlag::Smooth)]
    weights: WeightsFlag,
    /// Begin with a cache that --cache-out wrote: another view of the scene, another run
    #[arg(long, value_name = "FILE")]
    cache_in: Option<PathBuf>,
    /// Write the cache
    #[arg(long, value_name = "FILE")]
    cache_out: Option<PathBuf>,
    /// Write the records to look at: a point cloud (.ply) or a table (.csv)
    #[arg(long, value_name = "FILE.ply|.csv")]
    records_out: Option<PathBuf>,
    /// Pictures of the cache, as OUT.NAME.png and as layers
    #[arg(long, value_enum, value_delimiter = ',')]
    show: Vec<ShowFlag>,
}

#[derive(Clone, Copy, ValueEnum)]
enum ErrorFlag {
    /// The lecture's split sphere [slides 9, 11], without limits
    SplitSphere,
    /// The split sphere limited by gradients, pixels and neighbours
    Bounded,
    /// Second derivatives, nothing hiding anything
    HessianGeometric,
    /// Second derivatives, surfaces hiding each other
    HessianOcclusion,
}

#[derive(Clone, Copy, ValueEnum)]
enum RadiusFlag {
    /// Harmonic mean of the distances
    Harmonic,
    /// Smallest distance
    Minimum,
}

#[derive(Clone, Copy, ValueEnum)]
enum GradientsFlag {
    /// None
    Off,
    /// By the normal
    Rotation,
    /// By the position
    Translation,
    /// Both
    Both,
}

#[derive(Clone, Copy, ValueEnum)]
enum WeightsFlag {
    /// 1/error, cut off where a record ends [slide 11]
    Lecture,
    /// Nothing where a record ends
    Smooth,
}

#[derive(Clone, Copy, ValueEnum)]
enum ShowFlag {
    /// Where records are, coloured by their radius, small dark to large bright [slides 13, 14]
    Records,
    /// How far each record is good for
    Validity,
    /// The octree's cells as wires [slide 8]
    Octree,
    /// The octree's cells in the horizontal plane through the middle of the scene [slide 8]
    OctreeSlice,
    /// Weight of the record nearest to the picture's middle, and the line where it ends [slide 11]
    Weights,
}

impl Program for Args {
    type Params = Params;
    type Technique<'a> = IrradianceCaching<'a>;

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
            accuracy: self.accuracy,
            bounces: self.bounces,
            radius: match self.radius {
                RadiusFlag::Harmonic => SphereRadius::Harmonic,
                RadiusFlag::Minimum => SphereRadius::Minimum,
            },
            error: match self.error {
                ErrorFlag::SplitSphere => ErrorControl::SplitSphere,
                ErrorFlag::Bounded => ErrorControl::Bounded,
                ErrorFlag::HessianGeometric => ErrorControl::HessianGeometric,
                ErrorFlag::HessianOcclusion => ErrorControl::HessianOcclusion,
            },
            min_spacing: self.min_spacing,
            max_spacing: self.max_spacing,
            neighbour_clamping: !self.no_neighbour_clamping,
            leak_guard: !self.no_leak_guard,
            gradients: match self.gradients {
                GradientsFlag::Off => Gradients::Off,
                GradientsFlag::Rotation => Gradients::Rotation,
                GradientsFlag::Translation => Gradients::Translation,
                GradientsFlag::Both => Gradients::Both,
            },
            weights: match self.weights {
                WeightsFlag::Lecture => Weights::Lecture,
                WeightsFlag::Smooth => Weights::Smooth,
            },
            cache: self.cache_in.as_deref().map(read_cache).transpose()?,
            figures: self.show.iter().map(|f| f.figure()).collect(),
        })
    }

    fn outputs(&self) -> Vec<PathBuf> {
        self.cache_out.iter().chain(&self.records_out).cloned().collect()
    }

    fn export(&self, technique: &IrradianceCaching<'_>, path: &Path) -> Vec<u8> {
        if self.cache_out.as_deref() == Some(path) {
            return technique.saved().to_bytes();
        }
        let records = technique.cache().records().iter();
        let origin = technique.origin();
        if is_table(path) { to_csv(records, origin).into_bytes() } else { to_ply(records, origin) }
    }
}

impl ShowFlag {
    fn figure(self) -> Figure {
        match self {
            ShowFlag::Records => Figure::Records,
            ShowFlag::Validity => Figure::Validity,
            ShowFlag::Octree => Figure::Octree,
            ShowFlag::OctreeSlice => Figure::OctreeSlice,
            ShowFlag::Weights => Figure::Weights,
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
        let args = Args::parse_from(["irrcache", "scene.xml"]);
        assert_eq!(args.params(), Ok(Params::default()));
    }
}
