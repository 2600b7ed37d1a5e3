//! Light that arrives at a point, and visibility.

use crate::medium::{MediumId, Tracking};
use glam::{Vec2, Vec3};

use super::{Line, Scene};
use crate::bsdf::Transport;
use crate::geometry::{Geometry, Surface};
use crate::light::{Emission, EmitterPoint, Light, LightSample, LightTree, Targets, Vantage};
use crate::math::Rgb;
use crate::ray::{Hit, Ray};

impl Scene {
    /// Radiance that `surface` emits along `wo`.
    #[inline]
    pub fn emitted(&self, surface: &Surface, wo: Vec3) -> Rgb {
        match &self.shapes[surface.shape as usize].emission {
            Some(emission) if wo.dot(surface.ng) > 0.0 => emission.eval(surface.uv),
            _ => Rgb::BLACK,
        }
    }

    /// Radiance from all lights at infinity along `-d`.
    pub fn background(&self, d: Vec3) -> Rgb {
        self.lights.distant().map(|(_, light)| light.escaped(d).0).sum()
    }

    /// For each light at infinity, its radiance along `-d`, and the density per solid angle with which
    /// [`Scene::sample_light`] samples that direction.
    pub fn escaped(&self, d: Vec3) -> impl Iterator<Item = (Rgb, f32)> {
        self.escaped_from(None, d)
    }

    /// [`Scene::escaped`] with the densities of [`Scene::aim_at_light`]; those of [`Scene::sample_light`] without a
    /// point.
    #[inline]
    pub(crate) fn escaped_from(
        &self,
        at: Option<Vantage<'_>>,
        d: Vec3,
    ) -> impl Iterator<Item = (Rgb, f32)> {
        self.lights.distant().map(move |(k, light)| {
            let (radiance, pdf_w) = light.escaped(d);
            let probability = match &at {
                Some(at) => self.lights.probability_for(at, k),
                None => self.lights.probability(k),
            };
            (radiance, pdf_w * probability)
        })
    }

    /// The tree that chooses lights for a point. It is built at the first call, in parallel: do not call it in the
    /// parallel part of a pass.
    pub fn light_tree(&self) -> &LightTree {
        self.lights.tree(&self.shapes)
    }

    /// A copy of [`Scene::light_tree`] that learns during rendering which lights reach which part of the scene.
    pub fn learning_light_tree(&self) -> LightTree {
        self.lights.learning_tree(&self.shapes)
    }

    /// The tree that chooses lights for a point, if there are so many lights that it is better than power.
    #[inline]
    pub fn tree_of_many_lights(&self) -> Option<&LightTree> {
        self.lights.tree_of_many()
    }

    /// Sample light that arrives at `p`, without visibility. `u` chooses the light, by power, and the point on it.
    #[inline]
    pub fn sample_light(&self, p: Vec3, u: [f32; 2]) -> Option<LightSample> {
        let sample = self.aim_at_light(&Vantage::new(None, p), u)?;
        let radiance = sample.radiance * self.looked_up(&sample);
        Some(LightSample { radiance, map: None, ..sample })
    }

    /// Sample light that arrives at a point, without visibility. [`Scene::looked_up`] is still a factor on the radiance:
    /// most light samples are occluded, and a lookup in a large environment map waits for memory.
    #[inline]
    pub(crate) fn aim_at_light(&self, at: &Vantage, u: [f32; 2]) -> Option<LightSample> {
        let (light, probability, u0) = self.lights.choose_for(at, u)?;
        let emission = |s, k, point: &EmitterPoint| self.emission_at(s, k, point);
        let mut sample = self.lights.sample_light(light, at.p, [u0, u[1]], emission);
        if let Some(sample) = &mut sample {
            sample.pdf_w *= probability;
        }
        sample
    }

    /// Factor on the radiance of a sample from [`Scene::aim_at_light`].
    #[inline]
    pub(crate) fn looked_up(&self, sample: &LightSample) -> Rgb {
        self.lights.looked_up(sample)
    }

    /// Density per solid angle at `p` with which [`Scene::sample_light`] samples the emitting point `surface`.
    #[inline]
    pub fn light_pdf_w(&self, p: Vec3, surface: &Surface) -> f32 {
        self.light_pdf_w_from(&Vantage::new(None, p), surface)
    }

