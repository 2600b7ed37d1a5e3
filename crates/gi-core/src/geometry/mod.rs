//! Shapes as the scene describes them: meshes and analytic solids, in world space.

mod mesh;
mod shape;
mod shared;
mod surface;

pub use mesh::Mesh;
pub use shape::{Geometry, Instance, Shape};
pub use shared::Shared;
pub use surface::{Surface, Tangents};
