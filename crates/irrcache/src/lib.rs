//! Irradiance caching [slides 5-14]: indirect light of diffuse surfaces changes slowly, so compute it at few points and
//! interpolate.
//!
//! | | |
//! |---|---|
//! | estimated | direct light as a path tracer does, caustics from photons or as a path tracer does; indirect light of the Lambertian part of every surface from records of irradiance |
//! | record | E = pi / N sum_j L_i(x, w_j) over N stratified rays, its gradients, and how far it is good for [slides 7, 9, 10] |
//! | interpolation | E(x) = sum w_i E_i(x) / sum w_i over the records whose error at x is below the accuracy a [slide 11]; E_i(x) follows the gradients [slide 12] |
//! | `--rays` | N, rays of a record (1000) |
//! | `--accuracy` | a, the relative error allowed (0.1: the lecture's w > 10) |
//! | `--error` | how the error is estimated: the split sphere of the slides, bounded, or by Hessians |
//! | `--bounces` | levels of caches; without it gather rays go on as paths |
//! | `--min-spacing`, `--max-spacing` | limits of a record's radius, pixels |
//! | bias | light changes more slowly between records than it should: too few rays show as blotches as large as records, too coarse an accuracy as soft shadows that are missing and light that leaks at corners |
//! | coats | the base of a plastic counts as Lambertian: what its coat lets in from the side differs by a few per cent at most |
//! | sources | \[Ward88\], \[Ward92\], \[Tabellion04\], \[Krivanek06\], \[Schwarzhaupt12\] |

#![forbid(unsafe_code)]

pub mod file;
mod overture;
mod params;

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use gi_core::caustics::FocusedLight;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::film::{Film, Show};
use gi_core::math::{INV_PI, Rgb};
use gi_core::technique::{Picture, Setting, Technique};
use lightcache::export::to_file;
use lightcache::gather::sees;
use lightcache::record::Record;
use lightcache::site::{Query, RELAXED, Site};
use lightcache::{Cache, Weighing};

use file::{Levels, SavedCache};
pub use params::Params;

/// Irradiance caching.
pub struct IrradianceCaching<'a> {
    setting: Setting<'a>,
    params: Params,
    /// Light over mirrors and glass: of the overture, then of the last pass.
    focused: FocusedLight,
    /// The cache that the eye sees, then those that gather rays of the one before see.
    levels: Vec<Cache<Record>>,
    read: usize,
    relaxed: AtomicU64,
    failed: AtomicU64,
}

impl<'a> Technique<'a> for IrradianceCaching<'a> {
    type Params = Params;

    /// Fill the cache: look at every pixel from coarse to fine, and make records where none is good.
    fn prepare(setting: Setting<'a>, params: &Params) -> Result<Self, String> {
        let mut technique = Self::empty(setting, params);
        if let Some(path) = &params.files.cache_in {
            technique.read(&SavedCache::open(path)?)?;
        }
        if setting.show == Show::All || setting.show == Show::Indirect {
            technique.focused.shoot(setting.scene, setting.seed ^ OVERTURE, 0);
            technique.overture();
        }
        Ok(technique)
    }

    /// One path a pixel, its indirect light from the cache.
    fn pass(&mut self, index: u32, film: &mut Film) {
        self.focused.shoot(self.setting.scene, self.setting.seed, index);
        film.add_pass(|pixel| {
            let mut walk = EyeWalk::through_pixel(&self.setting, self.params.limits, pixel, index);
            while let Some(v) = &walk.next_vertex() {
                walk.add_emitted(v);
                if v.wants_estimate()
                    && let Some(estimate) = self.estimate(v)
                {
                    walk.add_estimate(v, estimate);
                }
                walk.add_direct(v);
                if !walk.scatter(v) {
                    break;
                }
            }
            walk.sample()
        });
    }

    fn statistics(&self) -> Vec<(String, f64)> {
        let first = &self.levels[0];
        let made: usize = self.levels.iter().map(|c| c.records().len()).sum::<usize>() - self.read;
        let rays: usize = (0..self.levels.len())
            .map(|k| self.levels[k].records().len() * self.gatherer(k).strata.count())
            .sum();
        let radii = first.records().iter().map(|r| f64::from(r.site.reach()));
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
        "direct light as path tracing does; caustics from photons (blurred) or paths; indirect light interpolated (biased) on the Lambertian part of \
         surfaces, path-traced over all other lobes"
            .into()
    }

    fn pictures(&self, film: &Film) -> Vec<Picture> {
        self.params.figures.iter().map(|f| f.draw(&self.setting, &self.levels[0], film)).collect()
    }

    fn export(&self, path: &Path) -> Vec<u8> {
        if self.params.files.cache_out.as_deref() == Some(path) {
            return self.saved().to_bytes();
        }
        to_file(path, self.cache().records().iter(), self.setting.scene.origin())
    }
}

