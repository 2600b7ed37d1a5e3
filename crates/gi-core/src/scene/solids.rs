//! Which media fill solid bodies, and which surfaces bound the same one.

use std::collections::HashMap;

use glam::Vec3;

use super::Scene;
use crate::geometry::{Geometry, Shape};
use crate::math::Bounds;

/// The solid bodies of a scene: media behind boundaries that all refract.
///
/// Primitives that share a corner bound one body; disks and cylinders bound one with all boundaries that their box touches.
/// A cavity in a body, and all copies of an instanced body, count as one body of their own.
pub struct Solids {
    /// By medium: whether it is bounded by refracting surfaces only.
    solid: Vec<bool>,
    /// By medium: whether lights stand in it.
    lit: Vec<bool>,
    /// By primitive: the number of the body, that of its first primitive.
    body_of: Vec<u32>,
}

impl Solids {
    /// Whether a medium fills solid bodies only.
    pub fn is_solid(&self, medium: usize) -> bool {
        self.solid[medium]
    }

    /// Whether no point of a medium is reached by light straight from a light.
    pub fn is_dark(&self, medium: usize) -> bool {
        self.solid[medium] && !self.lit[medium]
    }

    /// The body that a primitive bounds.
    pub fn body(&self, prim: u32) -> u32 {
        self.body_of[prim as usize]
    }
}

impl Scene {
    /// Find the solid bodies.
    pub fn solids(&self) -> Solids {
        let is_it =
            |m: usize, side: Option<usize>| side.is_some_and(|s| self.media[s] == self.media[m]);
        let bounds = |shape: &Shape, m| is_it(m, shape.interior) || is_it(m, shape.exterior);
        let all = 0..self.media.len();
        let lit = all.clone().map(|m| self.light_media.iter().any(|&round| is_it(m, round)));
        let solid = all.clone().map(|m| {
            let mut boundaries = self.shapes.iter().filter(|shape| bounds(shape, m)).peekable();
            boundaries.peek().is_some()
                && boundaries.all(|shape| self.materials[shape.material].refracts)
        });
        Solids { solid: solid.collect(), lit: lit.collect(), body_of: self.join_boundaries() }
    }

    /// For each primitive the first one of those that it hangs together with.
    fn join_boundaries(&self) -> Vec<u32> {
        let mut joined = Joined::new(self.shape_of.len());
        let mut at: HashMap<[u32; 3], u32> = HashMap::new();
        let boundaries: Vec<usize> =
            (0..self.shapes.len()).filter(|&k| self.shapes[k].is_boundary()).collect();
        for &k in &boundaries {
            let Geometry::Mesh(mesh) = &self.shapes[k].geometry else { continue };
            for triangle in 0..mesh.triangles.len() {
                let prim = self.first_primitive[k] + triangle as u32;
                for corner in mesh.corners(triangle) {
                    joined.join(*at.entry(bits(corner)).or_insert(prim), prim);
                }
            }
        }
        for &k in &boundaries {
            let geometry = &self.shapes[k].geometry;
            if !matches!(geometry, Geometry::Disk { .. } | Geometry::Cylinder { .. }) {
                continue;
            }
            let own = geometry.bounds();
            for &other in &boundaries {
                if touch(own, self.shapes[other].geometry.bounds()) {
                    joined.join(self.first_primitive[k], self.first_primitive[other]);
                }
            }
        }
        (0..self.shape_of.len() as u32).map(|prim| joined.first(prim)).collect()
    }
}

/// A point as a key; -0 and 0 are one coordinate.
fn bits(p: Vec3) -> [u32; 3] {
    p.to_array().map(|x| (x + 0.0).to_bits())
}

/// Whether two boxes have a point in common, to rounding.
fn touch(a: Bounds, b: Bounds) -> bool {
    let slack = 1e-5 * (a.extent() + b.extent()).max_element();
    (a.min - slack).cmple(b.max).all() && (b.min - slack).cmple(a.max).all()
}

/// Sets that are joined two by two; each is known by its first member.
struct Joined(Vec<u32>);

impl Joined {
    fn new(count: usize) -> Self {
        Joined((0..count as u32).collect())
    }

    fn first(&mut self, mut k: u32) -> u32 {
        while self.0[k as usize] != k {
            // Halve the way for those who come later.
            self.0[k as usize] = self.0[self.0[k as usize] as usize];
            k = self.0[k as usize];
        }
        k
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.first(a), self.first(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Mesh;
    use crate::material::Material;
    use crate::math::Rgb;
    use crate::medium::{Medium, Phase};
    use crate::scene::SceneParts;
    use crate::texture::Texture;

    /// Some faces of a tetrahedron with its first corner at `p`.
    fn tetrahedron(p: Vec3, faces: &[[u32; 3]]) -> Mesh {
        let positions = vec![p, p + Vec3::X, p + Vec3::Y, p + Vec3::Z];
        Mesh { positions, triangles: faces.to_vec(), ..Mesh::default() }
    }

    #[test]
    fn surfaces_that_share_corners_bound_one_body_and_null_ones_bound_none() {
        let glass = Material::Dielectric {
            eta: 1.5,
            reflectance: Texture::grey(1.0),
            transmittance: Texture::grey(1.0),
            roughness: None,
        };
        let sides = [[0, 2, 1], [0, 1, 3], [0, 3, 2]];
        let boundary = |geometry, material, inside| Shape {
            interior: Some(inside),
            ..Shape::new("boundary", Geometry::Mesh(geometry), material)
        };
        // One mesh of two bodies, the lid of one of them as a shape of its own, and a cloud.
        let mut two = tetrahedron(Vec3::ZERO, &sides);
        let far = tetrahedron(Vec3::splat(5.0), &sides);
        two.triangles.extend(far.triangles.iter().map(|t| t.map(|i| i + 4)));
        two.positions.extend(far.positions);
        let lid = tetrahedron(Vec3::splat(5.0), &[[1, 2, 3]]);
        let cloud = tetrahedron(Vec3::splat(-5.0), &sides);
        let grey =
            |s| Medium { sigma_t: Rgb::grey(s), albedo: Rgb::grey(0.5), phase: Phase::Isotropic };
        let parts = SceneParts {
            shapes: vec![boundary(two, 0, 0), boundary(lid, 0, 0), boundary(cloud, 1, 1)],
            materials: vec![glass, Material::Null],
            media: vec![grey(1.0), grey(2.0), grey(3.0)],
            ..SceneParts::default()
        };
        let scene = Scene::new(parts).expect("a scene");
        let solids = scene.solids();
        assert_eq!([0, 1, 2].map(|m| solids.is_solid(m)), [true, false, false]);
        assert!(solids.is_dark(0) && !solids.is_dark(1));
        let bodies: Vec<u32> = (0..10).map(|prim| solids.body(prim)).collect();
        assert_eq!(bodies, [0, 0, 0, 3, 3, 3, 3, 7, 7, 7]);
    }
}
