//! Radiance caching [slides 15-20]: on glossy surfaces too, the light that arrives at a point from each direction
//! changes slowly along the surface. Store it in spherical harmonics; for each view, its dot product with the BRDF is
//! the reflected light.
//!
//! | | |
//! |---|---|
//! | estimate | direct light as in path tracing; caustics from photons or as in path tracing; indirect light of diffuse surfaces from irradiance records, of rough glossy surfaces from radiance records |
//! | record | L_i(w) ~ sum_k l_k y_k(w), where l_k is the integral of L_i y_k over N stratified rays, and the gradient of l_k along the surface |
//! | interpolation | l(x) = sum w_j l_j(x) / sum w_j over the records whose error at x is below the accuracy a, as for irradiance [slide 11] |
//! | radiance | L_o(w_o) = sum_k c_k(w_o) l_k. The coefficients c_k of f_r(w_o, .) cos are tabulated per elevation of w_o; l is rotated into the shading frame [slide 18] |
//! | `--order` | n, the number of bands; the basis has n^2 functions. 0: per material, until at most 5 % of the BRDF's energy is left out |
//! | `--basis` | `sh`, or `hsh` for hemispherical harmonics |
//! | `--window` | bands fade toward the order, against ringing: `none`, `hanning`, `lanczos` |
//! | `--min-roughness` | lobes narrower than this are path-traced |
//! | `--mode` | `sh`, or `rho-e`: rho_hd(w_o) E / pi, as if light arrived equally from all directions [slide 15] |
//! | `--rays`, `--accuracy` | of irradiance records, as in irradiance caching; `--glossy-rays`, `--glossy-accuracy` of radiance records |
//! | bias | as in irradiance caching: blotches, missing soft shadows. The order limits sharpness: reflections look as if the surface were rougher, bright ones have rings, and at grazing angles light leaks from below the horizon |
//! | coats | the base of a plastic counts as Lambertian; its coat changes that by a few per cent at most |
//! | sources | \[Krivanek05\], \[Gautron04\], \[Green03\], \[Ivanic96\], \[Ramamoorthi01\] |
//!
//! Read next: `sh.rs` (the basis), `brdf.rs` (c_k), `record.rs` and `project.rs` (l_k and its gradient), `rotate.rs`
//! (rotation of l), `surfaces.rs` (which surface uses which record), `prepass.rs` (how the caches are filled); then the
//! crate `lightcache`.

#![forbid(unsafe_code)]

pub mod brdf;
pub mod caches;
pub mod figures;
pub mod file;
mod params;
mod prepass;
mod project;
pub mod record;
pub mod rotate;
pub mod sh;
mod statistics;
pub mod surfaces;
#[cfg(test)]
mod test_scenes;

use std::path::Path;

use gi_core::bytes::checksum;
use gi_core::caustics::FocusedLight;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::files;
use gi_core::film::{Film, Show};
use gi_core::math::{Frame, INV_PI, Rgb};
use gi_core::technique::{Picture, Setting, Technique};
use glam::Vec3A;
use lightcache::export::to_file;
use lightcache::guard::LeakGuard;
use lightcache::record::Gradients;
use lightcache::site::{Query, RELAXED, Site};

use brdf::{BrdfRow, BrdfTable};
pub use caches::Caches;
use figures::Subject;
use file::SavedCache;
pub use params::{Figure, Mode, Params};
use prepass::{Filler, Gatherers};
use rotate::Turn;
use sh::{Basis, Coefficients, MAX_FUNCTIONS};
use statistics::{LookupCounts, RaysPerRecord, statistics};
use surfaces::{Rule, Surfaces};

/// Radiance caching.
pub struct RadianceCaching<'a> {
    setting: Setting<'a>,
    params: Params,
    /// Photons of light over mirrors and glass, of the current pass.
    focused: FocusedLight,
    surfaces: Surfaces,
    guard: LeakGuard<'a>,
    caches: Caches,
    /// Number of records that came from a file.
    records_read: usize,
    counts: LookupCounts,
}

