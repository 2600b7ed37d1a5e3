//! Radiance caching [slides 15-20]: on glossy surfaces the light that comes to a point, direction by direction, changes
//! slowly too. Keep it in spherical harmonics, and let every view make its own dot product with the BRDF.
//!
//! | | |
//! |---|---|
//! | estimated | direct light as a path tracer does, caustics from photons or as a path tracer does; indirect light of diffuse surfaces from records of irradiance, of rough glossy ones from records of radiance |
//! | record | L_i(w) ~ sum_k l_k y_k(w), l_k = the integral of L_i y_k over N stratified rays, and how l_k changes along the surface |
//! | interpolation | l(x) = sum w_j l_j(x) / sum w_j over the records whose error at x is below the accuracy a, as for irradiance [slide 11] |
//! | radiance | L_o(w_o) = sum_k c_k(w_o) l_k, f_r(w_o, .) cos ~ sum_k c_k(w_o) y_k tabulated per elevation, l turned into the shading frame [slide 18] |
//! | `--order` | n: bands of the basis, n^2 functions (10); 0: per material, until 5 % of the BRDF's energy is left out |
//! | `--basis` | `sh`, or `hsh` for hemispherical harmonics |
//! | `--window` | bands fade toward the order against ringing: `none`, `hanning`, `lanczos` |
//! | `--min-roughness` | lobes narrower than this are path-traced (0.2) |
//! | `--mode` | `sh`, or `rho-e`: rho_hd(w_o) E / pi, light as if it were the same from everywhere [slide 15] |
//! | `--rays`, `--accuracy` | as for irradiance caching (1000, 0.1); `--glossy-rays` (2000), `--glossy-accuracy` (0.1) for radiance records |
//! | bias | what irradiance caching has (blotches, missing shadows); besides that the order blurs reflections as if the surface were rougher, rings round bright ones, and lets light through the horizon at grazing angles |
//! | coats | the base of a plastic counts as Lambertian: what its coat lets in from the side differs by a few per cent at most |
//! | sources | \[Krivanek05\], \[Gautron04\], \[Green03\], \[Ivanic96\], \[Ramamoorthi01\] |

#![forbid(unsafe_code)]

pub mod brdf;
pub mod figures;
pub mod file;
mod overture;
mod params;
pub mod record;
pub mod rotate;
pub mod sh;
pub mod surfaces;
#[cfg(test)]
mod test_scenes;

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use gi_core::caustics::FocusedLight;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::film::{Film, Show};
use gi_core::math::{Frame, INV_PI, Rgb};
use gi_core::technique::{Picture, Setting, Technique};
use glam::Vec3A;
use lightcache::control::{Control, ErrorControl};
use lightcache::export::to_file;
use lightcache::gather::sees;
use lightcache::record::{Gradients, Record};
use lightcache::site::{Query, RELAXED, Site, Sited};
use lightcache::{Cache, Weighing};

use file::{Records, SavedCache};
pub use params::{Mode, Params};
use record::RadianceRecord;
use rotate::Turn;
use sh::{Basis, Coefficients, MAX_FUNCTIONS};
use surfaces::{Rule, Surfaces};

/// Both caches.
pub struct Caches {
    /// Irradiance, of surfaces without a rough glossy lobe.
    pub diffuse: Cache<Record>,
    /// Radiance and irradiance, of those with one.
    pub glossy: Cache<RadianceRecord>,
}

/// Radiance caching.
pub struct RadianceCaching<'a> {
    setting: Setting<'a>,
    params: Params,
    /// Light over mirrors and glass: of the overture, then of the last pass.
    focused: FocusedLight,
    surfaces: Surfaces,
    /// Away only while it is filled.
    caches: Option<Caches>,
    read: usize,
    counts: Counts,
}

/// What happened at lookups.
#[derive(Default)]
struct Counts {
    relaxed: AtomicU64,
    failed: AtomicU64,
    negative: AtomicU64,
    glossy: AtomicU64,
}

