//! Where light from infinity is aimed: at what the eye's paths meet behind the first point where photons are gathered.
//!
//! A photon is worth what the picture makes of it. Paths from the eye, going on where they gather, end up at points in
//! proportion to that; a sun that lights ground to the horizon sends its photons there.

use gi_core::bsdf::Transport;
use gi_core::light::{Light, Targets};
use gi_core::math::Rgb;
use gi_core::sampler::Sampler;
use gi_core::technique::Setting;
use glam::Vec3;
use rayon::prelude::*;

use crate::Params;
use crate::gather::answered;

/// Paths from the eye. They are few beside those of a pass, and say about where, not how bright.
const PATHS: u32 = 4096;
/// Surfaces that one meets at most.
const MOST_MET: u32 = 8;
/// Makes the numbers of these paths differ from those of all others.
const STREAM: u32 = 0x6169_6d21;

/// What photons are aimed at; `None` where they begin as ever.
pub(crate) fn targets(setting: &Setting, params: &Params) -> Option<Targets> {
    if !setting.scene.lights().all().iter().any(Light::is_infinite) {
        return None;
    }
    let walks: Vec<Walk> =
        (0..PATHS).into_par_iter().map(|path| walk(setting, params, path)).collect();
    let (met, ends) = walks.into_iter().unzip::<_, _, Vec<_>, Vec<_>>();
    let [met, ends] = [met, ends].map(|lists| lists.into_iter().flatten().collect());
    setting.scene.around([met, ends])
}

/// Points and what photons there would be worth: where they would have to be scattered, and where they would be gathered.
type Walk = (Vec<(Vec3, f32)>, Vec<(Vec3, f32)>);

/// Walk a path from the eye.
fn walk(setting: &Setting, params: &Params, path: u32) -> Walk {
    let Setting { scene, camera, seed, .. } = *setting;
    let mut sampler = Sampler::new(seed ^ STREAM, 0, path);
    let [w, h] = camera.size().map(|n| n as f32);
    let [x, y] = sampler.next_2d();
    let mut ray = camera.ray([x * w, y * h], sampler.next_2d());
    let (mut met, mut ends) = (Vec::new(), Vec::new());
    let (mut worth, mut gathered) = (Rgb::WHITE, params.direct_by_photons);
    for _ in 0..MOST_MET {
        let Some((surface, _)) = scene.intersect(&ray) else { break };
        let wo = -ray.d;
        let bsdf = scene.bsdf(&surface, wo, Transport::Radiance);
        let Some(s) = bsdf.sample(wo, sampler.next_1d(), sampler.next_2d()) else { break };
        worth *= s.weight;
        let point = (surface.p, worth.luminance());
        if gathered && !s.null {
            met.push(point);
        }
        if !bsdf.is_delta() && answered(&bsdf, wo, params.min_roughness).is_some() {
            if ends.is_empty() {
                ends.push(point);
            }
            gathered = true;
        }
        ray = scene.spawn(&surface, s.wi);
    }
    (met, ends)
}
