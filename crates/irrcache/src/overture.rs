//! The overture: filling the caches before the picture, from coarse to fine.

use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::film::Show;
use gi_core::math::{INV_PI, Rgb};
use gi_core::progress;
use gi_core::rng::hash_words;
use gi_core::technique::Setting;
use rayon::prelude::*;

use crate::IrradianceCaching;
use crate::params::Params;
use lightcache::Cache;
use lightcache::control::Control;
use lightcache::fill::{coarse_to_fine, in_rounds, scattered};
use lightcache::gather::{Gatherer, Place};
use lightcache::hemisphere::Strata;
use lightcache::options::ReachOptions;
use lightcache::record::Record;

impl<'a> IrradianceCaching<'a> {
    /// How records of a level are made. Each level is seen through the one before, and may be coarser by as much: half the
    /// rays, half again the error, twice the spacing.
    pub(crate) fn gatherer(&self, level: usize) -> Gatherer<'a> {
        let Params { rays, accuracy, reach, .. } = self.params;
        let ReachOptions { min_spacing, max_spacing, .. } = reach;
        let pixel = self.setting.camera.pixel_width();
        let coarser = 2f32.powi(level as i32);
        let most = if max_spacing > 0.0 { max_spacing * pixel * coarser } else { f32::INFINITY };
        Gatherer {
            scene: self.setting.scene,
            limits: self.params.limits,
            seed: self.setting.seed,
            strata: Strata::of((rays >> level.min(31)).max(FEWEST_RAYS.min(rays))),
            control: Control {
                error: self.params.error,
                radius: self.params.radius,
                accuracy: (accuracy * 1.5f32.powi(level as i32)).min(COARSEST.max(accuracy)),
            },
            spacing: [min_spacing * pixel * coarser, most],
        }
    }

    /// Look at every pixel from coarse to fine.
    pub(crate) fn overture(&mut self) {
        let order = coarse_to_fine(self.setting.camera.size());
        let mut levels = std::mem::take(&mut self.levels);
        progress::begin(progress::SEARCHED, order.len() as u64);
        self.fill(&mut levels, 0, order.len(), |cache, k| {
            progress::advance(1);
            self.missing_in_pixel(cache, order[k])
        });
        self.levels = levels;
    }

    /// Where the path through a pixel asks for what no record is good for. It is the path of the first pass.
    fn missing_in_pixel(&self, cache: &Cache<Record>, [x, y]: [u32; 2]) -> Vec<Place> {
        let setting = Setting { show: Show::Indirect, ..self.setting };
        let stream = y * setting.camera.size()[0] as u32 + x;
        let pixel = [x as usize, y as usize];
        let mut missing = Vec::new();
        let mut walk = EyeWalk::through_pixel(&setting, self.params.limits, pixel, 0);
        while let Some(v) = &walk.next_vertex() {
            if v.wants_estimate() {
                let key = hash_words(&[stream, v.segments, v.non_delta]);
                if let Some(estimate) = self.note_missing(cache, v, 0, key, &mut missing) {
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

    /// Where the gather rays of a record ask the next level for what it does not have.
    fn missing_round(&self, next: &Cache<Record>, level: usize, place: &Place) -> Vec<Place> {
        let mut missing = Vec::new();
        let mut count = 0;
        self.gatherer(level - 1).record(place, &mut |v| {
            count += 1;
            let key = hash_words(&[place.key, level as u32, count]);
            self.note_missing(next, v, level, key, &mut missing)
        });
        missing
    }

    /// Note the place of `v` if no record is good enough for it. The estimate that is returned ends the path.
    fn note_missing(
        &self,
        cache: &Cache<Record>,
        v: &EyeVertex,
        level: usize,
        key: u32,
        missing: &mut Vec<Place>,
    ) -> Option<Estimate> {
        if !self.is_for_cache(v, level) {
            return None;
        }
        let part = v.bsdf.diffuse_part(v.wo)?;
        let surface = v.surface;
        let place = Place { surface, n: part.normal, segments: v.segments, length: v.length, key };
        if self.lookup(cache, &place.query(), 1.0).is_none() {
            missing.push(place);
        }
        let covers = Covers::Diffuse(part);
        Some(Estimate { covers, indirect: Rgb::BLACK, direct: None, caustic: None })
    }

    /// Fill the cache of a level, and those below it with what its gather rays will ask for.
    fn fill(
        &self,
        levels: &mut [Cache<Record>],
        level: usize,
        points: usize,
        ask: impl Fn(&Cache<Record>, usize) -> Vec<Place> + Sync,
    ) {
        let (this, deeper) = levels.split_first_mut().expect("a level");
        in_rounds(this, points, ask, |this, places| {
            if let Some(next) = deeper.first() {
                let missing = |place| self.missing_round(next, level + 1, place);
                let wanted: Vec<Place> = places.par_iter().flat_map_iter(missing).collect();
                let order = scattered(wanted.len());
                let ask: &(dyn Fn(&Cache<Record>, usize) -> Vec<Place> + Sync) = &|cache, k| {
                    let place = wanted[order[k] as usize];
                    let found = self.lookup(cache, &place.query(), 1.0);
                    if found.is_none() { vec![place] } else { Vec::new() }
                };
                self.fill(deeper, level + 1, wanted.len(), ask);
            }
            let gatherer = self.gatherer(level);
            let make = |place| match (deeper.first(), self.params.bounces) {
                (None, None) => gatherer.record(place, &mut |v| self.with_focused(None, v)),
                // The deepest of the levels asked for sees direct light only.
                (None, Some(_)) => {
                    gatherer.record(place, &mut |v| self.with_focused(answer(v, Rgb::BLACK), v))
                }
                (Some(next), _) => gatherer.record(place, &mut |v| {
                    let known = self.is_for_cache(v, level + 1).then(|| self.interpolate(next, v));
                    self.with_focused(known.flatten(), v)
                }),
            };
            let records: Vec<_> = places.par_iter().with_max_len(1).map(make).collect();
            records.into_iter().for_each(|record| this.insert(record));
        });
    }
}

/// The estimate of the diffuse part where the irradiance is `e`.
fn answer(v: &EyeVertex, e: Rgb) -> Option<Estimate> {
    let part = v.bsdf.diffuse_part(v.wo)?;
    let indirect = part.albedo * INV_PI * e;
    Some(Estimate { covers: Covers::Diffuse(part), indirect, direct: None, caustic: None })
}

/// Deeper levels do not have fewer rays than this.
const FEWEST_RAYS: u32 = 64;
/// Deeper levels are not less accurate than this.
const COARSEST: f32 = 0.5;
