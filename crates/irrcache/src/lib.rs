//! Irradiance caching [slides 5-14]: indirect light of diffuse surfaces changes slowly, so compute it at few points and
//! interpolate.
//!
//! | | |
//! |---|---|
//! | estimated | direct light and caustics as a path tracer does; indirect light of the Lambertian part of every surface from records of irradiance |
//! | record | E = pi / N sum_j L_i(x, w_j) over N stratified rays, its gradients, and how far it is good for [slides 7, 9, 10] |
//! | interpolation | E(x) = sum w_i E_i(x) / sum w_i over the records whose error at x is below the accuracy a [slide 11]; E_i(x) follows the gradients [slide 12] |
//! | `--rays` | N, rays of a record (1000) |
//! | `--accuracy` | a, the relative error allowed (0.1: the lecture's w > 10) |
//! | `--error` | how the error is estimated: the split sphere of the slides, bounded, or by Hessians |
//! | `--bounces` | levels of caches; without it gather rays go on as paths |
//! | `--min-spacing`, `--max-spacing` | limits of a record's radius, pixels |
//! | bias | light changes more slowly between records than it should: too few rays show as blotches as large as records, too coarse an accuracy as soft shadows that are missing and light that leaks at corners |
//! | sources | \[Ward88\], \[Ward92\], \[Tabellion04\], \[Krivanek06\], \[Schwarzhaupt12\] |

#![forbid(unsafe_code)]

pub mod cache;
pub mod control;
pub mod figures;
pub mod file;
pub mod fill;
pub mod gather;
pub mod gradients;
pub mod hemisphere;
pub mod hessian;
pub mod octree;
pub mod record;

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use gi_core::eye::{Answered, EyePath, EyeVertex, PathLimits, Supplied, nothing};
use gi_core::film::{Film, Show};
use gi_core::math::{INV_PI, Rgb};
use gi_core::rng::hash_words;
use gi_core::technique::{Picture, Setting, Technique};
use rayon::prelude::*;

use cache::{Cache, Interpolation, Weights};
use control::{Control, ErrorControl, SphereRadius};
use figures::Figure;
use file::SavedCache;
use fill::{coarse_to_fine, in_rounds, scattered};
use gather::{Gatherer, Place, sees};
use hemisphere::Strata;
use record::{Gradients, Query};

/// The knobs.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// How long paths may be.
    pub limits: PathLimits,
    /// Rays of a record.
    pub rays: u32,
    /// The accuracy a, relative.
    pub accuracy: f32,
    /// Levels of caches; `None` lets gather rays go on as paths.
    pub bounces: Option<u32>,
    /// The split sphere's length.
    pub radius: SphereRadius,
    /// What the error is estimated by.
    pub error: ErrorControl,
    /// Smallest radius of a record, pixels.
    pub min_spacing: f32,
    /// Largest radius of a record, pixels; 0 is the scene's radius.
    pub max_spacing: f32,
    /// Whether the radii of neighbours limit each other.
    pub neighbour_clamping: bool,
    /// Whether a ray looks for walls between a record and where it is used.
    pub leak_guard: bool,
    /// Which gradients are followed.
    pub gradients: Gradients,
    /// How records are weighed.
    pub weights: Weights,
    /// A cache to begin with.
    pub cache: Option<SavedCache>,
    /// What to draw.
    pub figures: Vec<Figure>,
}

impl Default for Params {
    fn default() -> Self {
        Params {
            limits: PathLimits::default(),
            rays: 1000,
            accuracy: 0.1,
            bounces: None,
            radius: SphereRadius::Harmonic,
            error: ErrorControl::HessianOcclusion,
            min_spacing: 3.0,
            max_spacing: 40.0,
            neighbour_clamping: true,
            leak_guard: true,
            gradients: Gradients::Both,
            weights: Weights::Smooth,
            cache: None,
            figures: Vec::new(),
        }
    }
}

