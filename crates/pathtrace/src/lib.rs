//! Path tracing: the truth that the other techniques are compared with.
//!
//! | | |
//! |---|---|
//! | estimated | every kind of light path that its walk can find, without bias |
//! | `--mode path` | paths from the eye; at each vertex light is sampled too, both weighted by the power heuristic |
//! | `--mode volpath` | the same in participating media: a path flies a distance drawn in proportion to transmittance, is scattered as the phase function says, and light sampled from there is dimmed on its way [slide 34] |
//! | `--mode light` | paths from the lights; each vertex, on surfaces and in media, is connected to the eye |
//! | `--max-depth` | path segments: 1 shows lights, 2 adds direct light; -1 is unbounded |
//! | `--rr-depth` | segments after which Russian roulette may end a path |
//! | how it fails | noise: `path` where light is focused (caustics of small lights), `light` behind mirrors and glass, and in media near the eye |
//! | sources | \[Kajiya86\], \[Veach97\] |

mod light;
mod params;

use gi_core::bytes::{Reader, Writer};
use gi_core::eye::{EyePath, InMedia, nothing};
use gi_core::film::Film;
use gi_core::technique::{Setting, Technique};

pub use params::{Mode, Params};

/// The path tracer.
pub struct PathTracer<'a> {
    setting: Setting<'a>,
    params: Params,
    /// Light paths begun so far.
    light_paths: u64,
}

impl<'a> Technique<'a> for PathTracer<'a> {
    type Params = Params;

    fn prepare(setting: Setting<'a>, params: &Params) -> Result<Self, String> {
        Ok(PathTracer { setting, params: *params, light_paths: 0 })
    }

    /// One path a pixel.
    fn pass(&mut self, index: u32, film: &mut Film) {
        match self.params.mode {
            Mode::Path => {
                let Setting { scene, camera, seed, show, .. } = self.setting;
                let path = EyePath { scene, limits: self.params.limits, show };
                film.add_pass(|pixel| path.sample_pixel(camera, seed, pixel, index, &mut nothing));
            }
            Mode::VolPath => {
                let Setting { scene, camera, seed, show, .. } = self.setting;
                let path = EyePath { scene, limits: self.params.limits, show };
                let medium = path.medium_round(camera);
                film.add_pass(|pixel| {
                    path.sample_pixel_by(camera, medium, seed, pixel, index, &mut InMedia)
                });
            }
            Mode::Light => self.light_pass(index, film),
        }
    }

    fn save_state(&self) -> Option<Vec<u8>> {
        let mut w = Writer::default();
        w.text(&format!("{:?}", self.params));
        w.u64(self.light_paths);
        Some(w.into_bytes())
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        let mut r = Reader::new(state);
        let params = r.text()?;
        if params != format!("{:?}", self.params) {
            return Err(format!("it was made with other parameters: {params}"));
        }
        self.light_paths = r.u64()?;
        r.end()
    }

    fn statistics(&self) -> Vec<(String, f64)> {
        match self.params.mode {
            Mode::Path | Mode::VolPath => Vec::new(),
            Mode::Light => vec![("light_paths".into(), self.light_paths as f64)],
        }
    }

    fn reach(&self) -> String {
        match self.params.mode {
            Mode::Path | Mode::VolPath => "all paths but those from point, spot and directional lights that reach the eye over \
                           delta lobes only after the last rough surface (E S* D S+ L)"
                .into(),
            Mode::Light => "E L and E D (S|D)* L, D in media too: what is seen without mirrors or glass; nothing that the eye sees \
                            through a delta lobe"
                .into(),
        }
    }
}
