//! Final gather: indirect light at the first diffuse surface, photons at the second [slides 28, 31].

use gi_core::bsdf::DiffusePart;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk, GatherRay};
use gi_core::film::Show;
use gi_core::math::{Frame, INV_PI, Rgb};
use gi_core::sampler::Sampler;
use gi_core::technique::Setting;
use gi_core::warp;
use glam::Vec3;

use crate::estimate::facing;
use crate::guide::Guide;
use crate::maps::PhotonMaps;
use crate::params::Params;
use crate::photon::PhotonKind;
use crate::rays::Rays;
use crate::shoot::is_near_specular;

/// The maps, and how a picture reads them.
pub(crate) struct Gatherer<'s, 'a> {
    pub(crate) setting: &'s Setting<'a>,
    pub(crate) params: &'s Params,
    pub(crate) maps: &'s PhotonMaps,
}

impl<'a> Gatherer<'_, 'a> {
    /// Caustics from their map [slide 27], indirect light by gather rays [slide 28]. The path continues for lobes that are not
    /// Lambertian.
    pub(crate) fn final_gather(
        &self,
        v: &EyeVertex<'a>,
        sampler: &mut Sampler,
        rays: &Rays,
    ) -> Option<Estimate> {
        let part = v.bsdf.diffuse_part(v.wo)?;
        let show = self.setting.show;
        let mut indirect = Rgb::BLACK;
        if matches!(show, Show::All | Show::Indirect) {
            indirect = self.gather(v, &part, sampler, rays);
        }
        // The caustic map also holds light over nearly specular surfaces, which counts as indirect light.
        let wanted = v.non_delta > 0 || matches!(show, Show::All | Show::Caustic | Show::Indirect);
        let caustic = match &self.maps.caustic {
            Some(map) if wanted => {
                let depth = self.photon_depth(v.segments)?;
                let place = (v.surface.p, facing(&v.surface, v.wo), depth);
                let probes = rays.probes(v.segments);
                let e = map.irradiance_seen(self.setting.scene, place, probes);
                let f = part.albedo * INV_PI;
                indirect += e.indirect * f;
                Some(e.caustic * f)
            }
            Some(_) => Some(Rgb::BLACK),
            None => None,
        };
        Some(Estimate { covers: Covers::Diffuse(part), direct: None, indirect, caustic })
    }

    /// Indirect light that the Lambertian part scatters: albedo times the mean radiance along gather rays.
    fn gather(
        &self,
        v: &EyeVertex<'a>,
        part: &DiffusePart,
        sampler: &mut Sampler,
        rays: &Rays,
    ) -> Rgb {
        // After a scattering one ray is enough: the path itself is one of many.
        let count = if v.non_delta == 0 { self.params.gather_rays } else { 1 };
        let frame = Frame::from_normal(part.normal);
        let guide = if v.non_delta == 0 { self.guide(v, &frame) } else { None };
        let mut sum = Rgb::BLACK;
        for k in 0..count {
            let u = if v.non_delta == 0 { rays.direction(k, count) } else { sampler.next_2d() };
            let (local, density) = match &guide {
                Some(guide) => guide.sample(u),
                None => (warp::cosine_hemisphere(u), 1.0),
            };
            sum += self.along(v, frame.to_world(local), sampler) / density;
        }
        sum * part.albedo / count as f32
    }

    /// The directions that photons of indirect light came from, if gather rays are guided \[Jensen95\].
    fn guide(&self, v: &EyeVertex<'a>, frame: &Frame) -> Option<Guide> {
        if self.params.guided == 0.0 {
            return None;
        }
        let (n, depth) = (facing(&v.surface, v.wo), self.photon_depth(v.segments)?);
        let mut photons = Vec::with_capacity(self.params.lookup);
        self.maps.global.visit(v.surface.p, n, depth, |photon| {
            if photon.kind() == PhotonKind::Indirect {
                photons.push((photon.direction(), photon.power.to_rgb().luminance()));
            }
        });
        Guide::new(frame, self.params.guided, photons.into_iter())
    }

    /// Radiance that arrives at a vertex from direction `wi` after a scattering by other than a delta lobe. The gather ray ends at the
    /// first diffuse surface that is far enough away to read precomputed irradiance.
    fn along(&self, v: &EyeVertex<'a>, wi: Vec3, sampler: &mut Sampler) -> Rgb {
        let scene = self.setting.scene;
        let ray = scene.spawn(&v.surface, wi);
        let start = GatherRay { ray, segments: v.segments + 1, length: v.length };
        let mut walk = EyeWalk::along(scene, self.params.limits, start, sampler.clone());
        if self.maps.media.is_some() {
            walk.use_media(scene.medium_toward(&v.surface, wi, v.medium));
        }
        let mut focused = 0;
        loop {
            self.add_medium(&mut walk);
            let Some(w) = &walk.next_vertex() else { break };
            walk.add_emitted(w);
            if w.wants_estimate() {
                // Light sources that are seen over nearly specular surfaces alone are in the caustic map.
                let is_focused = self.maps.caustic.is_some()
                    && w.non_delta == 1 + focused
                    && is_near_specular(&w.bsdf, w.wo);
                let estimate = if is_focused {
                    focused += 1;
                    Some(NO_LIGHTS)
                } else {
                    self.precomputed(w, w.length - v.length, &mut walk.sampler)
                };
                if let Some(estimate) = estimate {
                    walk.add_estimate(w, estimate);
                }
            }
            walk.add_direct(w);
            if !walk.scatter(w) {
                break;
            }
        }
        *sampler = walk.sampler.clone();
        walk.sample().radiance.indirect
    }

    /// Estimate at a vertex `w`, at the distance `far` from the gather point, by precomputed irradiance.
    fn precomputed(&self, w: &EyeVertex<'a>, far: f32, sampler: &mut Sampler) -> Option<Estimate> {
        let scene = self.setting.scene;
        let part = w.bsdf.diffuse_part(w.wo)?;
        let depth = self.photon_depth(w.segments)?;
        let (p, n) = (w.surface.p, facing(&w.surface, w.wo));
        let (covers, f) = (Covers::Diffuse(part), part.albedo * INV_PI);
        if w.bsdf.is_diffuse() {
            let (e, radius) = self.maps.irradiance(depth).lookup(scene, p, n)?;
            let (direct, caustic) = (Some(Rgb::BLACK), Some(Rgb::BLACK));
            let all = Estimate { covers, direct, indirect: e * part.albedo * INV_PI, caustic };
            return (far > radius).then_some(all);
        }
        // Other lobes need direct light separately.
        let e = self.maps.global.irradiance_seen(scene, (p, n, depth), || sampler.next_2d());
        (far * far > e.found.radius_sq).then(|| Estimate {
            covers,
            direct: None,
            indirect: e.indirect * f,
            caustic: Some(e.caustic * f),
        })
    }

    /// Maximum number of segments of a photon that may be joined to an eye path of `segments` segments; `None` if none may.
    pub(crate) fn photon_depth(&self, segments: u32) -> Option<u8> {
        let Some(most) = self.params.limits.max_depth else { return Some(u8::MAX) };
        let left = most.saturating_sub(segments);
        (left > 0).then_some(left.min(255) as u8)
    }
}

/// Accounts for light straight from sources and over delta lobes, which is added elsewhere. Adds nothing.
const NO_LIGHTS: Estimate = Estimate {
    covers: Covers::Diffuse(DiffusePart { albedo: Rgb::BLACK, normal: Vec3::Z }),
    direct: Some(Rgb::BLACK),
    indirect: Rgb::BLACK,
    caustic: Some(Rgb::BLACK),
};
