//! Photon tracing: from the lights to the maps [slide 22].

use gi_core::bsdf::Bsdf;
use gi_core::light::Targets;
use gi_core::rng::{bits_to_unit, hash_words};
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use gi_core::walk::{self, LightEvent, LightWalk, ProjectionMap, Roulette, Start};
use glam::Vec3;
use rayon::prelude::*;

use crate::photon::{Photon, Rgbe};
pub(crate) use collect::{Chunk, Hits, collect, paths};

mod collect;

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
    /// meet a diffuse part [slide 26, right]. The map says where they start.
    Caustic(&'a Targets, &'a ProjectionMap),
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

/// Random numbers that dither the power of hit `index`.
pub(crate) fn dither(seed: u32, index: usize) -> [f32; 3] {
    [0, 1, 2].map(|channel| bits_to_unit(hash_words(&[seed, index as u32, channel])))
}

impl Source<'_> {
    /// Trace until there are `count` photons. The path that reaches the number is the last.
    pub fn shoot(&self, wanted: Wanted, count: usize) -> Shot {
        self.shot(collect(count, |_, chunk| self.chunk(wanted, chunk)))
    }

    /// As [`Source::shoot`], for photons of caustics. A [`ProjectionMap`] learns where their paths must start.
    pub fn shoot_caustic(&self, targets: &Targets, count: usize) -> Shot {
        self.shot(collect(count, |starts, chunk| {
            self.chunk(Wanted::Caustic(targets, starts), chunk)
        }))
    }

    fn shot(&self, Hits { chunks, emitted, gave_up }: Hits<walk::Photon>) -> Shot {
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

    fn chunk(&self, wanted: Wanted, chunk: u64) -> Chunk<walk::Photon> {
        let mut out = Chunk::new();
        for path in paths(chunk) {
            let (start, walk) = self.begin(wanted, path);
            let mut visit = |Step { event, focused, .. }: Step| {
                let LightEvent::Surface(vertex) = event else { return };
                let asked_for = match wanted {
                    Wanted::Caustic(..) => {
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
        if let (_, Some(walk)) = self.begin(wanted, path) {
            self.follow(wanted, walk, visit);
        }
    }

    /// Begin path number `path`. Also returns where the projection map has started it, if there is one.
    fn begin(&self, wanted: Wanted, path: u64) -> (Option<Start>, Option<LightWalk<'_>>) {
        // Each map has its own stream. Within a stream, paths are the points of a sequence.
        let sampler =
            |stream: u32| Sampler::new(self.seed ^ stream, (path >> 32) as u32, path as u32);
        let walk = match wanted {
            Wanted::Global => LightWalk::begin(self.scene, sampler(0x676c_6f62)),
            Wanted::Volume => LightWalk::begin(self.scene, sampler(0x766f_6c75)),
            Wanted::Aimed(targets) => {
                LightWalk::begin_toward(self.scene, sampler(0x676c_6f62), targets)
            }
            Wanted::Caustic(targets, starts) => {
                let sampler = sampler(0x6361_7573);
                let (start, walk) =
                    LightWalk::begin_projected(self.scene, sampler, targets, starts);
                return (Some(start), walk);
            }
        };
        (None, walk)
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
            if !goes_on || (matches!(wanted, Wanted::Caustic(..)) && walk.non_delta() > focused) {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests;
