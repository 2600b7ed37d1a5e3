//! What a scene is loaded with, and what loading gives.

use std::collections::BTreeMap;
use std::path::PathBuf;

use gi_core::camera::CameraSpec;
use gi_core::filter::Filter;
use gi_core::scene::SceneParts;
use glam::Vec3;

use crate::origins::Origins;

/// What the command line says about a scene.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Names and values given with `-D`: they win over the scene's `<default>`s.
    pub defines: Vec<(String, String)>,
    /// The picture's width and height, instead of the scene's.
    pub size: Option<[usize; 2]>,
    /// Another camera than the scene's.
    pub camera: CameraOverride,
}

/// What of the camera is not as the scene says. In a scene without camera, a bare `.obj` say, what is not given is chosen so
/// that all is seen.
#[derive(Clone, Copy, Debug, Default)]
pub struct CameraOverride {
    /// Where it stands.
    pub origin: Option<Vec3>,
    /// What it looks at.
    pub target: Option<Vec3>,
    /// What is up; +y in a scene without camera.
    pub up: Option<Vec3>,
    /// Angle across the picture's width, degrees.
    pub fov: Option<f32>,
}

/// A scene as it was understood.
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
    /// Longest path that the scene's integrator asks for; -1 is without end.
    pub integrator_max_depth: Option<i32>,
    /// What was approximated or ignored, as `file:line: text`.
    pub warnings: Vec<String>,
    /// Hash of all bytes read and of the defines.
    pub hash: u64,
    /// Hash of what the world is made of: the same for any camera, film, integrator and preset.
    pub world: u64,
    /// All files that were read: the scene, included files, meshes and pictures.
    pub files: Vec<PathBuf>,
    pub(crate) origins: Origins,
}
