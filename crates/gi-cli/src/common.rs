//! The flags that all programs have.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use gi_core::film::Show;
use glam::Vec3;

use crate::Failure;
use crate::budget::{Budget, parse_time};

/// The flags that all programs have.
#[derive(Args, Clone, Debug)]
pub struct Common {
    /// Scene: Mitsuba XML (0.5, 0.6, 3.x), or a bare OBJ with its MTL
    pub scene: PathBuf,
    /// Picture to write: .exr (all layers), .pfm or .hdr; a .png view goes beside it [default: SCENE.PROGRAM.exr]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Passes: samples a pixel where a pass is one sample a pixel [default: 64]
    #[arg(long, visible_alias = "passes", value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Time for preparing and passes instead of a number of passes: 30s, 5m, 1.5h
    #[arg(long, value_name = "TIME", conflicts_with = "spp", value_parser = parse_time)]
    pub time: Option<std::time::Duration>,
    /// Width and height of the picture in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[usize; 2]>,
    /// Seed of every random number: the same seed gives the same bits, whatever the number of threads
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// Threads [default: one a processor]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Most segments of a light path: 1 shows lights, 2 adds direct light; -1 is unbounded
    #[arg(long, value_name = "N", default_value_t = -1, allow_negative_numbers = true)]
    pub max_depth: i32,
    /// Which light the picture shows; the components add up to the whole
    #[arg(long, value_enum, default_value_t = Component::All)]
    pub component: Component,
    /// Set a scene parameter ($NAME), or a preset of a program (gi.PROGRAM.FLAG)
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = parse_define)]
    pub define: Vec<(String, String)>,
    /// Where the camera stands [default: as the scene says; a bare OBJ is framed so that all is seen]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub origin: Option<Vec3>,
    /// What the camera looks at
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub target: Option<Vec3>,
    /// What is up for the camera
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub up: Option<Vec3>,
    /// Angle of view across the picture, degrees
    #[arg(long, value_name = "DEGREES")]
    pub fov: Option<f32>,
    /// Write the scene as it was understood, as Mitsuba 3 XML, and end
    #[arg(long, value_name = "FILE.xml")]
    pub export_mitsuba: Option<PathBuf>,
    /// Write statistics of the run
    #[arg(long, value_name = "FILE.json")]
    pub stats: Option<PathBuf>,
    /// Keep what is needed to go on in this file, every minute and at the end
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Go on from --checkpoint, to the same bits as a run that was never stopped
    #[arg(long, requires = "checkpoint")]
    pub resume: bool,
    /// Number of the first pass: ranges of passes can be made apart, kept as checkpoints, and merged
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub first_pass: u32,
    /// Make no passes: add up those of checkpoints of other ranges
    #[arg(long, value_name = "FILE", conflicts_with_all = ["checkpoint", "first_pass", "spp", "time"])]
    pub merge: Vec<PathBuf>,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

/// Kinds of light path, see [`gi_core::film::Components`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Component {
    /// Everything
    All,
    /// Lights as they are seen, and light that was scattered once on its way from a light to what is seen
    Direct,
    /// Light that was scattered at least twice by other than mirrors and glass
    Indirect,
    /// Light focused by mirrors and glass onto what is seen
    Caustic,
}

impl Common {
    /// What [`gi_core::film::Film`] shows.
    pub fn show(&self) -> Show {
        match self.component {
            Component::All => Show::All,
            Component::Direct => Show::Direct,
            Component::Indirect => Show::Indirect,
            Component::Caustic => Show::Caustic,
        }
    }

    /// Most segments of a path; `None` is unbounded.
    pub fn max_depth(&self) -> Option<u32> {
        u32::try_from(self.max_depth).ok()
    }

    /// When the run is to end.
    pub(crate) fn budget(&self) -> Budget {
        match (self.time, self.spp) {
            (Some(time), _) => Budget::Time(time),
            (None, passes) => Budget::Passes(passes.unwrap_or(DEFAULT_PASSES)),
        }
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

    /// Refuse what the parser cannot see to be wrong.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        if self.max_depth == 0 || self.max_depth < -1 {
            return Err(Failure::Input(format!(
                "error: --max-depth {}: a path has at least 1 segment; -1 is unbounded",
                self.max_depth
            )));
        }
        Ok(())
    }
}

/// Passes where none were asked for.
const DEFAULT_PASSES: u32 = 64;

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
