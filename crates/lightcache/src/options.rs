//! Options that irradiance caching and radiance caching share.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use gi_core::files::points_file;
use gi_core::options::number;

/// How the error of a record is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ErrorControl {
    /// The lecture's split sphere [slides 9, 11] (Ward88); limits by pixels and by neighbouring records do not apply
    SplitSphere,
    /// The split sphere, limited by the gradient, by pixels and by neighbouring records (Ward92, Krivanek06)
    Bounded,
    /// Second derivatives of the irradiance, without occlusion (Schwarzhaupt12)
    HessianGeometric,
    /// Second derivatives of the irradiance, with occlusion (Schwarzhaupt12)
    HessianOcclusion,
}

/// Which distance to its surroundings is the radius of the split sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SphereRadius {
    /// Harmonic mean of the distances
    Harmonic,
    /// Smallest distance: safer near thin objects, but makes more records
    Minimum,
}

/// Which gradients interpolation uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Gradients {
    /// None: the formula of slide 11
    Off,
    /// Only the rotational gradient: change with the normal
    Rotation,
    /// Only the translational gradient: change with the position
    Translation,
    /// Both gradients
    Both,
}

/// How records are weighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Weights {
    /// 1 / error, cut off where a record ends [slide 11]; the ends of records show as edges
    Lecture,
    /// 1 - error / accuracy: falls to zero where a record ends, so no edges show (Tabellion04)
    Smooth,
}

/// A picture of a cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CacheFigure {
    /// Positions of the records, coloured by radius from small (dark) to large (bright) [slides 13, 14]
    Records,
    /// Region in which each record is valid
    Validity,
    /// Cells of the octree as wires [slide 8]
    Octree,
    /// Cells and records of the octree at the bottom of the scene, seen from above [slide 8]
    OctreeSlice,
    /// Weight of the record nearest to the middle of the picture, with a line where the record ends [slide 11]
    Weights,
}

/// Where records are valid.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
pub struct ReachOptions {
    /// Minimum radius of a record in pixels; 0 sets no limit
    #[arg(long = "min-spacing", value_name = "PIXELS", default_value_t = 3.0, value_parser = spacing())]
    pub min_spacing: f32,
    /// Maximum radius of a record in pixels; 0 sets no limit
    #[arg(long = "max-spacing", value_name = "PIXELS", default_value_t = 40.0, value_parser = spacing())]
    pub max_spacing: f32,
    /// Let the radii of neighbouring records differ by more than the distance between the records
    #[arg(long = "no-neighbour-clamping", action = clap::ArgAction::SetFalse)]
    pub neighbour_clamping: bool,
    /// Do not look for walls between a record and the point that uses it; light then leaks under thin walls
    #[arg(long = "no-leak-guard", action = clap::ArgAction::SetFalse)]
    pub leak_guard: bool,
}

impl ReachOptions {
    /// Check that the maximum radius is at least the minimum.
    ///
    /// # Errors
    /// The message names both values.
    pub fn check(&self) -> Result<(), String> {
        let ReachOptions { min_spacing: min, max_spacing: max, .. } = *self;
        if max > 0.0 && max < min {
            return Err(format!("--max-spacing {max} is less than --min-spacing {min}"));
        }
        Ok(())
    }
}

/// Files that a cache is read from and written to.
#[derive(Args, Clone, Debug, Default, PartialEq, Eq)]
pub struct CacheFiles {
    /// Start with a cache written by --cache-out, for example for another view of the same scene
    #[arg(long, value_name = "FILE")]
    pub cache_in: Option<PathBuf>,
    /// Write the cache to a file for --cache-in
    #[arg(long, value_name = "FILE")]
    pub cache_out: Option<PathBuf>,
    /// Write the irradiance of all records as a point cloud (.ply) or a table (.csv)
    #[arg(long, value_name = "FILE.ply|.csv", value_parser = points_file)]
    pub records_out: Option<PathBuf>,
}

impl CacheFiles {
    /// The files to write.
    pub fn outputs(&self) -> Vec<PathBuf> {
        self.cache_out.iter().chain(&self.records_out).cloned().collect()
    }
}

/// A value parser for `--accuracy`.
pub fn accuracy() -> impl Fn(&str) -> Result<f32, String> + Clone + Send + Sync + 'static {
    number("a number above 0 and up to 1", |a| *a > 0.0 && *a <= 1.0)
}

fn spacing() -> impl Fn(&str) -> Result<f32, String> + Clone + Send + Sync + 'static {
    number("a number of pixels, 0 or more", |p: &f32| *p >= 0.0 && p.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use gi_core::options::defaults;

    #[test]
    fn a_maximum_spacing_of_0_is_no_limit() {
        let with = |min_spacing, max_spacing| {
            ReachOptions { min_spacing, max_spacing, ..defaults() }.check()
        };
        assert_eq!(with(3.0, 0.0), Ok(()));
        assert_eq!(with(3.0, 3.0), Ok(()));
        assert!(with(3.0, 2.0).is_err());
    }

    #[test]
    fn values_outside_their_range_are_refused() {
        assert_eq!(accuracy()("1"), Ok(1.0));
        assert!(["0", "1.1", "nan", "x"].iter().all(|t| accuracy()(t).is_err()));
        assert_eq!(spacing()("0"), Ok(0.0));
        assert!(["-1", "inf", "nan", "x"].iter().all(|t| spacing()(t).is_err()));
    }
}
