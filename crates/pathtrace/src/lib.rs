//! Path tracing: the reference for the other techniques.
//!
//! | | |
//! |---|---|
//! | estimate | all light paths that the walk can find, without bias |
//! | `--mode path` | paths from the eye with next-event estimation; the power heuristic weights both |
//! | `--mode volpath` | the same in participating media: distances are sampled in proportion to transmittance, directions by the phase function, and light samples are attenuated [slide 34] |
//! | `--mode light` | paths from the lights; each vertex, on a surface or in a medium, is connected to the eye |
//! | `--mode bdpt` | paths from both ends: every vertex of one is connected with every vertex of the other, and all ways to find a path are weighted [slide 38] |
//! | `--mode vcm` | the same, and vertices near each other are merged as in photon mapping; the blur shrinks with the passes |
//! | how it fails | noise: `path` for caustics of small lights, `light` in media near the eye. `light` sees nothing through mirrors and glass, and `bdpt` no caustics of small lamps there; `vcm` finds them, blurred |
//! | sources | \[Kajiya86\], \[Veach97\], \[Georgiev12\] |
//!
//! Read next: `gi_core::eye` (the eye walk), `light.rs` (paths from the lights), `bidir/` (paths from both ends), `params.rs` (the options).

mod bidir;
mod light;
mod params;
mod to_camera;

use gi_core::bytes::{Reader, Writer};
use gi_core::eye::{EyeEvent, EyeWalk};
use gi_core::film::{Film, Sample};
use gi_core::light::LightTree;
use gi_core::medium::MediumId;
use gi_core::technique::{Picture, Setting, Technique};

use bidir::Bidirectional;
pub use params::{Heuristic, LightSelection, Mode, Params};

/// The path tracer.
pub struct PathTracer<'a> {
    setting: Setting<'a>,
    params: Params,
    /// Chooses lights in paths from the eye; without a tree, they are chosen by power.
    light_tree: Option<&'a LightTree>,
    /// Number of light paths so far.
    light_paths: u64,
    /// Number of vertices of light paths that the last pass kept, and their memory in bytes.
    kept: (u64, u64),
}

impl<'a> Technique<'a> for PathTracer<'a> {
    type Params = Params;

    fn prepare(setting: Setting<'a>, params: &Params) -> Result<Self, String> {
        let from_lights = matches!(params.mode, Mode::Light | Mode::Bdpt | Mode::Vcm);
        if from_lights && setting.scene.hides_emitters() {
            // Hidden lamps would cast shadows toward the camera.
            return Err("the scene's `hide_emitters` is not supported by modes with paths from the lights: use \
                        `--mode path`"
                .into());
        }
        let light_tree = match params.light_selection {
            LightSelection::Auto => setting.scene.tree_of_many_lights(),
            LightSelection::Power => None,
            LightSelection::Tree => Some(setting.scene.light_tree()),
        };
        Ok(PathTracer { setting, params: params.clone(), light_tree, light_paths: 0, kept: (0, 0) })
    }

    /// One path per pixel.
    fn pass(&mut self, index: u32, film: &mut Film) {
        match self.params.mode {
            Mode::Path => film.add_pass(|pixel| self.path(pixel, index)),
            Mode::VolPath => {
                let medium = self.setting.camera_medium();
                film.add_pass(|pixel| self.path_in_media(pixel, index, medium));
            }
            Mode::Light => self.light_pass(index, film),
            Mode::Bdpt | Mode::Vcm => {
                self.kept = Bidirectional::new(self.setting, &self.params, index).pass(index, film);
            }
        }
    }

    fn save_state(&self) -> Option<Vec<u8>> {
        let mut w = Writer::default();
        w.text(&self.identity());
        w.u64(self.light_paths);
        Some(w.into_bytes())
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        let mut r = Reader::new(state);
        let params = r.text()?;
        if params != self.identity() {
            return Err(format!("it was made with other parameters: {params}"));
        }
        self.light_paths = r.u64()?;
        r.end()
    }

    fn statistics(&self) -> Vec<(String, f64)> {
        match self.params.mode {
            Mode::Path | Mode::VolPath => Vec::new(),
            Mode::Bdpt | Mode::Vcm => vec![
                ("light_vertices".into(), self.kept.0 as f64),
                ("light_vertices_bytes".into(), self.kept.1 as f64),
            ],
            Mode::Light => vec![("light_paths".into(), self.light_paths as f64)],
        }
    }

    fn pictures(&self, film: &Film) -> Vec<Picture> {
        if self.params.figures.is_empty() {
            return Vec::new();
        }
        bidir::strategies::draw(self.setting, &self.params, film)
    }

    fn reach(&self) -> String {
        match self.params.mode {
            Mode::Path | Mode::VolPath => "all paths but those from point, spot and directional lights that reach the eye over \
                           delta lobes only after the last rough surface (E S* D S+ L)"
                .into(),
            Mode::Bdpt => "all paths but those from point, spot and directional lights of which at least every second vertex is on a \
                          mirror or glass: E S+ (D S+)* L"
                .into(),
            Mode::Vcm => "all paths but E S+ L from point, spot and directional lights; those that only merging finds are blurred within a \
                         radius that shrinks with the passes. In media, as bdpt"
                .into(),
            Mode::Light => "E L and E D (S|D)* L, D in media too: what is seen without mirrors or glass; nothing that the eye sees \
                            through a delta lobe"
                .into(),
        }
    }
}

impl PathTracer<'_> {
    /// The options that the picture depends on.
    fn identity(&self) -> String {
        format!("{:?}", Params { figures: Vec::new(), ..self.params.clone() })
    }

    /// A path from the eye: at every vertex add emitted light, sample a light, and sample the BSDF for the next
    /// direction.
    #[inline]
    fn path(&self, pixel: [usize; 2], index: u32) -> Sample {
        let walk = EyeWalk::through_pixel(&self.setting, self.params.limits, pixel, index);
        let mut walk = walk.choosing_lights(self.light_tree);
        while let Some(v) = &walk.next_vertex() {
            walk.add_emitted(v);
            walk.add_direct(v);
            if !walk.scatter(v) {
                break;
            }
        }
        walk.sample()
    }

    /// The same in media: a medium may scatter the path before it reaches the next surface [slide 34].
    fn path_in_media(&self, pixel: [usize; 2], index: u32, medium: Option<MediumId>) -> Sample {
        let walk = EyeWalk::through_pixel(&self.setting, self.params.limits, pixel, index);
        let mut walk = walk.choosing_lights(self.light_tree).through_media(medium);
        while let Some(event) = &walk.next_event() {
            let continues = match event {
                EyeEvent::Surface(v) => {
                    walk.add_emitted(v);
                    walk.add_direct(v);
                    walk.scatter(v)
                }
                EyeEvent::Medium(v) => {
                    walk.add_direct_within(v);
                    walk.scatter_within(v)
                }
            };
            if !continues {
                break;
            }
        }
        walk.sample()
    }
}
