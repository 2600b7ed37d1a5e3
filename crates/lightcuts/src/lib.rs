//! Lightcuts [slides 53-61, Walter05]: all illumination becomes point lights, thousands to millions of them, and every
//! point is lit by a few clusters of them, chosen for it so that no cluster's error can be seen.
//!
//! | | |
//! |---|---|
//! | estimated | L(x) = sum over clusters C of a cut of f(x) G(x, y) V(x, y) power(C), with y the cluster's representative; passes, each with lights of its own, are averaged |
//! | `--error` | error that may be, relative to the whole: Weber's law |
//! | `--rule` | error of what: `cluster` (default), of each cluster alone, as in the lecture; `whole`, for 99 of 100 points of all clusters together too |
//! | `--max-cut` | most clusters of a cut (with `--error 0` no limit) |
//! | `--lights` | points of lights: areas, sky, sun (shared out by power) |
//! | `--vpls` | about how many virtual point lights indirect light has |
//! | `--fixed-lights` | all passes have the lights of the first: what lights' number leaves wrong stays |
//! | `--clamp`, `--compensation` | bound of the geometric term of indirect lights, and paths that bring back what it cuts off, as in instant radiosity |
//! | `--caustics` | `photon`: light that mirrors and glass focus is read from photons, blurred over discs that shrink with the passes; `path` |
//! | `--method` | `cuts`; `all`: light by light; `stochastic`, `one`: light drawn from the same trees, without bias \[Yuksel19, Conty18\] |
//! | `--reconstruct` | cuts at corners of blocks of pixels, interpolated between where they agree [Walter05, 5] |
//! | bias | a cluster's error is bounded by `--error` of the whole; errors of many clusters average out. None with `--error 0`, but for the blur of caustics |
//! | how it fails | lights that are few or near show as such; in the dark, where 2 % is little, and everywhere with `whole` and many lights, cuts reach their limit (`at_max_cut`) |
//! | sources | \[Walter05\], \[Keller97\], \[Kollig04\] |

#![forbid(unsafe_code)]

pub mod bound;
pub mod cluster;
pub mod cone;
pub mod cut;
pub mod figures;
pub mod light;
mod params;
mod picture;
pub mod reconstruct;
pub mod sample;
mod tally;
#[cfg(test)]
mod test_scenes;
pub mod tree;

use std::path::Path;

use gi_core::bytes::{Reader, Writer};
use gi_core::caustics::FocusedLight;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::film::{Film, Show};
use gi_core::sampler::Sampler;
use gi_core::technique::{Picture, Setting, Technique};
use vpl::{
    Direct, MIN_ROUGHNESS, Pilot, Prepared, Receiver, Shooting, Termination, Vpls, points, shoot,
};

use bound::Site;
use light::{At, Lights};
use reconstruct::Corners;
use tally::Tally;
use tree::Forest;

pub use params::{Method, Params, Reconstruction};

/// Lightcuts.
pub struct Lightcuts<'a> {
    setting: Setting<'a>,
    params: Params,
    pilot: Pilot,
    /// The lights of the last pass, and their trees.
    vpls: Vpls,
    forest: Forest,
    focused: FocusedLight,
    /// Which pass they were made for.
    made_for: u32,
    tally: Tally,
}

