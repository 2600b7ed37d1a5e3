//! The flags that all programs have.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Duration;

use gi_core::options::{Show, SurfaceLayers};
use gi_scene::AddedLight;
use glam::Vec3;

use crate::budget::{Budget, parse_time};
use crate::serve::Address;

/// Headings of the help.
const SCENE: &str = "Scene";
const PICTURE: &str = "Picture";
const BUDGET: &str = "Budget";
const RUN: &str = "Run";

/// The flags that all programs have.
#[derive(clap::Args, Clone, Debug)]
pub struct Common {
    /// Scene: Mitsuba XML (0.5, 0.6, 2, 3), pbrt (v3, v4), or a plain OBJ file with its MTL
    #[arg(help_heading = SCENE)]
    pub scene: PathBuf,
    /// Picture to write: .exr (all layers), .pfm or .hdr; a .png view is written beside it [default: SCENE.PROGRAM.exr, with --points
    /// SCENE.PROGRAM.csv]
    #[arg(help_heading = PICTURE, short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Number of passes; most techniques take one sample per pixel in each pass
    #[arg(help_heading = BUDGET, long, visible_alias = "passes", value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
    /// Time limit for preparation and passes, instead of a number of passes: 30s, 5m, 1.5h
    #[arg(help_heading = BUDGET, long, value_name = "TIME", conflicts_with = "spp", value_parser = parse_time)]
    pub time: Option<Duration>,
    /// Width and height of the picture in pixels [default: as in the scene]
    #[arg(help_heading = PICTURE, long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[usize; 2]>,
    /// Seed of all random numbers; the same seed gives the same bits with any number of threads
    #[arg(help_heading = RUN, long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// Number of threads [default: one per processor]
    #[arg(help_heading = RUN, short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Part of the light that the picture shows; direct, indirect and caustic add up to all
    #[arg(help_heading = PICTURE, long, value_enum, default_value_t = Show::All)]
    pub component: Show,
    /// Which surface the layers Albedo, N and Z describe; denoisers work better with non-specular
    #[arg(help_heading = PICTURE, long, value_enum, default_value_t = SurfaceLayers::First)]
    pub surface_layers: SurfaceLayers,
    /// Extra camera rays per pixel and pass that look only for light sources in view, also in mirrors and through glass. They make edges of
    /// lamps smooth after few passes. With 0, the technique's own paths find these sources
    #[arg(help_heading = PICTURE, long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=4096))]
    pub source_rays: u32,
    /// Set a parameter of the scene ($NAME), or a program's preset (gi.PROGRAM.FLAG)
    #[arg(help_heading = SCENE, short = 'D', value_name = "NAME=VALUE", value_parser = parse_define)]
    pub define: Vec<(String, String)>,
    /// Add a light to the scene: a clear sky with a sun, soft boxes, or a point light at the camera
    #[arg(help_heading = SCENE, long, value_name = "sky|studio|headlight", value_parser = parse_light)]
    pub light: Option<AddedLight>,
    /// Number of the sensor to render, from 0, in a scene that has several
    #[arg(help_heading = SCENE, long, value_name = "N")]
    pub sensor: Option<usize>,
    /// Compute irradiance at the points of this file instead of a picture: lines of x,y,z,nx,ny,nz. The output is a table (.csv) of r, g, b
    /// with standard errors. These leave out errors that samples share, such as those of records, photons and virtual lights
    #[arg(help_heading = SCENE, long, value_name = "FILE.csv", conflicts_with_all = ["size", "sensor", "origin", "target", "up", "fov", "inspect", "export_mitsuba"])]
    pub points: Option<PathBuf>,
    /// Position of the camera [default: as in the scene; for a plain OBJ file, one that shows the whole scene]
    #[arg(help_heading = SCENE, long, value_name = "X,Y,Z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub origin: Option<Vec3>,
    /// Point that the camera looks at
    #[arg(help_heading = SCENE, long, value_name = "X,Y,Z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub target: Option<Vec3>,
    /// Up direction of the camera
    #[arg(help_heading = SCENE, long, value_name = "X,Y,Z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub up: Option<Vec3>,
    /// Horizontal field of view in degrees
    #[arg(help_heading = SCENE, long, value_name = "DEGREES")]
    pub fov: Option<f32>,
    /// Memory that reading the scene and building its tree may take: 500M, 8G [default: half of the machine's]
    #[arg(help_heading = SCENE, long, value_name = "BYTES", value_parser = parse_memory)]
    pub max_memory: Option<u64>,
    /// Only print what was read and approximated, what looks wrong, and which program suits the scene
    #[arg(help_heading = SCENE, long, conflicts_with = "export_mitsuba")]
    pub inspect: bool,
    /// Only write the scene, as the program understood it, as Mitsuba 3 XML
    #[arg(help_heading = SCENE, long, value_name = "FILE.xml")]
    pub export_mitsuba: Option<PathBuf>,
    /// Write statistics of the run to this file
    #[arg(help_heading = RUN, long, value_name = "FILE.json")]
    pub stats: Option<PathBuf>,
    /// Save the state of the run to this file, after the first pass, at intervals and at the end
    #[arg(help_heading = RUN, long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Time between two checkpoints
    #[arg(help_heading = RUN, long, value_name = "TIME", default_value = "60s", value_parser = parse_time)]
    pub checkpoint_interval: Duration,
    /// Continue from the file of --checkpoint; the picture has the same bits as that of an uninterrupted run
    #[arg(help_heading = RUN, long, requires = "checkpoint")]
    pub resume: bool,
    /// Index of the first pass; separate runs can make ranges of passes and save them with --checkpoint for --merge
    #[arg(help_heading = BUDGET, long, value_name = "K", default_value_t = 0)]
    pub first_pass: u32,
    /// Make no passes, but add up the passes of checkpoints; give the option once per file
    #[arg(help_heading = RUN, long, value_name = "FILE", conflicts_with_all = ["checkpoint", "first_pass", "resume", "spp", "time"])]
    pub merge: Vec<PathBuf>,
    /// Rewrite the picture and its view during the run, at this interval or at a longer one so that it takes less than 1 % of
    /// the time; 0 turns it off [default: 10s if standard error is a terminal, else 0]
    #[arg(help_heading = PICTURE, long, value_name = "TIME", value_parser = parse_interval)]
    pub preview: Option<Duration>,
    /// Send the picture with all layers to the viewer tev, or to another program with its protocol, while it is made
    #[arg(help_heading = RUN, long, value_name = "HOST[:PORT]")]
    pub display_server: Option<String>,
    /// Serve a web page with the picture so far and the progress of the run, at PORT or HOST:PORT; without a host only to this machine.
    /// No ADDRESS is 127.0.0.1:8008
    #[arg(help_heading = RUN, long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = SERVE)]
    pub serve: Option<Address>,
    /// Print errors only
    #[arg(help_heading = RUN, short, long)]
    pub quiet: bool,
}

