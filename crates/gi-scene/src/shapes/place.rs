//! Moves meshes to their places.

use gi_core::geometry::Mesh;
use glam::{DAffine3, DVec3, Vec3};

/// Transform a mesh, whose coordinates are relative to `origin`. Positions are rounded to single precision only once.
/// Normals use the inverse transpose. The winding is kept, so a mirroring map flips face normals, as in Mitsuba.
pub(crate) fn place(mesh: &mut Mesh, m: &DAffine3, origin: DVec3) {
    for p in &mut mesh.positions {
        *p = m.transform_point3(p.as_dvec3() + origin).as_vec3();
    }
    let normal_map = m.matrix3.inverse().transpose().as_mat3();
    for n in &mut mesh.normals {
        *n = (normal_map * *n).try_normalize().unwrap_or(Vec3::Z);
    }
}
