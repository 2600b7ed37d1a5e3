//! Instant radiosity [slides 47-52, Keller97]: light paths leave virtual point lights where they meet surfaces, and
//! every point that the eye sees is lit by all of them, with shadows.
//!
//! | | |
//! |---|---|
//! | estimated | L(x) = sum_i f(x) f(y_i) cos cos' / d^2 V(x, y_i) power_i over the virtual point lights y_i of a pass, passes averaged: the accumulation buffer |
//! | `--vpls` | about how many lights a pass has |
//! | `--termination` | when light paths end: fractional absorption (the original) or Russian roulette |
//! | `--clamp` | bound of the geometric term cos cos' / d^2 in units of one over the squared radius of the scene; `inf` is none |
//! | `--compensation` | `path`: what the bound cut off comes back by paths, without bias \[Kollig04\]; `none` |
//! | `--caustics` | `photon`: light that mirrors and glass focus is read from photons, blurred over discs that shrink with the passes; `path` |
//! | `--vsl` | lights are small spheres instead of points: no bound, no bright spots on glossy surfaces, blurred \[Hasan09\] |
//! | `--relaxation` | passes k = 0, 1, ... bound by clamp (k + 1)^relaxation: the bias goes to zero \[Davidovic12\] |
//! | `--direct` | direct light by sampling lights, or by points of lights as virtual lights [slides 47, 48] |
//! | bias | none with compensation, but for the blur of caustics; with a bound alone, corners and contacts are too dark |
//! | how it fails | few lights show as hard shadows of each; without a bound, as bright spots where a light is near |
//! | sources | \[Keller97\], \[Kollig04\], \[Hasan09\], \[Davidovic12\] |

#![forbid(unsafe_code)]

pub mod figures;
mod params;
pub mod sphere;

use std::ops::Range;
use std::path::Path;

use gi_core::caustics::FocusedLight;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::film::{Film, Show};
use gi_core::math::Rgb;
use gi_core::sampler::Sampler;
use gi_core::technique::{Picture, Setting, Technique};
use vpl::{
    Direct, Energy, MIN_ROUGHNESS, Pilot, Prepared, Receiver, Shooting, Vpls, shoot, to_file,
};

pub use params::{Figure, Params};
use sphere::Spheres;

/// Instant radiosity.
pub struct InstantRadiosity<'a> {
    setting: Setting<'a>,
    params: Params,
    pilot: Pilot,
    /// The lights of the last pass.
    vpls: Vpls,
    spheres: Spheres,
    focused: FocusedLight,
    energy: Energy,
    /// Lights and paths of all passes.
    lights: u64,
    paths: u64,
}

impl<'a> Technique<'a> for InstantRadiosity<'a> {
    type Params = Params;

    fn prepare(setting: Setting<'a>, params: &Params) -> Result<Self, String> {
        let Setting { scene, camera, seed, .. } = setting;
        let pilot = Pilot::of(scene, seed);
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
            energy: Energy::default(),
            lights: 0,
            paths: 0,
        })
    }

    /// A set of virtual point lights, and one sample a pixel lit by all of them.
    fn pass(&mut self, index: u32, film: &mut Film) {
        self.vpls = self.shoot(index);
        if self.params.vsl {
            self.spheres = Spheres::round(&self.vpls.lights, self.setting.scene);
        }
        self.focused.shoot(self.setting.scene, self.setting.seed, index);
        self.lights += self.vpls.lights.len() as u64;
        self.paths += self.vpls.paths;
        let most = self.bound(index);
        let lights = Prepared::new(&self.vpls, self.setting.scene);
        film.add_pass(|pixel| {
            let mut walk = EyeWalk::through_pixel(&self.setting, self.params.limits, pixel, index);
            while let Some(v) = &walk.next_vertex() {
                walk.add_emitted(v);
                if v.wants_estimate()
                    && let Some(estimate) = self.gather(v, &lights, most, &mut walk.sampler)
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
        let [kept, cut] = self.energy.kept_and_cut();
        vec![
            ("vpls".into(), self.lights as f64),
            ("light_paths".into(), self.paths as f64),
            ("reflectance".into(), self.pilot.reflectance.into()),
            ("connections".into(), self.energy.connections() as f64),
            ("energy_cut".into(), cut / (kept + cut).max(f64::MIN_POSITIVE)),
            ("caustic_photons".into(), self.focused.photons() as f64),
            ("caustic_radius".into(), self.focused.mean_radius()),
            ("vpl_bytes".into(), self.vpls.memory_bytes() as f64),
        ]
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
    /// The lights of a pass: its light paths are the next of one sequence.
    fn shoot(&self, index: u32) -> Vpls {
        // Where nothing of their light is shown, there are none.
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
            // A path of the eye, the connection, and the light's own way are two segments more.
            max_scatterings: self.params.limits.max_depth.map(|d| d.saturating_sub(2)),
            lights: self.params.direct == Direct::Vpl,
            pilot: self.pilot,
        };
        shoot(self.setting.scene, &how)
    }

    /// The bound of a pass, per squared world unit.
    fn bound(&self, index: u32) -> f32 {
        let radius = self.setting.scene.radius();
        self.params.bound.clamp * (index as f32 + 1.0).powf(self.params.relaxation)
            / (radius * radius)
    }

    /// Light a vertex by all lights [slide 50].
    fn gather(
        &self,
        v: &EyeVertex,
        lights: &Prepared,
        most: f32,
        sampler: &mut Sampler,
    ) -> Option<Estimate> {
        let bsdf = v.bsdf.broad(v.wo, MIN_ROUGHNESS)?;
        let at = Receiver::new(&v.surface, v.wo, &bsdf);
        // A light after j scatterings has come j + 1 segments, and the connection is one more.
        let deepest = match self.params.limits.max_depth {
            None => u32::MAX,
            Some(most) => most.checked_sub(v.segments + 1)?,
        };
        let points = self.vpls.up_to(0).len();
        let surfaces = points..self.vpls.up_to(deepest).len();
        // The points of lights are direct light, and nothing bounds them [slides 47, 48].
        let direct = || self.add_up(&at, lights, 0..points, f32::INFINITY);
        let direct = (self.params.direct == Direct::Vpl).then(direct);
        let indirect = if self.params.vsl {
            self.spheres.gather(self, &at, surfaces, sampler)
        } else {
            self.add_up(&at, lights, surfaces, most)
        };
        let is_compensated = self.params.bound.is_compensated() && !self.params.vsl;
        let most = if is_compensated { most } else { f32::INFINITY };
        let covers = Covers::Visible { max_geometry: most, min_roughness: MIN_ROUGHNESS };
        // A photon after j scatterings has come j + 1 segments.
        let caustic = self.focused.radiance(self.setting.scene, (&v.surface, v.wo, &bsdf), deepest);
        Some(Estimate { covers, direct, indirect, caustic })
    }

    /// The sum over a range of lights, every geometric term bounded by `most`.
    fn add_up(&self, at: &Receiver, lights: &Prepared, range: Range<usize>, most: f32) -> Rgb {
        let (mut sum, mut cut) = (Rgb::BLACK, 0.0);
        let connections = lights.for_each_visible(range, at, |c, through| {
            let arrived = c.radiance * through;
            let share = if c.geometry > most { most / c.geometry } else { 1.0 };
            cut += (arrived * (1.0 - share)).luminance();
            sum += arrived * share;
        });
        self.energy.note(sum.luminance(), cut, connections);
        sum
    }

    /// The lights of the last pass.
    pub fn vpls(&self) -> &Vpls {
        &self.vpls
    }
}