/// How many times less accurate than allowed a record may be where no better one is found.
const RELAXED: f32 = 2.0;

/// Irradiance caching.
pub struct IrradianceCaching<'a> {
    setting: Setting<'a>,
    params: Params,
    /// The cache that the eye sees, then those that gather rays of the one before see.
    levels: Vec<Cache>,
    read: usize,
    relaxed: AtomicU64,
    failed: AtomicU64,
}

impl<'a> Technique<'a> for IrradianceCaching<'a> {
    type Params = Params;

    /// Fill the cache: look at every pixel from coarse to fine, and make records where none is good.
    fn prepare(setting: Setting<'a>, params: &Params) -> Result<Self, String> {
        let mut technique = Self::empty(setting, params);
        if let Some(saved) = &params.cache {
            technique.read(saved)?;
        }
        if setting.show == Show::All || setting.show == Show::Indirect {
            technique.overture();
        }
        Ok(technique)
    }

    /// One path a pixel, its indirect light from the cache.
    fn pass(&mut self, index: u32, film: &mut Film) {
        let Setting { scene, camera, seed, show, .. } = self.setting;
        let path = EyePath { scene, limits: self.params.limits, show };
        let this = &*self;
        film.add_pass(|pixel| {
            path.sample_pixel(camera, seed, pixel, index, &mut |v, _| this.supply(v, 0))
        });
    }

    fn statistics(&self) -> Vec<(String, f64)> {
        let first = &self.levels[0];
        let made: usize = self.levels.iter().map(|c| c.records().len()).sum::<usize>() - self.read;
        let rays: usize = (0..self.levels.len())
            .map(|k| self.levels[k].records().len() * self.gatherer(k).strata.count())
            .sum();
        let radii = first.records().iter().map(|r| f64::from(r.reach()));
        let mut all = vec![
            ("records".to_string(), first.records().len() as f64),
            ("records_made".to_string(), made as f64),
            ("records_read".to_string(), self.read as f64),
            ("gather_rays".to_string(), rays as f64),
            ("mean_radius".to_string(), radii.sum::<f64>() / first.records().len().max(1) as f64),
            ("lookups_relaxed".to_string(), self.relaxed.load(Relaxed) as f64),
            ("lookups_failed".to_string(), self.failed.load(Relaxed) as f64),
        ];
        for (k, level) in self.levels.iter().enumerate().skip(1) {
            all.push((format!("records_level_{}", k + 1), level.records().len() as f64));
        }
        all
    }

    fn reach(&self) -> String {
        "direct light and caustics as path tracing does; indirect light interpolated (biased) on the Lambertian part of \
         surfaces, path-traced over all other lobes"
            .into()
    }

    fn pictures(&self, film: &Film) -> Vec<Picture> {
        self.params.figures.iter().map(|f| f.draw(&self.setting, &self.levels[0], film)).collect()
    }
}

impl<'a> IrradianceCaching<'a> {
    fn empty(setting: Setting<'a>, params: &Params) -> Self {
        let how = Interpolation {
            accuracy: params.accuracy,
            gradients: params.gradients,
            weights: params.weights,
            slope: None,
        };
        let count = params.bounces.unwrap_or(1).max(1);
        let mut technique = IrradianceCaching {
            setting,
            params: params.clone(),
            levels: Vec::new(),
            read: 0,
            relaxed: AtomicU64::new(0),
            failed: AtomicU64::new(0),
        };
        for k in 0..count as usize {
            let control = technique.gatherer(k).control;
            let clamped = params.neighbour_clamping && control.has_limits();
            let slope = clamped.then(|| control.slope());
            let how = Interpolation { accuracy: control.accuracy, slope, ..how };
            technique.levels.push(Cache::new(setting.scene.bounds(), how));
        }
        technique
    }

