//! Paths from the eye.

use gi_core::bsdf::Transport;
use gi_core::film::{Components, Sample};
use gi_core::geometry::Surface;
use gi_core::math::Rgb;
use gi_core::nee::{direct_light, emitter_weight};
use gi_core::ray::Ray;
use gi_core::sampler::Sampler;
use glam::Vec3;

use crate::PathTracer;

/// Russian roulette lets at least one path in twenty end, so that no path is endless.
const MAX_SURVIVAL: f32 = 0.95;

/// What has happened on a path since the eye.
struct Prefix {
    /// Scattered share of the radiance, already divided by all densities.
    throughput: Rgb,
    /// Where the last scattering was, and its density per solid angle; `None` at the eye and after delta lobes.
    last: Option<(Vec3, f32)>,
    /// Scatterings by other than delta lobes.
    rough: u32,
    /// Whether the last scattering was by a delta lobe.
    after_delta: bool,
    /// Product of the squared indices that refraction divided the throughput by.
    eta_sq: f32,
}

impl PathTracer<'_> {
    /// One path through a pixel.
    pub(crate) fn sample_pixel(&self, [x, y]: [usize; 2], index: u32) -> Sample {
        let camera = self.setting.camera;
        let stream = (y * camera.size()[0] + x) as u32;
        let mut sampler = Sampler::new(self.setting.seed, stream, index);
        let [u, v] = sampler.next_2d();
        let lens = if camera.has_lens() { sampler.next_2d() } else { [0.5; 2] };
        let ray = camera.ray([x as f32 + u, y as f32 + v], lens);
        let mut sample = Sample { offset: [u - 0.5, v - 0.5], ..Sample::default() };
        self.trace(ray, &mut sampler, &mut sample);
        sample
    }

    /// Follow a path from the eye and add up the light that it finds.
    fn trace(&self, mut ray: Ray, sampler: &mut Sampler, out: &mut Sample) {
        let scene = self.setting.scene;
        let mut prefix = Prefix {
            throughput: Rgb::WHITE,
            last: None,
            rough: 0,
            after_delta: false,
            eta_sq: 1.0,
        };
        let mut segments = 1;
        let mut seen = false;
        loop {
            // Intersect.
            let Some(hit) = scene.closest(&ray) else {
                self.add_background(ray.d, &prefix, &mut out.radiance);
                return;
            };
            let surface = scene.surface(&ray, &hit);
            let wo = -ray.d;
            let bsdf = scene.bsdf(&surface, wo, Transport::Radiance);
            if !seen {
                (out.albedo, out.normal, out.depth) = (bsdf.albedo_hint(wo), surface.ns(), hit.t);
                seen = true;
            }
            // Add the light of an emitter.
            self.add_emitted(&surface, wo, &prefix, &mut out.radiance);
            // At the last segment only what passes straight through goes on: it meets nothing here.
            let ends = !self.params.goes_on(segments);
            if ends && bsdf.straight_through(wo).is_black() {
                return;
            }
            // Sample a light.
            if !ends {
                let direct = direct_light(scene, &surface, &bsdf, wo, sampler);
                *out.radiance.of_path(prefix.rough + 1, false) += prefix.throughput * direct;
            }
            // Choose the next direction.
            let (u_choice, u, u_roulette) =
                (sampler.next_1d(), sampler.next_2d(), sampler.next_1d());
            let Some(scatter) = bsdf.sample(wo, u_choice, u) else { return };
            if ends && !scatter.null {
                return;
            }
            prefix.throughput *= scatter.weight;
            if !scatter.null {
                segments += 1;
                prefix.last = (!scatter.delta).then_some((surface.p, scatter.pdf_w));
                prefix.rough += u32::from(!scatter.delta);
                prefix.after_delta = scatter.delta;
                prefix.eta_sq *= scatter.eta * scatter.eta;
            }
            // Play Russian roulette with what is left, the squeezing by refraction undone.
            let mut survival = 1.0;
            if segments > self.params.rr_depth {
                survival = (prefix.throughput.max() * prefix.eta_sq).min(MAX_SURVIVAL);
            }
            if u_roulette >= survival {
                return;
            }
            prefix.throughput = prefix.throughput / survival;
            ray = scene.spawn(&surface, scatter.wi);
        }
    }

    /// Light of a surface that the path has met, weighted against having sampled it as a light.
    fn add_emitted(&self, surface: &Surface, wo: Vec3, prefix: &Prefix, out: &mut Components) {
        let scene = self.setting.scene;
        let emitted = scene.emitted(surface, wo);
        if emitted.is_black() {
            return;
        }
        let weight = match prefix.last {
            Some((p, pdf_w)) => emitter_weight(Some(pdf_w), scene.light_pdf_w(p, surface)),
            None => 1.0,
        };
        *out.of_path(prefix.rough, prefix.after_delta) += prefix.throughput * emitted * weight;
    }

    /// Light from infinity, where the path has left the scene.
    fn add_background(&self, d: Vec3, prefix: &Prefix, out: &mut Components) {
        for (radiance, pdf_light) in self.setting.scene.escaped(d) {
            let weight = emitter_weight(prefix.last.map(|(_, pdf_w)| pdf_w), pdf_light);
            *out.of_path(prefix.rough, prefix.after_delta) += prefix.throughput * radiance * weight;
        }
    }
}
