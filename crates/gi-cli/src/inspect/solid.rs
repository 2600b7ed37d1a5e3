//! Closed shapes: whether they are closed, their volume, and what is inside.

use std::collections::HashMap;

use gi_core::geometry::{Geometry, Mesh, Shape};
use gi_core::math::Bounds;
use glam::{DVec3, Vec3};

/// Meshes with more triangles are not examined.
const MOST_TRIANGLES: usize = 4_000_000;

/// Whether each edge of a mesh belongs to two triangles with opposite directions. Vertices at the same position count
/// as one.
pub(super) fn is_closed(mesh: &Mesh) -> bool {
    if mesh.triangles.is_empty() || mesh.triangles.len() > MOST_TRIANGLES {
        return false;
    }
    let mut of_position: HashMap<[u32; 3], u32> = HashMap::new();
    // Adding zero makes the two zeros equal.
    let key = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
    let welded: Vec<u32> = mesh
        .positions
        .iter()
        .map(|p| {
            let next = of_position.len() as u32;
            *of_position.entry(key(*p)).or_insert(next)
        })
        .collect();
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for triangle in mesh.triangles.iter() {
        let corners = triangle.map(|i| welded[i as usize]);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            if a != b {
                *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
            }
        }
    }
    edges.values().all(|balance| *balance == 0)
}

/// The volume inside a closed mesh; negative if its normals point inward.
pub(super) fn signed_volume(mesh: &Mesh) -> f64 {
    let bounds = mesh.bounds();
    let center = bounds.center().as_dvec3();
    let cone = |k: usize| {
        let [a, b, c] = mesh.corners(k).map(|p| p.as_dvec3() - center);
        let volume = a.dot(b.cross(c)) / 6.0;
        // Shading normals decide which side is the front.
        let turned = mesh.oriented_normal(k).dot(mesh.area_vector(k)) < 0.0;
        if turned { -volume } else { volume }
    };
    (0..mesh.triangles.len()).map(cone).sum()
}

/// A closed shape of a scene.
pub(super) struct Solid<'a> {
    pub(super) shape: &'a Shape,
    pub(super) bounds: Bounds,
}

impl<'a> Solid<'a> {
    /// The shape, if it is closed.
    pub(super) fn of(shape: &'a Shape) -> Option<Solid<'a>> {
        let closed = match &shape.geometry {
            Geometry::Mesh(mesh) => is_closed(mesh),
            Geometry::Sphere { .. } => true,
            Geometry::Disk { .. } | Geometry::Cylinder { .. } => false,
        };
        closed.then(|| Solid { shape, bounds: shape.geometry.bounds() })
    }

    /// Whether its normals point inward.
    pub(super) fn is_inverted(&self) -> bool {
        let inward = match &self.shape.geometry {
            Geometry::Mesh(mesh) => signed_volume(mesh) < 0.0,
            _ => false,
        };
        inward != self.shape.flip_normals
    }

    /// Whether a point is inside: a ray from it crosses the surface an odd number of times.
    pub(super) fn contains(&self, p: Vec3) -> bool {
        if p.cmplt(self.bounds.min).any() || p.cmpgt(self.bounds.max).any() {
            return false;
        }
        match &self.shape.geometry {
            Geometry::Mesh(mesh) => {
                let crossed = (0..mesh.triangles.len()).filter(|k| crosses(p, mesh.corners(*k)));
                crossed.count() % 2 == 1
            }
            Geometry::Sphere { center, radius, .. } => p.distance(*center) < *radius,
            Geometry::Disk { .. } | Geometry::Cylinder { .. } => false,
        }
    }
}

/// Whether the ray from `p` in a fixed direction, which no edge of usual scenes has, crosses a triangle \[Moeller97\].
fn crosses(p: Vec3, [a, b, c]: [Vec3; 3]) -> bool {
    const DIRECTION: DVec3 = DVec3::new(0.297_13, 0.871_91, 0.389_17);
    let [a, b, c] = [a, b, c].map(|v| (v - p).as_dvec3());
    let (ab, ac) = (b - a, c - a);
    let across = DIRECTION.cross(ac);
    let determinant = ab.dot(across);
    if determinant == 0.0 {
        return false;
    }
    let u = -a.dot(across) / determinant;
    let q = (-a).cross(ab);
    let v = DIRECTION.dot(q) / determinant;
    let t = ac.dot(q) / determinant;
    u >= 0.0 && v >= 0.0 && u + v < 1.0 && t > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box from -1 to 1, its corners not shared between faces.
    fn cube() -> Mesh {
        let mut mesh = Mesh::default();
        let mut triangles = Vec::new();
        for axis in 0..3 {
            for side in [-1.0, 1.0f32] {
                let mut corner = |u: f32, v: f32| {
                    let mut p = [0.0; 3];
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u * side, v);
                    mesh.positions.push(Vec3::from(p));
                };
                [(-1., -1.), (1., -1.), (1., 1.), (-1., 1.)]
                    .into_iter()
                    .for_each(|(u, v)| corner(u, v));
                let first = mesh.positions.len() as u32 - 4;
                triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i: u32| first + i)));
            }
        }
        mesh.triangles = triangles.into();
        mesh
    }

    #[test]
    fn a_box_is_closed_and_its_volume_tells_which_way_it_faces() {
        let mesh = cube();
        assert!(is_closed(&mesh));
        assert!((signed_volume(&mesh) - 8.0).abs() < 1e-9);
        let mut inverted = cube();
        inverted.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!((signed_volume(&inverted) + 8.0).abs() < 1e-9);
        let mut open = cube();
        open.triangles.pop();
        assert!(!is_closed(&open));
        let mut torn = cube();
        torn.triangles[0].swap(0, 1);
        assert!(!is_closed(&torn), "one triangle faces the other way");
    }

    #[test]
    fn points_are_inside_by_the_parity_of_crossings() {
        let shape = Shape::new("box", Geometry::Mesh(cube()), 0);
        let solid = Solid::of(&shape).unwrap();
        for inside in [Vec3::ZERO, Vec3::splat(0.99), Vec3::new(-0.5, 0.7, 0.1)] {
            assert!(solid.contains(inside), "{inside}");
        }
        for outside in [Vec3::splat(1.01), Vec3::new(0.0, -2.0, 0.0), Vec3::new(0.0, 1.001, 0.0)] {
            assert!(!solid.contains(outside), "{outside}");
        }
        assert!(!solid.is_inverted());
    }
}
