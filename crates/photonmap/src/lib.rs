//! Photon mapping: light is traced from the lights and kept as photons; their density is its irradiance.
//!
//! | | |
//! |---|---|
//! | estimated | radiance from photons: L = sum over the k nearest of f(wi, wo) power / (pi r^2) [slide 24] |
//! | `--gather final` | direct light by sampling lights, caustics from a map of their own at the first diffuse surface [slide 27], indirect light by gather rays to the global map at the second [slides 28, 31] (default) |
//! | `--gather none` | the global map seen directly [slides 29, 30]; `--gather direct`: the same, with direct light by sampling lights |
//! | `--photons`, `--caustic-photons` | photons to store (100000 each) |
//! | `--volume-photons`, `--volume-lookup` | photons to store where media scatter light, and how many of them their radius reaches to (100000, 20) [slide 34]; read by [`volume`] |
//! | `--subsurface photons` | translucent solids by photons in the medium (default), or by diffusion from photons that enter (`dipole`) |
//! | `--lookup`, `--max-radius`, `--kernel` | photons of an estimate (50); bound on its radius (0: automatic); how photons count (epanechnikov) |
//! | `--gather-rays` | rays of a gather point in a pass (2): about as much work as direct light |
//! | bias, and how it looks | light is blurred over r: soft caustics, light through thin walls and round corners, dark rims of walls; blotches where photons are few |
//! | sources | \[Jensen95\], \[Jensen96\], \[Jensen98\], \[Christensen99\], \[Jensen01\], \[Jensen01b\], \[Jensen02\], \[Jarosz08\] |

#![forbid(unsafe_code)]

mod dipole;
pub mod estimate;
mod export;
mod file;
mod gather;
mod guide;
mod heap;
mod irradiance;
mod jensen;
mod kd;
pub mod kernel;
pub mod map;
mod maps;
mod media;
mod nearest;
mod outputs;
mod params;
pub mod photon;
mod pictures;
mod seen;
pub mod shoot;
mod solids;
#[cfg(test)]
mod test_scenes;
pub mod volume;

use std::path::Path;

use gi_core::eye::EyeWalk;
use gi_core::film::Film;
use gi_core::technique::{Picture, Setting, Technique};

use estimate::Estimator;
use gather::Rays;
use irradiance::{IrradianceMap, irradiance_maps};
use map::PhotonMap;
use maps::{Maps, load, shoot, source};
use media::MediaMaps;
pub use params::{Gather, Params, Show, Subsurface};
use shoot::Shot;
use volume::VolumeMaps;

/// Bound on the radius of an estimate of caustics, in radii that half of their photons need: they are seen as they are,
/// and have edges.
const CAUSTIC_RADIUS: f32 = 0.5;

impl Params {
    /// How a map is read by `k` photons an estimate, in a scene of some radius.
    fn estimator(&self, map: PhotonMap, k: usize, factor: f32, scene_radius: f32) -> Estimator {
        Estimator::new(map, self.kernel, k, self.max_radius * scene_radius, factor)
    }

    /// Bound on the radius of an estimate, in radii that half of the places need. Where it is dark, a disc that grows until
    /// it reaches what is bright reads too much, and nothing makes up for that. Where the maps are seen, this is less bad
    /// than blotches.
    fn radius_factor(&self) -> f32 {
        if self.gather == Gather::Final { 0.75 } else { 3.0 }
    }
}

/// Photon mapping.
pub struct PhotonMapping<'a> {
    setting: Setting<'a>,
    params: Params,
    global: Estimator,
    caustic: Option<Estimator>,
    /// Light in media, where there are any.
    media: Option<MediaMaps>,
    /// Irradiance ahead, by the depth that light may have; one for all where depth is unbounded.
    irradiance: Vec<IrradianceMap>,
    gave_up: [bool; 2],
}

