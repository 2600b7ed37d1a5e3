//! Which medium is where, and how much light passes through media.
//!
//! A shape that names a medium for either of its sides is a boundary. A path that crosses it enters the medium of the
//! other side, or none if that side names none. Other shapes do not change the medium. This is Mitsuba's rule.

use crate::medium::MediumId;
use glam::Vec3;

use super::Scene;
use crate::geometry::Surface;
use crate::light::{Light, LightSample};
use crate::math::Rgb;
use crate::medium::{Medium, Tracking};
use crate::ray::Ray;
use crate::sampler::Sampler;

/// Directions in which boundaries are searched. None is along an axis or a diagonal, where scenes have edges.
const LOOK: [Vec3; 8] = [
    Vec3::new(0.31, 0.84, 0.45),
    Vec3::new(-0.42, -0.79, 0.45),
    Vec3::new(0.87, -0.23, 0.43),
    Vec3::new(-0.91, 0.29, -0.30),
    Vec3::new(0.22, 0.27, 0.94),
    Vec3::new(-0.19, -0.33, -0.92),
    Vec3::new(0.61, 0.38, -0.69),
    Vec3::new(-0.57, 0.35, 0.74),
];

impl Scene {
    /// Whether any shape is the boundary of a medium that is not empty.
    #[inline]
    pub fn has_media(&self) -> bool {
        self.has_media
    }

    /// Whether the density of any medium varies.
    #[inline]
    pub fn has_varying_media(&self) -> bool {
        self.has_varying_media
    }

    /// One of [`Scene::media`].
    #[inline]
    pub fn medium(&self, id: MediumId) -> &Medium {
        &self.media[id.index()]
    }

    /// The medium on the side of `surface` that `d` points to. A surface that is not a boundary keeps `current`.
    #[inline]
    pub fn medium_toward(
        &self,
        surface: &Surface,
        d: Vec3,
        current: Option<MediumId>,
    ) -> Option<MediumId> {
        let shape = &self.shapes[surface.shape as usize];
        if !shape.is_boundary() {
            return current;
        }
        if d.dot(surface.ng) > 0.0 { shape.exterior } else { shape.interior }
    }

    /// The medium at `p`: that of the near side of the first visible boundary. `first` is the first direction to look
    /// in. Boundaries behind opaque surfaces count only if no other is visible. Without any boundary there is no
    /// medium.
    pub fn medium_at(&self, p: Vec3, first: Vec3) -> Option<MediumId> {
        if !self.has_media {
            return None;
        }
        let directions = || std::iter::once(first).chain(LOOK).map(Vec3::normalize);
        let look = |through: bool| {
            directions().find_map(|d| {
                let surface = self.first_boundary(Ray::new(p, d), through)?;
                Some(self.medium_toward(&surface, -d, None))
            })
        };
        look(false).or_else(|| look(true)).flatten()
    }

    /// The first boundary along a ray; with `through`, also behind opaque surfaces.
    pub(super) fn first_boundary(&self, mut ray: Ray, through: bool) -> Option<Surface> {
        // A ray that grazes a mesh may hit it very often. Then it finds nothing.
        for _ in 0..256 {
            let (surface, _) = self.intersect(&ray)?;
            if self.shapes[surface.shape as usize].is_boundary() {
                return Some(surface);
            }
            if !through && !self.has_null_at(surface.prim) {
                return None;
            }
            ray = self.spawn(&surface, ray.d);
        }
        None
    }

    /// Find the medium around each light.
    pub(super) fn find_media_round_lights(&mut self) {
        if !self.has_media {
            return;
        }
        let (center, radius) = self.lights.sphere();
        let outside = center + Vec3::new(0.1, 2.0, 0.2) * radius;
        let far = self.medium_at(outside, center - outside);
        let media = self.lights.all().iter().map(|light| match light {
            Light::Area { emitter, shape, .. } => {
                let shape = &self.shapes[*shape as usize];
                if shape.is_boundary() {
                    return shape.exterior;
                }
                let q = emitter.sample_area([0.4, 0.6]);
                let p = self.tree.offset_origin(q.p, q.normal, q.normal);
                self.medium_at(p, q.normal)
            }
            Light::Point { position, .. } => self.medium_at(*position, Vec3::NEG_Y),
            Light::Spot { position, frame, .. } => self.medium_at(*position, frame.n),
            _ => far,
        });
        self.light_media = media.collect();
    }

    /// The medium in which the light of light `light` starts.
    #[inline]
    pub fn medium_round_light(&self, light: usize) -> Option<MediumId> {
        self.light_media.get(light).copied().flatten()
    }

    /// Random numbers for the transmittance of media. Takes one dimension of the sampler if the density of any medium
    /// varies.
    #[inline]
    pub fn tracking(&self, sampler: &mut Sampler) -> Tracking {
        if self.has_varying_media { Tracking::new(sampler.next_2d()) } else { Tracking::none() }
    }

    /// Transmittance of a medium on a part of a ray, whose far end may be infinite.
    #[inline]
    pub(super) fn dimmed(
        &self,
        medium: Option<MediumId>,
        ray: &Ray,
        [from, to]: [f32; 2],
        random: &mut Tracking,
    ) -> Rgb {
        let Some(medium) = medium else { return Rgb::WHITE };
        let length = ray.d.length();
        let (o, d) = (ray.at(from), ray.d / length);
        self.medium(medium).transmittance_along(o, d, (to - from) * length, random)
    }

    /// Fraction of light that passes along a ray segment that starts in `medium`: transmittance of masks, panes and
    /// media. Random if the density of a medium varies.
    pub fn transmittance_through_media(
        &self,
        ray: Ray,
        medium: Option<MediumId>,
        random: &mut Tracking,
    ) -> Rgb {
        self.transmittance_through_media_to(ray, None, medium, random)
    }

    /// The same to a point of the flat primitive `end`, see [`Scene::transmittance_to`].
    pub fn transmittance_through_media_to(
        &self,
        ray: Ray,
        end: Option<u32>,
        medium: Option<MediumId>,
        random: &mut Tracking,
    ) -> Rgb {
        match self.tree.any(&ray) {
            None => self.dimmed(medium, &ray, [ray.tmin, ray.tmax], random),
            Some(prim) if !self.lets_pass(prim, end) => Rgb::BLACK,
            Some(_) => self.transmittance_through::<true>(ray, end, medium, random),
        }
    }

    /// [`Scene::visibility`] for a path that reached `surface` in `medium`.
    pub fn visibility_through_media(
        &self,
        surface: &Surface,
        medium: Option<MediumId>,
        light: &LightSample,
        random: &mut Tracking,
    ) -> Rgb {
        let medium = self.medium_toward(surface, light.wi, medium);
        let ray = match light.p {
            Some(q) => self.tree.shadow_ray(surface.p, surface.ng, q),
            None => self.spawn(surface, light.wi),
        };
        self.transmittance_through_media_to(ray, self.flat_end(light), medium, random)
    }

    /// Fraction of the light of a light sample that reaches the point `p` inside `medium`.
    pub fn visibility_from_within(
        &self,
        p: Vec3,
        medium: Option<MediumId>,
        light: &LightSample,
        random: &mut Tracking,
    ) -> Rgb {
        let ray = match light.p {
            // There is no surface to offset the origin from.
            Some(q) => self.tree.shadow_ray(p, Vec3::ZERO, q),
            None => Ray::new(p, light.wi),
        };
        self.transmittance_through_media_to(ray, self.flat_end(light), medium, random)
    }
}
