//! The faces around one point, searched by the direction of their normals. A mesh may have very many faces around one
//! point, and each of them asks for the others whose normals are similar.

use std::ops::Range;

use glam::Vec3;

/// This many faces or fewer are compared one by one.
const FEW: usize = 16;

/// A face at the point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// Unit normal, or zero for a face without area.
    pub(super) normal: Vec3,
    /// Weight of its normal in a mean.
    pub(super) weight: f32,
}

/// Some of the faces: those in one part of a k-d tree of their normals.
#[derive(Debug)]
struct Node {
    /// Bounding box of the normals.
    min: Vec3,
    max: Vec3,
    /// Weighted sum of the normals.
    sum: Vec3,
    faces: Range<usize>,
    /// The second child. The first one follows its parent. `None` in a leaf.
    second: Option<usize>,
}

/// All faces around a point.
#[derive(Debug)]
pub(super) struct Around {
    faces: Vec<Face>,
    nodes: Vec<Node>,
}

impl Around {
    pub(super) fn new(faces: Vec<Face>) -> Self {
        let mut around = Around { nodes: Vec::new(), faces };
        around.add(0..around.faces.len());
        around
    }

    fn add(&mut self, range: Range<usize>) {
        let faces = &mut self.faces[range.clone()];
        let mut node =
            Node { min: Vec3::MAX, max: Vec3::MIN, sum: Vec3::ZERO, faces: range, second: None };
        for face in &*faces {
            node.min = node.min.min(face.normal);
            node.max = node.max.max(face.normal);
            node.sum += face.normal * face.weight;
        }
        let (this, count) = (self.nodes.len(), faces.len());
        if count <= FEW || node.min == node.max {
            self.nodes.push(node);
            return;
        }
        let axis = (node.max - node.min).max_position();
        faces.select_nth_unstable_by(count / 2, |a, b| a.normal[axis].total_cmp(&b.normal[axis]));
        let (start, middle, end) = (node.faces.start, node.faces.start + count / 2, node.faces.end);
        self.nodes.push(node);
        self.add(start..middle);
        self.nodes[this].second = Some(self.nodes.len());
        self.add(middle..end);
    }

    /// The weighted sum of all normals whose cosine with `normal` is at least `limit`.
    pub(super) fn sum(&self, normal: Vec3, limit: f32) -> Vec3 {
        self.sum_below(0, normal, limit)
    }

    fn sum_below(&self, node: usize, normal: Vec3, limit: f32) -> Vec3 {
        let Node { min, max, sum, faces, second } = &self.nodes[node];
        let Some(second) = second else {
            if min == max && faces.len() > FEW {
                return if min.dot(normal) >= limit { *sum } else { Vec3::ZERO };
            }
            let near = self.faces[faces.clone()].iter().filter(|f| f.normal.dot(normal) >= limit);
            return near.map(|f| f.normal * f.weight).sum();
        };
        // The smallest and the largest cosine with any normal in the box.
        let (a, b) = (*min * normal, *max * normal);
        if a.min(b).element_sum() >= limit {
            return *sum;
        }
        if a.max(b).element_sum() < limit {
            return Vec3::ZERO;
        }
        self.sum_below(node + 1, normal, limit) + self.sum_below(*second, normal, limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_the_same_faces_as_a_comparison_with_all() {
        // Directions on a spiral over the sphere, many of them twice.
        let face = |k: usize| {
            let z = 1.0 - 2.0 * ((k / 2) as f32 + 0.5) / 500.0;
            let (sin, cos) = (2.4 * (k / 2) as f32).sin_cos();
            let across = (1.0 - z * z).sqrt();
            Face { normal: Vec3::new(across * cos, across * sin, z), weight: 0.1 + z.abs() }
        };
        let all: Vec<Face> = (0..1000).map(face).collect();
        let around = Around::new(all.clone());
        for limit in [-1.1f32, -0.3, 0.2, 0.7, 0.95, 1.1] {
            for query in all.iter().step_by(7) {
                let near = all.iter().filter(|f| f.normal.dot(query.normal) >= limit);
                let expected: Vec3 = near.map(|f| f.normal * f.weight).sum();
                let found = around.sum(query.normal, limit);
                // A face within rounding of the limit has a weight of at most 1.1, others a different sum.
                assert!(found.distance(expected) < 1e-2, "{limit}: {found} is not {expected}");
            }
        }
    }

    #[test]
    fn a_fan_of_equal_normals_is_one_leaf() {
        let around = Around::new(vec![Face { normal: Vec3::Z, weight: 0.5 }; 1000]);
        assert_eq!(around.nodes.len(), 1);
        assert_eq!(around.sum(Vec3::Z, 1.0), Vec3::Z * 500.0);
        assert_eq!(around.sum(Vec3::X, 0.5), Vec3::ZERO);
    }
}
