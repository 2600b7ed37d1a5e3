//! Meshes that a pbrt file contains, and surfaces that become meshes.

use gi_core::geometry::Mesh;
use glam::{DVec3, Vec2, Vec3};

use super::Translator;
use super::params::Params;
use crate::document::{ObjectId, Value};
use crate::hash::Hash;
use crate::local::Extent;
use crate::shapes::mesh_file::{self, ReadMesh};

/// Columns of triangles around a full surface of revolution. The error is 0.03 % of the radius.
const COLUMNS: usize = 128;

/// A point of the curve that makes a surface of revolution when it turns around the z axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct ProfilePoint {
    pub(super) radius: f64,
    pub(super) z: f64,
    /// The normal's components away from the axis and along it.
    pub(super) normal: [f64; 2],
}

/// The corners of a mesh, in double precision, with what belongs to each.
#[derive(Debug, Default)]
pub(super) struct Corners {
    pub(super) positions: Vec<DVec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) uvs: Vec<Vec2>,
}

impl Translator<'_> {
    /// The corners that a shape gives; `None` after an error.
    pub(super) fn corners(&self, params: &Params) -> Option<Corners> {
        let Some(points) = params.numbers("P") else {
            self.report.error(params.span, format!("`{}` without `point3 P`", params.plugin), "");
            return None;
        };
        if points.is_empty() || !points.len().is_multiple_of(3) {
            let message = format!("`P` has {} numbers", points.len());
            self.report.error(params.span_of("P"), message, "expected three for each point");
            return None;
        }
        let positions: Vec<DVec3> =
            points.chunks_exact(3).map(|p| DVec3::new(p[0], p[1], p[2])).collect();
        let per_corner = |name, width: usize| {
            let all = params.numbers(name)?;
            if all.len() == width * positions.len() {
                return Some(all);
            }
            let message = format!(
                "`{name}` has {} numbers for {} points: ignored",
                all.len(),
                positions.len()
            );
            self.report.warn(params.span_of(name), message);
            None
        };
        params.ignore(&["S", "faceIndices"]);
        let normals = per_corner("N", 3).unwrap_or_default().chunks_exact(3);
        let normals = normals.map(|n| DVec3::new(n[0], n[1], n[2]));
        // Normals of any length are valid, however small.
        let normals = normals.map(|n| n.try_normalize().unwrap_or(DVec3::ZERO).as_vec3());
        let uvs = per_corner("uv", 2).or_else(|| per_corner("st", 2)).unwrap_or_default();
        let uvs = uvs.chunks_exact(2).map(|uv| Vec2::new(uv[0] as f32, uv[1] as f32));
        Some(Corners { normals: normals.collect(), uvs: uvs.collect(), positions })
    }

    /// The indices of a shape, `per_face` for each face; `default` if they are not given. `None` after an error.
    pub(super) fn indices(
        &self,
        params: &Params,
        per_face: usize,
        count: usize,
        default: &[u32],
    ) -> Option<Vec<u32>> {
        let Some(all) = params.numbers("indices") else {
            if count == default.len() {
                return Some(default.to_vec());
            }
            let message = format!("`{}` without `integer indices`", params.plugin);
            self.report.error(params.span, message, "");
            return None;
        };
        let span = params.span_of("indices");
        if all.is_empty() || !all.len().is_multiple_of(per_face) {
            let message = format!("`indices` has {} numbers", all.len());
            let expected = format!("expected {per_face} for each face");
            self.report.error(span, message, &expected);
            return None;
        }
        let valid = |i: &f64| i.fract() == 0.0 && (0.0..count as f64).contains(i);
        if let Some(bad) = all.iter().find(|i| !valid(i)) {
            let message = format!("the index {bad} of {count} points");
            self.report.error(span, message, &format!("expected 0 to {}", count - 1));
            return None;
        }
        Some(all.iter().map(|i| *i as u32).collect())
    }

    /// Give a shape a mesh of its own.
    pub(super) fn inline_mesh(
        &mut self,
        shape: ObjectId,
        params: &Params,
        corners: Corners,
        triangles: Vec<[u32; 3]>,
    ) {
        let Corners { positions, normals, uvs } = corners;
        let mut hash = Hash::default();
        let lengths = [positions.len(), normals.len(), uvs.len(), triangles.len()];
        lengths.into_iter().for_each(|n| hash.word(n as u64));
        positions.iter().flat_map(|p| p.to_array()).for_each(|x| hash.word(x.to_bits()));
        let normals_and_uvs = normals
            .iter()
            .flat_map(|n| n.to_array())
            .chain(uvs.iter().flat_map(|uv| uv.to_array()));
        normals_and_uvs.for_each(|x| hash.word(x.to_bits().into()));
        triangles.iter().flatten().for_each(|i| hash.word(u64::from(*i)));
        let origin = Extent::of(positions.iter().copied()).map_or(DVec3::ZERO, |e| e.origin());
        let mesh = Mesh {
            positions: positions.iter().map(|p| (*p - origin).as_vec3()).collect(),
            normals,
            uvs: uvs.into(),
            triangles: triangles.into(),
        };
        let claim = self.report.budget.claim("meshes inside the scene file");
        if let Err(why) = claim.keep(mesh_file::bytes(&mesh)) {
            return self.report.error(params.span, why, "");
        }
        // What distinguishes this shape from others in the hash of the world.
        self.doc.set(shape, "contents", params.span, Value::Integer(hash.value() as i64));
        let read = ReadMesh { mesh, portable: false, note: None, origin, rounding: 0.0 };
        self.doc.inline_meshes.borrow_mut().insert(shape, read);
    }
}

/// The surface that a profile makes when it turns by `angle` (radians) around the z axis. The first texture coordinate
/// runs with the angle, the second along the profile.
pub(super) fn revolve(profile: &[ProfilePoint], angle: f64) -> (Corners, Vec<[u32; 3]>) {
    let (rows, columns) = (profile.len() - 1, COLUMNS);
    let mut corners = Corners::default();
    let full = angle >= std::f64::consts::TAU;
    for (row, point) in profile.iter().enumerate() {
        for column in 0..=columns {
            let u = column as f64 / columns as f64;
            // The seam must close exactly.
            let phi = if full && column == columns { 0.0 } else { angle * u };
            let (sin, cos) = phi.sin_cos();
            let around = |r: f64, z: f64| DVec3::new(r * cos, r * sin, z);
            corners.positions.push(around(point.radius, point.z));
            corners.normals.push(around(point.normal[0], point.normal[1]).as_vec3());
            corners.uvs.push(Vec2::new(u as f32, row as f32 / rows as f32));
        }
    }
    let at = |row: usize, column: usize| (row * (columns + 1) + column) as u32;
    let mut triangles = Vec::with_capacity(2 * rows * columns);
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            // At the axis, one of the two triangles has no area.
            if profile[row].radius != 0.0 {
                triangles.push([a, b, d]);
            }
            if profile[row + 1].radius != 0.0 {
                triangles.push([a, d, c]);
            }
        }
    }
    (corners, triangles)
}
