//! Classic mistakes in global illumination, made on purpose, each beside the right way.
//!
//! **This program is wrong on purpose.** Each estimator here is a few lines long and has its mistakes as variants; the first variant
//! of each is right. The project's programs contain none of these mistakes and share no estimator with this crate. `make mistakes`
//! draws all of them, and checks how far each is from the truth.
#![forbid(unsafe_code)]

mod density;
mod direct;
mod paths;
mod shrinking;
mod virtual_lights;
mod world;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, ValueEnum};

use world::World;

/// Render a classic mistake, or the right way beside it.
#[derive(Parser)]
#[command(name = "mistakes", version)]
struct Args {
    /// What to render
    #[arg(value_enum)]
    way: Way,
    /// The scene
    scene: PathBuf,
    /// The picture to write (.exr; a .png is written beside it)
    #[arg(short)]
    out: PathBuf,
    /// Width and height in pixels
    #[arg(long, default_value_t = 256)]
    size: usize,
    /// Samples per pixel, or passes
    #[arg(long, default_value_t = 64)]
    spp: u32,
    /// Light paths, per pass if there are several passes
    #[arg(long, default_value_t = 100_000)]
    light_paths: u32,
    /// Radius of a density estimate, as a fraction of the scene's radius
    #[arg(long, default_value_t = 0.03)]
    radius: f32,
}

/// The right ways and the mistakes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Way {
    /// Direct light, right: f = albedo / pi, times the cosine, divided by the density
    Direct,
    /// Direct light with f = albedo: 1 / pi is forgotten
    NoPi,
    /// Direct light with f = albedo / pi^2: 1 / pi is counted twice
    PiTwice,
    /// Direct light without the cosine at the surface
    NoCosine,
    /// Direct light with the cosine counted twice
    CosineTwice,
    /// Density of photons, right: power divided by the number of emitted paths, photons of the own side only
    Density,
    /// Photon power divided by the number of stored photons
    PerStored,
    /// Photons from behind the surface are counted
    FromBehind,
    /// Photons without the correction for shading normals
    NoAdjoint,
    /// Progressive radius, right: flux shrinks together with the radius
    Shrinking,
    /// The radius shrinks, and the flux that was found in the larger disc stays
    FluxStays,
    /// Virtual point lights with a bounded geometry term: a bit dark in corners, but without spots
    Clamped,
    /// Virtual point lights without a bound: spots
    Unclamped,
    /// Path tracing, right: survivors of Russian roulette are divided by the probability of survival
    Paths,
    /// Survivors of Russian roulette are not divided
    BiasedRoulette,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("mistakes: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn run(args: &Args) -> anyhow::Result<()> {
    let world = World::load(&args.scene, args.size)?;
    let picture = match args.way {
        Way::Direct | Way::NoPi | Way::PiTwice | Way::NoCosine | Way::CosineTwice => {
            direct::render(&world, args)
        }
        Way::Density | Way::PerStored | Way::FromBehind | Way::NoAdjoint => {
            density::render(&world, args)
        }
        Way::Shrinking | Way::FluxStays => shrinking::render(&world, args),
        Way::Clamped | Way::Unclamped => virtual_lights::render(&world, args),
        Way::Paths | Way::BiasedRoulette => paths::render(&world, args),
    };
    picture.save(&args.out)
}
