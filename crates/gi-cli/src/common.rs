//! The flags that all programs have.

use std::path::PathBuf;

use gi_core::options::Show;
use glam::Vec3;

use crate::budget::{Budget, parse_time};

/// The flags that all programs have.
#[derive(clap::Args, Clone, Debug)]
pub struct Common {
    /// Scene: Mitsuba XML (0.5, 0.6, 3.x), or a plain OBJ file with its MTL
    pub scene: PathBuf,
    /// Picture to write: .exr (all layers), .pfm or .hdr; a .png view is written beside it [default: SCENE.PROGRAM.exr]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Number of passes; most techniques take one sample per pixel in each pass
    #[arg(long, visible_alias = "passes", value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
    /// Time limit for preparation and passes, instead of a number of passes: 30s, 5m, 1.5h
    #[arg(long, value_name = "TIME", conflicts_with = "spp", value_parser = parse_time)]
    pub time: Option<std::time::Duration>,
    /// Width and height of the picture in pixels [default: as in the scene]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[usize; 2]>,
    /// Seed of all random numbers; the same seed gives the same bits with any number of threads
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// Number of threads [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Part of the light that the picture shows; direct, indirect and caustic add up to all
    #[arg(long, value_enum, default_value_t = Show::All)]
    pub component: Show,
    /// Set a parameter of the scene ($NAME), or a program's preset (gi.PROGRAM.FLAG)
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = parse_define)]
    pub define: Vec<(String, String)>,
    /// Position of the camera [default: as in the scene; for a plain OBJ file, one that shows the whole scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub origin: Option<Vec3>,
    /// Point that the camera looks at
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub target: Option<Vec3>,
    /// Up direction of the camera
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub up: Option<Vec3>,
    /// Horizontal field of view in degrees
    #[arg(long, value_name = "DEGREES")]
    pub fov: Option<f32>,
    /// Only write the scene, as the program understood it, as Mitsuba 3 XML
    #[arg(long, value_name = "FILE.xml")]
    pub export_mitsuba: Option<PathBuf>,
    /// Write statistics of the run to this file
    #[arg(long, value_name = "FILE.json")]
    pub stats: Option<PathBuf>,
    /// Save the state of the run to this file, every minute and at the end
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Continue from the file of --checkpoint; the picture has the same bits as that of an uninterrupted run
    #[arg(long, requires = "checkpoint")]
    pub resume: bool,
    /// Index of the first pass; separate runs can make ranges of passes and save them with --checkpoint for --merge
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub first_pass: u32,
    /// Make no passes, but add up the passes of checkpoints; give the option once per file
    #[arg(long, value_name = "FILE", conflicts_with_all = ["checkpoint", "first_pass", "spp", "time"])]
    pub merge: Vec<PathBuf>,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

impl Common {
    /// When the run is to end.
    pub(crate) fn budget(&self) -> Budget {
        self.time.map_or(Budget::Passes(self.spp), Budget::Time)
    }

    /// Where the picture goes.
    pub(crate) fn output(&self, program: &str) -> PathBuf {
        self.output.clone().unwrap_or_else(|| {
            let stem = self.scene.file_stem().unwrap_or_default().to_string_lossy();
            PathBuf::from(format!("{stem}.{program}.exr"))
        })
    }

    /// What the scene's loader must know.
    pub(crate) fn scene_options(&self) -> gi_scene::Options {
        let camera = gi_scene::CameraOverride {
            origin: self.origin,
            target: self.target,
            up: self.up,
            fov: self.fov,
        };
        gi_scene::Options { defines: self.define.clone(), size: self.size, camera }
    }
}

/// Largest picture accepted, in pixels a side.
const MAX_SIDE: usize = 32_768;

fn parse_size(text: &str) -> Result<[usize; 2], String> {
    let wrong = || format!("expected WIDTHxHEIGHT, like 512x512, each from 1 to {MAX_SIDE}");
    let (w, h) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
    let side = |t: &str| t.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n)).ok_or_else(wrong);
    Ok([side(w)?, side(h)?])
}

fn parse_define(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    Ok((name.to_string(), value.to_string()))
}

fn parse_vec3(text: &str) -> Result<Vec3, String> {
    let wrong = || "expected three numbers: X,Y,Z".to_string();
    let numbers: Vec<f32> =
        text.split(',').map(|t| t.trim().parse()).collect::<Result<_, _>>().map_err(|_| wrong())?;
    let [x, y, z] = numbers[..] else { return Err(wrong()) };
    Ok(Vec3::new(x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_defines_and_points() {
        assert_eq!(parse_size("640x480"), Ok([640, 480]));
        assert!(["640", "0x3", "x", "1e9x2", "-1x4"].iter().all(|t| parse_size(t).is_err()));
        assert_eq!(parse_define("a=b=c"), Ok(("a".into(), "b=c".into())));
        assert!(parse_define("a").is_err());
        assert_eq!(parse_vec3("1, -2,3"), Ok(Vec3::new(1.0, -2.0, 3.0)));
        assert!(parse_vec3("1,2").is_err());
    }
}