impl<'a> Technique<'a> for RadianceCaching<'a> {
    type Params = Params;

    /// Tabulate BRDFs, then fill the caches: look at every pixel from coarse to fine, and make records where none is
    /// valid.
    fn prepare(setting: Setting<'a>, params: &Params) -> Result<Self, String> {
        let Setting { scene, camera, seed, show, world, .. } = setting;
        let surfaces = Surfaces::new(scene, params);
        let mut caches = Caches::empty(&setting, params);
        let order = surfaces.order();
        let records_read = match &params.files.cache_in {
            Some(path) => file::insert(SavedCache::open(path)?, world, params, order, &mut caches)
                .map_err(|e| files::refusal(path, &e))?,
            None => 0,
        };
        let [width, height] = camera.size();
        let pixels = if params.caustics.by_photons() { width * height } else { 0 };
        let mut focused = FocusedLight::where_it_matters(scene, seed, pixels);
        let guard = LeakGuard { scene, is_on: params.reach.leak_guard };
        if matches!(show, Show::All | Show::Indirect) {
            focused.shoot(scene, seed ^ PREPASS_SEED, 0);
            let (setting, surfaces, focused) = (&setting, &surfaces, &focused);
            caches = Filler { setting, params, surfaces, focused, guard }.fill(caches);
        }
        let (params, counts) = (params.clone(), LookupCounts::default());
        Ok(RadianceCaching {
            setting,
            params,
            focused,
            surfaces,
            guard,
            caches,
            records_read,
            counts,
        })
    }

    /// One path per pixel; its indirect light comes from the caches.
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
        self.counts.save()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        self.counts.restore(state)
    }

    fn statistics(&self) -> Vec<(String, f64)> {
        let Gatherers { diffuse, glossy } = Gatherers::new(&self.setting, &self.params);
        let rays = RaysPerRecord { diffuse: diffuse.strata.count(), glossy: glossy.strata.count() };
        statistics(&self.caches, &self.surfaces, self.records_read, &rays, &self.counts)
    }

    fn reach(&self) -> String {
        let glossy = match &self.surfaces.decided[..] {
            [] => "no glossy lobes".to_string(),
            decided => decided.join("; "),
        };
        format!(
            "direct light as path tracing does; caustics from photons (blurred) or paths; indirect light interpolated (biased): of diffuse parts from \
             irradiance records, of glossy lobes of roughness {} or more from radiance records, of all others \
             path-traced; {glossy}",
            self.params.min_roughness
        )
    }

    fn pictures(&self, film: &Film) -> Vec<Picture> {
        let RadianceCaching { setting, params, surfaces, caches, .. } = self;
        let subject = Subject { setting, params, surfaces, caches, dot };
        self.params.figures.iter().flat_map(|f| f.draw(&subject, film)).collect()
    }

    fn export(&self, path: &Path) -> Vec<u8> {
        if self.params.files.cache_out.as_deref() == Some(path) {
            return self.saved().to_bytes();
        }
        to_file(path, self.caches.irradiance_records(), self.setting.scene.origin())
    }
}

/// Separates the random numbers of the prepass from those of the passes.
const PREPASS_SEED: u32 = 0x6f76_6572;

