//! Irradiance caching [slides 5-14]: indirect light of diffuse surfaces changes slowly, so compute it at few points and
//! interpolate.
//!
//! | | |
//! |---|---|
//! | estimate | direct light as in path tracing; caustics from photons or as in path tracing; indirect light of the Lambertian part of every surface from irradiance records |
//! | record | E = pi / N sum_j L_i(x, w_j) over N stratified rays, its gradients, and the radius within which it is valid [slides 7, 9, 10] |
//! | interpolation | E(x) = sum w_i E_i(x) / sum w_i over the records whose error at x is below the accuracy a [slide 11]; E_i(x) follows the gradients [slide 12] |
//! | weight | w_i = 1 / (\|x - x_i\| / R_i + sqrt(1 - n . n_i)), R_i the harmonic mean of the distances, with `--weights lecture --error split-sphere` [slides 9, 11]; by default weights fall to zero smoothly where a record ends |
//! | `--rays` | N, rays per record |
//! | `--accuracy` | a, the allowed relative error; w > 1 / a in the lecture |
//! | `--error` | how the error is estimated: by the split sphere of the slides, by the split sphere with limits, or by Hessians |
//! | `--bounces` | number of cache levels; without it gather rays continue as paths |
//! | `--min-spacing`, `--max-spacing` | limits of a record's radius in pixels |
//! | bias | light changes more slowly between records than it should. Too few rays show as blotches of the size of records. Too coarse an accuracy loses soft shadows, and light leaks at corners |
//! | coats | the base of a plastic counts as Lambertian; its coat changes that by a few per cent at most |
//! | sources | \[Ward88\], \[Ward92\], \[Tabellion04\], \[Krivanek06\], \[Schwarzhaupt12\] |
//!
//! Read next: `prepass.rs` (how the caches are filled), then in the crate `lightcache`: `gather.rs` and `hemisphere.rs`
//! (how a record is made), `site.rs` and `control.rs` (where it is valid), `cache.rs` (which records are near a point).

#![forbid(unsafe_code)]

pub mod file;
mod params;
mod prepass;
mod statistics;

use std::path::Path;

use gi_core::bytes::checksum;
use gi_core::caustics::FocusedLight;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::files;
use gi_core::film::{Film, Show};
use gi_core::math::{INV_PI, Rgb};
use gi_core::technique::{Picture, Setting, Technique};
use lightcache::Cache;
use lightcache::export::to_file;
use lightcache::guard::LeakGuard;
use lightcache::record::{Gradients, Record};
use lightcache::site::{Query, RELAXED};

use file::SavedCache;
pub use params::Params;
use prepass::{Filler, empty_levels, gatherer};
use statistics::{LookupCounts, statistics};

/// Irradiance caching.
pub struct IrradianceCaching<'a> {
    setting: Setting<'a>,
    params: Params,
    /// Photons of light over mirrors and glass, of the current pass.
    focused: FocusedLight,
    interpolation: Interpolation<'a>,
    /// The cache that the eye sees; then, level by level, the caches that the gather rays of the level before read.
    levels: Vec<Cache<Record>>,
    /// Number of records that came from a file.
    records_read: usize,
}

