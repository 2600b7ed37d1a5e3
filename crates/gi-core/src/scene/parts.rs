//! The scene as a file gives it.

use crate::geometry::{Instance, Shape};
use crate::light::LightSource;
use crate::material::Material;
use crate::medium::Medium;
use glam::Vec3;

/// Everything that a scene file gives but the camera.
#[derive(Clone, Debug, Default)]
pub struct SceneParts {
    /// Shapes, each once, in world space.
    pub shapes: Vec<Shape>,
    /// Groups of shapes that appear through [`SceneParts::instances`] only.
    pub groups: Vec<Vec<Shape>>,
    /// Copies of groups.
    pub instances: Vec<Instance>,
    /// Materials; children stand before their parents.
    pub materials: Vec<Material>,
    /// Media.
    pub media: Vec<Medium>,
    /// Lights that are no surfaces.
    pub lights: Vec<LightSource>,
    /// Where the origin of all these coordinates lies in those of the file, see [`SceneParts::recentre`].
    pub origin: Vec3,
}
