//! Shapes that need no file.

use gi_core::geometry::{Geometry, Mesh};
use gi_core::math::Frame;
use glam::{DAffine3, DVec3, Vec2, Vec3};

use super::place::place;
use crate::document::Node;

/// Relative difference of axis lengths below which a scale counts as uniform: files round to six digits.
const UNIFORM: f32 = 1e-3;
/// Rows of triangles of a deformed sphere; it has twice as many columns. The error is 0.01 % of the radius.
const SPHERE_ROWS: usize = 128;

/// Whether a transform mirrors, so that transformed normals point against the transformed winding.
fn mirrors(m: &DAffine3) -> bool {
    m.matrix3.determinant() < 0.0
}

/// Transform a mesh of flat faces. The faces keep the side of their normals, as in Mitsuba.
fn placed(mut mesh: Mesh, m: &DAffine3) -> Mesh {
    place(&mut mesh, m, DVec3::ZERO);
    if mirrors(m) {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    mesh
}

/// The square [-1, 1]^2 at z = 0, facing +z.
pub(crate) fn rectangle(to_world: &DAffine3) -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let mesh = Mesh {
        positions: corners.iter().map(|&(x, y)| Vec3::new(x, y, 0.0)).collect(),
        normals: Vec::new(),
        uvs: corners.iter().map(|&(x, y)| 0.5 * Vec2::new(x + 1.0, y + 1.0)).collect(),
        triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
    };
    placed(mesh, to_world)
}

/// The cube [-1, 1]^3; texture coordinates cover the unit square on each face.
pub(crate) fn cube(to_world: &DAffine3) -> Mesh {
    // For each face, the corners with uv (0,1), (1,1), (1,0), (0,0), as in Mitsuba.
    const FACES: [[[f32; 3]; 4]; 6] = [
        [[1., -1., -1.], [1., -1., 1.], [-1., -1., 1.], [-1., -1., -1.]],
        [[1., 1., -1.], [-1., 1., -1.], [-1., 1., 1.], [1., 1., 1.]],
        [[1., -1., -1.], [1., 1., -1.], [1., 1., 1.], [1., -1., 1.]],
        [[1., -1., 1.], [1., 1., 1.], [-1., 1., 1.], [-1., -1., 1.]],
        [[-1., -1., 1.], [-1., 1., 1.], [-1., 1., -1.], [-1., -1., -1.]],
        [[1., 1., -1.], [1., -1., -1.], [-1., -1., -1.], [-1., 1., -1.]],
    ];
    let mut mesh = Mesh::default();
    for (face, corners) in FACES.iter().enumerate() {
        mesh.positions.extend(corners.iter().map(|c| Vec3::from(*c)));
        mesh.uvs.extend([Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO]);
        let k = 4 * face as u32;
        mesh.triangles.extend([[k, k + 1, k + 2], [k + 3, k, k + 2]]);
    }
    placed(mesh, to_world)
}

/// A sphere, and whether its normals point inward: a mirroring transform flips them, as in Mitsuba 3.
pub(crate) fn sphere(node: Node<'_>, to_world: &DAffine3) -> Option<(Geometry, bool)> {
    let (center, radius) = (node.point("center").unwrap_or(DVec3::ZERO), node.float("radius", 1.0));
    if radius <= 0.0 {
        node.report.error(node.span_of("radius"), format!("radius {radius}"), "expected > 0");
        return None;
    }
    let scale = DAffine3::from_scale(DVec3::splat(radius.into()));
    let m = *to_world * DAffine3::from_translation(center) * scale;
    let axes = [to_world.matrix3.x_axis, to_world.matrix3.y_axis, to_world.matrix3.z_axis];
    let [(x, a), (y, b), (z, c)] = axes.map(|axis| crate::transform::unit(axis.as_vec3()));
    let size = [a, b, c];
    if !size.iter().all(|s| s.is_finite() && *s > 0.0) {
        node.error("the sphere has no volume", "");
        return None;
    }
    let even = size.iter().all(|s| (s / size[0] - 1.0).abs() < UNIFORM);
    if !even || [x.dot(y), y.dot(z), z.dot(x)].iter().any(|d| d.abs() > UNIFORM) {
        node.warn("a deformed sphere is approximated by a mesh");
        return Some((Geometry::Mesh(squeezed_sphere(&m)), false));
    }
    let mirrored = mirrors(&m);
    // A right-handed frame. In Mitsuba, u of a mirrored sphere runs in the opposite direction.
    let axes = Frame { s: x, t: z.cross(x), n: z };
    let (center, radius) = (m.translation.as_vec3(), radius * size[0]);
    Some((Geometry::Sphere { center, radius, axes }, mirrored))
}

/// The transformed unit sphere as triangles.
fn squeezed_sphere(m: &DAffine3) -> Mesh {
    let (rows, columns) = (SPHERE_ROWS, 2 * SPHERE_ROWS);
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let uv = Vec2::new(column as f32 / columns as f32, row as f32 / rows as f32);
            let (theta, phi) = (std::f32::consts::PI * uv.y, std::f32::consts::TAU * uv.x);
            // The seam and the poles must close exactly.
            let phi = if column == columns { 0.0 } else { phi };
            let sin = if row == 0 || row == rows { 0.0 } else { theta.sin() };
            let p = Vec3::new(sin * phi.cos(), sin * phi.sin(), theta.cos());
            mesh.positions.push(p);
            mesh.normals.push(p);
            mesh.uvs.push(uv);
        }
    }
    let at = |row: usize, column: usize| (row * (columns + 1) + column) as u32;
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            if row > 0 {
                mesh.triangles.push([a, c, b]);
            }
            if row + 1 < rows {
                mesh.triangles.push([b, c, d]);
            }
        }
    }
    placed(mesh, m)
}

/// The unit disk at z = 0, and whether du x dv points against its normal.
pub(crate) fn disk(to_world: &DAffine3) -> (Geometry, bool) {
    let [du, dv] = [DVec3::X, DVec3::Y].map(|a| to_world.transform_vector3(a).as_vec3());
    (Geometry::Disk { center: to_world.translation.as_vec3(), du, dv }, mirrors(to_world))
}

/// A cylinder from `p0` to `p1`. Its normals point outward even if the transform mirrors, as in Mitsuba 3.
pub(crate) fn cylinder(node: Node<'_>, to_world: &DAffine3) -> Option<Geometry> {
    let [p0, p1] = [("p0", DVec3::ZERO), ("p1", DVec3::Z)]
        .map(|(name, default)| node.point(name).unwrap_or(default));
    let radius = node.float("radius", 1.0);
    if radius <= 0.0 || p0 == p1 {
        node.error("the cylinder has no area", "");
        return None;
    }
    let s = (p1 - p0).normalize().any_orthonormal_vector();
    let t = (p1 - p0).normalize().cross(s);
    let [a, b] = [s, t].map(|v| to_world.transform_vector3(v).length() as f32);
    if (a / b - 1.0).abs() > UNIFORM {
        node.warn("a deformed cylinder is approximated by a round one");
    }
    let [p0, p1] = [p0, p1].map(|p| to_world.transform_point3(p).as_vec3());
    let radius = radius * (a * b).sqrt();
    if !(p0.is_finite() && p1.is_finite() && radius.is_finite() && radius > 0.0 && p0 != p1) {
        node.error("the cylinder has no area", "");
        return None;
    }
    Some(Geometry::Cylinder { p0, p1, radius })
}
