//! The overture: filling both caches before the picture, from coarse to fine.

use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::film::Show;
use gi_core::math::Rgb;
use gi_core::progress;
use gi_core::rng::hash_words;
use gi_core::technique::Setting;
use lightcache::control::{Control, ErrorControl};
use lightcache::fill::{coarse_to_fine, in_rounds};
use lightcache::gather::{Gatherer, Place};
use lightcache::hemisphere::Strata;
use lightcache::options::ReachOptions;
use lightcache::record::Record;
use rayon::prelude::*;

use crate::params::Params;
use crate::record::RadianceRecord;
use crate::surfaces::Rule;
use crate::{Caches, RadianceCaching};

/// A place that no record is good for, and which kind it wants.
struct Missing {
    place: Place,
    glossy: bool,
}

/// A record of either kind.
enum Made {
    Diffuse(Record),
    Glossy(RadianceRecord),
}

impl<'a> RadianceCaching<'a> {
    /// How irradiance records are made, and radiance records.
    pub(crate) fn gatherers(&self) -> [Gatherer<'a>; 2] {
        let Params { rays, glossy_rays, error, glossy_error, .. } = self.params;
        let Params { accuracy, glossy_accuracy, .. } = self.params;
        [
            self.gatherer(rays, error, accuracy),
            self.gatherer(glossy_rays, glossy_error, glossy_accuracy),
        ]
    }

    fn gatherer(&self, rays: u32, error: ErrorControl, accuracy: f32) -> Gatherer<'a> {
        let Params { radius, reach, limits, .. } = self.params;
        let ReachOptions { min_spacing, max_spacing, .. } = reach;
        let Setting { scene, seed, camera, .. } = self.setting;
        let pixel = camera.pixel_width();
        let most = if max_spacing > 0.0 { max_spacing * pixel } else { f32::INFINITY };
        Gatherer {
            scene,
            limits,
            seed,
            strata: Strata::of(rays),
            control: Control { error, radius, accuracy },
            spacing: [min_spacing * pixel, most],
        }
    }

    /// Look at every pixel from coarse to fine.
    pub(crate) fn overture(&mut self) {
        let order = coarse_to_fine(self.setting.camera.size());
        let mut caches = std::mem::take(&mut self.caches).expect("caches");
        let [diffuse, glossy] = self.gatherers();
        let (basis, functions) = (self.params.basis, self.surfaces.order());
        let make = |missing: &Missing| {
            let place = &missing.place;
            if !missing.glossy {
                return Made::Diffuse(diffuse.record(place, &mut |v| self.with_focused(None, v)));
            }
            let (frame, h) = glossy.look(place, &mut |v| self.with_focused(None, v));
            let irradiance = glossy.record_of(place, &frame, &h);
            Made::Glossy(RadianceRecord::new(irradiance, &frame, &h, basis, functions))
        };
        progress::begin(progress::SEARCHED, order.len() as u64);
        in_rounds(
            &mut caches,
            order.len(),
            |caches, k| {
                progress::advance(1);
                self.missing_in_pixel(caches, order[k])
            },
            |caches, missing| {
                let made: Vec<Made> = missing.par_iter().with_max_len(1).map(make).collect();
                for record in made {
                    match record {
                        Made::Diffuse(record) => caches.diffuse.insert(record),
                        Made::Glossy(record) => caches.glossy.insert(record),
                    }
                }
            },
        );
        self.caches = Some(caches);
    }

    /// Where the path through a pixel asks for what no record is good for. It is the path of the first pass.
    fn missing_in_pixel(&self, caches: &Caches, [x, y]: [u32; 2]) -> Vec<Missing> {
        let setting = Setting { show: Show::Indirect, ..self.setting };
        let stream = y * setting.camera.size()[0] as u32 + x;
        let pixel = [x as usize, y as usize];
        let mut missing = Vec::new();
        let mut walk = EyeWalk::through_pixel(&setting, self.params.limits, pixel, 0);
        while let Some(v) = &walk.next_vertex() {
            if v.wants_estimate() {
                let key = hash_words(&[stream, v.segments, v.non_delta]);
                if let Some(estimate) = self.note_missing(caches, v, key, &mut missing) {
                    walk.add_estimate(v, estimate);
                }
            }
            walk.skip_direct(v);
            if !walk.scatter(v) {
                break;
            }
        }
        missing
    }

    /// Note the place of `v` if no record is good enough for it. The estimate that is returned ends the path.
    fn note_missing(
        &self,
        caches: &Caches,
        v: &EyeVertex,
        key: u32,
        missing: &mut Vec<Missing>,
    ) -> Option<Estimate> {
        if !self.is_for_cache(v) {
            return None;
        }
        let (covers, n) = match self.surfaces.rule(v) {
            Rule::Path => return None,
            Rule::Diffuse(part) => (Covers::Diffuse(part), part.normal),
            Rule::Glossy { n, .. } => (Covers::NonDelta, n),
        };
        let glossy = matches!(covers, Covers::NonDelta);
        let place = Place { surface: v.surface, n, segments: v.segments, length: v.length, key };
        let found = if glossy {
            caches.glossy.has(&place.query(), |site| self.sees(site, &place.query()))
        } else {
            caches.diffuse.has(&place.query(), |site| self.sees(site, &place.query()))
        };
        if !found {
            missing.push(Missing { place, glossy });
        }
        Some(Estimate { covers, indirect: Rgb::BLACK, direct: None, caustic: None })
    }
}
