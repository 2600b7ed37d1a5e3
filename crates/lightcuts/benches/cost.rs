//! Measures where the time of a cut goes, and how loose its bounds are.
//!
//! `cargo bench -p lightcuts --bench cost -- [SCENE.xml] [--vpls N] [--lights N] [--error E] [--max-cut N] [-D
//! name=value]`. Prints, for points spread over the picture: the size of the cut, the number of bounds, and the time of
//! a bound, of the connection with a representative, and of its shadow ray. Then, by kind of light and of surface, for
//! the clusters of the cuts: the bound over the unshadowed light of the cluster, the bound of the error over the true
//! error, and the fraction of clusters that are entirely hidden.

mod common;

use std::hint::black_box;
use std::time::Instant;

use common::{Clock, GALLERY, Point, at, define, make, read};
use gi_core::bsdf::Transport;
use gi_core::camera::Camera;
use gi_core::math::Rgb;
use gi_core::scene::Scene;
use lightcuts::cut::{Cluster, Cut, Limits, Lit};
use lightcuts::light::{At, Lights};
use lightcuts::tree::{Family, Forest};
use lightcuts::{Params, choose, light_by_cut};
use vpl::Prepared;

/// Grid of points over the picture.
const POINTS: [usize; 2] = [24, 18];
/// Every how many points the clusters are compared with the truth.
const COMPARED: usize = 8;
/// How often a step is repeated for its time.
const REPETITIONS: usize = 3;

/// The command-line options.
struct Asked {
    scene: String,
    defines: Vec<(String, String)>,
    vpls: u32,
    lights: u32,
    limits: Limits,
}

fn main() {
    let asked = arguments();
    let (scene, camera) = read(&asked.scene, &asked.defines);
    let set = make(&scene, asked.lights, asked.vpls);
    let clock = Instant::now();
    let forest = Forest::build(&scene, &set, false, 1);
    let built = clock.elapsed().as_secs_f64();
    println!("{}: {} lights, trees in {built:.2} s", asked.scene, set.lights.len());
    let prepared = Prepared::new(&set, &scene);
    let lights = Lights { scene: &scene, prepared: &prepared, forest: &forest };
    let seen = seen(&scene, &camera);
    times(&lights, &seen, &asked.limits);
    ratios(&lights, &seen, &asked.limits);
}

/// Points spread over the picture.
fn seen<'a>(scene: &'a Scene, camera: &Camera) -> Vec<Point<'a>> {
    let [w, h] = POINTS;
    let size = [0, 1].map(|k| camera.size()[k] as f32 / POINTS[k] as f32);
    let point = |i: usize| {
        let film = [((i % w) as f32 + 0.5) * size[0], ((i / w) as f32 + 0.5) * size[1]];
        let ray = camera.ray(film, [0.5; 2]);
        let (surface, _) = scene.intersect(&ray)?;
        let bsdf = scene.bsdf(&surface, -ray.d, Transport::Radiance).broad(-ray.d, 0.1)?;
        (!bsdf.albedo().is_black()).then_some((surface, -ray.d, bsdf))
    };
    (0..w * h).filter_map(point).collect()
}

/// The smallest time of some repetitions in microseconds. Long steps are timed by the thread's CPU time if the system
/// reports it, so that other threads do not count.
fn microseconds(mut step: impl FnMut()) -> f64 {
    let once = |_| {
        let clock = Clock::start();
        step();
        1e6 * clock.seconds()
    };
    (0..REPETITIONS).map(once).fold(f64::INFINITY, f64::min)
}

/// Print the size of the cuts, and the time of their steps.
fn times(lights: &Lights, seen: &[Point], limits: &Limits) {
    let n = seen.len() as f64;
    let whole = |p: &Point| at(lights.scene, p, |at| light_by_cut(lights, at, limits));
    let cut_time = microseconds(|| seen.iter().for_each(|p| _ = black_box(whole(p)))) / n;
    let lit: Vec<Lit> = seen.iter().map(whole).collect();
    let mean = |f: &dyn Fn(&Lit) -> u32| lit.iter().map(|l| f64::from(f(l))).sum::<f64>() / n;
    let [size, rays, bounds] = [mean(&|l| l.size), mean(&|l| l.rays), mean(&|l| l.bounds)];
    let at_limit = 100.0 * mean(&|l| u32::from(l.at_most));
    println!(
        "cut {cut_time:.1} us a point: {size:.1} clusters, {rays:.1} rays, {bounds:.1} bounds; {at_limit:.1} % at --max-cut"
    );
    let [mut bound, mut connect, mut ray, mut count] = [0.0; 4];
    for p in seen.iter().step_by(COMPARED) {
        at(lights.scene, p, |at| {
            let mut cut = Cut::default();
            choose(lights, at, limits, &mut cut, &mut None);
            let clusters = cut.clusters();
            let tree = |c: &Cluster| &lights.forest.trees[c.tree as usize];
            let light = |c: &Cluster| tree(c).node(c.node).representative as usize;
            let connected = |c: &Cluster| lights.prepared.connect_unit(light(c), &at.receiver);
            let shadows: Vec<_> = clusters.iter().filter_map(connected).collect();
            count += clusters.len() as f64;
            bound += microseconds(|| {
                clusters.iter().for_each(|c| _ = black_box(lights.bound(at, c.tree, c.node)))
            });
            connect += microseconds(|| clusters.iter().for_each(|c| _ = black_box(connected(c))));
            ray += microseconds(|| {
                shadows.iter().for_each(|c| _ = black_box(c.transmittance(lights.scene)))
            });
        });
    }
    println!(
        "per cluster: bound {:.3} us, connection {:.3} us, shadow ray {:.3} us",
        bound / count,
        connect / count,
        ray / count
    );
}

