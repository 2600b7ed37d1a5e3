//! The contents of a scene file.

use crate::geometry::{Instance, Shape};
use crate::light::LightSource;
use crate::material::Material;
use crate::medium::Medium;
use glam::Vec3;

/// The contents of a scene file, without the camera.
#[derive(Clone, Debug, Default)]
pub struct SceneParts {
    /// Shapes, in world space.
    pub shapes: Vec<Shape>,
    /// Groups of shapes that appear only through [`SceneParts::instances`].
    pub groups: Vec<Vec<Shape>>,
    /// Copies of groups.
    pub instances: Vec<Instance>,
    /// Materials. Children come before their parents.
    pub materials: Vec<Material>,
    /// Media.
    pub media: Vec<Medium>,
    /// Lights that are not surfaces.
    pub lights: Vec<LightSource>,
    /// Whether the camera sees no light source directly: it sees what is behind lamps, and black instead of light from
    /// infinity.
    pub hides_emitters: bool,
    /// Position of this origin in the coordinates of the file, see [`SceneParts::recentre`].
    pub origin: Vec3,
}

/// Memory that [`Scene::new`](super::Scene::new) takes for each primitive while it builds the bounding volume hierarchy, in
/// bytes: the peak of whole runs with scenes of 1.6 to 6.5 million triangles, without the meshes.
const BUILD_BYTES: u64 = 260;

impl SceneParts {
    /// Number of triangles, spheres and other primitives. Those of a group count once.
    pub fn primitive_count(&self) -> usize {
        let shapes = self.shapes.iter().chain(self.groups.iter().flatten());
        shapes.map(|shape| shape.geometry.primitive_count()).sum()
    }

    /// The memory that [`Scene::new`](super::Scene::new) takes at its peak, besides these parts: about, in bytes.
    pub fn build_bytes(&self) -> u64 {
        BUILD_BYTES * self.primitive_count() as u64
    }
}
