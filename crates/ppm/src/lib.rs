//! Progressive photon mapping: passes of photons that are not stored, and a radius that shrinks [slides 35 to 46].
//!
//! | | |
//! |---|---|
//! | estimate | indirect light and caustics by photons; direct light by sampling lights |
//! | formula | L = tau / (pi R^2 n), n passes; R' = R sqrt((N + alpha M) / (N + M)), N' = N + alpha M, tau' = (tau + tau_M) R'^2 / R^2 [slides 41, 42] |
//! | `--method` | `ppm`: hit points are found once \[Hachisuka08\]; `sppm`: every pass finds new hit points \[Hachisuka09\]; `ppa`: R depends on the number of the pass only \[Knaus11\]; `adaptive`: R balances noise and bias \[Kaplanyan13\] |
//! | emission | light from infinity is aimed at the points that eye paths reach after the first gather point, without bias |
//! | edges and walls | only the visible part of a disc counts, and the flux is divided by its area |
//! | bias | light is blurred over R: caustics and contact shadows start soft, and sharpen with the passes |
//! | how it fails | blotches as large as the initial radius where photons are few, because the radius shrinks slowly there |
//! | sources | \[Hachisuka08\], \[Hachisuka09\], \[Hachisuka10\], \[Knaus11\], \[Kaplanyan13\] |
//!
//! In every pass tau / R^2 grows by exactly the flux of that pass / R^2, whatever R becomes later. So the estimate is
//! the mean of the estimates of all passes, each with its own radius, and a pass is a sample of the film as in any
//! other technique.
//!
//! Read next: `region.rs` (a pixel in a pass), `gather.rs` (gathering), `methods.rs` (radii), `photons.rs` (photon
//! tracing), `params.rs` (the options).
#![forbid(unsafe_code)]

mod aim;
mod checkpoint;
mod error;
mod gather;
mod initial;
pub mod methods;
mod params;
pub mod photons;
mod region;
mod shows;
pub mod statistics;

use std::path::Path;

use gi_core::film::{Film, PerPixel, Show};
use gi_core::technique::{Picture, Setting, Technique};

pub use crate::error::Moments;
use crate::initial::{AtBounds, PILOT};
use crate::methods::probabilistic_radius;
pub use crate::params::{Figure, Method, Params};
use crate::photons::{Emission, Photon, Photons};
use crate::region::{Look, Region};
pub use crate::shows::Trace;
use crate::statistics::{Counts, Pass, Statistics};

/// Progressive photon mapping.
pub struct Ppm<'a> {
    setting: Setting<'a>,
    params: Params,
    emission: Emission,
    pixels: PerPixel<Region>,
    at_bounds: AtBounds,
    traces: Vec<Trace>,
    counts: Counts,
}

/// Fewest light paths of a pass, unless `--photons` sets their number, if the irradiance of sensors is computed. One path per pixel would
/// be too few.
const FEWEST_PATHS_FOR_SENSORS: u32 = 1 << 16;

