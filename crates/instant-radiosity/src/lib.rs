//! Instant radiosity [slides 47-52, Keller97]: light paths leave virtual point lights where they meet surfaces, and all
//! of these lights illuminate every point that the eye sees, with shadows.
//!
//! | | |
//! |---|---|
//! | estimate | L(x) = sum_i f(x) f(y_i) min(G(x, y_i), b) V(x, y_i) power_i over the virtual point lights y_i of a pass, with the geometry term G = cos cos' / d^2. Passes are averaged: the accumulation buffer |
//! | `--vpls` | approximate number of lights per pass |
//! | `--termination` | when light paths end: fractional absorption (the original) or Russian roulette |
//! | `--clamp` | b, the upper bound of the geometry term, in units of 1 / (scene radius)^2; `inf` for no bound |
//! | `--compensation` | `path`: eye paths find the light that the bound cuts off, without bias \[Kollig04\]; `none`: it is lost |
//! | `--caustics` | `photon`: light focused by mirrors and glass is read from photons, blurred over discs that shrink with the passes; `path` |
//! | `--vsl` | lights are small spheres instead of points: no bound and no bright spots on glossy surfaces, but blur \[Hasan09\] |
//! | `--relaxation` | r: the bound of pass k = 0, 1, ... is clamp (k + 1)^r, so the bias goes to zero \[Davidovic12\] |
//! | `--direct` | direct light by sampling light sources, or by virtual lights placed on them [slides 47, 48] |
//! | bias | with compensation, only the blur of caustics; without it, corners and contacts are too dark |
//! | how it fails | with few lights each one casts a visible hard shadow; without a bound, surfaces near a light have bright spots |
//! | sources | \[Keller97\], \[Kollig04\], \[Hasan09\], \[Davidovic12\] |
//!
//! Read next: in the crate `vpl`: `shoot.rs` (light paths leave lights), `illuminate.rs` (f G power for one light),
//! `prepared.rs` (the shadow rays to many lights); here: `sphere.rs` (lights as spheres).

#![forbid(unsafe_code)]

pub mod figures;
mod params;
pub mod sphere;
mod statistics;

use std::ops::Range;
use std::path::Path;

use gi_core::caustics::FocusedLight;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::film::{Film, Show};
use gi_core::math::Rgb;
use gi_core::sampler::Sampler;
use gi_core::technique::{Picture, Setting, Technique};
use vpl::{Direct, MIN_ROUGHNESS, Pilot, Prepared, Receiver, Shooting, Vpls, shoot, to_file};

pub use params::{Figure, Params};
use sphere::{SphereLights, Spheres};
use statistics::Totals;

/// Instant radiosity.
pub struct InstantRadiosity<'a> {
    setting: Setting<'a>,
    params: Params,
    pilot: Pilot,
    /// The lights of the last pass.
    vpls: Vpls,
    spheres: Spheres,
    focused: FocusedLight,
    totals: Totals,
}

