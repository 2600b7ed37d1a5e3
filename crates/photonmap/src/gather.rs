//! Final gather: indirect light at the first diffuse surface, photons at the second [slides 28, 31].

use gi_core::bsdf::DiffusePart;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk, GatherRay};
use gi_core::film::Show;
use gi_core::math::{Frame, INV_PI, Rgb};
use gi_core::rng::hash_words;
use gi_core::sampler::Sampler;
use gi_core::warp;
use glam::Vec3;

use crate::estimate::facing;
use crate::guide::Guide;
use crate::photon::PhotonKind;
use crate::shoot::is_near_specular;
use crate::{Gather, PhotonMapping};

impl<'a> PhotonMapping<'a> {
    /// What the maps know at a vertex of a path from the eye.
    pub(crate) fn estimate(
        &self,
        v: &EyeVertex<'a>,
        sampler: &mut Sampler,
        rays: &Rays,
    ) -> Option<Estimate> {
        match self.params.gather {
            Gather::None => self.read_map(v, true, rays),
            Gather::Direct => self.read_map(v, false, rays),
            Gather::Final => self.final_gather(v, sampler, rays),
        }
    }

    /// The global map read at the vertex itself [slides 29, 30].
    fn read_map(&self, v: &EyeVertex<'a>, whole: bool, rays: &Rays) -> Option<Estimate> {
        let depth = self.photon_depth(v.segments)?;
        let place = (&v.surface, v.wo, &v.bsdf);
        let e = self.global.radiance(self.setting.scene, place, depth, rays.probes(v.segments));
        let (covers, direct) = (Covers::NonDelta, whole.then_some(e.direct));
        Some(Estimate { covers, direct, indirect: e.indirect, caustic: Some(e.caustic) })
    }

    /// Caustics from their map [slide 27], indirect light by rays to the photons behind [slide 28]. Lobes that are not
    /// Lambertian are left to the path.
    fn final_gather(
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
        // Light over nearly specular surfaces is indirect light, and read from the caustic map.
        let wanted = v.non_delta > 0 || matches!(show, Show::All | Show::Caustic | Show::Indirect);
        let caustic = match &self.caustic {
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

    /// Mean over gather rays of what they find, times albedo: indirect light that the Lambertian part scatters.
    fn gather(
        &self,
        v: &EyeVertex<'a>,
        part: &DiffusePart,
        sampler: &mut Sampler,
        rays: &Rays,
    ) -> Rgb {
        // Behind a glossy surface one ray is as good as the path's one.
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

    /// Where photons over rough surfaces came from, if gather rays are to be led there.
    fn guide(&self, v: &EyeVertex<'a>, frame: &Frame) -> Option<Guide> {
        if self.params.guided == 0.0 {
            return None;
        }
        let (n, depth) = (facing(&v.surface, v.wo), self.photon_depth(v.segments)?);
        let mut photons = Vec::with_capacity(self.params.lookup);
        self.global.visit(v.surface.p, n, depth, |photon| {
            if photon.kind() == PhotonKind::Indirect {
                photons.push((photon.direction(), photon.power.to_rgb().luminance()));
            }
        });
        Guide::new(frame, self.params.guided, photons.into_iter())
    }

    /// Light that comes to a vertex from direction `wi`, over a surface that scattered it by other than delta lobes: follow
    /// the ray to the first diffuse surface that is far enough away to read irradiance from the map.
    fn along(&self, v: &EyeVertex<'a>, wi: Vec3, sampler: &mut Sampler) -> Rgb {
        let scene = self.setting.scene;
        let ray = scene.spawn(&v.surface, wi);
        let start = GatherRay { ray, segments: v.segments + 1, length: v.length };
        let mut walk = EyeWalk::along(scene, self.params.limits, start, sampler.clone());
        if self.media.is_some() {
            walk = walk.through_media(scene.medium_toward(&v.surface, wi, v.medium));
        }
        let mut focused = 0;
        loop {
            self.add_medium(&mut walk);
            let Some(w) = &walk.next_vertex() else { break };
            walk.add_emitted(w);
            if w.wants_estimate() {
                // The caustic map holds the light of sources that is seen over nearly specular surfaces alone.
                let is_focused = self.caustic.is_some()
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
            let (e, radius) = self.irradiance(depth).lookup(scene, p, n)?;
            let (direct, caustic) = (Some(Rgb::BLACK), Some(Rgb::BLACK));
            let all = Estimate { covers, direct, indirect: e * part.albedo * INV_PI, caustic };
            return (far > radius).then_some(all);
        }
        // Other lobes need light straight from lights by itself.
        let e = self.global.irradiance_seen(scene, (p, n, depth), || sampler.next_2d());
        (far * far > e.found.radius_sq).then(|| Estimate {
            covers,
            direct: None,
            indirect: e.indirect * f,
            caustic: Some(e.caustic * f),
        })
    }

    /// Most segments of a photon's path that a path of `segments` from the eye may be joined to; `None` if there are none.
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

/// Numbers for the gather rays of a pixel's first diffuse surface: the rays of all passes are one sequence, so that they
/// are stratified together.
pub(crate) struct Rays {
    pub(crate) seed: u32,
    pub(crate) stream: u32,
    pub(crate) pass: u32,
}

impl Rays {
    /// Two numbers for ray `k` of the `n` of this pass.
    #[inline]
    pub(crate) fn direction(&self, k: u32, n: u32) -> [f32; 2] {
        let index = self.pass.wrapping_mul(n).wrapping_add(k);
        Sampler::new(self.seed ^ 0x6761_7468, self.stream, index).next_2d()
    }

    /// Numbers by which the disc of an estimate is probed where the path has so many segments.
    pub(crate) fn probes(&self, segments: u32) -> impl FnMut() -> [f32; 2] {
        let seed = hash_words(&[self.seed, 0x6469_7363, segments]);
        let mut sampler = Sampler::new(seed, self.stream, self.pass);
        move || sampler.next_2d()
    }
}