impl<'a> Technique<'a> for RadianceCaching<'a> {
    type Params = Params;

    /// Tabulate BRDFs, then fill the caches: look at every pixel from coarse to fine, and make records where none is good.
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

    /// One path a pixel, its indirect light from the caches.
    fn pass(&mut self, index: u32, film: &mut Film) {
        self.focused.shoot(self.setting.scene, self.setting.seed, index);
        film.add_pass(|pixel| {
            let mut walk = EyeWalk::through_pixel(&self.setting, self.params.limits, pixel, index);
            while let Some(v) = &walk.next_vertex() {
                walk.add_emitted(v);
                if v.wants_estimate()
                    && let Some(estimate) = self.with_focused(self.interpolate(v), v)
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
        let caches = self.caches();
        let (diffuse, glossy) = (caches.diffuse.records().len(), caches.glossy.records().len());
        let [per_diffuse, per_glossy] = self.gatherers().map(|g| g.strata.count());
        let mut all = vec![
            ("records", diffuse as f64),
            ("glossy_records", glossy as f64),
            ("records_made", (diffuse + glossy - self.read) as f64),
            ("records_read", self.read as f64),
            ("gather_rays", (diffuse * per_diffuse + glossy * per_glossy) as f64),
            ("mean_radius", mean_reach(&caches.diffuse)),
            ("glossy_mean_radius", mean_reach(&caches.glossy)),
            ("glossy_lookups", self.counts.glossy.load(Relaxed) as f64),
            ("lookups_relaxed", self.counts.relaxed.load(Relaxed) as f64),
            ("lookups_failed", self.counts.failed.load(Relaxed) as f64),
            ("lookups_negative", self.counts.negative.load(Relaxed) as f64),
        ]
        .into_iter()
        .map(|(name, value)| (name.to_string(), value))
        .collect::<Vec<_>>();
        for (material, table) in self.surfaces.tables() {
            all.push((format!("material_{material}_order"), table.order as f64));
            all.push((format!("material_{material}_left_out"), f64::from(table.left_out)));
        }
        all
    }

    fn reach(&self) -> String {
        format!(
            "direct light as path tracing does; caustics from photons (blurred) or paths; indirect light interpolated (biased): of diffuse parts from \
             irradiance records, of glossy lobes of roughness {} or more from radiance records, of all others \
             path-traced; {}",
            self.params.min_roughness,
            if self.surfaces.decided.is_empty() {
                "no glossy lobes".to_string()
            } else {
                self.surfaces.decided.join("; ")
            }
        )
    }

    fn pictures(&self, film: &Film) -> Vec<Picture> {
        self.params.figures.iter().flat_map(|f| f.draw(self, film)).collect()
    }

    fn export(&self, path: &Path) -> Vec<u8> {
        if self.params.files.cache_out.as_deref() == Some(path) {
            return self.saved().to_bytes();
        }
        to_file(path, self.irradiance_records(), self.setting.scene.origin())
    }
}

fn mean_reach(cache: &Cache<impl Sited>) -> f64 {
    let sum: f64 = cache.records().iter().map(|r| f64::from(r.site().reach())).sum();
    sum / cache.records().len().max(1) as f64
}

/// What keeps the photons of the overture apart from those of passes.
const OVERTURE: u32 = 0x6f76_6572;

impl<'a> RadianceCaching<'a> {
    fn empty(setting: Setting<'a>, params: &Params) -> Self {
        let Setting { scene, camera, seed, .. } = setting;
        let [w, h] = camera.size();
        let bounds = setting.scene.bounds();
        let how = |error: ErrorControl, accuracy: f32| {
            let control = Control { error, radius: params.radius, accuracy };
            let clamped = params.reach.neighbour_clamping && control.has_limits();
            let slope = clamped.then(|| control.slope());
            Weighing { accuracy, weights: params.weights, slope }
        };
        let caches = Caches {
            diffuse: Cache::new(bounds, how(params.error, params.accuracy)),
            glossy: Cache::new(bounds, how(params.glossy_error, params.glossy_accuracy)),
        };
        RadianceCaching {
            setting,
            params: params.clone(),
            surfaces: Surfaces::new(setting.scene, params),
            caches: Some(caches),
            read: 0,
            focused: FocusedLight::where_it_matters(
                scene,
                seed,
                if params.caustics.by_photons() { w * h } else { 0 },
            ),
            counts: Counts::default(),
        }
    }

    /// Add the light that mirrors and glass focus.
    pub(crate) fn with_focused(
        &self,
        estimate: Option<Estimate>,
        v: &EyeVertex,
    ) -> Option<Estimate> {
        self.focused.add_to(estimate, self.setting.scene, v, &self.params.limits)
    }

    /// Indirect light at a vertex, interpolated from the records of the caches.
    fn interpolate(&self, v: &EyeVertex) -> Option<Estimate> {
        if !self.is_for_cache(v) {
            return None;
        }
        let (covers, indirect) = match self.surfaces.rule(v) {
            Rule::Path => return None,
            Rule::Diffuse(part) => {
                let q = Query { p: v.surface.p, n: part.normal };
                let e = self.relaxing(|slack| self.irradiance(&q, slack))?;
                (Covers::Diffuse(part), part.albedo * INV_PI * e)
            }
            Rule::Glossy { part, n } => {
                self.counts.glossy.fetch_add(1, Relaxed);
                let q = Query { p: v.surface.p, n };
                let frame = Surfaces::frame(n, v.wo);
                let (e, light) = self.relaxing(|slack| self.radiance(&q, &frame, slack))?;
                let diffuse = part.map_or(Rgb::BLACK, |part| part.albedo * INV_PI * e);
                let glossy = match self.params.mode {
                    Mode::Sh => self.surfaces.glossy(v, &light),
                    Mode::RhoE => self.surfaces.albedo(v) * INV_PI * e,
                };
                (Covers::NonDelta, self.above_zero(diffuse + glossy))
            }
        };
        Some(Estimate { covers, indirect, direct: None, caustic: None })
    }

    /// Look up; between the pixels that the overture looked at: what is nearly good enough, or else a path.
    fn relaxing<T>(&self, lookup: impl Fn(f32) -> Option<T>) -> Option<T> {
        lookup(1.0).or_else(|| {
            let relaxed = lookup(RELAXED);
            let count = if relaxed.is_some() { &self.counts.relaxed } else { &self.counts.failed };
            count.fetch_add(1, Relaxed);
            relaxed
        })
    }

    /// Ringing may lead below zero.
    fn above_zero(&self, radiance: Rgb) -> Rgb {
        if radiance.to_array().iter().any(|v| *v < 0.0) {
            self.counts.negative.fetch_add(1, Relaxed);
        }
        radiance.map(|v| v.max(0.0))
    }

    /// Whether records hold what a vertex wants. With a largest depth they hold the light of what is left of it where they
    /// were made; elsewhere paths go on. Where only one segment is left there is no indirect light.
    pub(crate) fn is_for_cache(&self, v: &EyeVertex) -> bool {
        match self.params.limits.max_depth {
            None => true,
            Some(_) => v.segments == 1 && self.params.limits.goes_on(2),
        }
    }

    pub(crate) fn sees(&self, site: &Site, q: &Query) -> bool {
        !self.params.reach.leak_guard || sees(self.setting.scene, site, q)
    }

    fn irradiance(&self, q: &Query, slack: f32) -> Option<Rgb> {
        self.caches().diffuse.irradiance(q, self.gradients(), slack, |site| self.sees(site, q))
    }

    fn gradients(&self) -> Gradients {
        if self.params.gradients { Gradients::Both } else { Gradients::Off }
    }

    /// Irradiance and light in `frame`, whose z is the query's normal, from the records that are good for it.
    fn radiance(&self, q: &Query, frame: &Frame, slack: f32) -> Option<(Rgb, Coefficients)> {
        let Params { basis, gradients, .. } = self.params;
        let (mut e, mut weights) = (Rgb::BLACK, 0.0);
        let mut light = [Vec3A::ZERO; MAX_FUNCTIONS];
        let cache = &self.caches().glossy;
        cache.weigh(
            q,
            slack,
            |site| self.sees(site, q),
            |record, weight| {
                e += record.irradiance.extrapolate(q, self.gradients()) * weight;
                record.add_to(&mut light, q, frame, basis, (gradients, weight));
                weights += weight;
            },
        );
        if weights <= 0.0 {
            return None;
        }
        let order = self.surfaces.order();
        light[..order * order].iter_mut().for_each(|c| *c /= weights);
        if basis == Basis::Sh {
            Turn::into_frame(frame).apply(order, &mut light);
        }
        Some(((e / weights).map(|e| e.max(0.0)), light))
    }

    /// Settings that shape what a record holds: those of a saved cache must be this run's.
    fn shaping_settings(&self) -> String {
        let Params { accuracy, glossy_accuracy, basis, min_roughness, limits, .. } = &self.params;
        let Params { error, glossy_error, radius, .. } = &self.params;
        let depth = limits.max_depth.map_or(-1, |d| d as i32);
        let order = self.surfaces.order();
        let caustics = if self.params.caustics.by_photons() { "photon" } else { "path" };
        format!(
            "--accuracy {accuracy} ({error:?}) --glossy-accuracy {glossy_accuracy} ({glossy_error:?}, {radius:?}) \
             --order {order} --basis {basis:?} --min-roughness {min_roughness} --max-depth {depth} --caustics {caustics}"
        )
    }

    /// Take the records of a saved cache.
    fn read(&mut self, saved: &SavedCache) -> Result<(), String> {
        saved.check(self.setting.world, &self.shaping_settings())?;
        let functions = 3 * self.surfaces.order().pow(2);
        if saved.body.glossy.iter().any(|r| r.light.len() != functions) {
            return Err(
                "the cache is damaged: its records are of another order than it says".into()
            );
        }
        self.read = saved.body.diffuse.len() + saved.body.glossy.len();
        let caches = self.caches.as_mut().expect("caches");
        // Neighbours have limited each other already: putting them in changes nothing.
        saved.body.diffuse.iter().for_each(|r| caches.diffuse.insert(*r));
        saved.body.glossy.iter().for_each(|r| caches.glossy.insert(r.clone()));
        Ok(())
    }

    /// The caches as a file keeps them.
    pub fn saved(&self) -> SavedCache {
        let Caches { diffuse, glossy } = self.caches();
        let body =
            Records { diffuse: diffuse.records().to_vec(), glossy: glossy.records().to_vec() };
        SavedCache { world: self.setting.world, settings: self.shaping_settings(), body }
    }

    /// Both caches.
    pub fn caches(&self) -> &Caches {
        self.caches.as_ref().expect("caches")
    }

    /// The BRDF tables.
    pub fn surfaces(&self) -> &Surfaces {
        &self.surfaces
    }

    /// Irradiance of the records of both kinds.
    pub fn irradiance_records(&self) -> impl Iterator<Item = &Record> {
        let Caches { diffuse, glossy } = self.caches();
        diffuse.records().iter().chain(glossy.records().iter().map(|r| &r.irradiance))
    }
}
