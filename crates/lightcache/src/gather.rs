//! Making a record: rays over the hemisphere of a point [slides 7, 9, 10].

use std::f32::consts::PI;

use gi_core::eye::{Estimate, EyeVertex, EyeWalk, GatherRay, PathLimits};
use gi_core::geometry::Surface;
use gi_core::math::Frame;
use gi_core::rng::{bits_to_unit, hash_u32, hash_words};
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use glam::Vec3;

use crate::control::Control;
use crate::gradients::{rotational, translational};
use crate::hemisphere::{Hemisphere, Seen, Strata};
use crate::record::Record;
use crate::site::{Query, RELAXED, Site};

/// A point that needs a record.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The point.
    pub surface: Surface,
    /// Unit normal for irradiance.
    pub n: Vec3,
    /// Number of segments of the path from the eye.
    pub segments: u32,
    /// Length of that path, world.
    pub length: f32,
    /// Selects the random numbers of the record's rays. It differs between places, except on both sides of a straight
    /// passage.
    pub key: u32,
}

impl Place {
    /// The lookup at this place.
    pub fn query(&self) -> Query {
        Query { p: self.surface.p, n: self.n }
    }
}

/// Settings for making the records of one cache.
#[derive(Clone, Copy)]
pub struct Gatherer<'a> {
    /// The world.
    pub scene: &'a Scene,
    /// How long paths may be.
    pub limits: PathLimits,
    /// Seed of all random numbers.
    pub seed: u32,
    /// How hemispheres are divided.
    pub strata: Strata,
    /// How the region of validity is chosen.
    pub control: Control,
    /// Smallest and largest radius of a record, as a fraction of the length of the path to it.
    pub spacing: [f32; 2],
}

impl<'a> Gatherer<'a> {
    /// Make the record of a place. `estimate` gives the light at the vertices of gather rays; where it gives none, they
    /// continue as paths.
    pub fn record(
        &self,
        place: &Place,
        estimate: &mut impl FnMut(&EyeVertex<'a>) -> Option<Estimate>,
    ) -> Record {
        let (frame, h) = self.look(place, estimate);
        self.record_of(place, &frame, &h)
    }

    /// The light that rays from a place find, and the frame of their directions.
    pub fn look(
        &self,
        place: &Place,
        estimate: &mut impl FnMut(&EyeVertex<'a>) -> Option<Estimate>,
    ) -> (Frame, Hemisphere) {
        let frame = self.frame(place);
        let h = self.hemisphere(place, &frame, estimate);
        (frame, h)
    }

    /// The irradiance record of a hemisphere.
    pub fn record_of(&self, place: &Place, frame: &Frame, h: &Hemisphere) -> Record {
        let e = h.irradiance();
        let calm = h.without_sparks();
        let gradient = translational(&calm);
        let scene = self.scene.radius();
        // Distant parts of a large scene must not make records near the eye coarser.
        let unit = scene.min(place.length);
        let validity = self.control.validity(&calm, calm.irradiance(), &gradient, unit);
        let [least, most] = if self.control.has_limits() {
            self.spacing.map(|s| (s * place.length).min(scene))
        } else {
            [0.0, scene]
        };
        let radii = validity.radii.map(|r| r.min(most).max(least));
        let gradient = gradient.limited(e, RELAXED * radii[0].max(radii[1]));
        let site = Site {
            n: place.n,
            p: place.surface.p,
            radii,
            axis: frame.to_world(validity.axis),
            least,
            clear: h.nearest(),
        };
        let rotational = rotational(h).to_world(frame);
        Record { e, site, rotational, translational: gradient.to_world(frame) }
    }

    /// A frame whose tangents are rotated by a random angle, so that the borders of strata do not align between
    /// records.
    fn frame(&self, place: &Place) -> Frame {
        let angle = 2.0 * PI * bits_to_unit(hash_u32(place.key ^ 0x7475_726e));
        let frame = Frame::from_normal(place.n);
        let (sin, cos) = angle.sin_cos();
        let s = frame.s * cos + frame.t * sin;
        Frame { s, t: place.n.cross(s), n: place.n }
    }

    /// Trace all rays of the hemisphere.
    fn hemisphere(
        &self,
        place: &Place,
        frame: &Frame,
        estimate: &mut impl FnMut(&EyeVertex<'a>) -> Option<Estimate>,
    ) -> Hemisphere {
        let stream = hash_words(&[place.key, 0x6972_7261]);
        let sampler = |i: usize| Sampler::new(self.seed, stream, i as u32);
        let jitter = |i: usize| sampler(i).next_2d();
        Hemisphere::gather(self.strata, jitter, |i, direction| {
            let mut sampler = sampler(i);
            sampler.skip(); // `jitter` used these numbers
            let wi = frame.to_world(direction);
            let ray = self.scene.spawn(&place.surface, wi);
            let (segments, length) = (place.segments + 1, place.length);
            let start = GatherRay { ray, segments, length };
            let mut walk = EyeWalk::along(self.scene, self.limits, start, sampler);
            while let Some(v) = &walk.next_vertex() {
                walk.add_emitted(v);
                if v.wants_estimate()
                    && let Some(estimate) = estimate(v)
                {
                    walk.add_estimate(v, estimate);
                }
                walk.add_direct(v);
                if !walk.scatter(v) {
                    break;
                }
            }
            let found = walk.sample();
            // With a bent normal, rays may go below the surface. What they hit there says nothing about the
            // surroundings.
            let beneath = wi.dot(place.surface.ng) * place.n.dot(place.surface.ng) <= 0.0;
            let distance = if found.depth > 0.0 && !beneath { found.depth } else { f32::INFINITY };
            Seen {
                direction,
                radiance: found.radiance.indirect,
                distance,
                normal: frame.to_local(found.normal),
            }
        })
    }
}
