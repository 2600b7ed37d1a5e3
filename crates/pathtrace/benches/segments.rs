//! Measures path segments per second, and how the time divides into phases: camera rays, bounce rays, shadow rays and
//! shading. Shading is all time that is not spent in rays: surface points, materials, light samples, random numbers.
//!
//! `cargo bench -p pathtrace --bench segments -- SCENE.xml ...`; scenes have absolute paths or paths relative to
//! crates/pathtrace. One thread. Each time is the sum over chunks of pixels of the smallest time of all repetitions; the
//! measurements alternate. Chunks are short, so that other programs disturb few of them.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use gi_core::camera::Camera;
use gi_core::eye::{EyeVertex, EyeWalk};
use gi_core::film::{Sample, Show};
use gi_core::options::{PathLimits, SurfaceLayers};
use gi_core::ray::Ray;
use gi_core::rng::Pcg;
use gi_core::scene::Scene;
use gi_core::technique::Setting;

/// Paths per pixel, and longer side of the picture in pixels.
const PATHS: u32 = 16;
const SIDE: usize = 128;
const REPETITIONS: usize = 7;
/// Pixels per chunk.
const CHUNK: usize = 16;

/// The phases that have rays; shading is the rest.
const PHASES: [&str; 3] = ["camera rays", "bounce rays", "shadow rays"];

/// The rays of a chunk of pixels, by phase.
type Rays = [Vec<Ray>; 3];

fn main() {
    let arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    let mut scenes: Vec<String> = arguments.collect();
    if scenes.is_empty() {
        scenes = ["cornell-box", "cornell-glossy", "patio"]
            .map(|name| format!("{}/../../scenes/{name}.xml", env!("CARGO_MANIFEST_DIR")))
            .into();
    }
    for name in scenes {
        measure(&name);
    }
}

/// Measure a scene, and print the results.
fn measure(name: &str) {
    let loaded = gi_scene::load(Path::new(name), &gi_scene::Options::default());
    let Ok(mut loaded) = loaded.inspect_err(|problems| eprintln!("{problems}")) else {
        std::process::exit(2)
    };
    let longer = loaded.camera.size[0].max(loaded.camera.size[1]);
    loaded.camera.size = loaded.camera.size.map(|n| (n * SIDE).div_ceil(longer));
    let (scene, camera) = (Scene::new(loaded.parts).expect("a scene"), Camera::new(&loaded.camera));
    let setting = Setting {
        scene: &scene,
        world: 0,
        camera: &camera,
        seed: 1,
        show: Show::All,
        surface_layers: SurfaceLayers::First,
        source_rays: 0,
    };
    let (mut paths, mut rays, mut counts) = (0.0, [0.0; 3], [0; 3]);
    let [width, height] = camera.size();
    for first in (0..width * height).step_by(CHUNK) {
        let pixels: Vec<[usize; 2]> =
            (first..(first + CHUNK).min(width * height)).map(|i| [i % width, i / width]).collect();
        let chunk = record(&setting, &pixels);
        let best = race(&setting, &pixels, &chunk);
        paths += best[0];
        for (k, phase) in chunk.iter().enumerate() {
            counts[k] += phase.len();
            rays[k] += best[k + 1];
        }
    }
    report(name, paths, rays, counts);
}

/// Smallest seconds of the paths of a chunk, and of its rays alone by phase.
fn race(setting: &Setting, pixels: &[[usize; 2]], chunk: &Rays) -> [f64; 4] {
    let tree = setting.scene.tree();
    let mut best = [f64::INFINITY; 4];
    let mut time = |k: usize, work: &dyn Fn()| {
        let clock = Instant::now();
        work();
        best[k] = best[k].min(clock.elapsed().as_secs_f64());
    };
    for _ in 0..REPETITIONS {
        time(0, &|| {
            for_each_path(setting, pixels, |walk| {
                black_box(trace(walk, |_, _| ()));
            });
        });
        for k in [0, 1] {
            time(k + 1, &|| {
                black_box(chunk[k].iter().filter_map(|r| tree.closest(r)).count());
            });
        }
        time(3, &|| {
            black_box(chunk[2].iter().filter(|r| tree.occluded(r)).count());
        });
    }
    best
}

/// Call `work` with the start of every path of a chunk.
fn for_each_path(setting: &Setting, pixels: &[[usize; 2]], mut work: impl FnMut(EyeWalk)) {
    for &pixel in pixels {
        for index in 0..PATHS {
            work(EyeWalk::through_pixel(setting, PathLimits::default(), pixel, index));
        }
    }
}

/// Trace a path as the path tracer does. `note` gets each segment, and the vertex at its end.
#[inline(always)]
fn trace(mut walk: EyeWalk, mut note: impl FnMut(&Ray, Option<&EyeVertex>)) -> Sample {
    loop {
        let segment = *walk.segment();
        let vertex = walk.next_vertex();
        note(&segment, vertex.as_ref());
        let Some(v) = &vertex else { break };
        walk.add_emitted(v);
        walk.add_direct(v);
        if !walk.scatter(v) {
            break;
        }
    }
    walk.sample()
}

/// Record the rays of all paths of a chunk. Shadow rays go to light samples of their own, because a path does not tell
/// its light samples; on average they are the same.
fn record(setting: &Setting, pixels: &[[usize; 2]]) -> Rays {
    let [x, y] = pixels[0].map(|i| i as u64);
    let (mut rays, mut rng) = (Rays::default(), Pcg::new(x, y));
    for_each_path(setting, pixels, |walk| {
        let mut is_first = true;
        trace(walk, |segment, vertex| {
            rays[usize::from(!std::mem::take(&mut is_first))].push(*segment);
            rays[2].extend(vertex.and_then(|v| shadow_ray(setting.scene, v, rng.next_2d())));
        });
    });
    rays
}

/// The shadow ray of a light sample, if the sample carries light.
fn shadow_ray(scene: &Scene, v: &EyeVertex, u: [f32; 2]) -> Option<Ray> {
    let light = scene.sample_light(v.surface.p, u)?;
    let arriving = v.bsdf.f_cos(v.wo, light.wi) * light.radiance;
    (!arriving.is_black()).then(|| match light.p {
        Some(q) => scene.tree().shadow_ray(v.surface.p, v.surface.ng, q),
        None => scene.spawn(&v.surface, light.wi),
    })
}

fn report(name: &str, paths: f64, rays: [f64; 3], counts: [usize; 3]) {
    let segments = counts[0] + counts[1];
    let line = |phase: &str, count: usize, seconds: f64| {
        println!(
            "  {phase:12} {:6.2} M/s, {:3.0} % of the time",
            1e-6 * count as f64 / seconds,
            100.0 * seconds / paths
        );
    };
    println!(
        "{name}: {:.2} M segments/s, {:.2} M paths/s, {:.1} segments and {:.1} shadow rays per path",
        1e-6 * segments as f64 / paths,
        1e-6 * counts[0] as f64 / paths,
        segments as f64 / counts[0] as f64,
        counts[2] as f64 / counts[0] as f64,
    );
    for (k, phase) in PHASES.iter().enumerate() {
        line(phase, counts[k], rays[k]);
    }
    line("shading", segments, paths - rays.iter().sum::<f64>());
}