    /// How records of a level are made. Each level is seen through the one before, and may be coarser by as much: half the
    /// rays, half again the error, twice the spacing.
    fn gatherer(&self, level: usize) -> Gatherer<'a> {
        let Params { rays, accuracy, min_spacing, max_spacing, .. } = self.params;
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
    fn overture(&mut self) {
        let order = coarse_to_fine(self.setting.camera.size());
        let mut levels = std::mem::take(&mut self.levels);
        self.fill(&mut levels, 0, order.len(), |cache, k| self.missing_in_pixel(cache, order[k]));
        self.levels = levels;
    }

    /// Where the path through a pixel asks for what no record is good for. It is the path of the first pass.
    fn missing_in_pixel(&self, cache: &Cache, [x, y]: [u32; 2]) -> Vec<Place> {
        let Setting { scene, camera, seed, .. } = self.setting;
        let path = EyePath { scene, limits: self.params.limits, show: Show::Indirect };
        let mut missing = Vec::new();
        path.sample_pixel(camera, seed, [x as usize, y as usize], 0, &mut |v, _| {
            let key = hash_words(&[y * camera.size()[0] as u32 + x, v.segments, v.rough]);
            self.note_missing(cache, v, 0, key, &mut missing)
        });
        missing
    }

    /// Where the gather rays of a record ask the next level for what it does not have.
    fn missing_round(&self, next: &Cache, level: usize, place: &Place) -> Vec<Place> {
        let mut missing = Vec::new();
        let mut count = 0;
        self.gatherer(level - 1).record(place, &mut |v, _| {
            count += 1;
            let key = hash_words(&[place.key, level as u32, count]);
            self.note_missing(next, v, level, key, &mut missing)
        });
        missing
    }

    /// A supplier that notes what is missing and ends the path.
    fn note_missing(
        &self,
        cache: &Cache,
        v: &EyeVertex,
        level: usize,
        key: u32,
        missing: &mut Vec<Place>,
    ) -> Option<Supplied> {
        if !self.is_for_cache(v, level) {
            return None;
        }
        let part = v.bsdf.diffuse_part(v.wo)?;
        let surface = *v.surface;
        let place = Place { surface, n: part.normal, segments: v.segments, length: v.length, key };
        if self.lookup(cache, &place.query(), 1.0).is_none() {
            missing.push(place);
        }
        let answered = Answered::Diffuse(part);
        Some(Supplied { answered, indirect: Rgb::BLACK, caustic: None })
    }

    /// Fill the cache of a level, and those below it with what its gather rays will ask for.
    fn fill(
        &self,
        levels: &mut [Cache],
        level: usize,
        points: usize,
        ask: impl Fn(&Cache, usize) -> Vec<Place> + Sync,
    ) {
        let (this, deeper) = levels.split_first_mut().expect("a level");
        in_rounds(this, points, ask, |this, places| {
            if let Some(next) = deeper.first() {
                let missing = |place| self.missing_round(next, level + 1, place);
                let wanted: Vec<Place> = places.par_iter().flat_map_iter(missing).collect();
                let order = scattered(wanted.len());
                let ask: &(dyn Fn(&Cache, usize) -> Vec<Place> + Sync) = &|cache, k| {
                    let place = wanted[order[k] as usize];
                    let found = self.lookup(cache, &place.query(), 1.0);
                    if found.is_none() { vec![place] } else { Vec::new() }
                };
                self.fill(deeper, level + 1, wanted.len(), ask);
            }
            let gatherer = self.gatherer(level);
            let make = |place| match (deeper.first(), self.params.bounces) {
                (None, None) => gatherer.record(place, &mut nothing),
                // The deepest of the levels asked for sees direct light only.
                (None, Some(_)) => gatherer.record(place, &mut |v, _| answer(v, Rgb::BLACK)),
                (Some(next), _) => gatherer.record(place, &mut |v, _| {
                    self.is_for_cache(v, level + 1).then(|| self.supply_from(next, v)).flatten()
                }),
            };
            let records: Vec<_> = places.par_iter().with_max_len(1).map(make).collect();
            records.into_iter().for_each(|record| this.insert(record));
        });
    }

