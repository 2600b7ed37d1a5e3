//! The prepass: fills both caches before the picture, from the coarse pixels to the fine ones.
//!
//! A path goes through each pixel. Where no record is valid at its vertex, a record is made there.

use gi_core::caustics::FocusedLight;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::film::Show;
use gi_core::math::Rgb;
use gi_core::progress;
use gi_core::rng::hash_words;
use gi_core::technique::Setting;
use lightcache::control::{Control, ErrorControl};
use lightcache::fill::{coarse_to_fine, in_rounds};
use lightcache::gather::{Gatherer, Place};
use lightcache::guard::LeakGuard;
use lightcache::hemisphere::Strata;
use lightcache::options::ReachOptions;
use lightcache::record::Record;
use rayon::prelude::*;

use crate::caches::Caches;
use crate::params::Params;
use crate::record::RadianceRecord;
use crate::surfaces::{Rule, Surfaces};

/// Settings for making the records of both caches.
pub(crate) struct Gatherers<'a> {
    pub(crate) diffuse: Gatherer<'a>,
    pub(crate) glossy: Gatherer<'a>,
}

impl<'a> Gatherers<'a> {
    pub(crate) fn new(setting: &Setting<'a>, params: &Params) -> Self {
        let Params { reach, limits, radius, .. } = *params;
        let ReachOptions { min_spacing, max_spacing, .. } = reach;
        let pixel = setting.camera.pixel_width();
        let largest = if max_spacing > 0.0 { max_spacing * pixel } else { f32::INFINITY };
        let gatherer = |rays: u32, error: ErrorControl, accuracy: f32| Gatherer {
            scene: setting.scene,
            limits,
            seed: setting.seed,
            strata: Strata::of(rays),
            control: Control { error, radius, accuracy },
            spacing: [min_spacing * pixel, largest],
        };
        Gatherers {
            diffuse: gatherer(params.rays, params.error, params.accuracy),
            glossy: gatherer(params.glossy_rays, params.glossy_error, params.glossy_accuracy),
        }
    }
}

/// A place without a valid record.
struct Uncovered {
    place: Place,
    /// Whether it needs a radiance record.
    glossy: bool,
}

/// A record for one of the caches.
enum NewRecord {
    Diffuse(Record),
    Glossy(RadianceRecord),
}

/// Fills the caches. It borrows all settings.
pub(crate) struct Filler<'s, 'a> {
    pub(crate) setting: &'s Setting<'a>,
    pub(crate) params: &'s Params,
    pub(crate) surfaces: &'s Surfaces,
    /// Photons of light that mirrors and glass focus.
    pub(crate) focused: &'s FocusedLight,
    pub(crate) guard: LeakGuard<'a>,
}

impl Filler<'_, '_> {
    /// Fill both caches: look at every pixel from coarse to fine, and make records where none is valid.
    pub(crate) fn fill(&self, mut caches: Caches) -> Caches {
        let order = coarse_to_fine(self.setting.camera.size());
        progress::begin(progress::SEARCHED, order.len() as u64);
        let gatherers = Gatherers::new(self.setting, self.params);
        let make = |uncovered: &Uncovered| self.make_record(&gatherers, uncovered);
        in_rounds(
            &mut caches,
            order.len(),
            |caches, k| {
                progress::advance(1);
                self.uncovered_in_pixel(caches, order[k])
            },
            |caches, uncovered| {
                let made: Vec<_> = uncovered.par_iter().with_max_len(1).map(make).collect();
                for record in made {
                    match record {
                        NewRecord::Diffuse(record) => caches.diffuse.insert(record),
                        NewRecord::Glossy(record) => caches.glossy.insert(record),
                    }
                }
            },
        );
        caches
    }

    fn make_record(&self, gatherers: &Gatherers, uncovered: &Uncovered) -> NewRecord {
        let focused =
            |v: &EyeVertex| self.focused.add_to(None, self.setting.scene, v, &self.params.limits);
        let place = &uncovered.place;
        if !uncovered.glossy {
            return NewRecord::Diffuse(gatherers.diffuse.record(place, &mut |v| focused(v)));
        }
        let (frame, h) = gatherers.glossy.look(place, &mut |v| focused(v));
        let irradiance = gatherers.glossy.record_of(place, &frame, &h);
        let (basis, order) = (self.params.basis, self.surfaces.order());
        NewRecord::Glossy(RadianceRecord::new(irradiance, &frame, &h, basis, order))
    }

    /// Places without a valid record on the path through a pixel. It is the path of the first pass.
    fn uncovered_in_pixel(&self, caches: &Caches, [x, y]: [u32; 2]) -> Vec<Uncovered> {
        let setting = Setting { show: Show::Indirect, ..*self.setting };
        let stream = y * setting.camera.size()[0] as u32 + x;
        let pixel = [x as usize, y as usize];
        let mut uncovered = Vec::new();
        let mut walk = EyeWalk::through_pixel(&setting, self.params.limits, pixel, 0);
        while let Some(v) = &walk.next_vertex() {
            if v.wants_estimate() {
                let key = hash_words(&[stream, v.segments, v.non_delta]);
                if let Some(estimate) = self.visit(caches, v, key, &mut uncovered) {
                    walk.add_estimate(v, estimate);
                }
            }
            walk.skip_direct(v);
            if !walk.scatter(v) {
                break;
            }
        }
        uncovered
    }

    /// Add the place of `v` to `uncovered` if no record is valid there. The black estimate that is returned ends the
    /// path for the lobes that the record covers.
    fn visit(
        &self,
        caches: &Caches,
        v: &EyeVertex,
        key: u32,
        uncovered: &mut Vec<Uncovered>,
    ) -> Option<Estimate> {
        if !self.params.covers_depth(v.segments) {
            return None;
        }
        let (covers, n) = match self.surfaces.rule(v) {
            Rule::Path => return None,
            Rule::Diffuse(part) => (Covers::Diffuse(part), part.normal),
            Rule::Glossy { n, .. } => (Covers::NonDelta, n),
        };
        let glossy = matches!(covers, Covers::NonDelta);
        let place = Place { surface: v.surface, n, segments: v.segments, length: v.length, key };
        let q = place.query();
        let is_covered = if glossy {
            caches.glossy.has_valid(&q, |site| self.guard.passes(site, &q))
        } else {
            caches.diffuse.has_valid(&q, |site| self.guard.passes(site, &q))
        };
        if !is_covered {
            uncovered.push(Uncovered { place, glossy });
        }
        Some(Estimate { covers, indirect: Rgb::BLACK, direct: None, caustic: None })
    }
}
