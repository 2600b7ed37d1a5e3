//! Photon tracing: from the lights to the maps [slide 22].

use gi_core::bsdf::Bsdf;
use gi_core::light::Targets;
use gi_core::progress;
use gi_core::rng::{bits_to_unit, hash_words};
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use gi_core::walk::{self, LightEvent, LightWalk, ProjectionMap, Roulette, Start, Trial};
use glam::Vec3;
use rayon::prelude::*;

use crate::photon::{Photon, Rgbe};

/// A photon and the number of segments of its path, 255 standing for more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stored {
    /// The photon.
    pub photon: Photon,
    /// Segments from the light to here; 1 is light that came straight.
    pub depth: u8,
}

/// Which photons are wanted.
#[derive(Clone, Copy)]
pub enum Wanted<'a> {
    /// Every hit of a surface that is not delta lobes only [slide 26, left].
    Global,
    /// The same, with light from infinity aimed at points that matter; no path is left out.
    Aimed(&'a Targets),
    /// L S+ D: paths aimed at what has delta lobes or nearly such (see `is_near_specular`), stored where they first
    /// meet a diffuse part [slide 26, right]. They learn where to start; see [`ProjectionMap`].
    Caustic(&'a Targets),
    /// Scattering in media, see [`crate::volume`].
    Volume,
}

/// Where photons come from.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// The world.
    pub scene: &'a Scene,
    /// Seed of every random number.
    pub seed: u32,
    /// Most segments of a path from its light; `None` is unbounded.
    pub max_segments: Option<u32>,
    /// Whether media absorb and scatter photons on their way.
    pub media: bool,
}

/// The photons that were traced.
pub struct Shot {
    /// Photons in the order of their paths. Powers are already divided by `emitted`.
    pub photons: Vec<Stored>,
    /// Number of paths.
    pub emitted: u64,
    /// Whether tracing stopped before there were enough photons.
    pub gave_up: bool,
}

/// Stream of the random numbers of the caustic map.
const CAUSTIC: u32 = 0x6361_7573;
/// Paths that one task walks; photons are joined in the order of the paths.
const CHUNK: u64 = 4096;
/// Number of chunks per round. The number of photons is checked after each round. It is fixed, so that results do not depend on
/// the number of threads.
const ROUND: u64 = 16;
/// Number of paths from which the projection map learns. Learning takes one thread; after that, the map is fixed.
const LEARNED: u64 = 1 << 20;
/// Minimum and maximum number of paths per wanted photon.
const FEWEST_PATHS: u64 = 8;
const MOST_PATHS: u64 = 256;

/// What a chunk of paths has found.
pub(crate) struct Chunk<T> {
    pub(crate) hits: Vec<T>,
    /// Number of hits up to the end of each path.
    pub(crate) ends: Vec<u32>,
    /// Where the paths started, and whether they have hit anything, if they learn from it.
    pub(crate) trials: Vec<Trial>,
}

impl<T> Chunk<T> {
    pub(crate) fn new() -> Self {
        let ends = Vec::with_capacity(CHUNK as usize);
        Chunk { hits: Vec::new(), ends, trials: Vec::new() }
    }

    /// End a path that began at `start`.
    pub(crate) fn end_path(&mut self, start: Option<Start>) {
        let before = self.ends.last().copied().unwrap_or(0);
        let hits = self.hits.len() as u32;
        self.ends.push(hits);
        self.trials.extend(start.map(|start| start.result(hits > before)));
    }
}

/// Hits in the order of their paths, one list per chunk.
pub(crate) struct Hits<T> {
    pub(crate) chunks: Vec<Vec<T>>,
    /// Number of paths.
    pub(crate) emitted: u64,
    /// Whether tracing stopped before there were enough hits.
    pub(crate) gave_up: bool,
}

/// A vertex of a light path.
pub(crate) struct Step<'s, 'a> {
    /// Where the path began.
    pub(crate) start: Vec3,
    /// The vertex.
    pub(crate) event: &'s LightEvent<'a>,
    /// Number of scatterings by nearly specular surfaces before.
    pub(crate) focused: u32,
    /// The path after it was scattered; `None` where it ends.
    pub(crate) after: Option<&'s LightWalk<'a>>,
}

/// For the caustic map, lobes with a smaller alpha count as mirrors: a path from the eye hits a lamp through them only by luck, but
/// photons find their caustics.
pub(crate) const NEAR_SPECULAR: f32 = 0.1;

