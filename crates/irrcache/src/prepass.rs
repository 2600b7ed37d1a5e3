//! The prepass: fills the caches before the picture, from the coarse pixels to the fine ones.
//!
//! A path goes through each pixel. Where no record is valid at its vertex, a record is made there. With several cache
//! levels, the gather rays of that record are traced first: where they find no valid record in the next level, records
//! are made there beforehand.

use gi_core::bsdf::DiffusePart;
use gi_core::caustics::FocusedLight;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::film::Show;
use gi_core::math::Rgb;
use gi_core::progress;
use gi_core::rng::hash_words;
use gi_core::technique::Setting;
use lightcache::control::Control;
use lightcache::fill::{coarse_to_fine, in_rounds, scattered};
use lightcache::gather::{Gatherer, Place};
use lightcache::guard::LeakGuard;
use lightcache::hemisphere::Strata;
use lightcache::options::ReachOptions;
use lightcache::record::Record;
use lightcache::{Cache, Weighing};
use rayon::prelude::*;

use crate::params::Params;

/// Smallest number of gather rays per record in the deeper levels.
const FEWEST_RAYS: u32 = 64;
/// Largest error allowed in the deeper levels.
const COARSEST_ACCURACY: f32 = 0.5;

/// The settings for making the records of a level. A deeper level is seen only through the level before it, so it may
/// be coarser: half the rays, 1.5 times the error, twice the spacing.
pub(crate) fn gatherer<'a>(setting: &Setting<'a>, params: &Params, level: usize) -> Gatherer<'a> {
    let Params { rays, accuracy, reach, .. } = *params;
    let ReachOptions { min_spacing, max_spacing, .. } = reach;
    let pixel = setting.camera.pixel_width();
    let coarser = 2f32.powi(level as i32);
    let largest = if max_spacing > 0.0 { max_spacing * pixel * coarser } else { f32::INFINITY };
    Gatherer {
        scene: setting.scene,
        limits: params.limits,
        seed: setting.seed,
        strata: Strata::of((rays >> level.min(31)).max(FEWEST_RAYS.min(rays))),
        control: Control {
            error: params.error,
            radius: params.radius,
            accuracy: (accuracy * 1.5f32.powi(level as i32)).min(COARSEST_ACCURACY.max(accuracy)),
        },
        spacing: [min_spacing * pixel * coarser, largest],
    }
}

/// Empty caches, one per level.
pub(crate) fn empty_levels(setting: &Setting, params: &Params) -> Vec<Cache<Record>> {
    let empty = |level| {
        let control = gatherer(setting, params, level).control;
        let clamped = params.reach.neighbour_clamping && control.has_limits();
        let slope = clamped.then(|| control.slope());
        let how = Weighing { accuracy: control.accuracy, weights: params.weights, slope };
        Cache::new(setting.scene.bounds(), how)
    };
    (0..params.levels()).map(empty).collect()
}

/// Fills the caches. It borrows all settings; `interpolate` gives the indirect light at a vertex from a cache.
pub(crate) struct Filler<'s, 'a, I> {
    pub(crate) setting: &'s Setting<'a>,
    pub(crate) params: &'s Params,
    /// Photons of light that mirrors and glass focus.
    pub(crate) focused: &'s FocusedLight,
    pub(crate) guard: LeakGuard<'a>,
    pub(crate) interpolate: I,
}