impl<'a> Technique<'a> for Lightcuts<'a> {
    type Params = Params;

    fn prepare(setting: Setting<'a>, params: &Params) -> Result<Self, String> {
        let Setting { scene, camera, seed, .. } = setting;
        let pilot = Pilot::of(scene, seed);
        let [w, h] = camera.size();
        let pixels = if params.caustics.by_photons() { w * h } else { 0 };
        let focused = FocusedLight::new(scene, seed, pixels);
        let mut technique = Lightcuts {
            setting,
            params: params.clone(),
            pilot,
            vpls: Vpls::default(),
            forest: Forest::default(),
            focused,
            made_for: 0,
            tally: Tally::default(),
        };
        technique.make_lights(0);
        Ok(technique)
    }

    /// A set of lights and its trees, and one sample a pixel lit by cuts.
    fn pass(&mut self, index: u32, film: &mut Film) {
        if index != self.made_for && !self.params.fixed_lights {
            self.make_lights(index);
        }
        self.focused.shoot(self.setting.scene, self.setting.seed, index);
        let this = &*self;
        let prepared = Prepared::new(&this.vpls, this.setting.scene);
        let lights = this.lights(&prepared);
        if this.params.reconstruction.reconstruct {
            return picture::add_pass(this, &lights, index, film);
        }
        film.add_pass(|pixel| this.sample_pixel(&lights, pixel, index, |_| None));
    }

    /// Passes do not build on each other: what is kept are counts.
    fn save_state(&self) -> Option<Vec<u8>> {
        let mut w = Writer::default();
        w.text(&self.params.identity());
        self.tally.save(&mut w);
        Some(w.into_bytes())
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        let mut r = Reader::new(state);
        let params = r.text()?;
        if params != self.params.identity() {
            return Err(format!("it was made with other parameters: {params}"));
        }
        self.tally.restore(&mut r)?;
        r.end()
    }

    fn statistics(&self) -> Vec<(String, f64)> {
        let mut all = self.tally.statistics();
        let bytes = self.vpls.memory_bytes() as f64;
        all.push(("caustic_photons".into(), self.focused.photons() as f64));
        all.push(("caustic_radius".into(), self.focused.mean_radius()));
        all.push(("light_bytes".into(), bytes));
        all.push(("tree_bytes".into(), self.forest.memory_bytes() as f64));
        all
    }

    fn reach(&self) -> String {
        let params = &self.params;
        let direct = if params.direct == Direct::Vpl { "direct and indirect" } else { "indirect" };
        let cut = if params.bound.loses_light() {
            "; bounded geometric terms cut light off in corners (biased)"
        } else {
            ""
        };
        format!("all paths that path tracing reaches, {direct} light from point lights{cut}")
    }

    fn pictures(&self, film: &Film) -> Vec<Picture> {
        let prepared = Prepared::new(&self.vpls, self.setting.scene);
        let lights = self.lights(&prepared);
        self.params.figures.iter().flat_map(|f| f.draw(self, &lights, film)).collect()
    }

    fn export(&self, path: &Path) -> Vec<u8> {
        self.file(path)
    }
}

impl<'a> Lightcuts<'a> {
    /// All illumination becomes point lights, and they become trees [slide 61].
    fn make_lights(&mut self, index: u32) {
        let Setting { scene, seed, .. } = self.setting;
        let max_depth = self.params.limits.max_depth;
        let paths = self.pilot.paths_for(self.params.vpls);
        let how = Shooting {
            seed,
            first_path: index.wrapping_mul(paths),
            paths,
            termination: Termination::Roulette,
            // A path of the eye, the connection, and the light's own way are two segments more.
            max_scatterings: max_depth.map(|d| d.saturating_sub(2)),
            lights: false,
            pilot: self.pilot,
        };
        // What nobody will see need not be made.
        let indirect = !matches!(self.setting.show, Show::Direct | Show::Caustic);
        let mut set = if indirect { shoot(scene, &how) } else { Vpls::default() };
        if self.params.direct == Direct::Vpl {
            let direct = points(scene, &self.params.lights, seed, index).lights;
            set.lights.splice(0..0, direct);
        }
        let clock = std::time::Instant::now();
        gi_core::progress::begin("light trees", 0);
        self.forest = Forest::build(scene, &set, max_depth.is_some(), seed ^ index);
        self.tally.built(&set, clock.elapsed());
        (self.vpls, self.made_for) = (set, index);
    }