impl RadianceCaching<'_> {
    /// Indirect light at a vertex from the caches, and focused light from photons.
    fn estimate(&self, v: &EyeVertex) -> Option<Estimate> {
        let covered = self.params.covers_depth(v.segments);
        let estimate = covered.then(|| self.indirect(v)).flatten();
        self.focused.add_to(estimate, self.setting.scene, v, &self.params.limits)
    }

    /// Indirect light at a vertex, from the kind of record that its surface uses.
    fn indirect(&self, v: &EyeVertex) -> Option<Estimate> {
        let (covers, indirect) = match self.surfaces.rule(v) {
            Rule::Path => return None,
            Rule::Diffuse(part) => {
                let x = Query { p: v.surface.p, n: part.normal };
                let e = self.relaxing(|slack| self.irradiance(&x, slack))?;
                (Covers::Diffuse(part), part.albedo * INV_PI * e)
            }
            Rule::Glossy { part, n } => {
                self.counts.add_glossy();
                let x = Query { p: v.surface.p, n };
                let frame = Surfaces::frame(n, v.wo);
                let (e, light) = self.relaxing(|slack| self.radiance(&x, &frame, slack))?;
                let diffuse = part.map_or(Rgb::BLACK, |part| part.albedo * INV_PI * e);
                let glossy = match self.params.mode {
                    Mode::Sh => {
                        self.surfaces.sum_lobes(v, |brdf, cos_o| dot(&brdf.at(cos_o), &light))
                    }
                    Mode::RhoE => self.surfaces.sum_lobes(v, BrdfTable::albedo) * INV_PI * e,
                };
                (Covers::NonDelta, self.without_negative(diffuse + glossy))
            }
        };
        Some(Estimate { covers, indirect, direct: None, caustic: None })
    }

    /// Irradiance E(x) = sum w_j E_j(x) / sum w_j over the records that are valid at x [slide 11]. `slack` multiplies
    /// the allowed error.
    #[inline]
    fn irradiance(&self, x: &Query, slack: f32) -> Option<Rgb> {
        let (mut sum, mut weights) = (Rgb::BLACK, 0.0);
        let is_visible = |site: &Site| self.guard.passes(site, x);
        self.caches.diffuse.for_each_valid(x, slack, is_visible, |record, weight| {
            sum += record.extrapolate(x, self.gradients()) * weight;
            weights += weight;
        });
        // Gradients may lead below zero.
        (weights > 0.0).then(|| (sum / weights).map(|e| e.max(0.0)))
    }

    /// Irradiance E(x) and the coefficients l(x) = sum w_j l_j(x) / sum w_j of incoming light in `frame`, whose z is
    /// the query's normal.
    fn radiance(&self, x: &Query, frame: &Frame, slack: f32) -> Option<(Rgb, Coefficients)> {
        let Params { basis, gradients, .. } = self.params;
        let (mut e, mut weights) = (Rgb::BLACK, 0.0);
        let mut light = [Vec3A::ZERO; MAX_FUNCTIONS];
        let is_visible = |site: &Site| self.guard.passes(site, x);
        self.caches.glossy.for_each_valid(x, slack, is_visible, |record, weight| {
            e += record.irradiance.extrapolate(x, self.gradients()) * weight;
            record.add_to(&mut light, x, frame, basis, gradients, weight);
            weights += weight;
        });
        if weights <= 0.0 {
            return None;
        }
        let order = self.surfaces.order();
        light[..order * order].iter_mut().for_each(|l| *l /= weights);
        if basis == Basis::Sh {
            Turn::into_frame(frame).apply(order, &mut light);
        }
        Some(((e / weights).map(|e| e.max(0.0)), light))
    }

    /// Look up with the allowed error. Between the pixels of the prepass that may fail: then accept records with a
    /// larger error. If there are none, the path continues.
    fn relaxing<T>(&self, lookup: impl Fn(f32) -> Option<T>) -> Option<T> {
        lookup(1.0).or_else(|| {
            let relaxed = lookup(RELAXED);
            self.counts.add_relaxed(relaxed.is_some());
            relaxed
        })
    }

    /// Ringing may make a channel negative: set it to zero.
    fn without_negative(&self, radiance: Rgb) -> Rgb {
        if radiance.to_array().iter().any(|v| *v < 0.0) {
            self.counts.add_negative();
        }
        radiance.map(|v| v.max(0.0))
    }

    fn gradients(&self) -> Gradients {
        if self.params.gradients { Gradients::Both } else { Gradients::Off }
    }

    /// The caches in the form that a file stores.
    pub fn saved(&self) -> SavedCache {
        file::saved(self.setting.world, &self.params, self.surfaces.order(), &self.caches)
    }

    /// Both caches.
    pub fn caches(&self) -> &Caches {
        &self.caches
    }

    /// The BRDF tables.
    pub fn surfaces(&self) -> &Surfaces {
        &self.surfaces
    }
}

/// Reflected radiance, the dot product L_o(w_o) = sum_k c_k(w_o) l_k [slide 18]. In the frame of the tables the c_k
/// with m < 0 are zero.
#[inline]
fn dot(brdf: &BrdfRow, light: &Coefficients) -> Rgb {
    let (mut low, mut high) = (Vec3A::ZERO, Vec3A::ZERO);
    for l in 0..brdf.order {
        for m in 0..=l {
            let (c, k) = (l * (l + 1) / 2 + m, l * (l + 1) + m);
            low += brdf.low[c] * light[k];
            high += brdf.high[c] * light[k];
        }
    }
    Rgb::from(low.lerp(high, brdf.fraction).to_array())
}
