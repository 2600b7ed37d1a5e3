//! Buildings under sun and sky: light comes in from outside and is scattered further.

mod colonnade;
mod pavilion;

use glam::Vec3;

use crate::mesh::Mesh;

pub(crate) use colonnade::colonnade;
pub(crate) use pavilion::pavilion;

/// A cuboid on the ground: its centre, half width and half depth, and the heights of bottom and top.
fn block(x: f32, z: f32, half: [f32; 2], from: f32, to: f32) -> Mesh {
    Mesh::cuboid(Vec3::new(x - half[0], from, z - half[1]), Vec3::new(x + half[0], to, z + half[1]))
}

/// A horizontal rectangle that faces up.
fn plate(x: [f32; 2], z: [f32; 2], y: f32) -> Mesh {
    let corners = [[x[0], z[0]], [x[0], z[1]], [x[1], z[1]], [x[1], z[0]]];
    Mesh::quad(corners.map(|[x, z]| Vec3::new(x, y, z)))
}