impl<'a> Technique<'a> for Ppm<'a> {
    type Params = Params;

    /// Find the initial radii, and the hit points of `ppm`.
    fn prepare(setting: Setting<'a>, params: &Params) -> Result<Self, String> {
        let [w, h] = setting.camera.size();
        check_pixels(params, [w, h])?;
        let least = if setting.camera.sensors().is_some() { FEWEST_PATHS_FOR_SENSORS } else { 1 };
        let paths = if params.photons > 0 { params.photons } else { ((w * h) as u32).max(least) };
        let emission = Emission {
            seed: setting.seed,
            paths,
            rr_from: params.photon_rr_depth,
            max_segments: params.limits.max_depth.map(|most| most.saturating_sub(1)),
            direct: params.direct_by_photons,
            targets: aim::targets(&setting, params),
        };
        let photons = trace(&setting, params, &emission, PILOT);
        let look = Look { setting: &setting, params, index: PILOT, moments: false };
        let (pixels, at_bounds) = initial::regions(&look, &photons);
        let traces = params.trace_pixels.iter().map(|&at| Trace::new(at)).collect();
        let counts = Counts { error: f64::INFINITY, ..Counts::default() };
        let params = params.clone();
        Ok(Ppm { setting, params, emission, pixels, at_bounds, traces, counts })
    }

    /// One pass: trace photons, build the grid, then gather at every pixel.
    fn pass(&mut self, index: u32, film: &mut Film) {
        let photons = trace(&self.setting, &self.params, &self.emission, index);
        let grid = Photons::build(&photons, self.mean_radius(index));
        drop(photons);
        let look = Look {
            setting: &self.setting,
            params: &self.params,
            index,
            moments: self.needs_moments(),
        };
        let alpha = match self.params.method {
            Method::Ppm | Method::Sppm => self.params.alpha,
            // These methods choose the radius before the pass.
            Method::Ppa | Method::Adaptive => 1.0,
        };
        let passes_before = film.passes();
        film.add_pass_with(&mut self.pixels, |at, region| {
            let sample = look.pixel(at, region, &grid);
            if self.params.method == Method::Ppm {
                region
                    .hits
                    .iter_mut()
                    .for_each(|hit| update(&mut hit.statistics, &hit.pass, alpha));
                region.statistics = region.hits.first().map_or(region.statistics, |h| h.statistics);
            } else {
                update(&mut region.statistics, &region.pass, alpha);
            }
            sample
        });
        // The pass was interrupted, so it is not in the film.
        if film.passes() == passes_before {
            return;
        }
        let of_pass = Counts {
            passes: 1,
            paths: u64::from(self.emission.paths),
            stored: grid.len() as u64,
            contributed: self.pixels.sum(|r| r.pass.photons as f64) as u64,
            error: self.counts.error,
        };
        self.counts = of_pass.after(&self.counts);
        let unit = f64::from(self.setting.scene.radius());
        for trace in &mut self.traces {
            trace.push(index, self.counts.passes, self.pixels.get(trace.at), unit);
        }
        if self.needs_moments() {
            self.counts.error = self.error_estimate();
        }
    }

    fn is_done(&self) -> bool {
        self.counts.error < self.params.stop_at_error
    }

    fn recall(&mut self, index: u32, _: &Film) {
        if self.params.method == Method::Ppa {
            let look = Look {
                setting: &self.setting,
                params: &self.params,
                index,
                moments: self.needs_moments(),
            };
            self.pixels.for_each_row_mut(|region| look.choose_radius(region));
        }
    }

    /// Only the probabilistic radius does not depend on earlier passes.
    fn passes_are_independent(&self) -> bool {
        self.params.method == Method::Ppa
    }

    fn save_state(&self) -> Vec<u8> {
        self.write_state()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        self.read_state(state, true)
    }

    fn merge_state(&mut self, state: &[u8]) -> Result<(), String> {
        if !self.params.figures.is_empty() {
            return Err("`--show` draws the state of one run: leave it out of a merge".into());
        }
        if !self.traces.is_empty() {
            return Err(
                "`--trace-out` writes the passes of one run: leave it out of a merge".into()
            );
        }
        self.read_state(state, false)
    }

    fn statistics(&self) -> Vec<(String, f64)> {
        let Counts { passes, paths, stored, contributed, error } = self.counts;
        let pixels = self.setting.camera.size().iter().product::<usize>() as f64;
        let mean = self.pixels.sum(|r| r.statistics.radius) / pixels;
        let initial = self.pixels.sum(|r| r.initial) / pixels;
        let unit = f64::from(self.setting.scene.radius());
        let mut all = vec![
            ("photon_paths".into(), paths as f64),
            ("photons_stored".into(), stored as f64),
            ("photons_contributed".into(), contributed as f64),
            ("initial_radius_mean".into(), initial / unit),
            ("radius_mean".into(), mean / unit),
            ("initial_radius_at_least".into(), self.at_bounds.least as f64),
            ("initial_radius_at_most".into(), self.at_bounds.most as f64),
        ];
        if self.params.method == Method::Adaptive {
            let last = methods::derivative_radius(passes.saturating_sub(1));
            let at_most = |r: &Region| r.statistics.radius >= r.initial * last * (1.0 - 1e-9);
            let count = self.pixels.sum(|r| f64::from(u8::from(at_most(r))));
            all.push(("radius_at_most".into(), count));
        }
        if error.is_finite() {
            all.push(("error_estimate".into(), error));
        }
        all
    }

    fn reach(&self) -> String {
        format!(
            "all paths; those that end in photons with a blur that vanishes with the passes. Photons are gathered where the \
             sharpest lobe has alpha >= {}, on sharper surfaces only the Lambertian part gathers photons; paths follow the rest",
            self.params.min_roughness
        )
    }

    fn pictures(&self, _: &Film) -> Vec<Picture> {
        let unit = f64::from(self.setting.scene.radius());
        self.params.figures.iter().map(|what| what.draw(&self.pixels, unit)).collect()
    }

    fn export(&self, _: &Path) -> Vec<u8> {
        self.traces_csv()
    }
}

