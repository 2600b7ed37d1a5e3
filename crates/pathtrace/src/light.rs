//! Paths from the lights.

use gi_core::camera::Connection;
use gi_core::eye::EyeWalk;
use gi_core::film::{Components, Film, Sample};
use gi_core::filter::FilterTable;
use gi_core::light::Light;
use gi_core::math::Rgb;
use gi_core::medium::MediumId;
use gi_core::options::SurfaceLayers;
use gi_core::sampler::Sampler;
use gi_core::walk::{LightEvent, LightVertex, LightWalk, MediumVertex, Roulette, walk_in_order};
use glam::Vec3;

use crate::PathTracer;
use crate::to_camera::{project, transmittance};

/// Number of paths per task. The splats of all tasks are joined in order.
const CHUNK: u32 = 4096;

/// Light that falls on a pixel.
struct Splat {
    pixel: u32,
    non_delta: u32,
    after_delta: bool,
    power: Rgb,
}

impl PathTracer<'_> {
    /// As many light paths as there are pixels; every vertex is connected to the eye.
    pub(crate) fn light_pass(&mut self, index: u32, film: &mut Film) {
        let [w, h] = film.size();
        let filter = film.filter();
        let paths = (w * h) as u32;
        let chunks = walk_in_order(paths, CHUNK, |path, splats| {
            self.light_path(index, path, filter, splats);
        });
        // Add in the order of the paths: the sums do not depend on the number of threads.
        let mut picture = vec![Components::default(); w * h];
        for splat in chunks.iter().flatten() {
            *picture[splat.pixel as usize].of_path(splat.non_delta, splat.after_delta) +=
                splat.power * (1.0 / paths as f32);
        }
        let medium = self.setting.camera_medium();
        film.add_unfiltered(|[x, y]| {
            let mut sample = self.look([x, y], index, medium);
            let light = &picture[y * w + x];
            sample.radiance.direct += light.direct;
            sample.radiance.indirect += light.indirect;
            sample.radiance.caustic += light.caustic;
            sample
        });
        self.light_paths += u64::from(paths);
    }

    /// Walk one path and connect its vertices.
    fn light_path(&self, pass: u32, path: u32, filter: &FilterTable, splats: &mut Vec<Splat>) {
        let scene = self.setting.scene;
        // Each pass is a stream; within a stream, paths are the points of a sequence.
        let sampler = Sampler::new(self.setting.seed ^ 0x6c69_6768, pass, path);
        let Some(mut walk) = LightWalk::begin(scene, sampler) else { return };
        walk.use_media();
        let roulette = Roulette::ByAlbedo { from: self.params.limits.rr_depth };
        // Seen directly: connect the point on the light itself.
        let emission = *walk.emission();
        if let Light::Area { .. } = &scene.lights().all()[emission.light as usize]
            && let Some((c, pixel)) = self.connect(emission.p, filter, walk.sampler())
        {
            // The power of a cosine-distributed direction is pi times radiance per density of the point.
            let radiance = emission.power * std::f32::consts::FRAC_1_PI;
            let power = radiance * (c.wi.dot(emission.ng).max(0.0) * c.importance);
            let power = if power.is_black() {
                power
            } else {
                power * {
                    let (medium, sampler) = (walk.medium(), walk.sampler());
                    self.visibility((emission.p, emission.ng), medium, &c, sampler)
                }
            };
            splats.push(Splat { pixel, non_delta: 0, after_delta: false, power });
        }
        while let Some(event) = &walk.next_event() {
            // Segments from the light to here; the connection would be one more.
            if !self.params.limits.goes_on(event.depth() + 1) {
                return;
            }
            let goes_on = match event {
                LightEvent::Surface(vertex) => {
                    if !vertex.bsdf.is_delta() {
                        self.connect_surface(vertex, filter, walk.sampler(), splats);
                    }
                    walk.scatter(vertex, roulette)
                }
                LightEvent::Medium(vertex) => {
                    self.connect_within(vertex, filter, walk.sampler(), splats);
                    walk.scatter_within(vertex, roulette)
                }
            };
            if !goes_on {
                return;
            }
        }
    }

    fn connect_surface(
        &self,
        vertex: &LightVertex,
        filter: &FilterTable,
        sampler: &mut Sampler,
        splats: &mut Vec<Splat>,
    ) {
        let Some((c, pixel)) = self.connect(vertex.surface.p, filter, sampler) else { return };
        let f_cos = vertex.bsdf.f_cos(vertex.wo, c.wi);
        let power = vertex.power * f_cos * c.importance;
        if !power.is_black() {
            let medium = self.setting.scene.medium_toward(&vertex.surface, c.wi, vertex.medium);
            let power =
                power * self.visibility((vertex.surface.p, vertex.surface.ng), medium, &c, sampler);
            splats.push(Splat {
                pixel,
                non_delta: vertex.non_delta + 1,
                after_delta: vertex.after_delta,
                power,
            });
        }
    }

    /// Connect a point of a medium: the phase function is the fraction of the scattered power per solid angle toward
    /// the eye.
    fn connect_within(
        &self,
        vertex: &MediumVertex,
        filter: &FilterTable,
        sampler: &mut Sampler,
        splats: &mut Vec<Splat>,
    ) {
        let Some((c, pixel)) = self.connect(vertex.p, filter, sampler) else { return };
        let phase = self.setting.scene.medium(vertex.medium).phase.eval(vertex.wo, c.wi);
        // A point in a medium needs no ray offset.
        let left = self.visibility((vertex.p, Vec3::ZERO), Some(vertex.medium), &c, sampler);
        splats.push(Splat {
            pixel,
            non_delta: vertex.non_delta + 1,
            after_delta: vertex.after_delta,
            power: vertex.power * left * (phase * c.importance),
        });
    }
}

