//! What all estimators share: the scene, what the eye sees, light paths, and pictures.

use std::path::Path;

use anyhow::anyhow;
use gi_core::bsdf::Transport;
use gi_core::camera::{Camera, CameraSpec};
use gi_core::geometry::Surface;
use gi_core::grid::Item;
use gi_core::image_io::{ImageFile, Layers, write_file};
use gi_core::math::Rgb;
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use gi_core::walk::{LightVertex, LightWalk, Roulette, walk_in_order};
use glam::Vec3;
use rayon::prelude::*;

pub(crate) struct World {
    pub(crate) scene: Scene,
    pub(crate) camera: Camera,
}

/// A point that the eye sees: the surface, and the direction back to the eye.
pub(crate) struct Seen {
    pub(crate) surface: Surface,
    pub(crate) wo: Vec3,
}

/// A light path's visit to a surface.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Visit {
    /// Power of the path, not yet divided by the number of paths.
    pub(crate) power: Rgb,
    /// Direction back to where the light came from.
    pub(crate) wi: Vec3,
    /// Geometric normal on the side that the light came from.
    pub(crate) side: Vec3,
    /// Albedo of the surface.
    pub(crate) albedo: Rgb,
    /// |cos| with the shading normal over |cos| with the geometric normal.
    pub(crate) adjoint: f32,
}

impl World {
    pub(crate) fn load(path: &Path, side: usize) -> anyhow::Result<Self> {
        let options = gi_scene::Options { size: Some([side, side]), ..Default::default() };
        let loaded = gi_scene::load(path, &options).map_err(|e| anyhow!("{e}"))?;
        let camera = Camera::new(&CameraSpec { size: [side, side], ..loaded.camera });
        let scene = Scene::new(loaded.parts).map_err(|e| anyhow!("{}: {e}", path.display()))?;
        Ok(World { scene, camera })
    }

    /// What is seen through a point of the film, in pixels.
    pub(crate) fn seen(&self, film: [f32; 2]) -> Option<Seen> {
        let ray = self.camera.ray(film, [0.5; 2]);
        let (surface, _) = self.scene.intersect(&ray)?;
        Some(Seen { surface, wo: -ray.d })
    }

    /// f(wo, wi) at a point.
    pub(crate) fn f(&self, at: &Seen, wi: Vec3) -> Rgb {
        self.scene.bsdf(&at.surface, at.wo, Transport::Radiance).f(at.wo, wi)
    }

    /// A picture whose pixels are the mean of `spp` calls, with jittered points of the film and their random numbers.
    pub(crate) fn mean_of(
        &self,
        spp: u32,
        of: impl Fn([f32; 2], &mut Sampler) -> Rgb + Sync,
    ) -> Vec<Rgb> {
        let [w, h] = self.camera.size();
        let pixel = |i: usize| {
            let sample = |k: u32| {
                let mut sampler = Sampler::new(1, i as u32, k);
                let [dx, dy] = sampler.next_2d();
                of([(i % w) as f32 + dx, (i / w) as f32 + dy], &mut sampler)
            };
            (0..spp).map(sample).sum::<Rgb>() / spp as f32
        };
        (0..w * h).into_par_iter().map(pixel).collect()
    }

    /// All visits of light paths to surfaces, in the order of the paths.
    pub(crate) fn visits(&self, paths: u32, seed: u32) -> Vec<Vec<Item<Visit>>> {
        walk_in_order(paths, 4096, |path, out| {
            let Some(mut walk) = LightWalk::begin(&self.scene, Sampler::new(seed, 0, path)) else {
                return;
            };
            while let Some(vertex) = walk.next_vertex() {
                out.push(Item { p: vertex.surface.p, value: visit(&vertex) });
                if !walk.scatter(&vertex, Roulette::ByAlbedo { from: 1 }) {
                    return;
                }
            }
        })
    }

    /// Radiance that a light's surface emits toward the eye.
    pub(crate) fn emitted(&self, at: &Seen) -> Rgb {
        self.scene.emitted(&at.surface, at.wo)
    }
}

fn visit(vertex: &LightVertex) -> Visit {
    let (wi, ng, ns) = (vertex.wo, vertex.surface.ng, vertex.surface.ns());
    let cos = wi.dot(ng);
    let adjoint = if cos == 0.0 { 0.0 } else { (wi.dot(ns) / cos).abs() };
    let (side, albedo) = (ng * 1f32.copysign(cos), vertex.bsdf.albedo());
    Visit { power: vertex.power, wi, side, albedo, adjoint }
}

/// A picture with facts about how it was made.
pub(crate) struct Picture {
    pub(crate) size: [usize; 2],
    pub(crate) pixels: Vec<Rgb>,
    pub(crate) facts: Vec<(&'static str, f64)>,
}

impl Picture {
    pub(crate) fn new(world: &World, pixels: Vec<Rgb>) -> Self {
        Picture { size: world.camera.size(), pixels, facts: Vec::new() }
    }

    pub(crate) fn save(&self, path: &Path) -> anyhow::Result<()> {
        let mut layers = Layers::of_rgb(self.size, self.pixels.iter().map(|c| c.to_array()));
        let fact = |(name, v): &(&str, f64)| (format!("gi.{name}"), v.to_string());
        layers.metadata = self.facts.iter().map(fact).collect();
        for (path, kind) in
            [(path.to_path_buf(), ImageFile::Exr), (path.with_extension("png"), ImageFile::Png)]
        {
            write_file(&path, kind, &layers).map_err(|e| anyhow!("{}: {e}", path.display()))?;
        }
        Ok(())
    }
}
