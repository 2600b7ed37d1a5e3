//! Measures connections of points with virtual point lights, against only the shadow rays of the same connections.
//!
//! `cargo bench -p vpl --bench connections -- SCENE.xml ... [--vpls N]`; scenes have absolute paths or paths relative
//! to crates/vpl. One thread. Each time is the sum over chunks of points of the smallest time of all repetitions; the
//! two measurements alternate. The bench then prints the memory of a million lights.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use gi_core::bsdf::{Bsdf, Transport};
use gi_core::camera::Camera;
use gi_core::geometry::Surface;
use gi_core::math::Rgb;
use gi_core::ray::Ray;
use gi_core::scene::Scene;
use glam::Vec3;
use vpl::{Pilot, Prepared, Receiver, Shooting, Termination, Vpls, shoot};

const POINTS: usize = 64;
const CHUNK: usize = 256;
const REPETITIONS: usize = 5;

/// Smallest seconds of the connections, and of their shadow rays alone; and the number of connections.
fn race(scene: &Scene, points: &[(Surface, Vec3, Bsdf)], set: &Vpls) -> ([f64; 2], usize) {
    let (mut total, mut count) = ([0.0; 2], 0);
    let (prepared, all) = (Prepared::new(set, scene), 0..set.lights.len());
    for chunk in points.chunks(CHUNK) {
        let rays: Vec<Ray> = chunk
            .iter()
            .flat_map(|(surface, wo, bsdf)| {
                let at = Receiver::new(surface, *wo, bsdf);
                let connect = move |v| set.connect(scene, v, &at).map(|c| c.shadow);
                set.lights.iter().filter_map(connect).collect::<Vec<_>>()
            })
            .collect();
        count += rays.len();
        let mut best = [f64::INFINITY; 2];
        for _ in 0..REPETITIONS {
            let clock = Instant::now();
            for (surface, wo, bsdf) in chunk {
                let mut sum = Rgb::BLACK;
                let at = Receiver::new(surface, *wo, bsdf);
                prepared.for_each_visible(all.clone(), &at, |c, through| {
                    sum += c.radiance * through;
                });
                black_box(sum);
            }
            best[0] = best[0].min(clock.elapsed().as_secs_f64());
            let clock = Instant::now();
            black_box(rays.iter().filter(|r| scene.tree().occluded(r)).count());
            best[1] = best[1].min(clock.elapsed().as_secs_f64());
        }
        total = [0, 1].map(|k| total[k] + best[k]);
    }
    (total, count)
}

fn main() {
    let (mut scenes, mut vpls) = (Vec::new(), 1024);
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    while let Some(a) = arguments.next() {
        if a == "--vpls" {
            vpls = arguments.next().and_then(|n| n.parse().ok()).expect("--vpls N");
        } else {
            scenes.push(a);
        }
    }
    if scenes.is_empty() {
        scenes.push(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/cornell-box.xml").into());
    }
    for name in scenes {
        measure(&name, vpls);
    }
}

/// Measure a scene, and print the results.
fn measure(name: &str, vpls: u32) {
    let loaded = gi_scene::load(Path::new(name), &gi_scene::Options::default());
    let Ok(loaded) = loaded.inspect_err(|problems| eprintln!("{problems}")) else {
        std::process::exit(2)
    };
    let (scene, camera) = (Scene::new(loaded.parts).expect("a scene"), Camera::new(&loaded.camera));
    let pilot = Pilot::of(&scene, 0, false);
    let how = |vpls| Shooting {
        seed: 0,
        first_path: 0,
        paths: pilot.paths_for(vpls),
        termination: Termination::Roulette,
        max_scatterings: None,
        lights: false,
        pilot,
        through_media: false,
    };
    let set = shoot(&scene, &how(vpls));
    let size = camera.size().map(|n| n as f32 / POINTS as f32);
    let points: Vec<(Surface, Vec3, Bsdf)> = (0..POINTS * POINTS)
        .filter_map(|i| {
            let film = [(i % POINTS) as f32 + 0.5, (i / POINTS) as f32 + 0.5];
            let ray = camera.ray([film[0] * size[0], film[1] * size[1]], [0.5; 2]);
            let (surface, _) = scene.intersect(&ray)?;
            let bsdf = scene.bsdf(&surface, -ray.d, Transport::Radiance);
            Some((surface, -ray.d, bsdf))
        })
        .collect();
    let ([connected, bare], count) = race(&scene, &points, &set);
    let rate = |seconds: f64| count as f64 / seconds * 1e-6;
    println!(
        "{name}: {} lights, {} points: {:.2} M connections/s, {:.2} M bare shadow rays/s: {:.0} %",
        set.lights.len(),
        points.len(),
        rate(connected),
        rate(bare),
        100.0 * bare / connected,
    );
    let clock = Instant::now();
    let million = shoot(&scene, &how(1_000_000));
    println!(
        "{name}: {} lights shot in {:.2} s, {:.1} bytes each",
        million.lights.len(),
        clock.elapsed().as_secs_f64(),
        million.memory_bytes() as f64 / million.lights.len() as f64
    );
}