impl<'a> Technique<'a> for InstantRadiosity<'a> {
    type Params = Params;

    fn prepare(setting: Setting<'a>, params: &Params) -> Result<Self, String> {
        let Setting { scene, camera, seed, .. } = setting;
        let pilot = Pilot::of(scene, seed, false);
        let [w, h] = camera.size();
        let pixels = if params.caustics.by_photons() { w * h } else { 0 };
        let focused = FocusedLight::new(scene, seed, pixels);
        Ok(InstantRadiosity {
            setting,
            params: params.clone(),
            pilot,
            vpls: Vpls::default(),
            spheres: Spheres::default(),
            focused,
            totals: Totals::default(),
        })
    }

    /// Make a set of virtual point lights, and illuminate one sample per pixel by all of them.
    fn pass(&mut self, index: u32, film: &mut Film) {
        self.make_lights(index);
        self.totals.add(&self.vpls);
        let bound = self.bound(index);
        let lights = Prepared::new(&self.vpls, self.setting.scene);
        film.add_pass(|pixel| {
            let mut walk = EyeWalk::through_pixel(&self.setting, self.params.limits, pixel, index);
            while let Some(v) = &walk.next_vertex() {
                walk.add_emitted(v);
                if v.wants_estimate()
                    && let Some(estimate) = self.gather(v, &lights, bound, &mut walk.sampler)
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

    fn recall(&mut self, index: u32, _: &Film) {
        self.make_lights(index);
    }

    fn save_state(&self) -> Vec<u8> {
        self.totals.save()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        self.totals.restore(state)
    }

    fn statistics(&self) -> Vec<(String, f64)> {
        self.totals.statistics(&self.pilot, &self.focused, &self.vpls)
    }

    fn reach(&self) -> String {
        let cut = if self.params.bound.loses_light() && !self.params.vsl {
            "; bounded geometric terms cut light off in corners (biased)"
        } else {
            ""
        };
        format!(
            "all paths that path tracing reaches, indirect light from virtual point lights{cut}"
        )
    }

    fn pictures(&self, film: &Film) -> Vec<Picture> {
        let draw = |f: &Figure| f.draw(&self.setting, &self.vpls, film, self.params.pixel);
        self.params.figures.iter().map(draw).collect()
    }

    fn export(&self, path: &Path) -> Vec<u8> {
        to_file(path, &self.vpls.lights, self.setting.scene.origin())
    }
}

impl InstantRadiosity<'_> {
    /// Make the lights of a pass, and the photons of light over mirrors and glass.
    fn make_lights(&mut self, index: u32) {
        self.vpls = self.shoot(index);
        if self.params.vsl {
            self.spheres = Spheres::round(&self.vpls.lights, self.setting.scene);
        }
        self.focused.shoot(self.setting.scene, self.setting.seed, index);
    }

    /// The lights of a pass. Its light paths continue the sequence of the passes before it.
    fn shoot(&self, index: u32) -> Vpls {
        // If none of their light is shown, make none.
        match self.setting.show {
            Show::Caustic => return Vpls::default(),
            Show::Direct if self.params.direct == Direct::Sample => return Vpls::default(),
            _ => {}
        }
        let paths = self.pilot.paths_for(self.params.vpls);
        let how = Shooting {
            seed: self.setting.seed,
            first_path: index.wrapping_mul(paths),
            paths,
            termination: self.params.termination,
            // The eye ray and the connection are two of the segments that `max_depth` counts.
            max_scatterings: self.params.limits.max_depth.map(|d| d.saturating_sub(2)),
            lights: self.params.direct == Direct::Vpl,
            pilot: self.pilot,
            through_media: false,
        };
        shoot(self.setting.scene, &how)
    }

    /// The bound of the geometry term in a pass, per squared world unit.
    fn bound(&self, index: u32) -> f32 {
        let radius = self.setting.scene.radius();
        self.params.bound.clamp * (index as f32 + 1.0).powf(self.params.relaxation)
            / (radius * radius)
    }

    /// The light of a vertex from all virtual lights, and what it covers: the path continues for the rest.
    fn gather(
        &self,
        v: &EyeVertex,
        lights: &Prepared,
        bound: f32,
        sampler: &mut Sampler,
    ) -> Option<Estimate> {
        let bsdf = v.bsdf.broad(v.wo, MIN_ROUGHNESS)?;
        let x = Receiver::new(&v.surface, v.wo, &bsdf);
        // A light or photon after j scatterings has j + 1 segments behind it, and the connection is one more.
        let max_scatterings = match self.params.limits.max_depth {
            None => u32::MAX,
            Some(max_depth) => max_depth.checked_sub(v.segments + 1)?,
        };
        let on_sources = 0..self.vpls.up_to(0).len();
        let on_surfaces = on_sources.end..self.vpls.up_to(max_scatterings).len();
        // Virtual lights on light sources bring direct light; they have no bound [slides 47, 48].
        let direct = || self.add_up(&x, lights, on_sources, f32::INFINITY);
        let direct = (self.params.direct == Direct::Vpl).then(direct);
        let indirect = if self.params.vsl {
            self.add_up_spheres(&x, on_surfaces, sampler)
        } else {
            self.add_up(&x, lights, on_surfaces, bound)
        };
        let is_compensated = self.params.bound.is_compensated() && !self.params.vsl;
        let max_geometry = if is_compensated { bound } else { f32::INFINITY };
        let covers = Covers::Visible { max_geometry, min_roughness: MIN_ROUGHNESS };
        let scene = self.setting.scene;
        let caustic = self.focused.radiance(scene, (&v.surface, v.wo, &bsdf), max_scatterings);
        Some(Estimate { covers, direct, indirect, caustic })
    }

    /// L(x) = sum_i f(x) f(y_i) min(G, b) V power_i over a range of the lights [slide 50].
    fn add_up(&self, x: &Receiver, lights: &Prepared, range: Range<usize>, bound: f32) -> Rgb {
        let (mut sum, mut cut) = (Rgb::BLACK, 0.0);
        let connections = lights.for_each_visible(range, x, |connection, visibility| {
            // f(x) f(y_i) G V power_i, with G not clamped yet.
            let radiance = connection.radiance * visibility;
            let kept = if connection.geometry > bound { bound / connection.geometry } else { 1.0 };
            cut += (radiance * (1.0 - kept)).luminance();
            sum += radiance * kept;
        });
        self.totals.energy.note(sum.luminance(), cut, connections);
        sum
    }

    /// The same sum over lights as spheres; it needs no bound.
    fn add_up_spheres(&self, x: &Receiver, range: Range<usize>, sampler: &mut Sampler) -> Rgb {
        let lights = SphereLights {
            scene: self.setting.scene,
            vpls: &self.vpls,
            spheres: &self.spheres,
            samples: self.params.vsl_samples,
        };
        let (sum, connections) = lights.gather(x, range, sampler);
        self.totals.energy.note(sum.luminance(), 0.0, connections);
        sum
    }

    /// The lights of the last pass.
    pub fn vpls(&self) -> &Vpls {
        &self.vpls
    }
}
