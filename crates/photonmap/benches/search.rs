//! Building and searching photon maps: the fast layout against the lecture's, and with the feature `rivals` against
//! kiddo, interleaved in one run.
//!
//! `cargo bench -p photonmap --bench search --features rivals -- [PHOTONS] [QUERIES]` (10000000 and 40000). `DUMP=FILE` writes the
//! photons' positions, then the queries', as 32-bit floats, for measuring other libraries on the same points.
//! Rates are of one thread; each is the least time of all repetitions of its chunk of queries.

use std::time::Instant;

use gi_core::math::Rgb;
use gi_core::rng::Pcg;
use gi_core::warp;
use glam::Vec3;
use photonmap::map::{Layout, Order, PhotonMap};
use photonmap::photon::{Payload, Photon, PhotonKind, Rgbe};
use photonmap::shoot::Stored;

const K: usize = 50;
const REPETITIONS: usize = 4;
const CHUNK: usize = 5000;

/// A point of a room with a bumpy ball in it, as photons would lie: 62 % on the walls, 2 % in a caustic, the rest on
/// the ball.
fn point(rng: &mut Pcg, with_caustic: bool) -> Vec3 {
    let u = rng.next_f32();
    if u < 0.62 || (u < 0.64 && !with_caustic) {
        let mut p = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * 2.0 - 1.0;
        let face = rng.next_below(6) as usize;
        p[face / 2] = if face.is_multiple_of(2) { -1.0 } else { 1.0 };
        return p;
    }
    if u < 0.64 {
        let q = warp::disk(rng.next_2d());
        return Vec3::new(0.5 + 0.2 * q.x, -1.0, 0.5 + 0.2 * q.y);
    }
    let d = warp::sphere(rng.next_2d());
    let bumps = (9.0 * d.x).sin() * (11.0 * d.y).sin() * (10.0 * d.z).sin();
    d * (0.6 + 0.1 * bumps)
}

fn photon(p: Vec3) -> Stored {
    let power = Rgbe::nearest(Rgb::new(p.x.abs(), p.y.abs(), p.z.abs()));
    Stored { photon: Photon::new(p, power, Vec3::Y, Vec3::Y, PhotonKind::Indirect), depth: 1 }
}

fn timed<T>(name: &str, work: impl FnOnce() -> T) -> T {
    let clock = Instant::now();
    let out = work();
    println!("build {name:<28} {:6.2} s", clock.elapsed().as_secs_f64());
    out
}

/// A name, and a search: how many it found, and what they bring.
type Search<'a> = (&'a str, Box<dyn Fn(Vec3) -> (usize, f64) + 'a>);

/// Let all searches answer all queries; print rates, and ratios to the first.
fn race(title: &str, searches: &[Search], queries: &[Vec3]) {
    let chunks: Vec<&[Vec3]> = queries.chunks(CHUNK).collect();
    let mut best = vec![vec![f64::INFINITY; searches.len()]; chunks.len()];
    let mut sums = vec![(0usize, 0f64); searches.len()];
    for repetition in 0..REPETITIONS {
        for (c, chunk) in chunks.iter().enumerate() {
            for (s, (_, search)) in searches.iter().enumerate() {
                // Warm up on the neighbour, so that no one profits from what the one before has read.
                let neighbour = chunks[(c + 1) % chunks.len()];
                for &q in &neighbour[..neighbour.len() / 2] {
                    std::hint::black_box(search(q));
                }
                let clock = Instant::now();
                let sum = chunk.iter().fold((0, 0.0), |sum, &q| {
                    let found = search(q);
                    (sum.0 + found.0, sum.1 + found.1)
                });
                best[c][s] = best[c][s].min(clock.elapsed().as_secs_f64());
                if repetition == 0 {
                    sums[s] = (sums[s].0 + sum.0, sums[s].1 + sum.1);
                }
            }
        }
    }
    println!("\n{title}: {} queries, k = {K}", queries.len());
    for (s, (name, _)) in searches.iter().enumerate() {
        let time = |s: usize| best.iter().map(|b| b[s]).sum::<f64>();
        let n = queries.len() as f64;
        println!(
            "  {name:<28} {:8.1} kq/s   ratio {:5.2}   found {:.3}, power {:.6}",
            n / time(s) * 1e-3,
            time(0) / time(s),
            sums[s].0 as f64 / n,
            sums[s].1 / n
        );
    }
}

