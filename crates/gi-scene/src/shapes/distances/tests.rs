use super::*;
use crate::budget::Budget;

/// Distances from a sphere around the middle of the unit cube, at n^3 points.
fn sphere(n: usize, radius: f32) -> Vec<f32> {
    let at = |i: usize| i as f32 / (n - 1) as f32 - 0.5;
    let points = (0..n.pow(3)).map(|k| Vec3::new(at(k % n), at(k / n % n), at(k / n / n)));
    points.map(|p| p.length() - radius).collect()
}

fn mesh(size: [usize; 3], values: &[f32]) -> Mesh {
    let budget = Budget::new(u64::MAX);
    Distances::new(size, values).unwrap().mesh(&mut budget.claim("a test")).unwrap()
}

#[test]
fn a_sphere_is_closed_faces_outward_and_has_its_area_and_normals() {
    let mesh = mesh([41; 3], &sphere(41, 0.3));
    let mut edges = HashMap::new();
    for t in mesh.triangles.iter() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
        }
    }
    assert!(edges.values().all(|n| *n == 0), "every edge has a triangle on each side");
    let area: f32 = (0..mesh.triangles.len()).map(|k| 0.5 * mesh.area_vector(k).length()).sum();
    // Between points h apart, interpolated distances from a sphere of radius r are too large by up to h^2 / (4 r).
    let exact = 4.0 * std::f32::consts::PI * 0.3 * 0.3;
    let most = 1.05 * 0.025f32.powi(2) / (4.0 * 0.3);
    assert!((1.0 - 2.0 * most / 0.3..1.0).contains(&(area / exact)), "{area} and {exact}");
    for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
        let radial = (*p - 0.5).normalize();
        assert!(n.dot(radial) > 0.999, "{p}: {n}");
        assert!((0.3 - most..0.3001).contains(&(*p - 0.5).length()), "{p}");
    }
    for k in 0..mesh.triangles.len() {
        let middle = mesh.corners(k).iter().sum::<Vec3>() / 3.0 - 0.5;
        assert!(mesh.area_vector(k).dot(middle) >= 0.0, "triangle {k}");
    }
}

#[test]
fn normals_of_a_stretched_grid_are_those_of_its_planes() {
    // The plane x + 2 y = 1.3 in a grid with other numbers of points along each axis.
    let size = [4, 7, 3];
    let at = |i: usize, axis: usize| i as f32 / (size[axis] - 1) as f32;
    let values: Vec<f32> =
        (0..size.iter().product()).map(|k| at(k % 4, 0) + 2.0 * at(k / 4 % 7, 1) - 1.3).collect();
    let mesh = mesh(size, &values);
    let exact = Vec3::new(1.0, 2.0, 0.0).normalize();
    assert!(!mesh.normals.is_empty());
    for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
        assert!((p.x + 2.0 * p.y - 1.3).abs() < 1e-5 && n.dot(exact) > 0.99999, "{p} {n}");
    }
}

#[test]
fn a_grid_of_one_sign_has_no_surface_and_a_large_one_is_counted() {
    assert!(mesh([2; 3], &[1.0; 8]).triangles.is_empty());
    assert!(Distances::new([1, 2, 2], &[0.0; 4]).is_none());
    let (values, budget) = (sphere(41, 0.3), Budget::new(100_000));
    let distances = Distances::new([41; 3], &values).unwrap();
    assert!(distances.mesh(&mut budget.claim("m.vol")).is_err());
}
