//! Traces paths until there are enough hits.

use gi_core::progress;
use gi_core::walk::{ProjectionMap, Start, Trial};
use rayon::prelude::*;

/// Paths that one task walks; photons are joined in the order of the paths.
pub(super) const CHUNK: u64 = 4096;
/// Number of chunks per round. The number of photons is checked after each round. It is fixed, so that results do not depend on
/// the number of threads.
pub(super) const ROUND: u64 = 16;
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
    /// Training data for the projection map: start and success of each path. Empty for other maps.
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

/// Path budget for `count` hits, after `emitted` paths have given `hits` hits. It shrinks continuously as the yield falls.
fn worth(count: usize, hits: usize, emitted: u64) -> u64 {
    let paths = |a_hit: u64| (count as u64).saturating_mul(a_hit).max(CHUNK * ROUND);
    let most = paths(MOST_PATHS);
    let share = most as f64 * hits as f64 / (emitted.max(1) as f64 * count as f64);
    ((most as f64 * share.min(1.0)) as u64).max(paths(FEWEST_PATHS))
}

/// Trace chunks of paths until there are `count` hits or the budget is spent. The path that reaches the number is the last.
/// `walk` traces the chunk with the given number. After each of the first rounds, the projection map learns from the paths.
pub(crate) fn collect<T: Send>(
    count: usize,
    walk: impl Fn(&ProjectionMap, u64) -> Chunk<T> + Sync,
) -> Hits<T> {
    let (mut chunks, mut hits, mut emitted, mut gave_up) = (Vec::new(), 0, 0u64, false);
    let mut starts = ProjectionMap::default();
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
            .map(|chunk| walk(&starts, first + chunk as u64))
            .collect();
        if emitted < LEARNED {
            starts.learn(round.iter_mut().flat_map(|chunk| std::mem::take(&mut chunk.trials)));
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

/// The paths of chunk number `chunk`.
pub(crate) fn paths(chunk: u64) -> std::ops::Range<u64> {
    chunk * CHUNK..(chunk + 1) * CHUNK
}
