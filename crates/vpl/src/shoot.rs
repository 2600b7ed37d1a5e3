//! Light paths leave a virtual point light at each of their vertices [slide 49].

use gi_core::math::{INV_PI, Rgb};
use gi_core::progress;
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use gi_core::walk::{LightEvent, LightVertex, LightWalk, Roulette};
use glam::Vec3;
use rayon::prelude::*;

use crate::light::{Kind, LitSurface, MIN_ROUGHNESS, Vpl, Vpls};
use crate::options::Termination;

/// The settings of light paths.
#[derive(Clone, Copy, Debug)]
pub struct Shooting {
    /// Seed of all random numbers.
    pub seed: u32,
    /// Index of the first path in the sequence that all sets of lights share.
    pub first_path: u32,
    /// Number of paths.
    pub paths: u32,
    /// When they end.
    pub termination: Termination,
    /// Largest number of scatterings of a path; `None` sets no limit.
    pub max_scatterings: Option<u32>,
    /// Whether the points on light sources where paths start become virtual lights too.
    pub lights: bool,
    /// What a few pilot paths found out about the scene.
    pub pilot: Pilot,
    /// Whether media attenuate and scatter the paths. Only surfaces get lights.
    pub through_media: bool,
}

/// What a few pilot paths found out about the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pilot {
    /// Mean reflectance: the fraction of paths that continue at a vertex.
    pub reflectance: f32,
    /// Mean number of virtual point lights per path with Russian roulette, without the points on light sources.
    pub lights_per_path: f32,
}

/// Number of pilot paths.
const PILOT_PATHS: u32 = 2048;
/// Largest reflectance: paths must end even in a scene that absorbs nothing.
const MAX_REFLECTANCE: f32 = 0.95;
/// Number of paths per task; the lights of all tasks are joined in order.
const CHUNK: u32 = 256;
/// Separates the random numbers of light paths from those of eye paths.
const SALT: u32 = 0x7670_6c73;

impl Pilot {
    /// Walk a few paths with Russian roulette. Media scatter them if `through_media` is set.
    pub fn of(scene: &Scene, seed: u32, through_media: bool) -> Self {
        let (mut met, mut went_on, mut lights) = (0u32, 0u32, 0u32);
        for path in 0..PILOT_PATHS {
            let sampler = Sampler::new(seed ^ SALT ^ 0x0070_696c, 1, path);
            let Some(mut walk) = LightWalk::begin(scene, sampler) else { continue };
            if through_media {
                walk.use_media();
            }
            while let Some(event) = &walk.next_event() {
                met += 1;
                let goes_on = match event {
                    LightEvent::Surface(v) => {
                        lights += u32::from(!v.bsdf.is_delta());
                        walk.scatter(v, Roulette::ByAlbedo { from: 1 })
                    }
                    LightEvent::Medium(v) => walk.scatter_within(v, Roulette::ByAlbedo { from: 1 }),
                };
                if !goes_on {
                    break;
                }
                went_on += 1;
            }
        }
        Pilot {
            reflectance: (went_on as f32 / met.max(1) as f32).clamp(0.01, MAX_REFLECTANCE),
            lights_per_path: (lights as f32 / PILOT_PATHS as f32).max(0.01),
        }
    }

    /// Number of paths that leave about `vpls` lights. Fractional absorption leaves as many as roulette, on average.
    pub fn paths_for(&self, vpls: u32) -> u32 {
        ((vpls as f32 / self.lights_per_path).round() as u32).max(1)
    }
}

/// The lights of a chunk of paths.
#[derive(Default)]
struct Chunk {
    lights: Vec<Vpl>,
    surfaces: Vec<LitSurface>,
    arrived: Rgb,
    emitted: Rgb,
}

/// Walk light paths, and leave a light at every vertex whose surface scatters non-specularly. The lights do not depend
/// on the number of threads.
pub fn shoot(scene: &Scene, how: &Shooting) -> Vpls {
    progress::begin("light paths", u64::from(how.paths));
    let chunks: Vec<Chunk> = (0..how.paths.div_ceil(CHUNK))
        .into_par_iter()
        .with_max_len(1)
        .map(|c| {
            let mut chunk = Chunk::default();
            if progress::is_abandoned() {
                return chunk;
            }
            let end = ((c + 1) * CHUNK).min(how.paths);
            (c * CHUNK..end).for_each(|path| how.walk(scene, path, &mut chunk));
            progress::advance(u64::from(end - c * CHUNK));
            chunk
        })
        .collect();
    let mut all = Vpls { paths: how.paths.into(), ..Vpls::default() };
    for chunk in chunks {
        let first = all.surfaces.len() as u32;
        all.lights.extend(chunk.lights.into_iter().map(|v| match v.kind {
            Kind::Glossy(k) => Vpl { kind: Kind::Glossy(first + k), ..v },
            _ => v,
        }));
        all.surfaces.extend(chunk.surfaces);
        all.arrived += chunk.arrived;
        all.emitted += chunk.emitted;
    }
    // A stable sort: lights of equal depth keep the order of the paths.
    all.lights.sort_by_key(|v| v.depth);
    all
}