/// A photon map's search, with or without a question that every photon is asked.
fn ours(map: &PhotonMap, radius_sq: f32, asks: bool) -> Box<dyn Fn(Vec3) -> (usize, f64) + '_> {
    Box::new(move |q| {
        let mut power = 0.0;
        let found = map.nearest(
            q,
            K,
            radius_sq,
            |p, depth| !asks || (depth < 200 && p.normal().y > 0.5),
            |photon, _, _| power += f64::from(photon.power.to_rgb().r),
        );
        (found.count, power)
    })
}

#[cfg(feature = "rivals")]
fn kiddo_search<'a>(
    points: &[Vec3],
    payloads: &'a [Payload],
    radius_sq: f32,
) -> Box<dyn Fn(Vec3) -> (usize, f64) + 'a> {
    use kiddo::{ImmutableKdTree, SquaredEuclidean};
    let coordinates: Vec<[f32; 3]> = points.iter().map(|p| p.to_array()).collect();
    let tree: ImmutableKdTree<f32, 3> =
        timed("kiddo", || ImmutableKdTree::new_from_slice(&coordinates).expect("a tree"));
    let k = std::num::NonZeroUsize::new(K).expect("not zero");
    Box::new(move |q| {
        let q = q.to_array();
        let query = tree.query(&q).nearest_n::<SquaredEuclidean<f32>>(k);
        let found = query.within(radius_sq).unsorted().execute();
        let power = found.iter().map(|e| f64::from(payloads[e.item as usize].power.to_rgb().r));
        (found.len(), power.sum())
    })
}

fn main() {
    let mut numbers = std::env::args().skip(1).filter_map(|a| a.parse::<usize>().ok());
    let (n, queries) = (numbers.next().unwrap_or(10_000_000), numbers.next().unwrap_or(40_000));
    let mut rng = Pcg::new(5, 0);
    let points: Vec<Vec3> = (0..n).map(|_| point(&mut rng, true)).collect();
    let mut asked: Vec<Vec3> = (0..queries).map(|_| point(&mut rng, false)).collect();
    if let Some(path) = std::env::var_os("DUMP") {
        let all = points.iter().chain(&asked).flat_map(|p| p.to_array());
        let bytes: Vec<u8> = all.flat_map(f32::to_le_bytes).collect();
        std::fs::write(path, bytes).expect("the dump is written");
    }
    // Twice the radius that holds k where photons lie evenly.
    let radius_sq = (0.05 * (1e6 / n as f32).sqrt()).powi(2);
    let threads = rayon::current_num_threads();
    println!("{n} photons, largest radius {}; {threads} threads for building", radius_sq.sqrt());

    let stored: Vec<Stored> = points.iter().map(|&p| photon(p)).collect();
    let (for_jensen, for_fast) = (stored.clone(), stored.clone());
    let jensen =
        timed("jensen", || PhotonMap::build(for_jensen, 1, Layout::Jensen, Order::Any, false));
    let fast = timed("fast", || PhotonMap::build(for_fast, 1, Layout::Fast, Order::Any, false));
    // Others return numbers; what the photons bring is read in the order that they were given.
    let payloads: Vec<Payload> = stored.iter().map(|s| s.photon.payload).collect();
    drop(stored);
    for (name, map) in [("jensen", &jensen), ("fast", &fast)] {
        println!("bytes a photon, {name}: {:.2}", map.bytes() as f64 / n as f64);
    }

    #[cfg_attr(not(feature = "rivals"), expect(unused_mut))]
    let mut searches: Vec<Search> = vec![
        ("jensen", ours(&jensen, radius_sq, false)),
        ("fast", ours(&fast, radius_sq, false)),
        ("fast, asking for the side", ours(&fast, radius_sq, true)),
    ];
    #[cfg(feature = "rivals")]
    searches.push(("kiddo", kiddo_search(&points, &payloads, radius_sq)));
    std::hint::black_box(&payloads);
    race("random order", &searches, &asked);
    let cell = |x: f32| ((x + 1.0) * 511.0) as u64;
    let spread = |v: u64| (0..10).fold(0u64, |m, b| m | (v >> b & 1) << (3 * b));
    asked.sort_by_key(|p| spread(cell(p.x)) | spread(cell(p.y)) << 1 | spread(cell(p.z)) << 2);
    race("neighbours in turn, as a renderer asks", &searches, &asked);
}
