//! Paths from the eye: at every vertex, all ways to complete the path to a light.

use gi_core::bsdf::Transport;
use gi_core::eye::{EyeEvent, EyeWalk};
use gi_core::film::{Components, Sample};
use gi_core::math::Rgb;
use glam::Vec3;

use super::light_paths::LightVertex;
use super::trail::Trail;
use super::vertex::{Site, Vertex, facing};
use super::weight::{self, Partials};
use super::{Bidirectional, PassPaths};

/// What a way to complete the path has found.
pub(crate) struct Found {
    /// Number of vertices on the light's side, the point on the light included.
    pub(crate) s: u32,
    /// Number of vertices on the eye's side, the point on the lens included.
    pub(crate) t: u32,
    /// Radiance, not weighted.
    pub(crate) radiance: Rgb,
    /// Whether two vertices were merged; both count.
    pub(crate) merged: bool,
    /// Weight among all ways to find the same path.
    pub(crate) weight: f32,
    /// Number of scatterings that are not by delta lobes, and whether delta lobes lie between the last of them and the light:
    /// see [`Components::of_path`].
    pub(crate) kind: (u32, bool),
}

/// Smallest cosine between the normals of two points that are merged.
const SAME_SURFACE: f32 = 0.5;

impl<'a> Bidirectional<'a> {
    /// The sample of a pixel. `paths` are the light paths of the pass. `visit` is called with everything that the path finds.
    pub(crate) fn sample(
        &self,
        pixel: [usize; 2],
        index: u32,
        paths: &PassPaths,
        visit: &mut impl FnMut(&Found),
    ) -> Sample {
        let mut radiance = Components::default();
        let sample = self.eye_path(pixel, index, paths, &mut |found: Found| {
            visit(&found);
            let (non_delta, then_delta) = found.kind;
            *radiance.of_path(non_delta, then_delta) += found.radiance * found.weight;
        });
        Sample { radiance, ..sample }
    }

    /// Walk a path from the eye, and call `add` with everything that it finds. The sample's radiance is of no use.
    fn eye_path(
        &self,
        pixel: [usize; 2],
        index: u32,
        paths: &PassPaths,
        add: &mut impl FnMut(Found),
    ) -> Sample {
        let number = (pixel[1] * self.setting.camera.size()[0] + pixel[0]) as u32;
        // Path and pixel have the same number, if there are enough paths.
        let light_path = paths.light.path(number % self.light_paths);
        let mut walk = EyeWalk::through_pixel(&self.setting, self.limits, pixel, index);
        walk.use_media(self.camera_medium);
        let mut trail = Trail::new(walk.segment().o);
        while let Some(event) = &walk.next_event() {
            let (site, wo) = site_of(event);
            self.add_emitted((site, wo), &walk, &trail, add);
            let vertex = self.eye_vertex((site, wo), &walk, &trail);
            if vertex.connects() && self.limits.goes_on(vertex.segments) {
                self.sample_light(&vertex, &mut walk, add);
                for light in light_path {
                    if self.limits.goes_on(vertex.segments + light.segments()) {
                        self.connect(&vertex, light, add);
                    }
                }
                self.merge(&vertex, paths, add);
            }
            let goes_on = match event {
                EyeEvent::Surface(v) => walk.scatter(v),
                EyeEvent::Medium(v) => walk.scatter_within(v),
            };
            if !goes_on {
                return walk.sample();
            }
            // Passing straight through a surface makes no vertex.
            if walk.segments() > vertex.segments {
                trail.turn(self, &vertex, walk.turned());
            }
        }
        self.add_background(&walk, &trail, add);
        walk.sample()
    }