/// What is known about a cluster.
struct Checked {
    kind: String,
    /// Bound of its light over its unshadowed light.
    light: f32,
    /// Bound of its error over its true error.
    error: f32,
    /// Whether all of its light is hidden.
    hidden: bool,
}

/// Print how loose bounds are, by kind of light and of surface.
fn ratios(lights: &Lights, seen: &[Point], limits: &Limits) {
    let mut checked = Vec::new();
    for p in seen.iter().step_by(COMPARED) {
        at(lights.scene, p, |at| check(lights, at, limits, &mut checked));
    }
    println!("clusters | bound over light: median, 90 % | bound over error: median, 90 % | hidden");
    let mut kinds: Vec<String> = checked.iter().map(|c| c.kind.clone()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    for kind in kinds {
        let of: Vec<&Checked> = checked.iter().filter(|c| c.kind == kind).collect();
        let at = |f: fn(&Checked) -> f32, share: f64| {
            let mut all: Vec<f32> = of.iter().map(|c| f(c)).collect();
            all.sort_unstable_by(f32::total_cmp);
            all[((all.len() - 1) as f64 * share) as usize]
        };
        let hidden = of.iter().filter(|c| c.hidden).count() as f64 / of.len() as f64;
        println!(
            "{:8} | {:8.2} {:8.2} | {:8.2} {:8.2} | {:5.1} % | {kind}",
            of.len(),
            at(|c| c.light, 0.5),
            at(|c| c.light, 0.9),
            at(|c| c.error, 0.5),
            at(|c| c.error, 0.9),
            100.0 * hidden
        );
    }
}

/// Compare the clusters of a point's cut with the truth.
fn check<'a>(
    lights: &Lights<'_, 'a>,
    at: &At<'_, '_, 'a>,
    limits: &Limits,
    checked: &mut Vec<Checked>,
) {
    let mut cut = Cut::default();
    choose(lights, at, limits, &mut cut, &mut None);
    let surface = if at.site.is_lambertian() { "diffuse" } else { "glossy" };
    for c in cut.clusters().iter().filter(|c| c.error > 0.0) {
        let tree = &lights.forest.trees[c.tree as usize];
        let members = tree.members(c.node);
        let open = |k: u32| {
            let c = lights.prepared.connect_unit(k as usize, &at.receiver)?;
            let power = lights.prepared.set().lights[k as usize].power;
            Some(c.radiance * at.kept(c.geometry, tree.is_direct()) * power)
        };
        let unshadowed: Rgb = members.iter().filter_map(|&k| open(k)).sum();
        let truth: Rgb = members.iter().map(|&k| lights.one(at, k)).sum();
        let estimate = c.unit * tree.node(c.node).power;
        let bound = lights.bound(at, c.tree, c.node).unwrap_or(Rgb::BLACK);
        let family = match tree.family {
            Family::Omni => "omni",
            Family::Oriented => "oriented",
            Family::Directional => "parallel",
            Family::Glossy => "glossy",
        };
        let source = if tree.is_direct() { "direct" } else { "indirect" };
        checked.push(Checked {
            kind: format!("{source}, {family} lights on {surface} surfaces"),
            light: bound.luminance() / unshadowed.luminance(),
            error: c.error / (estimate - truth).luminance().abs(),
            hidden: truth.is_black(),
        });
    }
}

fn arguments() -> Asked {
    let mut asked = Asked {
        scene: GALLERY.into(),
        defines: Vec::new(),
        vpls: 16_384,
        lights: 4096,
        limits: Params::default().cut,
    };
    let mut arguments = std::env::args().skip(1).filter(|a| a != "--bench");
    while let Some(a) = arguments.next() {
        let mut value = || arguments.next().unwrap_or_else(|| panic!("{a} needs a value"));
        match a.as_str() {
            "--vpls" => asked.vpls = value().parse().expect("--vpls N"),
            "--lights" => asked.lights = value().parse().expect("--lights N"),
            "--error" => asked.limits.error = value().parse().expect("--error E"),
            "--max-cut" => asked.limits.max_cut = Some(value().parse().expect("--max-cut N")),
            "-D" => asked.defines.push(define(&value())),
            _ => asked.scene = a,
        }
    }
    asked
}
