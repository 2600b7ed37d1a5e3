//! Light paths, and a virtual point light at each of their vertices [slide 49].

use gi_core::math::{INV_PI, Rgb};
use gi_core::progress;
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use gi_core::walk::{LightVertex, LightWalk, Roulette};
use glam::Vec3;
use rayon::prelude::*;

use crate::{Kind, LitSurface, MIN_ROUGHNESS, Termination, Vpl, Vpls};

/// How light paths are walked.
#[derive(Clone, Copy, Debug)]
pub struct Shooting {
    /// Seed of all random numbers.
    pub seed: u32,
    /// Number of the first path: sets of lights with paths of their own go together as one sequence.
    pub first_path: u32,
    /// Number of paths.
    pub paths: u32,
    /// When they end.
    pub termination: Termination,
    /// Most scatterings of a path; `None` is unbounded.
    pub max_scatterings: Option<u32>,
    /// Whether the points of lights that paths start from are lights too.
    pub lights: bool,
    /// What a pilot found out about the scene.
    pub pilot: Pilot,
}

/// What a few paths tell about the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pilot {
    /// Mean reflectance: share of scattered power that goes on.
    pub reflectance: f32,
    /// Virtual point lights that a path leaves by roulette, lights' own points apart.
    pub lights_per_path: f32,
}

/// Paths of a pilot.
const PILOT_PATHS: u32 = 2048;
/// Paths of a scene that absorbs nothing must end too.
const MAX_REFLECTANCE: f32 = 0.95;
/// Paths that one task walks; their lights are joined in order.
const CHUNK: u32 = 256;
/// What keeps the numbers of light paths apart from those of the eye's.
const SALT: u32 = 0x7670_6c73;

