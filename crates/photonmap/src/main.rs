//! `photonmap`: photon mapping.

use std::process::ExitCode;

use std::path::{Path, PathBuf};

use clap::{Parser, ValueEnum};
use gi_cli::{Common, Program, check_points_file, is_table, parse_pixel};
use photonmap::kernel::Kernel;
use photonmap::map::Layout;
use photonmap::{Gather, Params, PhotonMapping, Show, Subsurface};

/// Photon mapping: photons from the lights, density estimates, final gather.
///
/// What it does badly shows as blur: soft caustics, light through thin walls, dark rims of walls; with too few photons as
/// blotches. More photons make it sharper, more photons an estimate (--lookup) smoother.
#[derive(Parser)]
#[command(name = "photonmap", version)]
struct Args {
    #[command(flatten)]
    common: Common,
    /// Photons to store in the global map [slide 26]: more blur less
    #[arg(long, value_name = "N", default_value_t = Params::default().photons)]
    photons: usize,
    /// Photons to store in the caustic map [slide 26]; 0 leaves caustics to paths from the eye
    #[arg(long, value_name = "N", default_value_t = Params::default().caustic_photons)]
    caustic_photons: usize,
    /// Photons to store where media scatter light [slide 34]; 0 leaves media out
    #[arg(long, value_name = "N", default_value_t = Params::default().volume_photons)]
    volume_photons: usize,
    /// Photons in a medium that the radius of one of them reaches to: more are smoother and blur more
    #[arg(long, value_name = "K", default_value_t = Params::default().volume_lookup, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=1000))]
    volume_lookup: usize,
    /// How the light in translucent solids is found [slide 34]
    #[arg(long, value_enum, default_value_t = SubsurfaceFlag::Photons)]
    subsurface: SubsurfaceFlag,
    /// Photons of an estimate [slide 24]: more are smoother and blur more
    #[arg(long, value_name = "K", default_value_t = Params::default().lookup)]
    lookup: usize,
    /// Largest radius of an estimate, as a share of the scene's radius; 0 is automatic
    #[arg(long, value_name = "R", default_value_t = Params::default().max_radius)]
    max_radius: f32,
    /// How photons count by their distance [slide 24]
    #[arg(long, value_enum, default_value_t = KernelFlag::Epanechnikov)]
    kernel: KernelFlag,
    /// Where the maps are read [slides 27-31]
    #[arg(long, value_enum, default_value_t = GatherFlag::Final)]
    gather: GatherFlag,
    /// Rays of a gather point in a pass [slide 31]
    #[arg(long, value_name = "N", default_value_t = Params::default().gather_rays, value_parser = clap::value_parser!(u32).range(1..=65536))]
    gather_rays: u32,
    /// Share of the gather rays that are led to where photons came from, from 0 to below 1 [slide 31]
    #[arg(long, value_name = "SHARE", default_value_t = Params::default().guided)]
    guided: f32,
    /// Pictures of the maps beside the picture [slides 22, 23, 25, 26, 34]; several joined by commas
    #[arg(long, value_enum, value_delimiter = ',', value_name = "WHAT")]
    show: Vec<ShowFlag>,
    /// Save the photons
    #[arg(long, value_name = "FILE")]
    map_out: Option<PathBuf>,
    /// Use photons that --map-out saved, for another view of the same scene
    #[arg(long, value_name = "FILE")]
    map_in: Option<PathBuf>,
    /// Write the photons with their maps and kinds: .ply (points) or .csv
    #[arg(long, value_name = "FILE")]
    photons_out: Option<PathBuf>,
    /// Write the estimate at a pixel against the number of photons [slide 24], see --probe
    #[arg(long, value_name = "FILE.csv", requires = "probe")]
    probe_out: Option<PathBuf>,
    /// The pixel of --probe-out
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel)]
    probe: Option<[usize; 2]>,
    /// How photons lie in memory [slide 25]; the picture is the same
    #[arg(long, value_enum, default_value_t = LayoutFlag::Fast)]
    photon_layout: LayoutFlag,
}

#[derive(Clone, Copy, ValueEnum)]
enum KernelFlag {
    /// All the same but the k-th
    Box,
    /// Falls linearly with the distance
    Cone,
    /// Jensen's Gaussian
    Gaussian,
    /// Falls with the squared distance, to zero
    Epanechnikov,
    /// Epanechnikov's squared
    Simpson,
    /// The slide's formula as it stands, too bright by k / (k - 1)
    Lecture,
}