impl Shooting {
    fn walk(&self, scene: &Scene, path: u32, chunk: &mut Chunk) {
        // The paths of all sets are consecutive points of one sequence.
        let sampler = Sampler::new(self.seed ^ SALT, 0, self.first_path.wrapping_add(path));
        let Some(mut walk) = LightWalk::begin(scene, sampler) else { return };
        if self.through_media {
            walk.use_media();
        }
        let paths = self.paths as f32;
        chunk.emitted += walk.emission().power / paths;
        if self.lights {
            chunk.lights.push(Vpl::of_emission(scene, walk.emission(), paths));
        }
        let mut scatterings = 0;
        // The light at a vertex scatters there once: a path with j scatterings leaves a light of depth j + 1.
        while self.max_scatterings.is_none_or(|most| scatterings < most) {
            let Some(event) = &walk.next_event() else { return };
            scatterings = event.depth() + 1;
            let roulette = self.roulette(path, scatterings);
            let goes_on = match event {
                LightEvent::Surface(vertex) => {
                    chunk.arrived += vertex.power / paths;
                    if !vertex.bsdf.is_delta() {
                        chunk.leave(scene, vertex, paths);
                    }
                    walk.scatter(vertex, roulette)
                }
                LightEvent::Medium(vertex) => walk.scatter_within(vertex, roulette),
            };
            if !goes_on {
                return;
            }
        }
    }

    /// How it is decided whether a path continues after `scatterings` scatterings.
    fn roulette(&self, path: u32, scatterings: u32) -> Roulette {
        match self.termination {
            Termination::Roulette => Roulette::ByAlbedo { from: 1 },
            Termination::Fractional => {
                // The paths with the smallest indices survive. Their number is whole, so the survival fraction is
                // exact.
                let left = |j: u32| {
                    let share = f64::from(self.pilot.reflectance).powi(j as i32);
                    (f64::from(self.paths) * share).ceil().max(1.0) as u32
                };
                let (before, after) = (left(scatterings - 1), left(scatterings));
                // The last path uses Russian roulette, or it would never end.
                if before == 1 {
                    return Roulette::ByAlbedo { from: 1 };
                }
                Roulette::Decided { survives: path < after, survival: after as f32 / before as f32 }
            }
        }
    }
}

impl Chunk {
    /// Leave a light at a vertex.
    fn leave(&mut self, scene: &Scene, vertex: &LightVertex, paths: f32) {
        let (surface, power) = (&vertex.surface, vertex.power / paths);
        let Some(bsdf) = vertex.bsdf.broad(vertex.wo, MIN_ROUGHNESS) else { return };
        let depth = vertex.depth + 1;
        let toward = |n: Vec3| n * 1f32.copysign(n.dot(vertex.wo));
        let n = toward(surface.ng);
        // A Lambertian surface emits by the cosine with its geometric normal even if a shading normal differs: the
        // correction by both normals leaves just that. Other surfaces evaluate their BSDF.
        let (kind, ns, power) = match bsdf.diffuse_only(vertex.wo) {
            Some(part) => {
                let bent = part.normal.dot(vertex.wo) / n.dot(vertex.wo).max(f32::MIN_POSITIVE);
                (Kind::Oriented, part.normal, power * part.albedo * (INV_PI * bent))
            }
            None => {
                self.surfaces.push(LitSurface { surface: *surface, wo: vertex.wo });
                (Kind::Glossy(self.surfaces.len() as u32 - 1), toward(surface.ns()), power)
            }
        };
        debug_assert!(power.is_finite(), "a virtual light of power {power:?}");
        // One light of infinite power would make every estimate and every light tree infinite.
        if !power.is_black() && power.is_finite() {
            let on = scene.flat_at(surface);
            self.lights.push(Vpl { p: surface.p, n, ns, power, kind, depth, on });
        }
    }
}

#[cfg(test)]
mod tests;
