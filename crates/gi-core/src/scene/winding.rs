//! Find the inner side of a medium's boundary.

use super::SceneParts;
use super::media_check::is_closed;
use crate::geometry::{Geometry, Shape};
use crate::medium::MediumId;

impl SceneParts {
    /// Make `interior` of every closed boundary the enclosed side. Normals decide on which side a medium is. A mesh
    /// with inward winding has inward normals, so its medium would fill the space outside. Shapes that are closed only
    /// together, such as six rectangles, are examined together. Returns a warning for each boundary that was flipped.
    pub fn enclose_media(&mut self) -> Vec<String> {
        let mut warnings = Vec::new();
        let lists = std::iter::once(&mut self.shapes).chain(&mut self.groups);
        lists.for_each(|shapes| enclose(shapes, &mut warnings));
        warnings
    }
}

/// Flip the boundaries that face inward.
fn enclose(shapes: &mut [Shape], warnings: &mut Vec<String>) {
    let mut turn = |shapes: &mut [Shape], of: &[usize]| {
        for &k in of {
            let shape = &mut shapes[k];
            std::mem::swap(&mut shape.interior, &mut shape.exterior);
            warnings.push(format!(
                "shape \"{}\" faces inward: its `interior` medium is taken to be what it encloses",
                shape.name
            ));
        }
    };
    let boundaries: Vec<usize> =
        (0..shapes.len()).filter(|&k| shapes[k].interior.is_some()).collect();
    let (closed, open): (Vec<usize>, Vec<usize>) =
        boundaries.into_iter().partition(|&k| is_closed([&shapes[k]].into_iter()));
    for k in closed {
        if volume(&shapes[k]) < 0.0 {
            turn(shapes, &[k]);
        }
    }
    let mut media: Vec<Option<MediumId>> = open.iter().map(|&k| shapes[k].interior).collect();
    media.sort_unstable();
    media.dedup();
    for medium in media {
        let of: Vec<usize> =
            open.iter().copied().filter(|&k| shapes[k].interior == medium).collect();
        let volume: f64 = of.iter().map(|&k| volume(&shapes[k])).sum();
        if volume < 0.0 && is_closed(of.iter().map(|&k| &shapes[k])) {
            turn(shapes, &of);
        }
    }
}

/// The enclosed volume of a shape, negative if its normals point inward. For an open mesh: its contribution to the
/// volume of a closed one.
fn volume(shape: &Shape) -> f64 {
    let volume = match &shape.geometry {
        Geometry::Sphere { radius, .. } => f64::from(*radius).powi(3),
        Geometry::Mesh(mesh) => (0..mesh.triangles.len())
            .map(|k| {
                let [a, b, c] = mesh.corners(k).map(|p| p.as_dvec3());
                let six = a.dot(b.cross(c));
                let turned = mesh.oriented_normal(k).dot(mesh.area_vector(k)) < 0.0;
                if turned { -six } else { six }
            })
            .sum(),
        Geometry::Disk { .. } | Geometry::Cylinder { .. } => 0.0,
    };
    if shape.flip_normals { -volume } else { volume }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Mesh;
    use glam::Vec3;

    /// A tetrahedron with outward faces, filled with medium 0.
    fn tetrahedron(offset: Vec3) -> Shape {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|p| p + offset).to_vec();
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].into();
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        Shape { interior: Some(MediumId::new(0)), ..Shape::new("body", Geometry::Mesh(mesh), 0) }
    }

    fn turned(shape: &Shape) -> Shape {
        let Geometry::Mesh(mut mesh) = shape.geometry.clone() else { unreachable!() };
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        Shape { geometry: Geometry::Mesh(mesh), ..shape.clone() }
    }

    fn interiors(shapes: Vec<Shape>) -> (Vec<Option<MediumId>>, usize) {
        let mut parts = SceneParts { shapes, ..SceneParts::default() };
        let warnings = parts.enclose_media();
        (parts.shapes.iter().map(|s| s.interior).collect(), warnings.len())
    }

    #[test]
    fn a_boundary_with_inward_winding_has_its_medium_inside() {
        for offset in [Vec3::ZERO, Vec3::new(50.0, -30.0, 7.0)] {
            let body = tetrahedron(offset);
            assert_eq!(interiors(vec![body.clone()]), (vec![Some(MediumId::new(0))], 0));
            assert_eq!(
                interiors(vec![turned(&body), body.clone()]),
                (vec![None, Some(MediumId::new(0))], 1)
            );
            let flipped = Shape { flip_normals: true, ..body.clone() };
            assert_eq!(interiors(vec![flipped.clone()]), (vec![None], 1));
            assert_eq!(interiors(vec![turned(&flipped)]), (vec![Some(MediumId::new(0))], 0));
        }
    }

    #[test]
    fn faces_that_are_closed_only_together_are_examined_together() {
        let faces = |shape: &Shape| -> Vec<Shape> {
            let Geometry::Mesh(mesh) = &shape.geometry else { unreachable!() };
            let face = |t: &[u32; 3]| {
                let mesh = Mesh { triangles: vec![*t].into(), ..mesh.clone() };
                Shape { geometry: Geometry::Mesh(mesh), ..shape.clone() }
            };
            mesh.triangles.iter().map(face).collect()
        };
        let body = tetrahedron(Vec3::new(2.0, 1.0, -4.0));
        assert_eq!(interiors(faces(&body)), (vec![Some(MediumId::new(0)); 4], 0));
        assert_eq!(interiors(faces(&turned(&body))), (vec![None; 4], 4));
        // An open bowl does not define an inside.
        assert_eq!(
            interiors(faces(&turned(&body))[1..].to_vec()),
            (vec![Some(MediumId::new(0)); 3], 0)
        );
    }
}
