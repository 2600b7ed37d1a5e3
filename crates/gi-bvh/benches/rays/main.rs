//! Traces single rays through generated meshes: compares this tree with others, as ratios from one run.
//!
//! `cargo bench -p gi-bvh --bench rays -- [MESH [RAYS]]`. With `--features embree` and `EMBREE_LIB=path[:path]`, it
//! also runs Embree 3 or 4, and the ratios are then relative to Embree.
//!
//! For each chunk of rays, all tracers run in turn. Before its timed run, each tracer traces the neighbouring chunk, so
//! that its own data is in the caches. Of several rounds, the smallest thread time counts. The reported ratio is the
//! median of the ratios of all chunks.

#[cfg(feature = "embree")]
mod embree;
mod meshes;
#[path = "../../src/random.rs"]
mod random;
mod rivals;

use std::time::Instant;

use gi_bvh::Bvh;
use gi_bvh::ray::Ray;
use meshes::{Rays, Scene};
use obvhs::{bvh2::Bvh2, cwbvh::CwBvh};
use rivals::Obvhs;

const CHUNK: usize = 16_384;
const ROUNDS: usize = 5;
const SETS: [&str; 3] = ["primary", "bounce", "shadow"];

type Closest<'a> = Box<dyn FnMut(&[Ray], &mut [Answer]) + 'a>;
type Occluded<'a> = Box<dyn FnMut(&[Ray], &mut [bool]) + 'a>;
type Answer = Option<(f32, u32)>;

struct Tracer<'a> {
    name: String,
    closest: Closest<'a>,
    occluded: Occluded<'a>,
}

macro_rules! tracer {
    ($name:expr, $tree:expr, $closest:expr) => {{
        let (tree, closest) = ($tree, $closest);
        Tracer {
            name: $name.to_string(),
            closest: Box::new(move |rays, out| {
                out.iter_mut().zip(rays).for_each(|(o, r)| *o = closest(tree, r))
            }),
            occluded: Box::new(move |rays, out| {
                out.iter_mut().zip(rays).for_each(|(o, r)| *o = tree.occluded(r))
            }),
        }
    }};
}

fn main() {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let filter = arguments.first().map_or("", String::as_str);
    let count = arguments.get(1).map_or(1 << 17, |n| n.parse().expect("the number of rays"));
    let libraries = libraries();
    let mut table = Vec::new();
    for scene in meshes::scenes(filter) {
        println!("{}: {} triangles", scene.name, scene.mesh.faces.len());
        build_times(&scene, &libraries);
        let rows = run(&scene, count, &libraries);
        table.push(rows);
    }
    summary(&table);
}

#[cfg(feature = "embree")]
type Libraries = Vec<embree::Library>;
#[cfg(not(feature = "embree"))]
struct Libraries;

#[cfg(feature = "embree")]
fn libraries() -> Libraries {
    let paths = std::env::var("EMBREE_LIB")
        .expect("EMBREE_LIB is the path of the library, or several paths separated by colons");
    paths
        .split(':')
        .map(|p| embree::Library::open(p).unwrap_or_else(|e| panic!("{p}: {e}")))
        .collect()
}

#[cfg(not(feature = "embree"))]
fn libraries() -> Libraries {
    Libraries
}

/// CPU time of this thread, seconds.
#[cfg(unix)]
fn thread_seconds() -> f64 {
    let mut t = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the pointer is to a timespec.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut t) };
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}

#[cfg(not(unix))]
fn thread_seconds() -> f64 {
    use std::sync::LazyLock;
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

/// Build times with one and two threads, each the smallest of a few.
fn build_times(scene: &Scene, libraries: &Libraries) {
    let triangles = scene.mesh.triangles();
    let least = |f: &mut dyn FnMut() -> f64| (0..4).map(|_| f()).fold(f64::INFINITY, f64::min);
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let mut own = || {
            let start = Instant::now();
            let bvh = pool.install(|| Bvh::build(&triangles, &[]).expect("sound meshes"));
            let seconds = start.elapsed().as_secs_f64();
            drop(bvh);
            seconds
        };
        let own = least(&mut own);
        println!(
            "  build, {threads} thread(s): gilab {:7.1} ms{}",
            1e3 * own,
            embree_builds(scene, libraries, threads, own)
        );
    }
}

#[cfg(feature = "embree")]
fn embree_builds(scene: &Scene, libraries: &Libraries, threads: usize, own: f64) -> String {
    use std::fmt::Write;
    let mut text = String::new();
    for library in libraries {
        let builds = || embree::Embree::new(library, &scene.mesh, false, threads);
        let (version, seconds) = (0..4)
            .map(|_| builds())
            .fold((0, f64::INFINITY), |(_, s), e| (e.version(), s.min(e.build_seconds)));
        write!(text, ", Embree {version} {:7.1} ms, {:.2} times", 1e3 * seconds, own / seconds)
            .expect("a string");
    }
    text
}

#[cfg(not(feature = "embree"))]
fn embree_builds(_: &Scene, _: &Libraries, _: usize, _: f64) -> String {
    String::new()
}

/// A tracer's name and its speed relative to the first.
struct Row {
    name: String,
    ratio: [f64; 3],
}

