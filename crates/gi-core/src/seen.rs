//! Paths from the eye, walked before a picture is made: where its light will be asked for.

use glam::Vec3;

use crate::bsdf::{Bsdf, Scatter, Transport};
use crate::geometry::Surface;
use crate::math::Rgb;
use crate::sampler::Sampler;
use crate::technique::Setting;

/// A surface that a path has met.
pub struct Met<'m, 'a> {
    /// The point.
    pub surface: &'m Surface,
    /// Unit direction back along the path.
    pub wo: Vec3,
    /// How it scatters.
    pub bsdf: &'m Bsdf<'a>,
    /// How it scatters the path now.
    pub scatter: &'m Scatter,
    /// Luminance of the share of radiance that the picture sees of light that comes along the path now.
    pub worth: f32,
}

/// Walk path number `path` from the eye through a random pixel, for at most `most` surfaces or until `visit` says that it
/// is enough. `stream` makes the numbers of one use differ from those of another.
pub fn walk_from_eye(
    setting: &Setting,
    stream: u32,
    path: u32,
    most: u32,
    mut visit: impl FnMut(&Met) -> bool,
) {
    let Setting { scene, camera, seed, .. } = *setting;
    let mut sampler = Sampler::new(seed ^ stream, 0, path);
    let [w, h] = camera.size().map(|n| n as f32);
    let [x, y] = sampler.next_2d();
    let mut ray = camera.ray([x * w, y * h], sampler.next_2d());
    let mut throughput = Rgb::WHITE;
    for _ in 0..most {
        let Some((surface, _)) = scene.intersect(&ray) else { return };
        let wo = -ray.d;
        let bsdf = scene.bsdf(&surface, wo, Transport::Radiance);
        let Some(s) = bsdf.sample(wo, sampler.next_1d(), sampler.next_2d()) else { return };
        throughput *= s.weight;
        let worth = throughput.luminance();
        if !visit(&Met { surface: &surface, wo, bsdf: &bsdf, scatter: &s, worth }) {
            return;
        }
        ray = scene.spawn(&surface, s.wi);
    }
}