    /// The same for [`Scene::aim_at_light`].
    #[inline]
    pub(crate) fn light_pdf_w_from(&self, at: &Vantage, surface: &Surface) -> f32 {
        let Some(k) = self.light_at(surface) else { return 0.0 };
        match &self.lights.all()[k] {
            Light::Area { emitter, .. } => {
                self.lights.probability_for(at, k) * emitter.pdf_w(at.p, surface.p, surface.ng)
            }
            _ => 0.0,
        }
    }

    /// Index of the light that `surface` belongs to.
    #[inline]
    pub fn light_at(&self, surface: &Surface) -> Option<usize> {
        let primitive = surface.prim - self.first_primitive(surface.shape as usize);
        self.lights.of_primitive(surface.shape, primitive)
    }

    /// Begin a light path, see [`Emission`].
    pub fn emit(&self, u_light: f32, u_p: [f32; 2], u_d: [f32; 2]) -> Option<Emission> {
        self.lights.emit(u_light, u_p, u_d, |s, k, point| self.emission_at(s, k, point))
    }

    /// Begin a light path at a light that the caller chose, with the caller's probability.
    pub fn emit_from(
        &self,
        chosen: (usize, f32),
        u_p: [f32; 2],
        u_d: [f32; 2],
    ) -> Option<Emission> {
        self.lights.emit_from(chosen, u_p, u_d, |s, k, point| self.emission_at(s, k, point))
    }

    /// Begin a light path toward targets, see [`Targets`].
    pub fn emit_toward(
        &self,
        targets: &Targets,
        u_light: f32,
        u_p: [f32; 2],
        u_d: [f32; 2],
    ) -> Option<Emission> {
        let emission = |s, k, point: &EmitterPoint| self.emission_at(s, k, point);
        self.lights.emit_toward(targets, u_light, u_p, u_d, emission)
    }

    /// Targets that aim most light paths from infinity at weighted points: where light should be scattered first, and
    /// where it should end. Every light path can still be sampled. `None` without such points, or without lights at
    /// infinity.
    pub fn around(&self, points: [Vec<(Vec3, f32)>; 2]) -> Option<Targets> {
        Targets::around(points, &self.lights)
    }

    /// Radiance of an emitting primitive at one of its points.
    #[inline]
    fn emission_at(&self, shape: u32, primitive: u32, point: &EmitterPoint) -> Rgb {
        match &self.shapes[shape as usize].emission {
            Some(emission) if emission.is_constant() => emission.eval(Vec2::ZERO),
            Some(emission) => emission.eval(self.texture_coordinates(shape, primitive, point)),
            None => Rgb::BLACK,
        }
    }

    /// Fraction of the light of a light sample that reaches `surface`.
    #[inline(always)]
    pub fn visibility(&self, surface: &Surface, light: &LightSample) -> Rgb {
        let ray = match light.p {
            Some(q) => self.tree.shadow_ray(surface.p, surface.ng, q),
            None => self.spawn(surface, light.wi),
        };
        self.transmittance_to(ray, self.flat_end(light))
    }

    /// Whether a ray from `from` to the surface point `to` meets no other surface first, not even one that light passes straight
    /// through.
    #[inline]
    pub fn sees(&self, from: &Surface, to: &Surface) -> bool {
        let ray = self.tree.shadow_ray(from.p, from.ng, to.p);
        match self.tree.any(&ray) {
            None => true,
            Some(prim) if Some(prim) != self.flat_at(to) => false,
            Some(prim) => self.tree.closest(&ray).is_none_or(|hit| hit.prim == prim),
        }
    }

    /// Fraction of light that passes along a ray segment: 0 or 1, or the transmittance of masks and panes.
    #[inline]
    pub fn transmittance(&self, ray: Ray) -> Rgb {
        self.transmittance_to(ray, None)
    }