/// Whether a surface has only lobes that are nearly specular. The result is the same from both ends of a path.
pub(crate) fn is_near_specular(bsdf: &Bsdf, wo: Vec3) -> bool {
    bsdf.roughness() < NEAR_SPECULAR && !has_diffuse_part(bsdf, wo)
}

/// Whether either side has a diffuse part.
fn has_diffuse_part(bsdf: &Bsdf, wo: Vec3) -> bool {
    bsdf.diffuse_part(wo).or_else(|| bsdf.diffuse_part(-wo)).is_some()
}

/// Path budget for `count` hits, after `emitted` paths have given `hits` hits. It shrinks continuously as the yield falls.
fn worth(count: usize, hits: usize, emitted: u64) -> u64 {
    let paths = |a_hit: u64| (count as u64).saturating_mul(a_hit).max(CHUNK * ROUND);
    let most = paths(MOST_PATHS);
    let share = most as f64 * hits as f64 / (emitted.max(1) as f64 * count as f64);
    ((most as f64 * share.min(1.0)) as u64).max(paths(FEWEST_PATHS))
}

/// Trace chunks of paths until there are `count` hits or the budget is spent. The path that reaches the number is the last.
/// `walk` traces the chunk with the given number. Paths that start where the map says improve it from round to round.
pub(crate) fn collect<T: Send>(
    count: usize,
    walk: impl Fn(&ProjectionMap, u64) -> Chunk<T> + Sync,
) -> Hits<T> {
    let (mut chunks, mut hits, mut emitted, mut gave_up) = (Vec::new(), 0, 0u64, false);
    let mut map = ProjectionMap::default();
    progress::begin("photons stored", count as u64);
    while hits < count {
        if emitted >= worth(count, hits, emitted) {
            gave_up = true;
            break;
        }
        let first = emitted / CHUNK;
        let mut round: Vec<Chunk<T>> = (0..ROUND as usize)
            .into_par_iter()
            .with_max_len(1)
            .map(|chunk| walk(&map, first + chunk as u64))
            .collect();
        if emitted < LEARNED {
            let trials = round.iter_mut().flat_map(|chunk| std::mem::take(&mut chunk.trials));
            map.learn(trials.collect());
        }
        for mut chunk in round {
            if hits >= count {
                break;
            }
            // Cut after the path that reaches the number.
            let enough = chunk.ends.iter().position(|&end| hits + end as usize >= count);
            let paths = enough.map_or(chunk.ends.len(), |k| k + 1);
            chunk.hits.truncate(chunk.ends[paths - 1] as usize);
            hits += chunk.hits.len();
            progress::advance(chunk.hits.len() as u64);
            emitted += paths as u64;
            chunks.push(chunk.hits);
        }
    }
    Hits { chunks, emitted, gave_up }
}

/// Random numbers that dither the power of hit `index`.
pub(crate) fn dither(seed: u32, index: usize) -> [f32; 3] {
    [0, 1, 2].map(|channel| bits_to_unit(hash_words(&[seed, index as u32, channel])))
}

/// The paths of chunk number `chunk`.
pub(crate) fn paths(chunk: u64) -> std::ops::Range<u64> {
    chunk * CHUNK..(chunk + 1) * CHUNK
}