impl<'a> IrradianceCaching<'a> {
    fn empty(setting: Setting<'a>, params: &Params) -> Self {
        let Setting { scene, camera, seed, .. } = setting;
        let [w, h] = camera.size();
        let count = params.bounces.unwrap_or(1).max(1);
        let mut technique = IrradianceCaching {
            setting,
            params: params.clone(),
            levels: Vec::new(),
            read: 0,
            focused: FocusedLight::where_it_matters(
                scene,
                seed,
                if params.caustics.by_photons() { w * h } else { 0 },
            ),
            relaxed: AtomicU64::new(0),
            failed: AtomicU64::new(0),
        };
        for k in 0..count as usize {
            let control = technique.gatherer(k).control;
            let clamped = params.reach.neighbour_clamping && control.has_limits();
            let slope = clamped.then(|| control.slope());
            let how = Weighing { accuracy: control.accuracy, weights: params.weights, slope };
            technique.levels.push(Cache::new(setting.scene.bounds(), how));
        }
        technique
    }

    /// What the first cache and the photons know of the light at a vertex.
    fn estimate(&self, v: &EyeVertex) -> Option<Estimate> {
        let known = self.is_for_cache(v, 0).then(|| self.interpolate(&self.levels[0], v));
        self.with_focused(known.flatten(), v)
    }

    /// Add the light that mirrors and glass focus.
    pub(crate) fn with_focused(
        &self,
        estimate: Option<Estimate>,
        v: &EyeVertex,
    ) -> Option<Estimate> {
        self.focused.add_to(estimate, self.setting.scene, v, &self.params.limits)
    }

    /// Indirect light of the Lambertian part: albedo E / pi, E interpolated from the records of a cache [slide 11].
    pub(crate) fn interpolate(&self, cache: &Cache<Record>, v: &EyeVertex) -> Option<Estimate> {
        let part = v.bsdf.diffuse_part(v.wo)?;
        let q = Query { p: v.surface.p, n: part.normal };
        let e = self.lookup(cache, &q, 1.0).or_else(|| {
            // Between the pixels of the prepass, accept records with a slightly larger error; else the path continues.
            let relaxed = self.lookup(cache, &q, RELAXED);
            if relaxed.is_some() { &self.relaxed } else { &self.failed }.fetch_add(1, Relaxed);
            relaxed
        })?;
        let covers = Covers::Diffuse(part);
        Some(Estimate { covers, indirect: part.albedo * INV_PI * e, direct: None, caustic: None })
    }

    /// Whether records hold what a vertex wants. With a largest depth they hold the light of what is left of it where they
    /// were made; elsewhere paths go on. Where only one segment is left there is no indirect light.
    pub(crate) fn is_for_cache(&self, v: &EyeVertex, level: usize) -> bool {
        match self.params.limits.max_depth {
            None => true,
            Some(_) => v.segments == 1 + level as u32 && self.params.limits.goes_on(v.segments + 1),
        }
    }

    pub(crate) fn lookup(&self, cache: &Cache<Record>, q: &Query, slack: f32) -> Option<Rgb> {
        let scene = self.setting.scene;
        let sees = |site: &Site| !self.params.reach.leak_guard || sees(scene, site, q);
        cache.irradiance(q, self.params.gradients, slack, sees)
    }

    /// Settings that shape what a record holds: those of a saved cache must be this run's.
    fn shaping_settings(&self) -> String {
        let Params { accuracy, bounces, radius, error, limits, .. } = &self.params;
        let bounces = bounces.map_or("path".to_string(), |b| b.to_string());
        let depth = limits.max_depth.map_or(-1, |d| d as i32);
        let caustics = if self.params.caustics.by_photons() { "photon" } else { "path" };
        format!(
            "--accuracy {accuracy} --error {error:?} --radius {radius:?} --bounces {bounces} --max-depth {depth} --caustics {caustics}"
        )
    }

    /// Take the records of a saved cache.
    fn read(&mut self, saved: &SavedCache) -> Result<(), String> {
        saved.check(self.setting.world, &self.shaping_settings())?;
        for (cache, records) in self.levels.iter_mut().zip(&saved.body.0) {
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
            body: Levels(self.levels.iter().map(|c| c.records().to_vec()).collect()),
        }
    }

    /// The cache that the eye sees.
    pub fn cache(&self) -> &Cache<Record> {
        &self.levels[0]
    }
}

/// What keeps the photons of the overture apart from those of passes.
const OVERTURE: u32 = 0x6f76_6572;
