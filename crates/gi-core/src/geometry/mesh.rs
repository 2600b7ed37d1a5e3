use glam::{Affine3A, Vec2, Vec3};

use super::Shared;
use crate::math::Bounds;

/// A triangle mesh in world space. Per-vertex arrays are empty or as long as `positions`. Copies share what does not
/// depend on their place.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertices.
    pub positions: Vec<Vec3>,
    /// Unit shading normals; empty for face normals.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, v = 0 at the top row of an image; empty for barycentric coordinates.
    pub uvs: Shared<Vec2>,
    /// Three indices per triangle; counter-clockwise seen from outside.
    pub triangles: Shared<[u32; 3]>,
}

impl Mesh {
    /// The corners of triangle `k`.
    #[inline]
    pub fn corners(&self, k: usize) -> [Vec3; 3] {
        self.triangles[k].map(|i| self.positions[i as usize])
    }

    /// The bounding box of all vertices.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.positions.iter().copied())
    }

    /// Area-weighted face normal of triangle `k`: the cross product of its edges, whose length is twice the area.
    #[inline]
    pub fn area_vector(&self, k: usize) -> Vec3 {
        let [a, b, c] = self.corners(k);
        (b - a).cross(c - a)
    }

    /// Unit face normal of triangle `k`, on the side of its shading normals if the mesh has them; zero for a triangle
    /// without area.
    pub fn oriented_normal(&self, k: usize) -> Vec3 {
        let n = self.area_vector(k).normalize_or_zero();
        if self.normals.is_empty() {
            return n;
        }
        let shading: Vec3 = self.triangles[k].iter().map(|&i| self.normals[i as usize]).sum();
        if n.dot(shading) < 0.0 { -n } else { n }
    }

    /// Transform the mesh by an affine map. Normals use the inverse transpose. The winding is kept, so a mirroring map
    /// flips face normals, as in Mitsuba.
    pub fn transform(&mut self, m: &Affine3A) {
        for p in &mut self.positions {
            *p = m.transform_point3(*p);
        }
        let normal_map = m.matrix3.inverse().transpose();
        for n in &mut self.normals {
            *n = (normal_map * *n).try_normalize().unwrap_or(Vec3::Z);
        }
    }

    /// Replace the shading normals by the angle-weighted mean of the faces around each vertex \[Thurmer98\].
    pub fn smooth_normals(&mut self) {
        let mut sums = vec![Vec3::ZERO; self.positions.len()];
        for k in 0..self.triangles.len() {
            let Some(n) = self.area_vector(k).try_normalize() else { continue };
            let p = self.corners(k);
            for (j, &index) in self.triangles[k].iter().enumerate() {
                let (a, b) = (p[(j + 1) % 3] - p[j], p[(j + 2) % 3] - p[j]);
                sums[index as usize] += n * a.angle_between(b);
            }
        }
        self.normals = sums.into_iter().map(|n| n.try_normalize().unwrap_or(Vec3::Z)).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_follow_the_inverse_transpose() {
        let mut mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y + Vec3::Z],
            triangles: vec![[0, 1, 2]].into(),
            ..Mesh::default()
        };
        mesh.smooth_normals();
        let squash = Affine3A::from_scale(Vec3::new(1.0, 0.2, 3.0));
        mesh.transform(&squash);
        let face = mesh.area_vector(0).normalize();
        for n in &mesh.normals {
            assert!((*n - face).length() < 1e-6, "{n} is not {face}");
        }
    }
}
