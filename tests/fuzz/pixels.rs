//! From the text of a scene to pixels, with every technique.

use std::path::Path;

use gi_core::camera::Camera;
use gi_core::film::{Film, Show};
use gi_core::scene::Scene;
use gi_core::technique::Technique;
use gi_scene::{Options, load};
use gi_tests::World;
use glam::Vec3A;

use crate::common::{Folder, Slot};
use crate::corpus;

/// Memory that a scene may take.
const MEMORY: u64 = 1 << 28;
/// Most pixels of a picture.
const SIZE: [usize; 2] = [4, 3];

/// A technique with parameters that make a pass cheap.
pub(crate) struct Renderer {
    name: &'static str,
    render: fn(&World) -> Result<Film, String>,
}

fn render<'a, T: Technique<'a>>(world: &'a World, params: &T::Params) -> Result<Film, String> {
    let mut film = Film::new(world.camera.size(), gi_core::filter::Filter::Box, Show::All);
    let mut technique = T::prepare(world.setting(1, Show::All), params)?;
    technique.pass(0, &mut film);
    Ok(film)
}

fn render_paths(world: &World, mode: pathtrace::Mode) -> Result<Film, String> {
    let params = pathtrace::Params { mode, ..Default::default() };
    render::<pathtrace::PathTracer>(world, &params)
}

pub(crate) const RENDERERS: [Renderer; 10] = [
    Renderer {
        name: "paths from the eye",
        render: |world| render_paths(world, pathtrace::Mode::Path),
    },
    Renderer {
        name: "paths from the lights",
        render: |world| render_paths(world, pathtrace::Mode::Light),
    },
    Renderer {
        name: "paths from both ends",
        render: |world| render_paths(world, pathtrace::Mode::Bdpt),
    },
    Renderer {
        name: "vertex connection and merging",
        render: |world| render_paths(world, pathtrace::Mode::Vcm),
    },
    Renderer {
        name: "irradiance caching",
        render: |world| {
            let params = irrcache::Params { rays: 32, ..Default::default() };
            render::<irrcache::IrradianceCaching>(world, &params)
        },
    },
    Renderer {
        name: "radiance caching",
        render: |world| {
            let params = radcache::Params { rays: 32, glossy_rays: 32, ..Default::default() };
            render::<radcache::RadianceCaching>(world, &params)
        },
    },
    Renderer {
        name: "photon mapping",
        render: |world| {
            let (photons, caustic_photons, volume_photons) = (200, 100, 100);
            let params = photonmap::Params {
                photons,
                caustic_photons,
                volume_photons,
                ..Default::default()
            };
            render::<photonmap::PhotonMapping>(world, &params)
        },
    },
    Renderer {
        name: "progressive photon mapping",
        render: |world| {
            let params = ppm::Params { photons: 200, initial_photons: 200, ..Default::default() };
            render::<ppm::Ppm>(world, &params)
        },
    },
    Renderer {
        name: "instant radiosity",
        render: |world| {
            let params = instant_radiosity::Params { vpls: 20, ..Default::default() };
            render::<instant_radiosity::InstantRadiosity>(world, &params)
        },
    },
    Renderer {
        name: "lightcuts",
        render: |world| {
            let params = lightcuts::Params { vpls: 20, ..Default::default() };
            render::<lightcuts::Lightcuts>(world, &params)
        },
    },
];

/// Scenes in a format, in a folder with the files that they name.
pub(crate) struct Target {
    /// Small valid scenes.
    pub(crate) files: Vec<Vec<u8>>,
    _folder: Folder,
    input: Slot,
    options: Options,
}

impl Target {
    /// Scenes in `xml` or `pbrt`.
    pub(crate) fn new(kind: &str) -> Self {
        let folder = Folder::in_memory();
        corpus::write_companions(&folder);
        let input = folder.slot(&format!("scene.{kind}"));
        let options = Options { max_memory: MEMORY, size: Some(SIZE), ..Options::default() };
        let mut files = corpus::files(kind);
        if kind == "xml" {
            files.extend(corpus::files("sky"));
        }
        Target { files, _folder: folder, input, options }
    }

    /// Render a scene with one technique, or with all.
    pub(crate) fn check(&self, bytes: &[u8], only: Option<usize>) -> Result<bool, String> {
        let Some(world) = self.world(self.input.replace(bytes)) else { return Ok(false) };
        let renderers = RENDERERS.iter().enumerate();
        for (_, r) in renderers.filter(|(k, _)| only.is_none_or(|only| only == *k)) {
            let film = (r.render)(&world).map_err(|why| format!("{}: {why}", r.name))?;
            let layers = film.layers();
            for name in ["R", "G", "B"] {
                let values = layers.channel(name).unwrap_or_default();
                if values.is_empty() || values.iter().any(|v| !v.is_finite()) {
                    return Err(format!("{}: a pixel of {name} is not finite", r.name));
                }
            }
        }
        Ok(true)
    }

    /// The scene in the same state as in the programs; `None` if it is refused.
    fn world(&self, path: &Path) -> Option<World> {
        let mut loaded = load(path, &self.options).ok()?;
        loaded.camera.to_world.translation += Vec3A::from(loaded.parts.recentre());
        let scene = Scene::new(loaded.parts).ok()?;
        Some(World { scene, camera: Camera::new(&loaded.camera) })
    }
}

/// Render damaged scenes, each with the next technique.
#[cfg(test)]
fn fuzz(kind: &str) {
    let (target, mut count) = (Target::new(kind), 0);
    crate::harness::fuzz(&format!("pixels.{kind}"), &target.files, |bytes| {
        count += 1;
        target.check(bytes, Some(count % RENDERERS.len()))
    });
}

#[test]
fn scenes_have_finite_pictures_whatever_is_damaged() {
    fuzz("xml");
}

#[test]
fn pbrt_scenes_have_finite_pictures_whatever_is_damaged() {
    fuzz("pbrt");
}