impl<'a> Technique<'a> for PhotonMapping<'a> {
    type Params = Params;

    /// Shoot photons, build the maps, compute irradiance ahead.
    fn prepare(setting: Setting<'a>, params: &Params) -> Result<Self, String> {
        media::check(&setting, params)?;
        let Maps { global, caustic, volume, order } = match &params.map_in {
            Some(path) => load(&setting, params, path)?,
            None => shoot(&setting, params),
        };
        let gave_up = [global.gave_up, caustic.as_ref().is_some_and(|c| c.gave_up)];
        let estimator = |shot: Shot, k, factor| {
            let bounded = params.limits.max_depth.is_some();
            let map = PhotonMap::build(shot.photons, shot.emitted, params.layout, order, bounded);
            params.estimator(map, k, factor, setting.scene.radius())
        };
        // Gather rays average: for them half as many photons are read, and blurred less.
        let halves = if params.gather == Gather::Final { 2 } else { 1 };
        let (k, factor) = (params.lookup.div_ceil(halves), params.radius_factor());
        let mut global = estimator(global, k, factor);
        let caustic = caustic.map(|shot| estimator(shot, params.lookup, CAUSTIC_RADIUS));
        let places = seen::places(&setting, params.gather, irradiance::count(global.map.len()));
        if params.max_radius == 0.0 {
            global.bound_radius(&places, factor);
        }
        let irradiance = match params.gather {
            Gather::Final => irradiance_maps(&setting, params, &global, &places),
            Gather::None | Gather::Direct => Vec::new(),
        };
        let media = params
            .knows_media(setting.scene)
            .then(|| MediaMaps::shoot(&source(&setting, params), params, volume));
        let params = params.clone();
        Ok(PhotonMapping { setting, params, global, caustic, media, irradiance, gave_up })
    }

    /// One path from the eye a pixel; the maps answer where it meets what scatters light.
    fn pass(&mut self, index: u32, film: &mut Film) {
        let Setting { camera, seed, .. } = self.setting;
        let medium = self.setting.camera_medium();
        film.add_pass(|pixel| {
            let stream = (pixel[1] * camera.size()[0] + pixel[0]) as u32;
            let rays = Rays { seed, stream, pass: index };
            let mut walk = EyeWalk::through_pixel(&self.setting, self.params.limits, pixel, index);
            if self.media.is_some() {
                walk = walk.through_media(medium);
            }
            loop {
                self.add_medium(&mut walk);
                let Some(v) = &walk.next_vertex() else { break };
                walk.add_emitted(v);
                if v.wants_estimate()
                    && let Some(estimate) = self.estimate(v, &mut walk.sampler, &rays)
                {
                    walk.add_estimate(v, estimate);
                }
                walk.add_direct(v);
                if !walk.scatter(v) {
                    break;
                }
            }
            walk.sample()
        });
    }

    fn pictures(&self, film: &Film) -> Vec<Picture> {
        self.draw(film)
    }

    fn export(&self, path: &Path) -> Vec<u8> {
        self.file(path)
    }

    fn statistics(&self) -> Vec<(String, f64)> {
        let mut out = Vec::new();
        let maps = [("global", Some(&self.global)), ("caustic", self.caustic.as_ref())];
        for ((name, map), gave_up) in maps.into_iter().zip(self.gave_up) {
            let Some(Estimator { map, max_radius_sq, .. }) = map else { continue };
            out.push((format!("{name}_photons"), map.len() as f64));
            out.push((format!("{name}_paths"), map.emitted as f64));
            out.push((format!("{name}_bytes"), map.bytes() as f64));
            let radius = max_radius_sq.sqrt() / self.setting.scene.radius();
            out.push((format!("{name}_max_radius"), f64::from(radius)));
            out.push((format!("{name}_gave_up"), f64::from(u8::from(gave_up))));
        }
        if let Some(media) = &self.media {
            out.extend(media.statistics());
        }
        let bytes: usize = self.irradiance.iter().map(IrradianceMap::bytes).sum();
        out.push(("irradiance_bytes".into(), bytes as f64));
        out
    }

    fn reach(&self) -> String {
        "all paths, blurred where photons answer; E S* D S+ L only as far as the caustic map has photons".into()
    }
}

impl PhotonMapping<'_> {
    fn maps(&self) -> [Option<&PhotonMap>; 2] {
        [Some(&self.global.map), self.caustic.as_ref().map(|c| &c.map)]
    }

    fn volume(&self) -> Option<&VolumeMaps> {
        self.media.as_ref().map(|media| &media.volume)
    }

    /// Irradiance of light that took at most `depth` segments.
    fn irradiance(&self, depth: u8) -> &IrradianceMap {
        let last = self.irradiance.len() - 1;
        &self.irradiance[(depth as usize - 1).min(last)]
    }
}