impl Source<'_> {
    /// Trace until there are `count` photons. The path that reaches the number is the last.
    pub fn shoot(&self, wanted: Wanted, count: usize) -> Shot {
        let Hits { chunks, emitted, gave_up } =
            collect(count, |map, chunk| self.chunk(wanted, map, chunk));
        Shot { photons: self.pack(chunks, emitted), emitted, gave_up }
    }

    /// Divide powers by the number of paths and pack the photons.
    fn pack(&self, chunks: Vec<Vec<walk::Photon>>, emitted: u64) -> Vec<Stored> {
        let share = (1.0 / emitted.max(1) as f64) as f32;
        let mut firsts = Vec::with_capacity(chunks.len());
        let total = chunks.iter().fold(0, |first, chunk| {
            firsts.push(first);
            first + chunk.len()
        });
        let packed: Vec<Vec<Stored>> = chunks
            .into_par_iter()
            .zip(firsts)
            .map(|(hits, first)| {
                let pack = |(k, hit): (usize, &walk::Photon)| {
                    let power = Rgbe::dithered(hit.power * share, dither(self.seed, first + k));
                    let photon = Photon::new(hit.p, power, hit.wi, hit.n, hit.kind);
                    Stored { photon, depth: hit.segments.min(255) as u8 }
                };
                hits.iter().enumerate().map(pack).collect()
            })
            .collect();
        let mut photons = Vec::with_capacity(total);
        packed.into_iter().for_each(|chunk| photons.extend(chunk));
        photons
    }

    fn chunk(&self, wanted: Wanted, map: &ProjectionMap, chunk: u64) -> Chunk<walk::Photon> {
        let mut out = Chunk::new();
        for path in paths(chunk) {
            let (start, walk) = self.begin(wanted, path, Some(map));
            let mut visit = |Step { event, focused, .. }: Step| {
                let LightEvent::Surface(vertex) = event else { return };
                let asked_for = match wanted {
                    Wanted::Caustic(_) => {
                        event.depth() > 0
                            && event.non_delta() == focused
                            && has_diffuse_part(&vertex.bsdf, vertex.wo)
                    }
                    _ => true,
                };
                if asked_for && !vertex.bsdf.is_delta() {
                    // The number of paths is known only at the end: `pack` divides by it.
                    let hit = walk::Photon::at(vertex, 1.0);
                    if hit.power.is_finite() && !hit.power.is_black() {
                        out.hits.push(hit);
                    }
                }
            };
            if let Some(walk) = walk {
                self.follow(wanted, walk, &mut visit);
            }
            out.end_path(start);
        }
        out
    }

    /// Trace path number `path` and call `visit` at every vertex.
    pub(crate) fn walk(&self, wanted: Wanted, path: u64, visit: &mut impl FnMut(Step)) {
        if let (_, Some(walk)) = self.begin(wanted, path, None) {
            self.follow(wanted, walk, visit);
        }
    }

    /// Begin path number `path`; `map` says where paths of the caustic map start. Also returns its choice.
    fn begin(
        &self,
        wanted: Wanted,
        path: u64,
        map: Option<&ProjectionMap>,
    ) -> (Option<Start>, Option<LightWalk<'_>>) {
        // Each map has its own stream. Within a stream, paths are the points of a sequence.
        let sampler =
            |stream: u32| Sampler::new(self.seed ^ stream, (path >> 32) as u32, path as u32);
        let (scene, toward) = (self.scene, LightWalk::begin_toward);
        match (wanted, map) {
            (Wanted::Global, _) => (None, LightWalk::begin(scene, sampler(0x676c_6f62))),
            (Wanted::Volume, _) => (None, LightWalk::begin(scene, sampler(0x766f_6c75))),
            (Wanted::Aimed(targets), _) => (None, toward(scene, sampler(0x676c_6f62), targets)),
            (Wanted::Caustic(targets), None) => (None, toward(scene, sampler(CAUSTIC), targets)),
            (Wanted::Caustic(targets), Some(map)) => {
                let (start, walk) =
                    LightWalk::begin_projected(scene, sampler(CAUSTIC), targets, map);
                (Some(start), walk)
            }
        }
    }

    /// Follow a path to its end.
    fn follow(&self, wanted: Wanted, mut walk: LightWalk, visit: &mut impl FnMut(Step)) {
        if self.media {
            walk.use_media();
        }
        let (start, mut focused) = (walk.emission().p, 0);
        while let Some(event) = &walk.next_event() {
            if self.max_segments.is_some_and(|most| event.depth() >= most) {
                return;
            }
            // Roulette from the first scattering on keeps powers nearly equal [Jensen01, 5.1].
            let roulette = Roulette::ByAlbedo { from: 1 };
            let goes_on = match event {
                LightEvent::Surface(vertex) => match wanted {
                    Wanted::Aimed(targets) => walk.scatter_toward(vertex, roulette, targets),
                    _ => walk.scatter(vertex, roulette),
                },
                LightEvent::Medium(vertex) => walk.scatter_within(vertex, roulette),
            };
            visit(Step { start, event, focused, after: goes_on.then_some(&walk) });
            if let LightEvent::Surface(vertex) = event
                && is_near_specular(&vertex.bsdf, vertex.wo)
            {
                focused += walk.non_delta() - event.non_delta();
            }
            if !goes_on || (matches!(wanted, Wanted::Caustic(_)) && walk.non_delta() > focused) {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests;