impl<'a, I> Filler<'_, 'a, I>
where
    I: Fn(&Cache<Record>, &EyeVertex) -> Option<Estimate> + Sync,
{
    /// Fill all levels: look at every pixel from coarse to fine, and make records where none is valid.
    pub(crate) fn fill(&self, mut levels: Vec<Cache<Record>>) -> Vec<Cache<Record>> {
        let order = coarse_to_fine(self.setting.camera.size());
        progress::begin(progress::SEARCHED, order.len() as u64);
        let find = |cache: &Cache<Record>, k: usize| {
            progress::advance(1);
            self.uncovered_in_pixel(cache, order[k])
        };
        self.fill_level(&mut levels, 0, order.len(), find);
        levels
    }

    /// Fill the cache of a level in rounds, and before each round the deeper levels with what the round's gather rays
    /// will look up. `find` gives the places without a valid record at one of `points` points.
    fn fill_level(
        &self,
        levels: &mut [Cache<Record>],
        level: usize,
        points: usize,
        find: impl Fn(&Cache<Record>, usize) -> Vec<Place> + Sync,
    ) {
        let (this, deeper) = levels.split_first_mut().expect("a level");
        in_rounds(this, points, find, |this, places| {
            if let Some(next) = deeper.first() {
                let places_seen = |place| self.uncovered_from(next, level + 1, place);
                let wanted: Vec<Place> = places.par_iter().flat_map_iter(places_seen).collect();
                let order = scattered(wanted.len());
                let find: &(dyn Fn(&Cache<Record>, usize) -> Vec<Place> + Sync) = &|cache, k| {
                    let place = wanted[order[k] as usize];
                    if self.is_covered(cache, &place) { Vec::new() } else { vec![place] }
                };
                self.fill_level(deeper, level + 1, wanted.len(), find);
            }
            let next = deeper.first();
            let make = |place| self.make_record(place, level, next);
            let records: Vec<_> = places.par_iter().with_max_len(1).map(make).collect();
            records.into_iter().for_each(|record| this.insert(record));
        });
    }

    /// Make the record of a place. Its gather rays read the `next` cache level; without one they continue as paths, or
    /// see only direct light if `--bounces` sets the number of levels.
    fn make_record(&self, place: &Place, level: usize, next: Option<&Cache<Record>>) -> Record {
        let gatherer = gatherer(self.setting, self.params, level);
        match (next, self.params.bounces) {
            (None, None) => gatherer.record(place, &mut |v| self.with_focused(None, v)),
            (None, Some(_)) => gatherer
                .record(place, &mut |v| self.with_focused(v.bsdf.diffuse_part(v.wo).map(black), v)),
            (Some(next), _) => gatherer.record(place, &mut |v| {
                let covered = self.params.covers_depth(v.segments, level + 1);
                let estimate = covered.then(|| (self.interpolate)(next, v));
                self.with_focused(estimate.flatten(), v)
            }),
        }
    }

    /// Add the light that mirrors and glass focus.
    fn with_focused(&self, estimate: Option<Estimate>, v: &EyeVertex) -> Option<Estimate> {
        self.focused.add_to(estimate, self.setting.scene, v, &self.params.limits)
    }

    /// Places without a valid record on the path through a pixel. It is the path of the first pass.
    fn uncovered_in_pixel(&self, cache: &Cache<Record>, [x, y]: [u32; 2]) -> Vec<Place> {
        let setting = Setting { show: Show::Indirect, ..*self.setting };
        let stream = y * setting.camera.size()[0] as u32 + x;
        let pixel = [x as usize, y as usize];
        let mut places = Vec::new();
        let mut walk = EyeWalk::through_pixel(&setting, self.params.limits, pixel, 0);
        while let Some(v) = &walk.next_vertex() {
            if v.wants_estimate() {
                let key = hash_words(&[stream, v.segments, v.non_delta]);
                if let Some(estimate) = self.visit(cache, v, 0, key, &mut places) {
                    walk.add_estimate(v, estimate);
                }
            }
            walk.skip_direct(v);
            if !walk.scatter(v) {
                break;
            }
        }
        places
    }

    /// Places without a valid record in cache `level`, seen by the gather rays that start at `place`.
    fn uncovered_from(&self, cache: &Cache<Record>, level: usize, place: &Place) -> Vec<Place> {
        let mut places = Vec::new();
        let mut vertices = 0;
        gatherer(self.setting, self.params, level - 1).record(place, &mut |v| {
            vertices += 1;
            let key = hash_words(&[place.key, level as u32, vertices]);
            self.visit(cache, v, level, key, &mut places)
        });
        places
    }

    /// Add the place of `v` to `places` if no record is valid there. The black estimate that is returned ends the
    /// path's diffuse part.
    fn visit(
        &self,
        cache: &Cache<Record>,
        v: &EyeVertex,
        level: usize,
        key: u32,
        places: &mut Vec<Place>,
    ) -> Option<Estimate> {
        if !self.params.covers_depth(v.segments, level) {
            return None;
        }
        let part = v.bsdf.diffuse_part(v.wo)?;
        let surface = v.surface;
        let place = Place { surface, n: part.normal, segments: v.segments, length: v.length, key };
        if !self.is_covered(cache, &place) {
            places.push(place);
        }
        Some(black(part))
    }

    fn is_covered(&self, cache: &Cache<Record>, place: &Place) -> bool {
        let q = place.query();
        cache.has_valid(&q, |site| self.guard.passes(site, &q))
    }
}

/// An estimate without light for the Lambertian part: the path continues only over other lobes.
fn black(part: DiffusePart) -> Estimate {
    let covers = Covers::Diffuse(part);
    Estimate { covers, indirect: Rgb::BLACK, direct: None, caustic: None }
}