impl Pilot {
    /// Walk a few paths, by roulette.
    pub fn of(scene: &Scene, seed: u32) -> Self {
        let (mut met, mut went_on, mut lights) = (0u32, 0u32, 0u32);
        for path in 0..PILOT_PATHS {
            let sampler = Sampler::new(seed ^ SALT ^ 0x0070_696c, 1, path);
            let Some(mut walk) = LightWalk::begin(scene, sampler) else { continue };
            while let Some(vertex) = walk.next_vertex() {
                met += 1;
                lights += u32::from(!vertex.bsdf.is_delta());
                if !walk.scatter(&vertex, Roulette::ByAlbedo { from: 1 }) {
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

    /// How many paths leave about so many lights. (Fractional absorption leaves as many as roulette, in the mean.)
    pub fn paths_for(&self, vpls: u32) -> u32 {
        ((vpls as f32 / self.lights_per_path).round() as u32).max(1)
    }
}

/// What a chunk of paths left.
#[derive(Default)]
struct Chunk {
    lights: Vec<Vpl>,
    surfaces: Vec<LitSurface>,
    arrived: Rgb,
    emitted: Rgb,
}

/// Walk light paths and leave a light wherever one meets a surface that scatters by other than delta lobes. The same lights
/// for any number of threads.
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
    // Stable: within a depth the order stays that of the paths.
    all.lights.sort_by_key(|v| v.depth);
    all
}

impl Shooting {
    fn walk(&self, scene: &Scene, path: u32, chunk: &mut Chunk) {
        // One sequence: its points are the paths of all sets.
        let sampler = Sampler::new(self.seed ^ SALT, 0, self.first_path.wrapping_add(path));
        let Some(mut walk) = LightWalk::begin(scene, sampler) else { return };
        let paths = self.paths as f32;
        chunk.emitted += walk.emission().power / paths;
        if self.lights {
            chunk.lights.push(Vpl::of_emission(scene, walk.emission(), paths));
        }
        let mut scatterings = 0;
        // The light at a vertex scatters there once more.
        while self.max_scatterings.is_none_or(|most| scatterings < most) {
            let Some(vertex) = walk.next_vertex() else { return };
            scatterings = vertex.depth + 1;
            chunk.arrived += vertex.power / paths;
            if !vertex.bsdf.is_delta() {
                chunk.leave(scene, &vertex, paths);
            }
            if !walk.scatter(&vertex, self.roulette(path, scatterings)) {
                return;
            }
        }
    }

    /// Whether a path goes on after so many scatterings.
    fn roulette(&self, path: u32, scatterings: u32) -> Roulette {
        match self.termination {
            Termination::Roulette => Roulette::ByAlbedo { from: 1 },
            Termination::Fractional => {
                // Of those that came so far, those with the smallest numbers: whole paths, so the share is what it is.
                let left = |j: u32| {
                    let share = f64::from(self.pilot.reflectance).powi(j as i32);
                    (f64::from(self.paths) * share).ceil().max(1.0) as u32
                };
                let (before, after) = (left(scatterings - 1), left(scatterings));
                // The last path of all plays for itself, or it would never end.
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
        // A Lambertian surface shines as the cosine, of its geometric normal even where another one shades it: that is
        // what the correction by both normals comes to. All other surfaces are asked.
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
        // Lights of no finite power would leave no estimate and no tree of lights finite.
        if !power.is_black() && power.is_finite() {
            let on = scene.flat_at(surface);
            self.lights.push(Vpl { p: surface.p, n, ns, power, kind, depth, on });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Receiver;
    use gi_core::bsdf::Transport;
    use gi_core::geometry::{Geometry, Shape};
    use gi_core::light::LightSource;
    use gi_core::material::Material;
    use gi_core::math::Frame;
    use gi_core::ray::Ray;
    use gi_core::scene::SceneParts;
    use gi_core::texture::Texture;
    use std::f32::consts::PI;

    /// The inside of a unit sphere of this albedo, a point light of intensity 1 somewhere in it.
    fn sphere(albedo: f32) -> Scene {
        let axes = Frame::from_normal(Vec3::Z);
        let geometry = Geometry::Sphere { center: Vec3::ZERO, radius: 1.0, axes };
        let shapes = vec![Shape { flip_normals: true, ..Shape::new("sphere", geometry, 0) }];
        let materials = vec![Material::Diffuse { reflectance: Texture::grey(albedo) }];
        let position = Vec3::new(0.2, 0.1, -0.3);
        let lights = vec![LightSource::Point { position, intensity: Rgb::WHITE }];
        let parts = SceneParts { shapes, materials, lights, ..SceneParts::default() };
        Scene::new(parts).expect("a scene")
    }

    fn shooting(scene: &Scene, termination: Termination) -> Shooting {
        let pilot = Pilot::of(scene, 3);
        let (paths, max_scatterings) = (4096, None);
        Shooting {
            seed: 1,
            first_path: 0,
            paths,
            termination,
            max_scatterings,
            lights: false,
            pilot,
        }
    }

    #[test]
    fn powers_add_up_to_the_geometric_series() {
        let albedo = 0.6f32;
        let scene = sphere(albedo);
        for termination in [Termination::Fractional, Termination::Roulette] {
            let how = shooting(&scene, termination);
            // The pilot's reflectance is a frequency over some 5000 scatterings.
            assert!((how.pilot.reflectance - albedo).abs() < 0.03, "{:?}", how.pilot);
            let set = shoot(&scene, &how);
            let emitted = 4.0 * PI;
            assert!((set.emitted.g / emitted - 1.0).abs() < 1e-4);
            // Lights leave rho Phi, rho^2 Phi, ... : rho / (1 - rho) Phi in all. By roulette every survivor has the power
            // of its path, and their number has a standard deviation of sqrt(rho) / (1 - rho) a path.
            let left: f32 = set.lights.iter().map(|v| v.power.g * PI).sum();
            let expected = albedo / (1.0 - albedo) * emitted;
            let sigma = albedo.sqrt() / (1.0 - albedo) / 64.0 * albedo;
            assert!(
                (left / emitted - expected / emitted).abs() < 4.0 * sigma,
                "{termination:?}: {left} is not {expected}"
            );
            assert!((set.arrived.g * albedo / left - 1.0).abs() < 1e-4);
            if termination == Termination::Fractional {
                let first = set.up_to(1);
                let power: f32 = first.iter().map(|v| v.power.g * PI).sum();
                assert!(
                    (power / (albedo * emitted) - 1.0).abs() < 1e-4,
                    "every path leaves its first light"
                );
                assert_eq!(first.len(), 4096);
            }
            assert!(set.lights.is_sorted_by_key(|v| v.depth));
        }
    }

    #[test]
    fn one_light_by_hand() {
        let scene = sphere(0.5);
        let p = Vec3::new(0.0, 0.0, 1.0);
        let power = Rgb::new(1.0, 2.0, 3.0);
        let vpl =
            Vpl { p, n: -Vec3::Z, ns: -Vec3::Z, power, kind: Kind::Oriented, depth: 1, on: None };
        let set = Vpls::default();
        // The sphere's lowest point, seen from its middle: cosines 1, distance 2, f = 0.5 / pi.
        let ray = Ray::new(Vec3::ZERO, -Vec3::Z);
        let (surface, _) = scene.intersect(&ray).expect("the sphere");
        let wo = Vec3::Z;
        let bsdf = scene.bsdf(&surface, wo, Transport::Radiance);
        let at = Receiver::new(&surface, wo, &bsdf);
        let c = set.connect(&scene, &vpl, &at).expect("they face each other");
        assert!(
            (c.radiance.g - 2.0 * 0.5 / PI / 4.0).abs() < 1e-6 && (c.geometry - 0.25).abs() < 1e-6
        );
        assert!(!scene.tree().occluded(&c.shadow));
        // From the side: on a unit sphere cos cos' / d^2 is 1/4 wherever the points lie.
        let ray = Ray::new(Vec3::ZERO, Vec3::X);
        let (surface, _) = scene.intersect(&ray).expect("the sphere");
        let bsdf = scene.bsdf(&surface, -Vec3::X, Transport::Radiance);
        let at = Receiver::new(&surface, -Vec3::X, &bsdf);
        let c = set.connect(&scene, &vpl, &at).expect("they see each other");
        assert!((c.geometry - 0.25).abs() < 1e-6);
        // One that shines away lights nothing; parallel light does not fall off.
        assert!(set.connect(&scene, &Vpl { n: Vec3::Z, ns: Vec3::Z, ..vpl }, &at).is_none());
        let sun = Vpl { n: Vec3::X, kind: Kind::Directional, ..vpl };
        let c = set.connect(&scene, &sun, &at).expect("it shines on it");
        assert!((c.radiance.b - 3.0 * 0.5 / PI).abs() < 1e-6);
    }

    #[test]
    fn the_lights_are_the_same_for_any_number_of_threads_and_sets_join_into_one() {
        let scene = sphere(0.7);
        let how = shooting(&scene, Termination::Roulette);
        let with = |threads: usize| {
            let pool =
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| shoot(&scene, &how)).lights
        };
        let one = with(1);
        assert!(one == with(2) && one == with(4));
        let half = |first_path| shoot(&scene, &Shooting { first_path, paths: 2048, ..how }).lights;
        assert_eq!(half(0).len() + half(2048).len(), one.len());
    }
}