fn run(scene: &Scene, count: usize, libraries: &Libraries) -> Vec<Row> {
    let bvh = Bvh::build(&scene.mesh.triangles(), &[]).expect("sound meshes");
    println!(
        "  gilab: {} nodes, depth {}, {:.1} MiB",
        bvh.node_count(),
        bvh.depth(),
        bvh.memory_bytes() as f64 / 1048576.0
    );
    let rays = meshes::rays(scene, &bvh, count);
    let cw = Obvhs::<CwBvh>::new(&scene.mesh);
    let b2 = Obvhs::<Bvh2>::new(&scene.mesh);
    #[cfg(feature = "embree")]
    let embrees: Vec<(String, embree::Embree)> = (libraries.iter())
        .flat_map(|l| [(l, false), (l, true)])
        .map(|(l, robust)| {
            (if robust { " robust" } else { "" }, embree::Embree::new(l, &scene.mesh, robust, 1))
        })
        .map(|(mode, e)| (format!("Embree {}{mode}", e.version()), e))
        .collect();
    let mut tracers = Vec::new();
    #[cfg(feature = "embree")]
    for (name, e) in &embrees {
        tracers.push(tracer!(name, e, |e: &embree::Embree, r: &Ray| e.closest(r)));
    }
    let _ = libraries;
    tracers.push(tracer!("gilab", &bvh, |b: &Bvh, r: &Ray| b.closest(r).map(|h| (h.t, h.prim))));
    tracers.push(tracer!("obvhs CwBvh", &cw, |b: &Obvhs<CwBvh>, r: &Ray| b.closest(r)));
    tracers.push(tracer!("obvhs Bvh2", &b2, |b: &Obvhs<Bvh2>, r: &Ray| b.closest(r)));
    let differences = compare(&mut tracers, &rays);
    let best = time(&mut tracers, &rays);
    report(&tracers, &best, &differences)
}

/// For each tracer, the number of answers that differ from the first tracer's.
fn compare(tracers: &mut [Tracer], rays: &Rays) -> Vec<usize> {
    let mut reference: Option<(Vec<Answer>, Vec<bool>)> = None;
    let differ = |a: &Answer, b: &Answer| match (a, b) {
        (Some(a), Some(b)) => (a.0 - b.0).abs() > 1e-4 * a.0.max(1e-3),
        (a, b) => a.is_some() != b.is_some(),
    };
    let mut count = Vec::new();
    for tracer in tracers {
        let mut hits = vec![None; rays.bounce.len()];
        let mut blocked = vec![false; rays.shadow.len()];
        (tracer.closest)(&rays.bounce, &mut hits);
        (tracer.occluded)(&rays.shadow, &mut blocked);
        let (h, b) = reference.get_or_insert_with(|| (hits.clone(), blocked.clone()));
        let wrong_hits = h.iter().zip(&hits).filter(|(a, b)| differ(a, b)).count();
        count.push(wrong_hits + b.iter().zip(&blocked).filter(|(a, b)| a != b).count());
    }
    count
}

/// Smallest time in seconds for each chunk, tracer and set of rays.
fn time(tracers: &mut [Tracer], rays: &Rays) -> Vec<Vec<[f64; 3]>> {
    let chunk = CHUNK.min(rays.primary.len());
    let chunks = rays.primary.len() / chunk;
    let mut hits = vec![None; chunk];
    let mut blocked = vec![false; chunk];
    let mut best = vec![vec![[f64::INFINITY; 3]; tracers.len()]; chunks];
    for _ in 0..ROUNDS {
        for (k, best) in best.iter_mut().enumerate() {
            for set in 0..SETS.len() {
                for (tracer, best) in tracers.iter_mut().zip(best.iter_mut()) {
                    let mut go = |k: usize| {
                        let part = k * chunk..(k + 1) * chunk;
                        match set {
                            0 => (tracer.closest)(&rays.primary[part], &mut hits),
                            1 => (tracer.closest)(&rays.bounce[part], &mut hits),
                            _ => (tracer.occluded)(&rays.shadow[part], &mut blocked),
                        }
                    };
                    go((k + 1) % chunks);
                    let start = thread_seconds();
                    go(k);
                    best[set] = best[set].min(thread_seconds() - start);
                }
            }
        }
    }
    best
}

fn report(tracers: &[Tracer], best: &[Vec<[f64; 3]>], differences: &[usize]) -> Vec<Row> {
    println!(
        "  {:24} million rays/s: {:>8} {:>8} {:>8}   relative: {:>7} {:>7} {:>7}   different answers",
        "", SETS[0], SETS[1], SETS[2], SETS[0], SETS[1], SETS[2]
    );
    let rays = CHUNK.min(CHUNK * best.len()) as f64;
    let mut rows = Vec::new();
    for (i, tracer) in tracers.iter().enumerate() {
        let rate = |set: usize| {
            rays * best.len() as f64 / best.iter().map(|c| c[i][set]).sum::<f64>() / 1e6
        };
        let ratio: [f64; 3] = std::array::from_fn(|set| {
            let mut ratios: Vec<f64> = best.iter().map(|c| c[0][set] / c[i][set]).collect();
            ratios.sort_by(f64::total_cmp);
            ratios[ratios.len() / 2]
        });
        println!(
            "  {:24} {:15} {:8.2} {:8.2} {:8.2}   {:9} {:7.2} {:7.2} {:7.2}   {}",
            tracer.name,
            "",
            rate(0),
            rate(1),
            rate(2),
            "",
            ratio[0],
            ratio[1],
            ratio[2],
            differences[i]
        );
        rows.push(Row { name: tracer.name.clone(), ratio });
    }
    rows
}

/// Geometric means over the meshes.
fn summary(table: &[Vec<Row>]) {
    let Some(first) = table.first() else { return println!("no such mesh") };
    println!("geometric mean over {} meshes, relative to {}", table.len(), first[0].name);
    for (i, row) in first.iter().enumerate() {
        let mean = |set: usize| {
            let sum: f64 = table.iter().map(|rows| rows[i].ratio[set].ln()).sum();
            (sum / table.len() as f64).exp()
        };
        println!("  {:24} {:7.2} {:7.2} {:7.2}", row.name, mean(0), mean(1), mean(2));
    }
}