#[derive(Clone, Copy, ValueEnum)]
enum GatherFlag {
    /// At the first surface, for all light [slides 29, 30]
    None,
    /// At the first surface, direct light by sampling lights
    Direct,
    /// At the second diffuse surface, caustics at the first [slide 31]
    Final,
}

#[derive(Clone, Copy, ValueEnum)]
enum SubsurfaceFlag {
    /// Photons in the medium
    Photons,
    /// Diffusion from the photons that enter: smooth, too dark where a solid is thin; --max-depth counts the way through as two segments
    Dipole,
}

#[derive(Clone, Copy, ValueEnum)]
enum LayoutFlag {
    /// The lecture's left-balanced tree
    Jensen,
    /// Leaves of 32
    Fast,
}

#[derive(Clone, Copy, ValueEnum)]
enum ShowFlag {
    /// The first 200 photon paths
    Paths,
    /// The photons of each map as dots, those in media through glass too
    Photons,
    /// Cells of the tree
    Cells,
    /// Caustic photons and gather rays at --probe, or at the middle [slides 27, 28]
    Gathering,
}

impl Program for Args {
    type Params = Params;
    type Technique<'a> = PhotonMapping<'a>;

    fn common(&self) -> &Common {
        &self.common
    }

    fn knows_media(&self) -> bool {
        self.volume_photons > 0
    }

    fn finds_focused_light(&self) -> bool {
        self.caustic_photons > 0
    }

    fn params(&self) -> Result<Params, String> {
        if self.photons == 0 || self.lookup == 0 {
            return Err("--photons and --lookup are at least 1".into());
        }
        if !(self.max_radius >= 0.0 && self.max_radius.is_finite()) {
            return Err(format!(
                "--max-radius {}: a share of the scene's radius, 0 or more",
                self.max_radius
            ));
        }
        if !(0.0..1.0).contains(&self.guided) {
            return Err(format!("--guided {}: a share from 0 to below 1", self.guided));
        }
        check_points_file("--photons-out", &self.photons_out)?;
        let kernel = match self.kernel {
            KernelFlag::Box => Kernel::Box,
            KernelFlag::Cone => Kernel::Cone,
            KernelFlag::Gaussian => Kernel::Gaussian,
            KernelFlag::Epanechnikov => Kernel::Epanechnikov,
            KernelFlag::Simpson => Kernel::Simpson,
            KernelFlag::Lecture => Kernel::Lecture,
        };
        let gather = match self.gather {
            GatherFlag::None => Gather::None,
            GatherFlag::Direct => Gather::Direct,
            GatherFlag::Final => Gather::Final,
        };
        let show = self.show.iter().map(|s| match s {
            ShowFlag::Paths => Show::Paths,
            ShowFlag::Photons => Show::Photons,
            ShowFlag::Cells => Show::Cells,
            ShowFlag::Gathering => Show::Gathering { pixel: self.probe },
        });
        let show = show.collect();
        let layout = match self.photon_layout {
            LayoutFlag::Jensen => Layout::Jensen,
            LayoutFlag::Fast => Layout::Fast,
        };
        let subsurface = match self.subsurface {
            SubsurfaceFlag::Photons => Subsurface::Photons,
            SubsurfaceFlag::Dipole => Subsurface::Dipole,
        };
        Ok(Params {
            photons: self.photons,
            caustic_photons: self.caustic_photons,
            volume_photons: self.volume_photons,
            volume_lookup: self.volume_lookup,
            subsurface,
            lookup: self.lookup,
            max_radius: self.max_radius,
            kernel,
            gather,
            gather_rays: self.gather_rays,
            guided: self.guided,
            layout,
            max_depth: self.common.max_depth(),
            map_in: self.map_in.as_deref().map(gi_cli::read_input).transpose()?,
            show,
        })
    }

    fn outputs(&self) -> Vec<PathBuf> {
        [&self.map_out, &self.photons_out, &self.probe_out].into_iter().flatten().cloned().collect()
    }

    fn export(&self, technique: &PhotonMapping, path: &Path) -> Vec<u8> {
        if self.map_out.as_deref() == Some(path) {
            technique.save()
        } else if let (Some(file), Some(pixel)) = (&self.probe_out, self.probe)
            && file == path
        {
            technique.probe(pixel)
        } else {
            technique.export(is_table(path))
        }
    }
}

fn main() -> ExitCode {
    gi_cli::main::<Args>()
}
