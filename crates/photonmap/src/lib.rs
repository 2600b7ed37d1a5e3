//! Photon mapping [slides 21-34]: trace light from the lights, store it as photons, and estimate radiance from their density.
//!
//! | | |
//! |---|---|
//! | estimate | radiance from photons: L = sum of f(wi, wo) power / (pi r^2) over the k nearest photons [slide 24] |
//! | `--gather final` | direct light by sampling lights; caustics from their own map at the first diffuse surface [slide 27]; indirect light by gather rays that read the global map at the second [slides 28, 31] |
//! | `--gather none`, `direct` | the global map read at the first surface [slides 29, 30]; with `direct`, direct light by sampling lights |
//! | media | volume photons by the beam radiance estimate [slide 34]; translucent solids by volume photons or by the dipole |
//! | bias | light is blurred over r: caustics are soft, light leaks round corners closer than r, and few photons show as blotches |
//! | sources | \[Jensen95\], \[Jensen96\], \[Jensen98\], \[Christensen99\], \[Jensen01\], \[Jensen01b\], \[Jensen02\], \[Jarosz08\] |
//!
//! Read next: `shoot.rs` (photon tracing), `estimate.rs` (the density estimate), `gather.rs` (final gather), `kd.rs` and
//! `nearest.rs` (the search), `params.rs` (the options).

mod beam;
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
mod order;
mod outputs;
mod params;
pub mod photon;
mod pictures;
mod rays;
mod seen;
pub mod shoot;
mod solids;
#[cfg(test)]
mod test_scenes;
pub mod volume;

use std::path::Path;

use gi_core::bytes::checksum;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::film::Film;
use gi_core::math::INV_PI;
use gi_core::sampler::Sampler;
use gi_core::technique::{Picture, Setting, Technique};

use estimate::{Density, facing};
use gather::Gatherer;
use maps::PhotonMaps;
pub use params::{Figure, Gather, Params, Subsurface};
use rays::Rays;

/// Photon mapping.
pub struct PhotonMapping<'a> {
    setting: Setting<'a>,
    params: Params,
    maps: PhotonMaps,
}

impl<'a> Technique<'a> for PhotonMapping<'a> {
    type Params = Params;

    /// Trace photons and build the maps [slides 22, 26].
    fn prepare(setting: Setting<'a>, params: &Params) -> Result<Self, String> {
        let maps = PhotonMaps::new(&setting, params)?;
        Ok(PhotonMapping { setting, params: params.clone(), maps })
    }

    /// One path per pixel. The maps estimate the light at its vertices.
    fn pass(&mut self, index: u32, film: &mut Film) {
        let gatherer = self.gatherer();
        let medium = self.setting.camera_medium();
        film.add_pass(|pixel| {
            let rays = Rays::of_pixel(&self.setting, pixel, index);
            let mut walk = EyeWalk::through_pixel(&self.setting, self.params.limits, pixel, index);
            if self.maps.media.is_some() {
                walk.use_media(medium);
            }
            loop {
                gatherer.add_medium(&mut walk);
                let Some(v) = &walk.next_vertex() else { break };
                walk.add_emitted(v);
                if v.wants_estimate()
                    && let Some(estimate) = gatherer.estimate(v, &mut walk.sampler, &rays)
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

    fn prepared(&self) -> u64 {
        checksum(&self.gatherer().save())
    }

    fn pictures(&self, film: &Film) -> Vec<Picture> {
        self.gatherer().draw(film)
    }

    fn export(&self, path: &Path) -> Vec<u8> {
        self.gatherer().contents(path)
    }

    fn statistics(&self) -> Vec<(String, f64)> {
        self.maps.statistics(self.setting.scene.radius())
    }

    fn reach(&self) -> String {
        "all paths; light from photons is blurred; E S* D S+ L only where the caustic map has photons".into()
    }
}

impl<'a> PhotonMapping<'a> {
    fn gatherer(&self) -> Gatherer<'_, 'a> {
        Gatherer { setting: &self.setting, params: &self.params, maps: &self.maps }
    }
}

impl<'a> Gatherer<'_, 'a> {
    /// The light that the maps know at a vertex.
    fn estimate(&self, v: &EyeVertex<'a>, sampler: &mut Sampler, rays: &Rays) -> Option<Estimate> {
        if self.params.gather == Gather::Final {
            return self.final_gather(v, sampler, rays);
        }
        let photons = self.radiance(v, rays)?;
        let direct = (self.params.gather == Gather::None).then_some(photons.direct);
        let (indirect, caustic) = (photons.indirect, Some(photons.caustic));
        Some(Estimate { covers: Covers::NonDelta, direct, indirect, caustic })
    }

    /// Radiance from the global map at the vertex itself: L = sum of f(wi, wo) power / (pi r^2) over the k nearest photons
    /// [slides 24, 29, 30]. `per_area` is 1 / (pi r^2), the slide's weight; `--kernel` can make it depend on the distance.
    fn radiance(&self, v: &EyeVertex<'a>, rays: &Rays) -> Option<Density> {
        let place = (v.surface.p, facing(&v.surface, v.wo), self.photon_depth(v.segments)?);
        let (scene, map) = (self.setting.scene, &self.maps.global);
        let probes = rays.probes(v.segments);
        Some(match v.bsdf.lambertian(v.wo) {
            Some(albedo) => map.density_seen(scene, place, probes, |photon, per_area| {
                albedo * INV_PI * photon.power.to_rgb() * per_area
            }),
            None => map.density_seen(scene, place, probes, |photon, per_area| {
                v.bsdf.f(v.wo, photon.direction()) * photon.power.to_rgb() * per_area
            }),
        })
    }
}
