//! Area lights that emit from both sides: two sheets back to back.

use gi_core::geometry::{Geometry, Shape};

use crate::document::{Class, Node};

/// Distance between the two sheets, as a fraction of the shape's size.
const DISTANCE: f32 = 1e-4;

/// The second sheet of a shape whose emitter has two sides: just behind the first, and turned round.
pub(crate) fn second(node: Node<'_>, shape: &Shape) -> Option<Shape> {
    let emitters = node.children(Class::Emitter);
    let two_sided = node.doc.is_pbrt && emitters.first()?.bool("two_sided", false);
    if !two_sided || shape.emission.is_none() {
        return None;
    }
    let distance = DISTANCE * shape.geometry.bounds().extent().length();
    let behind = if shape.flip_normals { distance } else { -distance };
    let mut second = shape.clone();
    second.flip_normals = !shape.flip_normals;
    match &mut second.geometry {
        Geometry::Mesh(mesh) => {
            let mut normals = mesh.clone();
            normals.smooth_normals();
            for (p, n) in mesh.positions.iter_mut().zip(&normals.normals) {
                *p += *n * behind;
            }
        }
        Geometry::Disk { center, du, dv } => *center += du.cross(*dv).normalize_or_zero() * behind,
        Geometry::Sphere { radius, .. } | Geometry::Cylinder { radius, .. } => *radius += behind,
    }
    Some(second)
}