    /// What the cache knows of the indirect light at a vertex.
    fn supply(&self, v: &EyeVertex, level: usize) -> Option<Supplied> {
        if !self.is_for_cache(v, level) {
            return None;
        }
        self.supply_from(&self.levels[level], v)
    }

    fn supply_from(&self, cache: &Cache, v: &EyeVertex) -> Option<Supplied> {
        let part = v.bsdf.diffuse_part(v.wo)?;
        let q = Query { p: v.surface.p, n: part.normal };
        let e = self.lookup(cache, &q, 1.0).or_else(|| {
            // Between the pixels that the overture looked at: what is nearly good enough, or else a path.
            let relaxed = self.lookup(cache, &q, RELAXED);
            if relaxed.is_some() { &self.relaxed } else { &self.failed }.fetch_add(1, Relaxed);
            relaxed
        })?;
        let answered = Answered::Diffuse(part);
        Some(Supplied { answered, indirect: part.albedo * INV_PI * e, caustic: None })
    }

    /// Whether records hold what a vertex wants. With a largest depth they hold the light of what is left of it where they
    /// were made; elsewhere paths go on. Where only one segment is left there is no indirect light.
    fn is_for_cache(&self, v: &EyeVertex, level: usize) -> bool {
        match self.params.limits.max_depth {
            None => true,
            Some(_) => v.segments == 1 + level as u32 && self.params.limits.goes_on(v.segments + 1),
        }
    }

    fn lookup(&self, cache: &Cache, q: &Query, slack: f32) -> Option<Rgb> {
        let scene = self.setting.scene;
        cache.irradiance(q, slack, |record| !self.params.leak_guard || sees(scene, record, q))
    }

    /// Settings that shape what a record holds: those of a saved cache must be this run's.
    fn shaping_settings(&self) -> String {
        let Params { accuracy, bounces, radius, error, limits, .. } = &self.params;
        let bounces = bounces.map_or("path".to_string(), |b| b.to_string());
        let depth = limits.max_depth.map_or(-1, |d| d as i32);
        format!(
            "--accuracy {accuracy} --error {error:?} --radius {radius:?} --bounces {bounces} --max-depth {depth}"
        )
    }

    /// Take the records of a saved cache.
    fn read(&mut self, saved: &SavedCache) -> Result<(), String> {
        if saved.world != self.setting.world {
            return Err(
                "the cache was made of another scene: its shapes, materials or lights differ"
                    .into(),
            );
        }
        let settings = self.shaping_settings();
        if saved.settings != settings {
            return Err(format!(
                "the cache was made with {}, this run has {settings}: make them alike",
                saved.settings
            ));
        }
        for (cache, records) in self.levels.iter_mut().zip(&saved.levels) {
            self.read += records.len();
            // Neighbours have limited each other already: putting them in changes nothing.
            records.iter().for_each(|r| cache.insert(*r));
        }
        Ok(())
    }

    /// The cache as a file keeps it.
    pub fn saved(&self) -> SavedCache {
        SavedCache {
            world: self.setting.world,
            settings: self.shaping_settings(),
            levels: self.levels.iter().map(|c| c.records().to_vec()).collect(),
        }
    }

    /// The cache that the eye sees.
    pub fn cache(&self) -> &Cache {
        &self.levels[0]
    }
}

/// A supplier that knows the irradiance.
fn answer(v: &EyeVertex, e: Rgb) -> Option<Supplied> {
    let part = v.bsdf.diffuse_part(v.wo)?;
    let indirect = part.albedo * INV_PI * e;
    Some(Supplied { answered: Answered::Diffuse(part), indirect, caustic: None })
}

/// Deeper levels do not have fewer rays than this.
const FEWEST_RAYS: u32 = 64;
/// Deeper levels are not less accurate than this.
const COARSEST: f32 = 0.5;
