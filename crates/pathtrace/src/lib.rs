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
//! Read next: `gi_core::eye` (the eye walk), `reuse.rs` (paths that pixels share), `light.rs` (paths from the lights), `bidir/` (paths
//! from both ends), `params.rs` (the options).

mod bidir;
mod light;
mod params;
mod reuse;
mod to_camera;

use gi_core::bytes::{Reader, Writer};
use gi_core::eye::{EyeEvent, EyeWalk};
use gi_core::film::{Film, Sample, Show};
use gi_core::light::LightTree;
use gi_core::medium::MediumId;
use gi_core::technique::{Picture, Setting, Technique};

use bidir::strategies::Pyramid;
use bidir::{Bidirectional, Plan};
pub use params::{Heuristic, LightSelection, Mode, Params};

/// The path tracer.
pub struct PathTracer<'a> {
    setting: Setting<'a>,
    params: Params,
    /// Chooses lights in paths from the eye; without a tree, they are chosen by power.
    light_tree: Option<&'a LightTree>,
    /// Number of light paths so far.
    light_paths: u64,
    /// For paths from both ends.
    plan: Option<Plan>,
    /// Number of light vertices that the last pass kept, and the memory of vertices and photons in bytes.
    kept: (u64, u64),
    /// What each way finds, if it is to be shown.
    pyramid: Option<Pyramid>,
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
        if from_lights && setting.camera.sensors().is_some() {
            return Err("--points works with paths from the eye only: use `--mode path`".into());
        }
        if params.reuse > 1 && setting.camera.sensors().is_some() {
            return Err("--reuse: the points of --points are not neighbours: leave it out".into());
        }
        let light_tree = match params.light_selection {
            LightSelection::Auto => setting.scene.tree_of_many_lights(),
            LightSelection::Power => None,
            LightSelection::Tree => Some(setting.scene.light_tree()),
        };
        let connects = matches!(params.mode, Mode::Bdpt | Mode::Vcm);
        let plan = connects.then(|| Plan::make(&setting, params));
        let pyramid = !params.figures.is_empty();
        let pyramid = pyramid.then(|| Pyramid::new(setting.camera.size()));
        let (params, light_paths, kept) = (params.clone(), 0, (0, 0));
        Ok(PathTracer { setting, params, light_tree, light_paths, plan, kept, pyramid })
    }

    /// One path per pixel.
    fn pass(&mut self, index: u32, film: &mut Film) {
        match self.params.mode {
            Mode::Path if self.reuses_paths() => {
                film.add_pass_by_tile(|tile| self.reuse_paths(tile, index));
            }
            Mode::Path => film.add_pass(|pixel| self.path(pixel, index)),
            Mode::VolPath => {
                let medium = self.setting.camera_medium();
                film.add_pass(|pixel| self.path_in_media(pixel, index, medium));
            }
            Mode::Light => self.light_pass(index, film),
            Mode::Bdpt | Mode::Vcm => {
                let paths = self.bidirectional(index);
                self.kept = paths.pass(index, film, self.pyramid.as_mut());
            }
        }
    }

    fn recall(&mut self, index: u32, film: &Film) {
        if self.plan.is_some() {
            self.kept = self.bidirectional(index).kept(index, film);
        }
    }

    fn save_state(&self) -> Vec<u8> {
        let mut w = Writer::default();
        w.u64(self.light_paths);
        w.into_bytes()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        if self.pyramid.is_some() {
            return Err("`--show strategies` needs all passes in one run".into());
        }
        let mut r = Reader::new(state);
        self.light_paths += r.u64()?;
        r.end()
    }

    fn statistics(&self) -> Vec<(String, f64)> {
        match self.params.mode {
            Mode::Path | Mode::VolPath => Vec::new(),
            Mode::Bdpt | Mode::Vcm => vec![
                ("light_paths_per_pass".into(), f64::from(self.plan.map_or(0, |p| p.light_paths))),
                ("radius_of_first_pass".into(), f64::from(self.plan.map_or(0.0, |p| p.radius))),
                ("light_vertices".into(), self.kept.0 as f64),
                ("light_vertices_bytes".into(), self.kept.1 as f64),
            ],
            Mode::Light => vec![("light_paths".into(), self.light_paths as f64)],
        }
    }

    fn pictures(&self, film: &Film) -> Vec<Picture> {
        self.pyramid.iter().flat_map(|pyramid| pyramid.draw(film.size())).collect()
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

impl<'a> PathTracer<'a> {
    /// Whether pixels use each other's paths: only light that is scattered at least twice is shared.
    fn reuses_paths(&self) -> bool {
        self.params.reuse > 1 && matches!(self.setting.show, Show::All | Show::Indirect)
    }

    /// Paths from both ends, of pass `index`.
    fn bidirectional(&self, index: u32) -> Bidirectional<'a> {
        let plan = self.plan.expect("made for these modes");
        Bidirectional::new(self.setting, &self.params, plan, index)
    }

    /// A path from the eye: at every vertex add emitted light, sample a light, and sample the BSDF for the next
    /// direction.
    #[inline]
    fn path(&self, pixel: [usize; 2], index: u32) -> Sample {
        let mut walk = EyeWalk::through_pixel(&self.setting, self.params.limits, pixel, index);
        walk.choose_lights_by(self.light_tree);
        walk_on(&mut walk);
        walk.sample()
    }

    /// The same in media: a medium may scatter the path before it reaches the next surface [slide 34].
    fn path_in_media(&self, pixel: [usize; 2], index: u32, medium: Option<MediumId>) -> Sample {
        let mut walk = EyeWalk::through_pixel(&self.setting, self.params.limits, pixel, index);
        walk.use_media(medium);
        walk.choose_lights_by(self.light_tree);
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

/// Walk a path to its end: at every vertex add emitted light, sample a light, and sample the BSDF for the next direction.
#[inline(always)]
fn walk_on(walk: &mut EyeWalk) {
    while let Some(v) = &walk.next_vertex() {
        walk.add_emitted(v);
        walk.add_direct(v);
        if !walk.scatter(v) {
            break;
        }
    }
}
