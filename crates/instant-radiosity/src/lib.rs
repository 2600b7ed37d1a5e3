//! Instant radiosity [slides 47-52, Keller97]: light paths leave virtual point lights where they meet surfaces, and
//! every point that the eye sees is lit by all of them, with shadows.
//!
//! | | |
//! |---|---|
//! | estimated | L(x) = sum_i f(x) f(y_i) cos cos' / d^2 V(x, y_i) power_i over the virtual point lights y_i of a pass, passes averaged: the accumulation buffer |
//! | `--vpls` | about how many lights a pass has (128) |
//! | `--termination` | when light paths end: fractional absorption (the original) or Russian roulette |
//! | `--clamp` | bound of the geometric term cos cos' / d^2 in units of one over the squared radius of the scene (20); `inf` is none |
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
pub mod sphere;

use std::ops::Range;

use gi_core::caustics::FocusedLight;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk, PathLimits};
use gi_core::film::Film;
use gi_core::math::Rgb;
use gi_core::sampler::Sampler;
use gi_core::technique::{Picture, Setting, Technique};
use vpl::{Energy, MIN_ROUGHNESS, Pilot, Prepared, Receiver, Shooting, Termination, Vpls, shoot};

use figures::Figure;
use sphere::Spheres;

/// The knobs.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// How long paths may be.
    pub limits: PathLimits,
    /// About how many virtual point lights a pass has.
    pub vpls: u32,
    /// When light paths end.
    pub termination: Termination,
    /// Bound of the geometric term, in units of one over the squared radius of the scene.
    pub clamp: f32,
    /// Whether paths bring back what the bound cut off.
    pub compensation: bool,
    /// Whether photons supply the light that mirrors and glass focus, instead of paths looking for it.
    pub caustic_photons: bool,
    /// How fast the bound grows with the passes.
    pub relaxation: f32,
    /// Spheres instead of points.
    pub vsl: bool,
    /// Directions in which a sphere's light is added up.
    pub vsl_samples: u32,
    /// Whether points of lights are virtual lights too, instead of direct light being sampled.
    pub direct_by_vpls: bool,
    /// What to draw.
    pub figures: Vec<Figure>,
}

impl Default for Params {
    fn default() -> Self {
        Params {
            limits: PathLimits::default(),
            vpls: 128,
            termination: Termination::Roulette,
            clamp: 20.0,
            compensation: true,
            caustic_photons: true,
            relaxation: 0.0,
            vsl: false,
            vsl_samples: 4,
            direct_by_vpls: false,
            figures: Vec::new(),
        }
    }
}

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
        let pixels = if params.caustic_photons { w * h } else { 0 };
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
        let cut = if self.params.compensation || self.params.clamp.is_infinite() || self.params.vsl
        {
            ""
        } else {
            "; bounded geometric terms cut light off in corners (biased)"
        };
        format!(
            "all paths that path tracing reaches, indirect light from virtual point lights{cut}"
        )
    }

    fn pictures(&self, film: &Film) -> Vec<Picture> {
        self.params.figures.iter().map(|f| f.draw(&self.setting, &self.vpls, film)).collect()
    }
}

impl InstantRadiosity<'_> {
    /// See [`gi_core::scene::Scene::origin`].
    pub fn origin(&self) -> glam::Vec3 {
        self.setting.scene.origin()
    }

    /// The lights of a pass: its light paths are the next of one sequence.
    fn shoot(&self, index: u32) -> Vpls {
        let paths = self.pilot.paths_for(self.params.vpls);
        let how = Shooting {
            seed: self.setting.seed,
            first_path: index.wrapping_mul(paths),
            paths,
            termination: self.params.termination,
            // A path of the eye, the connection, and the light's own way are two segments more.
            max_scatterings: self.params.limits.max_depth.map(|d| d.saturating_sub(2)),
            lights: self.params.direct_by_vpls,
            pilot: self.pilot,
        };
        shoot(self.setting.scene, &how)
    }

    /// The bound of a pass, per squared world unit.
    fn bound(&self, index: u32) -> f32 {
        let radius = self.setting.scene.radius();
        self.params.clamp * (index as f32 + 1.0).powf(self.params.relaxation) / (radius * radius)
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
        let direct = self.params.direct_by_vpls.then(direct);
        let indirect = if self.params.vsl {
            self.spheres.gather(self, &at, surfaces, sampler)
        } else {
            self.add_up(&at, lights, surfaces, most)
        };
        let most = if self.params.compensation && !self.params.vsl { most } else { f32::INFINITY };
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
