//! Tables for the surface point of a hit. What a point needs of a primitive is in one record, and what it needs of a
//! vertex is in another: a hit of a large mesh waits for memory once per record.

use glam::{Vec2, Vec3};

use super::SceneError;
use crate::geometry::{Geometry, Shape};

/// A primitive. The record fills half a cache line.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub(super) struct Primitive {
    /// Its shape.
    pub(super) shape: u32,
    /// The corners of a triangle, as indices of [`Vertex`]; not used by other primitives.
    pub(super) corners: [u32; 3],
    /// Unit face normal of a triangle; not used by other primitives.
    pub(super) normal: Vec3,
}

/// A vertex of a mesh. The record fills half a cache line.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub(super) struct Vertex {
    pub(super) p: Vec3,
    /// Unit shading normal; not used if the mesh has none.
    pub(super) normal: Vec3,
    /// Texture coordinates; not used if the mesh has none.
    pub(super) uv: Vec2,
}

/// The primitives of all shapes, numbered consecutively, and the vertices of all meshes.
#[derive(Default)]
pub(super) struct Primitives {
    pub(super) all: Vec<Primitive>,
    pub(super) vertices: Vec<Vertex>,
    /// Number of the first primitive of each shape.
    pub(super) first: Vec<u32>,
}

impl Primitives {
    pub(super) fn new(shapes: &[Shape]) -> Result<Self, SceneError> {
        let mut primitives = Primitives::default();
        for (k, shape) in shapes.iter().enumerate() {
            primitives.add(k as u32, shape)?;
        }
        Ok(primitives)
    }

    fn add(&mut self, k: u32, shape: &Shape) -> Result<(), SceneError> {
        self.first.push(self.all.len() as u32);
        let first_vertex = self.vertices.len();
        let end = self.all.len() + shape.geometry.primitive_count();
        let Geometry::Mesh(mesh) = &shape.geometry else {
            self.all.push(Primitive { shape: k, corners: [0; 3], normal: Vec3::Z });
            return Ok(());
        };
        if end.max(first_vertex + mesh.positions.len()) >= u32::MAX as usize {
            let cause = "more than 4 billion primitives or vertices in the scene".to_string();
            return Err(SceneError::Shape { name: shape.name.clone(), cause });
        }
        let corner = |i: u32| first_vertex as u32 + i;
        self.all.extend(mesh.triangles.iter().enumerate().map(|(t, triangle)| {
            let [a, b, c] = mesh.corners(t);
            let normal = triangle_normal(b - a, c - a);
            Primitive { shape: k, corners: triangle.map(corner), normal }
        }));
        self.vertices.extend(mesh.positions.iter().enumerate().map(|(i, &p)| Vertex {
            p,
            normal: mesh.normals.get(i).copied().unwrap_or(Vec3::Z),
            uv: mesh.uvs.get(i).copied().unwrap_or(Vec2::ZERO),
        }));
        Ok(())
    }
}

/// Unit normal of a triangle with these edges, also if they are tiny.
fn triangle_normal(e1: Vec3, e2: Vec3) -> Vec3 {
    e1.cross(e2).try_normalize().unwrap_or_else(|| {
        let scale = 1.0 / e1.abs().max_element().max(e2.abs().max_element());
        (e1 * scale).cross(e2 * scale).try_normalize().unwrap_or(Vec3::Z)
    })
}
