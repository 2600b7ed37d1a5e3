//! Options for loading a scene, and the result of loading.

use std::collections::BTreeMap;
use std::path::PathBuf;

use gi_core::camera::CameraSpec;
use gi_core::filter::Filter;
use gi_core::scene::SceneParts;
use glam::Vec3;

use crate::budget::half_of_the_machine;
use crate::origins::Origins;

/// The command line's options for a scene.
#[derive(Clone, Debug)]
pub struct Options {
    /// Names and values given with `-D`; they override the scene's `<default>`s.
    pub defines: Vec<(String, String)>,
    /// The picture's width and height, instead of the scene's.
    pub size: Option<[usize; 2]>,
    /// Which of the scene's sensors is used, from 0. `None` uses the first one.
    pub sensor: Option<usize>,
    /// A light to add to the scene.
    pub light: Option<AddedLight>,
    /// Changes to the scene's camera.
    pub camera: CameraOverride,
    /// The memory that the scene may take, in bytes: pictures, meshes, text, and the bounding volume hierarchy
    /// while it is built. By default half of this machine's memory.
    pub max_memory: u64,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            defines: Vec::new(),
            size: None,
            sensor: None,
            light: None,
            camera: CameraOverride::default(),
            max_memory: half_of_the_machine(),
        }
    }
}

/// A light that the user adds to a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AddedLight {
    /// A clear sky with the sun behind the camera.
    Sky,
    /// Soft boxes in a bright room.
    Studio,
    /// A point light at the camera.
    Headlight,
}

impl AddedLight {
    /// The names of all added lights.
    pub const NAMES: [&str; 3] = ["sky", "studio", "headlight"];

    /// The light of that name.
    pub fn named(name: &str) -> Option<AddedLight> {
        let all = [AddedLight::Sky, AddedLight::Studio, AddedLight::Headlight];
        let index = AddedLight::NAMES.iter().position(|known| *known == name)?;
        Some(all[index])
    }
}

/// Camera settings that override the scene's. If the scene has no camera (a bare `.obj`, for example), settings that
/// are not given are chosen so that the whole scene is visible.
#[derive(Clone, Copy, Debug, Default)]
pub struct CameraOverride {
    /// Position.
    pub origin: Option<Vec3>,
    /// The point it looks at.
    pub target: Option<Vec3>,
    /// The up direction; +y in a scene without a camera.
    pub up: Option<Vec3>,
    /// Horizontal angle of view, degrees.
    pub fov: Option<f32>,
}

/// A loaded scene.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Shapes, materials, lights.
    pub parts: SceneParts,
    /// Camera and picture size.
    pub camera: CameraSpec,
    /// Reconstruction filter.
    pub filter: Filter,
    /// Values of the scene's `<default name="gi.*">`, after `-D`.
    pub presets: BTreeMap<String, String>,
    /// Longest path of the scene's integrator; -1 means unlimited.
    pub integrator_max_depth: Option<i32>,
    /// Warnings about what was approximated or ignored, as `file:line: text`.
    pub warnings: Vec<String>,
    /// Hash of all bytes read and of the defines.
    pub hash: u64,
    /// Hash of the world alone: independent of camera, film, integrator and presets.
    pub world: u64,
    /// Memory that meshes, pictures and text take, in bytes.
    pub memory: u64,
    /// All files that were read: the scene, included files, meshes and pictures.
    pub files: Vec<PathBuf>,
    pub(crate) origins: Origins,
}