impl PathTracer<'_> {
    /// Connect a point to the camera: returns the connection and the pixel. The importance includes the weight of the
    /// filter.
    fn connect(
        &self,
        p: Vec3,
        filter: &FilterTable,
        sampler: &mut Sampler,
    ) -> Option<(Connection, u32)> {
        let (mut c, pixel, weight) = project(self.setting.camera, p, filter, sampler)?;
        c.importance *= weight;
        Some((c, pixel))
    }

    /// Transmittance from a point in `medium` to the camera.
    fn visibility(
        &self,
        (p, ng): (Vec3, Vec3),
        medium: Option<MediumId>,
        c: &Connection,
        sampler: &mut Sampler,
    ) -> Rgb {
        let scene = self.setting.scene;
        let mut random = scene.tracking(sampler);
        transmittance(scene, scene.tree().shadow_ray(p, ng, c.end), None, medium, &mut random)
    }

    /// Light that only a path from the eye can find: light from infinity seen directly. Also fills in the layers that
    /// describe a surface. The eye is in `medium`.
    fn look(&self, pixel: [usize; 2], index: u32, medium: Option<MediumId>) -> Sample {
        let eye_path = || EyeWalk::through_pixel(&self.setting, self.params.limits, pixel, index);
        let mut straight = eye_path();
        straight.use_media(medium);
        while let Some(v) = &straight.next_vertex() {
            if !straight.pass_straight(v) {
                break;
            }
        }
        let mut sample = straight.sample();
        if self.setting.surface_layers == SurfaceLayers::NonSpecular {
            describe_behind_mirrors(eye_path(), &mut sample);
        }
        sample
    }
}

/// Fill in the layers from the first surface that is not specular: `walk` follows mirrors and glass to it.
fn describe_behind_mirrors(mut walk: EyeWalk, sample: &mut Sample) {
    while let Some(v) = &walk.next_vertex() {
        if walk.is_described() || !walk.scatter(v) {
            break;
        }
    }
    let Sample { albedo, normal, depth, .. } = walk.sample();
    (sample.albedo, sample.normal, sample.depth) = (albedo, normal, depth);
}
