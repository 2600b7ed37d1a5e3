//! Measures the time per point with cuts and with all lights, from 10 to 1,000,000 lights [slides 53, 61].
//!
//! `cargo bench -p lightcuts --bench scaling -- [SCENE.xml] [--lights N,N...] [--max-cut N] [--connections N] [--error
//! E] [--rule cluster|whole] [-D name=value]`. A quarter of the lights are points on light sources, the others are on
//! surfaces. Times are CPU times of one thread: for each chunk of points, the smallest of all repetitions; the two
//! methods alternate. If illuminating all points by all lights needs more than `--connections` connections, both
//! methods illuminate fewer points. With `--connections 0`, only lights and trees are built. Memory is that of lights
//! and trees.

mod common;

use std::hint::black_box;
use std::time::Instant;

use common::{Clock, GALLERY, Point, at, define, make, read};
use gi_core::bsdf::Transport;
use gi_core::camera::Camera;
use gi_core::scene::Scene;
use lightcuts::cut::{Limits, Lit, Rule};
use lightcuts::light::Lights;
use lightcuts::tree::Forest;
use lightcuts::{Params, light_by_cut};
use rayon::prelude::*;
use vpl::Prepared;

/// Grid of points over the picture, horizontally and vertically.
const POINTS: [usize; 2] = [64, 48];
/// Number of lights times points that are timed together, small enough that some repetition runs undisturbed; and the
/// number of repetitions.
const CHUNK: usize = 5000;
const REPETITIONS: usize = 5;
/// Smallest number of points that are illuminated, and largest number that are timed.
const LEAST: usize = 16;
const TIMED: usize = 256;
/// Weber's law: an error of this size is invisible [slide 54], whatever `--error` is.
const WEBER: f32 = 0.02;

/// The command-line options.
struct Asked {
    scene: String,
    defines: Vec<(String, String)>,
    numbers: Vec<u32>,
    limits: Limits,
    connections: usize,
}

fn main() {
    let asked = arguments();
    let (scene, camera) = read(&asked.scene, &asked.defines);
    let seen = seen(&scene, &camera);
    println!("{}: {} points, {:?}", asked.scene, seen.len(), asked.limits);
    println!(
        "   lights  build s   MB | us/point: all   cuts  ratio | mean cut  rays at limit | error: median    99 %  \
         below 2 % (points)"
    );
    let mut last: Option<(f64, f64)> = None;
    for &number in &asked.numbers {
        let (lights, ratio) = measure(&scene, &seen, number, &asked);
        if let Some((before, r)) = last.filter(|(_, r)| (*r < 1.0) != (ratio < 1.0)) {
            let t = r.ln() / (r.ln() - ratio.ln());
            println!(
                "-- as fast as brute force at {:.0} lights",
                before * (lights / before).powf(t)
            );
        }
        last = Some((lights, ratio));
    }
}

/// Points spread over the picture, in an order in which any first part of them is also spread over the picture.
fn seen<'a>(scene: &'a Scene, camera: &Camera) -> Vec<Point<'a>> {
    let [w, h] = POINTS;
    let size = [0, 1].map(|k| camera.size()[k] as f32 / POINTS[k] as f32);
    // A step that has no factor in common with the number of points.
    let order = (0..w * h).map(|i| i * 1013 % (w * h));
    let point = |i: usize| {
        let film = [((i % w) as f32 + 0.5) * size[0], ((i / w) as f32 + 0.5) * size[1]];
        let ray = camera.ray(film, [0.5; 2]);
        let (surface, _) = scene.intersect(&ray)?;
        let bsdf = scene.bsdf(&surface, -ray.d, Transport::Radiance);
        // Skip lamps that scatter no light.
        let lit = !bsdf.is_delta() && !bsdf.albedo().is_black();
        lit.then_some((surface, -ray.d, bsdf))
    };
    order.filter_map(point).collect()
}