    /// The vertex that the path has reached.
    fn eye_vertex<'v>(
        &self,
        (site, wo): (Site<'v, 'a>, Vec3),
        walk: &EyeWalk,
        trail: &Trail,
    ) -> Vertex<'v, 'a> {
        let (facing, p) = (facing(site, wo), site.p());
        let partials = trail.reach(&self.ways, facing, p, || {
            let importance = self.setting.camera.importance(-wo, trail.from.distance(p));
            Partials::of_eye(&self.ways, importance, facing)
        });
        Vertex {
            scene: self.setting.scene,
            site,
            transport: Transport::Radiance,
            wo,
            carried: walk.throughput(),
            partials,
            segments: walk.segments(),
            non_delta: trail.non_delta,
        }
    }

    /// The path hits a light (s = 0). Light that the camera sees directly is found in no other way.
    fn add_emitted(
        &self,
        (site, wo): (Site, Vec3),
        walk: &EyeWalk,
        trail: &Trail,
        add: &mut impl FnMut(Found),
    ) {
        let (scene, Site::Surface { surface, .. }) = (self.setting.scene, site) else { return };
        let radiance = walk.throughput() * scene.emitted(surface, wo);
        if radiance.is_black() || walk.source_is_left_out() {
            return;
        }
        let weight = match (&trail.leaving, scene.light_at(surface)) {
            (Some(leaving), Some(light)) => {
                let end = scene.lights().end(light, [surface.p, surface.ng], wo, trail.from);
                weight::hit_light(
                    &self.ways,
                    leaving,
                    &end,
                    trail.non_delta == 1 && !trail.after_delta,
                )
            }
            _ => 1.0,
        };
        let kind = (trail.non_delta, trail.after_delta);
        add(Found { s: 0, t: walk.segments() + 1, radiance, weight, kind, merged: false });
    }

    /// Light from infinity along the next segment (s = 0).
    fn add_background(&self, walk: &EyeWalk, trail: &Trail, add: &mut impl FnMut(Found)) {
        if walk.source_is_left_out() {
            return;
        }
        let scene = self.setting.scene;
        let kind = (trail.non_delta, trail.after_delta);
        for (radiance, pdf_w) in scene.escaped(walk.turned().0) {
            let end = scene.lights().end_at_infinity(pdf_w);
            let direct = trail.non_delta == 1 && !trail.after_delta;
            let weight =
                trail.leaving.map_or(1.0, |l| weight::hit_light(&self.ways, &l, &end, direct));
            let radiance = walk.throughput() * radiance;
            add(Found { s: 0, t: walk.segments() + 1, radiance, weight, kind, merged: false });
        }
    }

    /// Sample a light (s = 1).
    fn sample_light(&self, vertex: &Vertex, walk: &mut EyeWalk, add: &mut impl FnMut(Found)) {
        let (scene, p) = (self.setting.scene, vertex.p());
        let Some(light) = scene.sample_light(p, walk.sampler.next_2d()) else { return };
        let (f_cos, pdf_w) = vertex.f_cos_pdf(light.wi);
        let radiance = vertex.carried * f_cos * light.radiance / light.pdf_w;
        if radiance.is_black() {
            return;
        }
        let radiance = radiance * vertex.visibility(&light);
        let end = scene.lights().end_of_sample(&light, p);
        let joint = vertex.joint(light.wi, 1.0);
        let weight = weight::light_sample(
            &self.ways,
            &vertex.partials,
            &end,
            pdf_w,
            &joint,
            vertex.non_delta == 0,
        );
        let kind = (vertex.non_delta + 1, false);
        add(Found { s: 1, t: vertex.segments + 1, radiance, weight, kind, merged: false });
    }

    /// Connect a vertex of the eye with one of a light path (s > 1, t > 1).
    fn connect(&self, eye: &Vertex, kept: &LightVertex, add: &mut impl FnMut(Found)) {
        let (scene, p) = (self.setting.scene, kept.p());
        let to = p - eye.p();
        let distance_sq = to.length_squared();
        // Points that coincide cannot be connected; merging finds such paths.
        if distance_sq == 0.0 {
            return;
        }
        let d = to / distance_sq.sqrt();
        if kept.faces_away(-d) {
            return;
        }
        let (f_eye, pdf_eye) = eye.f_cos_pdf(d);
        let scattered = eye.carried * f_eye / distance_sq;
        if scattered.is_black() {
            return;
        }
        // The ray first: evaluating the other BSDF costs more.
        let arriving = scattered * eye.transmittance_to(p, d, kept.flat(scene));
        if arriving.is_black() {
            return;
        }
        kept.visit(scene, |light| {
            let (f_light, pdf_light) = light.f_cos_pdf(-d);
            let radiance = arriving * f_light * light.carried;
            if radiance.is_black() {
                return;
            }
            let ours = eye.joint(d, pdf_light / distance_sq);
            let theirs = light.joint(-d, pdf_eye / distance_sq);
            let (eye_side, light_side) = ((&eye.partials, &ours), (&light.partials, &theirs));
            let weight = weight::connection(&self.ways, eye_side, light_side);
            let (s, t) = (light.segments + 1, eye.segments + 1);
            let kind = (eye.non_delta + light.non_delta + 2, false);
            add(Found { s, t, radiance, weight, kind, merged: false });
        });
    }

    /// Merge a vertex of the eye with the photons around it, as in photon mapping.
    fn merge(&self, eye: &Vertex, paths: &PassPaths, add: &mut impl FnMut(Found)) {
        let (Some(photons), Site::Surface { surface, bsdf, .. }) = (&paths.photons, eye.site)
        else {
            return;
        };
        if !eye.merges() {
            return;
        }
        photons.within(surface.p, self.radius, |_, photon, _| {
            // The two points become one.
            if !self.limits.goes_on(eye.segments + photon.segments - 1) {
                return;
            }
            // Both sides agree, and both points are on the same surface.
            let sides = (photon.wi.dot(photon.ng) * photon.wi.dot(surface.ng)).signum();
            if photon.ng.dot(surface.ng) * sides < SAME_SURFACE {
                return;
            }
            let radiance = eye.carried * bsdf.f(eye.wo, photon.wi) * photon.power;
            if radiance.is_black() {
                return;
            }
            let radiance = radiance / self.ways.merges;
            let (forward, backward) = (bsdf.pdf_w(eye.wo, photon.wi), eye.reverse_pdf_w(photon.wi));
            let partials = [&eye.partials, &photon.partials];
            let direct = eye.non_delta == 0 && photon.segments == 1;
            let weight = weight::merging(&self.ways, partials, [forward, backward], direct);
            let kind = (eye.non_delta + 1 + photon.kind.0, photon.kind.1);
            let (s, t) = (photon.segments + 1, eye.segments + 1);
            add(Found { s, t, radiance, weight, kind, merged: true });
        });
    }
}

/// Where an event of the walk is, and the direction back along the path.
fn site_of<'v, 'a>(event: &'v EyeEvent<'a>) -> (Site<'v, 'a>, Vec3) {
    match event {
        EyeEvent::Surface(v) => {
            let (surface, bsdf, medium) = (&v.surface, &v.bsdf, v.medium);
            (Site::Surface { surface, bsdf, medium }, v.wo)
        }
        EyeEvent::Medium(v) => (Site::Medium { p: v.p, medium: v.medium }, v.wo),
    }
}