impl Common {
    /// When the run is to end.
    pub(crate) fn budget(&self) -> Budget {
        self.time.map_or(Budget::Passes(self.spp), Budget::Time)
    }

    /// Whether something other than a number of passes says when the run ends.
    pub(crate) fn has_other_budget(&self) -> bool {
        self.time.is_some() || !self.merge.is_empty()
    }

    /// Time between two previews; `None` makes no previews.
    pub(crate) fn preview(&self) -> Option<Duration> {
        let default =
            || if std::io::stderr().is_terminal() { DEFAULT_PREVIEW } else { Duration::ZERO };
        Some(self.preview.unwrap_or_else(default)).filter(|time| !time.is_zero())
    }

    /// Where the picture goes.
    pub(crate) fn output(&self, program: &str) -> PathBuf {
        self.output.clone().unwrap_or_else(|| {
            let stem = self.scene.file_stem().unwrap_or_default().to_string_lossy();
            let extension = if self.points.is_some() { "csv" } else { "exr" };
            PathBuf::from(format!("{stem}.{program}.{extension}"))
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
        let mut options = gi_scene::Options {
            defines: self.define.clone(),
            size: self.size,
            sensor: self.sensor,
            light: self.light,
            camera,
            ..gi_scene::Options::default()
        };
        if let Some(most) = self.max_memory {
            options.max_memory = most;
        }
        options
    }
}

/// Where the live page is served, if no address is given: only programs on this machine reach it.
const SERVE: &str = "127.0.0.1:8008";

/// Time between two previews on a terminal.
const DEFAULT_PREVIEW: Duration = Duration::from_secs(10);

/// A time span; 0 is none.
fn parse_interval(text: &str) -> Result<Duration, String> {
    let number = text.trim().trim_end_matches(char::is_alphabetic);
    if number.parse() == Ok(0.0) { Ok(Duration::ZERO) } else { parse_time(text) }
}

/// Largest picture accepted, in pixels a side.
const MAX_SIDE: usize = 32_768;

fn parse_size(text: &str) -> Result<[usize; 2], String> {
    let wrong = || format!("expected WIDTHxHEIGHT, like 512x512, each from 1 to {MAX_SIDE}");
    let (w, h) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
    let side = |t: &str| t.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n)).ok_or_else(wrong);
    Ok([side(w)?, side(h)?])
}

/// A number of bytes, or of thousands, millions or billions of bytes.
fn parse_memory(text: &str) -> Result<u64, String> {
    let wrong = "expected a number of bytes, which may end in K, M or G: 500M, 8G";
    let (number, factor) = match text.char_indices().next_back() {
        Some((at, 'k' | 'K')) => (&text[..at], 1e3),
        Some((at, 'm' | 'M')) => (&text[..at], 1e6),
        Some((at, 'g' | 'G')) => (&text[..at], 1e9),
        _ => (text, 1.0),
    };
    let bytes = number.parse::<f64>().ok().map(|n| n * factor).filter(|n| *n >= 1.0 && *n < 1e18);
    bytes.map(|n| n as u64).ok_or_else(|| wrong.to_string())
}

fn parse_light(text: &str) -> Result<AddedLight, String> {
    let names = || format!("expected {}", AddedLight::NAMES.join(", "));
    AddedLight::named(text).ok_or_else(names)
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
        assert!(["0", "0s", "0.0", "0m"].iter().all(|t| parse_interval(t) == Ok(Duration::ZERO)));
        assert!(["", "s", "-1s"].iter().all(|t| parse_interval(t).is_err()));
        assert_eq!(
            ["500M", "1.5G", "2k", "7"].map(parse_memory),
            [500_000_000, 1_500_000_000, 2000, 7].map(Ok)
        );
        assert!(["", "G", "-1M", "nan", "1T", "0"].iter().all(|t| parse_memory(t).is_err()));
        assert_eq!(parse_vec3("1, -2,3"), Ok(Vec3::new(1.0, -2.0, 3.0)));
        assert!(parse_vec3("1,2").is_err());
    }
}
