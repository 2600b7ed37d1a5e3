//! Photon tracing in media.

use gi_core::math::Rgb;
use gi_core::medium::MediumId;
use gi_core::rng::{bits_to_unit, hash_words};
use gi_core::walk::{LightEvent, MediumVertex};

use super::hierarchy::VolumePhoton;
use crate::photon::{Photon, PhotonKind, Rgbe};
use crate::shoot::{Chunk, Hits, Source, Step, Wanted, collect, dither, paths};

/// Maximum mean number of photons per path that scatters in media. A path in marble scatters hundreds of times: if all scatterings
/// were stored, the map would come from few paths and share their noise.
const KEPT_OF_PATH: f32 = 4.0;

/// What was shot.
pub(crate) struct VolumeShot {
    /// For each map its photons, in the order of their paths. Powers are already divided by `emitted`.
    pub(crate) photons: Vec<Vec<VolumePhoton>>,
    /// Paths begun.
    pub(crate) emitted: u64,
    /// Share of scatterings that was stored.
    pub(crate) kept: f32,
    /// Whether emission was given up before there were as many photons as wanted.
    pub(crate) gave_up: bool,
}

/// A scattering before it is packed: its power is not yet divided by the number of paths.
#[derive(Clone, Copy)]
struct Scattering {
    vertex: MediumVertex,
    kind: PhotonKind,
}

/// Trace until there are `count` photons: scatterings of all light but direct light. `map_of` gives the map of each medium, and
/// `is_wanted` whether its photons are stored.
pub(super) fn shoot(
    source: &Source,
    count: usize,
    map_of: &[usize],
    is_wanted: &(impl Fn(MediumId) -> bool + Sync),
) -> VolumeShot {
    let kept = if count > 0 { share_to_keep(source, is_wanted) } else { 1.0 };
    let Hits { chunks, emitted, gave_up } =
        collect(count, |_, k| chunk(source, k, kept, is_wanted));
    let share = (1.0 / (emitted.max(1) as f64 * f64::from(kept))) as f32;
    let mut photons = vec![Vec::new(); map_of.len()];
    for (k, Scattering { vertex, kind }) in chunks.into_iter().flatten().enumerate() {
        let power = Rgbe::dithered(vertex.power * share, dither(source.seed ^ 0x766f_6c75, k));
        // The normal says nothing here.
        let photon = Photon::new(vertex.p, power, vertex.wo, vertex.wo, kind);
        let depth = (vertex.depth + 1).min(255) as u8;
        photons[map_of[vertex.medium.index()]].push(VolumePhoton { photon, depth });
    }
    VolumeShot { photons, emitted, kept, gave_up }
}

/// Fraction of the scatterings to store, from the first chunk of paths.
fn share_to_keep(source: &Source, is_wanted: &impl Fn(MediumId) -> bool) -> f32 {
    let Chunk { hits, ends, .. } = chunk(source, 0, 1.0, is_wanted);
    let starts = std::iter::once(&0).chain(&ends);
    let scattered = ends.iter().zip(starts).filter(|(end, start)| end > start).count();
    (KEPT_OF_PATH * scattered as f32 / hits.len().max(1) as f32).min(1.0)
}

/// Scatterings of a chunk of paths, of which the fraction `keep` is stored.
fn chunk(
    source: &Source,
    chunk: u64,
    keep: f32,
    is_wanted: &impl Fn(MediumId) -> bool,
) -> Chunk<Scattering> {
    let mut out = Chunk::new();
    for path in paths(chunk) {
        source.walk(Wanted::Volume, path, &mut |Step { event, .. }| {
            let LightEvent::Medium(vertex) = event else { return };
            let kind = event.kind();
            let words = [source.seed ^ 0x6b65_6570, path as u32, (path >> 32) as u32, vertex.depth];
            let is_light = vertex.power != Rgb::BLACK && vertex.power.is_finite();
            let is_light = is_light && is_wanted(vertex.medium);
            if kind != PhotonKind::Direct && is_light && bits_to_unit(hash_words(&words)) < keep {
                out.hits.push(Scattering { vertex: *vertex, kind });
            }
        });
        out.end_path(None);
    }
    out
}
