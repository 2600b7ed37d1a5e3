//! Repairs and smooths shading normals.

use std::collections::HashMap;

use gi_core::geometry::Mesh;
use glam::{Vec2, Vec3};

use around::{Around, Face};

mod around;

/// Whether all vertex normals of triangle `k` point against it.
fn faces_away(mesh: &Mesh, k: usize) -> bool {
    let face = mesh.area_vector(k);
    mesh.triangles[k].iter().all(|&i| mesh.normals[i as usize].dot(face) < 0.0)
}

/// Whether [`face_the_normals`] changes nothing.
pub(crate) fn face_their_normals(mesh: &Mesh) -> bool {
    !(0..mesh.triangles.len()).any(|k| faces_away(mesh, k))
}

/// Flip the winding of each triangle whose vertex normals all point against it. Mitsuba also takes the sides from the
/// normals. (A mirroring transform reverses the winding but not the normals.)
pub(crate) fn face_the_normals(mesh: &mut Mesh) {
    for k in 0..mesh.triangles.len() {
        if faces_away(mesh, k) {
            mesh.triangles[k].swap(1, 2);
        }
    }
}

/// Replace invalid vertex normals (zero, or not finite) by the mean normal of the adjacent faces, on the side of the
/// other normals of these faces. Returns the number of replaced normals.
pub(crate) fn replace_bad_normals(mesh: &mut Mesh) -> usize {
    const SHORTEST: f32 = 1e-6; // valid normals have unit length here
    let bad: Vec<bool> =
        mesh.normals.iter().map(|n| !n.is_finite() || n.length() < SHORTEST).collect();
    let count = bad.iter().filter(|b| **b).count();
    if count == 0 {
        return 0;
    }
    for (n, _) in mesh.normals.iter_mut().zip(&bad).filter(|(_, bad)| **bad) {
        *n = Vec3::ZERO;
    }
    let mut sums = vec![Vec3::ZERO; mesh.normals.len()];
    for k in 0..mesh.triangles.len() {
        let face = mesh.oriented_normal(k) * mesh.area_vector(k).length();
        mesh.triangles[k].iter().for_each(|&i| sums[i as usize] += face);
    }
    for i in (0..bad.len()).filter(|&i| bad[i]) {
        // A vertex of no face, or only of degenerate ones, is invisible.
        mesh.normals[i] = sums[i].try_normalize().unwrap_or(Vec3::Z);
    }
    count
}

/// The warning about replaced normals.
pub(crate) fn bad_normals(count: usize, name: &str) -> String {
    format!("`{name}`: {count} normals are zero or not finite: face normals replace them")
}

/// Memory per triangle that [`smooth_up_to`] needs at most.
pub(crate) const BYTES: u64 = 640;

/// Give each corner the mean normal of the adjacent faces whose normals are within `angle` (radians) of its own face's.
/// Faces are adjacent if they share a position.
pub(crate) fn smooth_up_to(mesh: &mut Mesh, angle: f32) {
    let key = |p: Vec3| p.to_array().map(|x| (x + 0.0).to_bits());
    let faces: Vec<Vec3> =
        (0..mesh.triangles.len()).map(|k| mesh.area_vector(k).normalize_or_zero()).collect();
    let mut at: HashMap<[u32; 3], Vec<Face>> = HashMap::new();
    for (k, &normal) in faces.iter().enumerate() {
        let p = mesh.corners(k);
        for j in 0..3 {
            let (a, b) = (p[(j + 1) % 3] - p[j], p[(j + 2) % 3] - p[j]);
            let weight = if normal == Vec3::ZERO { 0.0 } else { a.angle_between(b) };
            at.entry(key(p[j])).or_default().push(Face { normal, weight });
        }
    }
    let at: HashMap<_, _> = at.into_iter().map(|(p, faces)| (p, Around::new(faces))).collect();
    let limit = angle.cos();
    let mut out = Mesh::default();
    let mut known = HashMap::new();
    for (k, &face) in faces.iter().enumerate() {
        let corner = |j: usize| {
            let i = mesh.triangles[k][j] as usize;
            let p = mesh.positions[i];
            let n = at[&key(p)].sum(face, limit).try_normalize().unwrap_or(Vec3::Z);
            let uv = mesh.uvs.get(i).copied().unwrap_or(Vec2::ZERO);
            let id = (key(p), key(n), uv.to_array().map(f32::to_bits));
            *known.entry(id).or_insert_with(|| {
                out.positions.push(p);
                out.normals.push(n);
                if !mesh.uvs.is_empty() {
                    out.uvs.push(uv);
                }
                out.positions.len() as u32 - 1
            })
        };
        let triangle = [0, 1, 2].map(corner);
        out.triangles.push(triangle);
    }
    *mesh = out;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::solids;
    use glam::DAffine3;

    #[test]
    fn a_cube_stays_sharp_below_ninety_degrees_and_becomes_smooth_above() {
        let mut sharp = solids::cube(&DAffine3::IDENTITY);
        smooth_up_to(&mut sharp, 45f32.to_radians());
        for k in 0..sharp.triangles.len() {
            let face = sharp.area_vector(k).normalize();
            for i in sharp.triangles[k] {
                assert!((sharp.normals[i as usize] - face).length() < 1e-6);
            }
        }
        let mut round = solids::cube(&DAffine3::IDENTITY);
        smooth_up_to(&mut round, 100f32.to_radians());
        for (p, n) in round.positions.iter().zip(&round.normals) {
            assert!((p.normalize() - *n).length() < 1e-5, "{p} {n}");
        }
    }

    #[test]
    fn triangles_follow_their_normals() {
        let mut mesh = solids::rectangle(&DAffine3::IDENTITY);
        mesh.normals = vec![-Vec3::Z; 4];
        face_the_normals(&mut mesh);
        assert!(mesh.area_vector(0).z < 0.0 && mesh.area_vector(1).z < 0.0);
    }
}