/// Add a pass to the statistics, and shrink the disc so that a fraction `alpha` of the pass's photons stays [slides 41,
/// 42]:
///
/// N' = N + alpha M, R' = R sqrt(N' / (N + M)), tau' = (tau + tau_M) R'^2 / R^2
pub fn update(statistics: &mut Statistics, pass: &Pass, alpha: f64) {
    // d'(x) = (N + M) / (pi R^2): the density stays the same, so the area shrinks in proportion to the number of
    // photons [slide 41].
    let (n, m) = (statistics.photons, pass.photons as f64);
    let ratio = if n + m > 0.0 { (n + alpha * m) / (n + m) } else { 1.0 };
    statistics.radius *= ratio.sqrt();
    statistics.photons = (n + m) * ratio;
    for (tau, tau_m) in statistics.flux.iter_mut().zip(pass.flux) {
        *tau = (*tau + tau_m) * ratio;
    }
}

/// Check that the pixels to trace lie in the picture.
fn check_pixels(params: &Params, [w, h]: [usize; 2]) -> Result<(), String> {
    if let Some([x, y]) = params.trace_pixels.iter().find(|[x, y]| *x >= w || *y >= h) {
        return Err(format!("--trace-pixel {x},{y}: the picture has {w} x {h} pixels"));
    }
    Ok(())
}

/// The photons of a pass.
fn trace(setting: &Setting, params: &Params, emission: &Emission, pass: u32) -> Vec<Vec<Photon>> {
    if setting.show == Show::Direct && !params.direct_by_photons {
        return Vec::new();
    }
    emission.trace(setting.scene, pass, |vertex| {
        !vertex.bsdf.is_delta()
            && gather::covers(&vertex.bsdf, vertex.wo, params.min_roughness).is_some()
    })
}

impl Ppm<'_> {
    /// The traced pixels as CSV: one line per pixel and pass.
    pub fn traces_csv(&self) -> Vec<u8> {
        shows::to_csv(&self.traces)
    }

    /// Whether noise and bias are needed.
    fn needs_moments(&self) -> bool {
        let p = &self.params;
        p.method == Method::Adaptive || p.stop_at_error > 0.0 || p.figures.contains(&Figure::Error)
    }

    /// Mean radius over the picture before pass `index`, world units. The order in which photons are added depends on it, so with
    /// [`Method::Ppa`] it must not depend on earlier passes.
    fn mean_radius(&self, index: u32) -> f32 {
        let pixels = self.setting.camera.size().iter().product::<usize>() as f64;
        let sum = match self.params.method {
            Method::Ppa => {
                self.pixels.sum(|r| r.initial) * probabilistic_radius(index, self.params.alpha)
            }
            _ => self.pixels.sum(|r| r.statistics.radius),
        };
        (sum / pixels) as f32
    }

    /// The root of the estimated relMSE of the picture's luminance: (noise^2 + bias^2) / (radiance^2 + 0.01). Infinite
    /// during the first passes.
    pub fn error_estimate(&self) -> f64 {
        if self.counts.passes < FEWEST_PASSES {
            return f64::INFINITY;
        }
        let pixels = self.setting.camera.size().iter().product::<usize>() as f64;
        let relative = |m: &Moments| {
            let scale = m.mean() * m.mean() + RELATIVE_FLOOR;
            (m.noise_sq() + m.bias_sq()) / scale
        };
        (self.pixels.sum(|r| relative(&r.moments)) / pixels).max(0.0).sqrt()
    }
}

/// Number of passes before which the variance is not trusted.
const FEWEST_PASSES: u32 = 4;

/// Keeps relative errors of dark pixels finite.
const RELATIVE_FLOOR: f64 = 1e-2;