    /// [`Scene::transmittance`] to a point of the flat primitive `end`, which is ignored: it cannot occlude its own
    /// point, but rounding makes it seem so for slivers, whose hit points are inaccurate along their length.
    #[inline(always)]
    pub fn transmittance_to(&self, ray: Ray, end: Option<u32>) -> Rgb {
        match self.tree.any(&ray) {
            None => Rgb::WHITE,
            // Any hit is sufficient: an opaque one ends the search.
            Some(prim) if !self.lets_pass(prim, end) => Rgb::BLACK,
            Some(_) => self.transmittance_through::<false>(ray, end, None, &mut Tracking::none()),
        }
    }

    /// Whether a hit emits light, or scatters it by a delta lobe.
    pub(crate) fn may_shine(&self, hit: &Hit) -> bool {
        let shape = &self.shapes[self.primitives.all[hit.prim as usize].shape as usize];
        let material = &self.materials[shape.material];
        shape.emission.is_some() || material.has_delta || material.has_null
    }

    /// Whether light may pass straight through a primitive.
    pub(super) fn has_null_at(&self, prim: u32) -> bool {
        self.materials[self.shapes[self.primitives.all[prim as usize].shape as usize].material]
            .has_null
    }

    /// Whether a segment that ends on the primitive `end` continues past a hit of `prim`.
    #[inline]
    pub(super) fn lets_pass(&self, prim: u32, end: Option<u32>) -> bool {
        self.has_null && self.has_null_at(prim) || Some(prim) == end
    }

    /// The primitive of a light sample, if it is flat.
    #[inline]
    pub(super) fn flat_end(&self, light: &LightSample) -> Option<u32> {
        let [shape, primitive] = light.primitive?;
        self.flat_primitive(shape, primitive)
    }

    /// The index of a shape's primitive, counted through all shapes, if the primitive is flat.
    #[inline]
    fn flat_primitive(&self, shape: u32, primitive: u32) -> Option<u32> {
        let flat = matches!(self.shapes[shape as usize].geometry, Geometry::Mesh(_));
        flat.then(|| self.first_primitive(shape as usize) + primitive)
    }

    /// The flat primitive of light `light`, see [`Scene::transmittance_to`].
    pub fn flat_light(&self, light: u32) -> Option<u32> {
        match &self.lights.all()[light as usize] {
            Light::Area { shape, primitive, .. } => self.flat_primitive(*shape, *primitive),
            _ => None,
        }
    }

    /// The flat primitive that contains `surface`, see [`Scene::transmittance_to`]. `None` in instances, because their
    /// primitives are at several places.
    pub fn flat_at(&self, surface: &Surface) -> Option<u32> {
        let shape = &self.shapes[surface.shape as usize];
        let flat = matches!(shape.geometry, Geometry::Mesh(_));
        (flat && surface.instance == Hit::NO_INSTANCE).then_some(surface.prim)
    }

    /// Transmittance along a segment that starts in `medium` and ends on the primitive `end`: of surfaces that light
    /// passes straight through, and with `MEDIA` also of media.
    pub(super) fn transmittance_through<const MEDIA: bool>(
        &self,
        mut ray: Ray,
        end: Option<u32>,
        mut medium: Option<MediumId>,
        random: &mut Tracking,
    ) -> Rgb {
        let length = ray.d.length();
        let toward = -ray.d / length;
        let (mut left, mut passed) = (Rgb::WHITE, ray.tmin);
        let mut line = Line::default();
        while let Some(hit) = self.closest_on(&mut line, &ray, ray.tmax) {
            if !self.lets_pass(hit.prim, end) || !line.cross() {
                return Rgb::BLACK;
            }
            if Some(hit.prim) != end {
                let surface = self.surface(&ray, &hit);
                left *= self.bsdf(&surface, toward, Transport::Radiance).straight_through(toward);
                if MEDIA {
                    left *= self.dimmed(medium, &ray, [passed, hit.t], random);
                    medium = self.medium_toward(&surface, ray.d, medium);
                    passed = hit.t;
                }
                if left.is_black() {
                    return Rgb::BLACK;
                }
            }
            ray = self.tree.beyond(&ray, hit.t);
        }
        if MEDIA {
            left * self.dimmed(medium, &ray, [passed, ray.tmax.max(passed)], random)
        } else {
            left
        }
    }
}