/// Print a line of the table. Returns the number of lights, and the speedup of cuts.
fn measure(scene: &Scene, seen: &[Point], number: u32, asked: &Asked) -> (f64, f64) {
    let direct = (number / 4).max(1);
    let set = make(scene, direct, number - direct);
    let clock = Instant::now();
    let forest = Forest::build(scene, &set, false, 1);
    let building = clock.elapsed().as_secs_f64();
    let prepared = Prepared::new(&set, scene);
    let lights = Lights { scene, prepared: &prepared, forest: &forest };
    let with = |p: &Point, by_cut: bool| {
        at(scene, p, |at| match by_cut {
            true => light_by_cut(&lights, at, &asked.limits),
            false => lights.light_by_all(at),
        })
    };
    let memory = (set.memory_bytes() + forest.memory_bytes()) as f64 * 1e-6;
    print!("{:9} {building:8.3} {memory:6.1}", set.lights.len());
    if asked.connections == 0 {
        println!();
        return (set.lights.len() as f64, 1.0);
    }
    let compared = (asked.connections / set.lights.len().max(1)).clamp(LEAST, seen.len());
    // Limit the points so that timing takes half of the total time.
    let timed = (compared / (2 * REPETITIONS)).clamp(LEAST, TIMED).min(seen.len());
    let seen = &seen[..compared];
    let [all, cuts] = race(&seen[..timed], set.lights.len(), &with).map(|s| s / timed as f64 * 1e6);
    let lit: Vec<Lit> = seen.par_iter().map(|p| with(p, true)).collect();
    let relative = |(p, lit): (&Point, &Lit)| {
        let exact = with(p, false).all().luminance();
        (exact > 0.0).then(|| ((lit.all().luminance() - exact) / exact).abs())
    };
    let pairs = seen.par_iter().zip(&lit).with_max_len(1);
    let mut errors: Vec<f32> = pairs.filter_map(relative).collect();
    errors.sort_unstable_by(f32::total_cmp);
    let of = |share: f64| errors[((errors.len() - 1) as f64 * share).round() as usize] * 100.0;
    let below = errors.partition_point(|e| *e <= WEBER) as f64;
    let mean = |f: &dyn Fn(&Lit) -> f64| lit.iter().map(f).sum::<f64>() / lit.len() as f64;
    println!(
        " | {all:12.1} {cuts:8.1} {:7.2} | {:6.1} {:7.1} {:5.1} % | {:10.2} % {:6.2} % \
         {:10.2} % ({})",
        all / cuts,
        mean(&|l| l.size.into()),
        mean(&|l| l.rays.into()),
        100.0 * mean(&|l| u32::from(l.at_most).into()),
        of(0.5),
        of(0.99),
        100.0 * below / errors.len() as f64,
        errors.len()
    );
    (set.lights.len() as f64, all / cuts)
}

/// Smallest seconds with all lights and with cuts; the two methods alternate.
fn race(points: &[Point], lights: usize, with: &impl Fn(&Point, bool) -> Lit) -> [f64; 2] {
    let mut total = [0.0; 2];
    // Long chunks are timed by clock ticks, so they must take many ticks.
    let together = if lights < 20_000 { (CHUNK / lights.max(1)).max(1) } else { points.len() };
    for chunk in points.chunks(together) {
        let mut best = [f64::INFINITY; 2];
        for _ in 0..REPETITIONS {
            for (k, best) in best.iter_mut().enumerate() {
                let clock = Clock::start();
                chunk.iter().for_each(|p| _ = black_box(with(p, k == 1)));
                *best = best.min(clock.seconds());
            }
        }
        total = [0, 1].map(|k| total[k] + best[k]);
    }
    total
}

fn arguments() -> Asked {
    let mut asked = Asked {
        scene: GALLERY.into(),
        defines: Vec::new(),
        numbers: vec![10, 20, 50, 100, 1000, 10_000, 100_000, 1_000_000],
        limits: Limits { max_cut: Some(20_000), ..Params::default().cut },
        connections: 400_000_000,
    };
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    while let Some(a) = arguments.next() {
        let mut value = || arguments.next().unwrap_or_else(|| panic!("{a} needs a value"));
        match a.as_str() {
            "--lights" => {
                let number = |n: &str| n.parse().expect("--lights N,N...");
                asked.numbers = value().split(',').map(number).collect();
            }
            "--rule" => {
                asked.limits.rule = match value().as_str() {
                    "cluster" => Rule::Cluster,
                    "whole" => Rule::Whole,
                    other => panic!("there is no rule {other}: use cluster or whole"),
                }
            }
            "--max-cut" => asked.limits.max_cut = Some(value().parse().expect("--max-cut N")),
            "--error" => asked.limits.error = value().parse().expect("--error E"),
            "--connections" => asked.connections = value().parse().expect("--connections N"),
            "-D" => asked.defines.push(define(&value())),
            _ => asked.scene = a,
        }
    }
    asked
}