impl<'a> Technique<'a> for IrradianceCaching<'a> {
    type Params = Params;

    /// Fill the caches: look at every pixel from coarse to fine, and make records where none is valid.
    fn prepare(setting: Setting<'a>, params: &Params) -> Result<Self, String> {
        let Setting { scene, camera, seed, show, .. } = setting;
        let mut levels = empty_levels(&setting, params);
        let records_read = match &params.files.cache_in {
            Some(path) => file::insert(SavedCache::open(path)?, setting.world, params, &mut levels)
                .map_err(|e| files::refusal(path, &e))?,
            None => 0,
        };
        let [width, height] = camera.size();
        let pixels = if params.caustics.by_photons() { width * height } else { 0 };
        let mut focused = FocusedLight::where_it_matters(scene, seed, pixels);
        let interpolation = Interpolation::new(&setting, params);
        if matches!(show, Show::All | Show::Indirect) {
            focused.shoot(scene, seed ^ PREPASS_SEED, 0);
            let filler = Filler {
                setting: &setting,
                params,
                focused: &focused,
                guard: interpolation.guard,
                interpolate: |cache: &Cache<Record>, v: &EyeVertex| interpolation.light(cache, v),
            };
            levels = filler.fill(levels);
        }
        let params = params.clone();
        Ok(IrradianceCaching { setting, params, focused, interpolation, levels, records_read })
    }

    /// One path per pixel; its indirect light comes from the cache.
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

    fn prepared(&self) -> u64 {
        checksum(&self.saved().to_bytes())
    }

    fn save_state(&self) -> Vec<u8> {
        self.interpolation.counts.save()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        self.interpolation.counts.restore(state)
    }

    fn statistics(&self) -> Vec<(String, f64)> {
        let rays = |level| gatherer(&self.setting, &self.params, level).strata.count();
        statistics(&self.levels, self.records_read, rays, &self.interpolation.counts)
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

impl IrradianceCaching<'_> {
    /// Indirect light at a vertex from the first cache, and focused light from photons.
    fn estimate(&self, v: &EyeVertex) -> Option<Estimate> {
        let covered = self.params.covers_depth(v.segments, 0);
        let estimate = covered.then(|| self.interpolation.light(&self.levels[0], v)).flatten();
        self.focused.add_to(estimate, self.setting.scene, v, &self.params.limits)
    }

    /// The caches in the form that a file stores.
    pub fn saved(&self) -> SavedCache {
        file::saved(self.setting.world, &self.params, &self.levels)
    }

    /// The cache that the eye sees.
    pub fn cache(&self) -> &Cache<Record> {
        &self.levels[0]
    }
}

/// Interpolates between the records of a cache.
struct Interpolation<'a> {
    gradients: Gradients,
    guard: LeakGuard<'a>,
    counts: LookupCounts,
}

impl<'a> Interpolation<'a> {
    fn new(setting: &Setting<'a>, params: &Params) -> Self {
        let guard = LeakGuard { scene: setting.scene, is_on: params.reach.leak_guard };
        Interpolation { gradients: params.gradients, guard, counts: LookupCounts::default() }
    }

    /// Indirect light of the Lambertian part of a vertex: albedo E / pi.
    fn light(&self, cache: &Cache<Record>, v: &EyeVertex) -> Option<Estimate> {
        let part = v.bsdf.diffuse_part(v.wo)?;
        let q = Query { p: v.surface.p, n: part.normal };
        let e = self.irradiance(cache, &q, 1.0).or_else(|| {
            // Between the pixels of the prepass, accept records with a larger error; if there are none, the path
            // continues.
            let relaxed = self.irradiance(cache, &q, RELAXED);
            self.counts.add(relaxed.is_some());
            relaxed
        })?;
        let indirect = part.albedo * INV_PI * e;
        Some(Estimate { covers: Covers::Diffuse(part), indirect, direct: None, caustic: None })
    }

    /// E(x) = sum w_i E_i(x) / sum w_i over the records that are valid at x [slide 11]; `None` where there are none.
    /// `slack` multiplies the allowed error.
    #[inline]
    fn irradiance(&self, cache: &Cache<Record>, x: &Query, slack: f32) -> Option<Rgb> {
        let (mut sum, mut weights) = (Rgb::BLACK, 0.0);
        let is_visible = |site: &_| self.guard.passes(site, x);
        cache.for_each_valid(x, slack, is_visible, |record, weight| {
            sum += record.extrapolate(x, self.gradients) * weight;
            weights += weight;
        });
        // Gradients may lead below zero.
        (weights > 0.0).then(|| (sum / weights).map(|e| e.max(0.0)))
    }
}

/// Separates the random numbers of the prepass from those of the passes.
const PREPASS_SEED: u32 = 0x6f76_6572;