    /// The lights, ready to light points.
    fn lights<'l>(&'l self, prepared: &'l Prepared<'l, 'a>) -> Lights<'l, 'a> {
        Lights { scene: self.setting.scene, prepared, forest: &self.forest }
    }

    /// One path through a pixel. `corners` gives samples to reconstruct its first point from, if there are any.
    fn sample_pixel<'s>(
        &self,
        lights: &Lights<'_, 'a>,
        pixel: [usize; 2],
        index: u32,
        corners: impl Fn(&EyeVertex) -> Option<Corners<'s>>,
    ) -> gi_core::film::Sample {
        let mut walk = EyeWalk::through_pixel(&self.setting, self.params.limits, pixel, index);
        while let Some(v) = &walk.next_vertex() {
            walk.add_emitted(v);
            if v.wants_estimate() {
                let corners = corners(v);
                if let Some(estimate) = self.gather(lights, v, corners.as_ref(), &mut walk.sampler)
                {
                    walk.add_estimate(v, estimate);
                }
            }
            walk.add_direct(v);
            if !walk.scatter(v) {
                break;
            }
        }
        walk.sample()
    }

    /// Light a vertex.
    fn gather(
        &self,
        lights: &Lights<'_, 'a>,
        v: &EyeVertex<'a>,
        corners: Option<&Corners>,
        sampler: &mut Sampler,
    ) -> Option<Estimate> {
        let bsdf = v.bsdf.broad(v.wo, MIN_ROUGHNESS)?;
        let at = self.at(&v.surface, v.wo, &bsdf, (v.segments, v.non_delta))?;
        let params = &self.params;
        let lit = match (params.method, corners) {
            (Method::Cuts, Some(corners)) if lights.agree_on_the_whole(&at, corners) => {
                let agree = params.reconstruction.agree;
                self.tally.reconstructed();
                lights.reconstruct(&at, corners, &params.cut, agree)
            }
            (Method::Cuts, _) => lights.light(&at, &params.cut),
            (Method::All, _) => lights.light_by_all(&at),
            (Method::Stochastic, _) => lights.light_stochastically(&at, params.samples, sampler),
            (Method::One, _) => lights.light_by_some(&at, params.samples, sampler),
        };
        self.tally.note(&lit, v.non_delta == 0);
        let max_geometry = self.compensated();
        Some(Estimate {
            covers: Covers::Visible { max_geometry, min_roughness: MIN_ROUGHNESS },
            direct: (params.direct == Direct::Vpl).then_some(lit.direct),
            indirect: lit.indirect,
            caustic: self.focused.radiance(
                self.setting.scene,
                (&v.surface, v.wo, &bsdf),
                self.deepest(v.segments)?,
            ),
        })
    }

    /// What is asked about a point that a path met after so many segments and rough scatterings; `None` where no light is
    /// near enough to count.
    fn at<'s>(
        &self,
        surface: &'s gi_core::geometry::Surface,
        wo: glam::Vec3,
        bsdf: &'s gi_core::bsdf::Bsdf<'a>,
        (segments, rough): (u32, u32),
    ) -> Option<At<'s, 's, 'a>> {
        let deepest = self.deepest(segments)?;
        // Further from the eye all light is indirect.
        let direct = match self.setting.show {
            Show::All => true,
            Show::Direct => rough == 0,
            Show::Indirect => rough > 0,
            Show::Caustic => false,
        };
        let indirect = matches!(self.setting.show, Show::All | Show::Indirect);
        Some(At {
            receiver: Receiver::new(surface, wo, bsdf),
            site: Site::new(surface, wo, bsdf, self.most()),
            deepest: if indirect { deepest } else { 0 },
            direct: direct && self.params.direct == Direct::Vpl,
        })
    }

    /// Most scatterings of light that may come to a point which a path met after so many segments: a light or a photon
    /// after j scatterings, the light's own included, has come j + 1 segments.
    fn deepest(&self, segments: u32) -> Option<u32> {
        match self.params.limits.max_depth {
            None => Some(u32::MAX),
            Some(most) => most.checked_sub(segments + 1),
        }
    }

    /// The bound of the geometric term, per squared world unit.
    fn most(&self) -> f32 {
        let radius = self.setting.scene.radius();
        self.params.bound.clamp / (radius * radius)
    }

    /// The bound beyond which paths look for light.
    fn compensated(&self) -> f32 {
        if self.params.bound.is_compensated() { self.most() } else { f32::INFINITY }
    }

    /// The lights of the last pass.
    pub fn vpls(&self) -> &Vpls {
        &self.vpls
    }

    /// Their trees.
    pub fn forest(&self) -> &Forest {
        &self.forest
    }
}
