//! The photons of a medium, each with its radius, in a balanced hierarchy of boxes: which of them does a ray pierce?
//!
//! Photons lie in the order of the tree. Node i of the heap covers a run of them, halved at its middle down to leaves of at
//! most [`LEAF`]; neither pointers nor counts are stored.

use gi_core::math::Bounds;
use gi_core::ray::Ray;
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::PI;

use super::VolumePhoton;

/// Most photons of a leaf.
const LEAF: usize = 8;

/// Photons that a ray can be asked about.
pub(super) struct Hierarchy {
    photons: Vec<VolumePhoton>,
    /// Squared radius of each photon, world units.
    radius_sq: Vec<f32>,
    /// The box round the spheres of each node's photons; node 1 is the root, the children of i are 2 i and 2 i + 1.
    boxes: Vec<Bounds>,
    levels: u32,
}

/// A node and its run of photons.
#[derive(Clone, Copy)]
struct Node {
    index: usize,
    from: usize,
    to: usize,
    level: u32,
}

impl Node {
    fn halves(self) -> [Node; 2] {
        let Node { index, from, to, level } = self;
        let (middle, level) = ((from + to) / 2, level + 1);
        [
            Node { index: 2 * index, from, to: middle, level },
            Node { index: 2 * index + 1, from: middle, to, level },
        ]
    }
}

impl Hierarchy {
    /// Order the photons, and give each the radius of the sphere that holds its `k` nearest.
    pub(super) fn build(mut photons: Vec<VolumePhoton>, k: usize) -> Self {
        let mut levels = 0;
        while photons.len() >> levels > LEAF {
            levels += 1;
        }
        order(&mut photons, levels);
        let radius_sq = vec![0.0; photons.len()];
        let mut tree = Hierarchy { photons, radius_sq, boxes: Vec::new(), levels };
        tree.enclose();
        let radii = (0..tree.photons.len()).into_par_iter();
        tree.radius_sq = radii.map(|i| tree.kth_nearest(tree.photons[i].photon.p(), k)).collect();
        tree.enclose();
        tree
    }

    pub(super) fn len(&self) -> usize {
        self.photons.len()
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.photons[..])
            + size_of_val(&self.radius_sq[..])
            + size_of_val(&self.boxes[..])
    }

    fn root(&self) -> Node {
        Node { index: 1, from: 0, to: self.photons.len(), level: 0 }
    }

    /// Boxes round the spheres, from the leaves to the root.
    fn enclose(&mut self) {
        let mut boxes = vec![Bounds::EMPTY; 2 << self.levels];
        self.enclose_node(self.root(), &mut boxes);
        self.boxes = boxes;
    }

    fn enclose_node(&self, node: Node, boxes: &mut [Bounds]) -> Bounds {
        let found = if node.level == self.levels {
            (node.from..node.to).fold(Bounds::EMPTY, |bounds, i| {
                let (p, r) = (self.photons[i].photon.p(), self.radius_sq[i].sqrt());
                bounds.with(p - r).with(p + r)
            })
        } else {
            let [a, b] = node.halves().map(|half| self.enclose_node(half, boxes));
            a.union(b)
        };
        boxes[node.index] = found;
        found
    }

    /// Squared distance of the `k`-th nearest photon to `p`, itself not counted; of the farthest where there are fewer.
    fn kth_nearest(&self, p: Vec3, k: usize) -> f32 {
        // The nearest k + 1 so far, nearest first: the photon itself is among them.
        let mut nearest: Vec<f32> = Vec::with_capacity(k + 2);
        let mut stack = vec![(0.0, self.root())];
        while let Some((far, node)) = stack.pop() {
            if nearest.len() > k && far >= nearest[k] {
                continue;
            }
            if node.level < self.levels {
                let mut halves = node.halves().map(|h| (distance_sq(&self.boxes[h.index], p), h));
                if halves[0].0 < halves[1].0 {
                    halves.swap(0, 1);
                }
                stack.extend(halves);
                continue;
            }
            for stored in &self.photons[node.from..node.to] {
                let d = stored.photon.p().distance_squared(p);
                if nearest.len() <= k || d < nearest[k] {
                    let at = nearest.partition_point(|&other| other <= d);
                    nearest.insert(at, d);
                    nearest.truncate(k + 1);
                }
            }
        }
        nearest.last().copied().unwrap_or(0.0)
    }

    /// Visit the photons whose disc across `ray` (unit direction) the ray pierces before the distance `reach`, with that
    /// distance and the density per area that the photon has there: 2 (1 - d^2 / r^2) / (pi r^2), Epanechnikov's kernel.
    pub(super) fn pierced(
        &self,
        ray: &Ray,
        reach: f32,
        mut visit: impl FnMut(&VolumePhoton, f32, f32),
    ) {
        let inverse = ray.d.recip();
        // No level leaves more than one node behind.
        let mut stack = [self.root(); 64];
        let mut count = usize::from(!self.photons.is_empty());
        while count > 0 {
            count -= 1;
            let node = stack[count];
            if !meets(&self.boxes[node.index], ray.o, inverse, reach) {
                continue;
            }
            if node.level < self.levels {
                let [a, b] = node.halves();
                (stack[count], stack[count + 1]) = (b, a);
                count += 2;
                continue;
            }
            let run = node.from..node.to;
            for (stored, &r2) in self.photons[run.clone()].iter().zip(&self.radius_sq[run]) {
                let to = stored.photon.p() - ray.o;
                let t = to.dot(ray.d);
                let d2 = (to - ray.d * t).length_squared();
                if t > 0.0 && t < reach && d2 < r2 {
                    visit(stored, t, 2.0 * (1.0 - d2 / r2) / (PI * r2));
                }
            }
        }
    }
}

/// Halve at the median along the longest side, `levels` times.
fn order(photons: &mut [VolumePhoton], levels: u32) {
    if levels == 0 {
        return;
    }
    let bounds = Bounds::of(photons.iter().map(|s| s.photon.p()));
    let axis = bounds.extent().max_position();
    let middle = photons.len() / 2;
    let key = |s: &VolumePhoton| s.photon.position[axis];
    photons.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
    let (a, b) = photons.split_at_mut(middle);
    rayon::join(|| order(a, levels - 1), || order(b, levels - 1));
}

/// Squared distance of `p` from a box; 0 inside.
fn distance_sq(bounds: &Bounds, p: Vec3) -> f32 {
    p.distance_squared(p.clamp(bounds.min, bounds.max))
}

/// Whether a ray enters a box before `reach`.
#[inline]
#[expect(clippy::neg_cmp_op_on_partial_ord, reason = "what is no number is met")]
fn meets(bounds: &Bounds, o: Vec3, inverse: Vec3, reach: f32) -> bool {
    let (a, b) = ((bounds.min - o) * inverse, (bounds.max - o) * inverse);
    let near = a.min(b).max_element().max(0.0);
    let far = a.max(b).min_element().min(reach);
    // Where the ray runs in a side's plane, 0 times infinity is no number: the box counts as met.
    !(near > far * 1.000_001)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photon::{Kind, Photon, Rgbe};
    use gi_core::rng::Pcg;
    use gi_core::warp;

    fn strewn(n: usize) -> Vec<VolumePhoton> {
        let mut rng = Pcg::new(4, 2);
        let mut photon = |_| {
            let p = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32() * 0.5);
            let photon = Photon::new(p, Rgbe::BLACK, Vec3::X, Vec3::X, Kind::Indirect);
            VolumePhoton { photon, depth: 2 }
        };
        (0..n).map(&mut photon).collect()
    }

    #[test]
    fn radii_reach_to_the_kth_nearest_as_sorting_finds_it() {
        for (n, k) in [(1, 5), (7, 3), (9, 20), (1000, 12)] {
            let tree = Hierarchy::build(strewn(n), k);
            for (stored, r2) in tree.photons.iter().zip(&tree.radius_sq) {
                let p = stored.photon.p();
                let mut all: Vec<f32> =
                    tree.photons.iter().map(|s| s.photon.p().distance_squared(p)).collect();
                all.sort_by(f32::total_cmp);
                assert_eq!(*r2, all[k.min(n - 1)], "{n} photons, k = {k}");
            }
        }
    }

    #[test]
    fn a_ray_finds_the_photons_that_a_scan_of_all_finds() {
        for n in [0, 1, 8, 9, 3000] {
            let tree = Hierarchy::build(strewn(n), 10);
            let mut rng = Pcg::new(9, 1);
            for k in 0..300 {
                let o = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32() - 0.2);
                let mut d = warp::sphere(rng.next_2d());
                if k % 5 == 0 {
                    // Along an axis, in the plane of no side and of some.
                    d = [Vec3::X, -Vec3::Y, Vec3::Z][k % 3];
                }
                let (ray, reach) = (Ray::new(o, d), 0.2 + rng.next_f32());
                let mut found = Vec::new();
                tree.pierced(&ray, reach, |s, _, _| {
                    found.push(s.photon.position.map(f32::to_bits))
                });
                let mut expected: Vec<[u32; 3]> = tree
                    .photons
                    .iter()
                    .zip(&tree.radius_sq)
                    .filter(|(s, r2)| {
                        let to = s.photon.p() - o;
                        let t = to.dot(d);
                        t > 0.0 && t < reach && (to - d * t).length_squared() < **r2
                    })
                    .map(|(s, _)| s.photon.position.map(f32::to_bits))
                    .collect();
                found.sort_unstable();
                expected.sort_unstable();
                assert_eq!(found, expected, "{n} photons, ray {k}");
            }
        }
    }

    #[test]
    fn a_photon_has_24_bytes_and_the_hierarchy_adds_less_than_18() {
        assert_eq!(size_of::<VolumePhoton>(), 24);
        let n = 100_000;
        let tree = Hierarchy::build(strewn(n), 4);
        assert!((tree.bytes() as f64 / n as f64) < 42.0, "{}", tree.bytes());
    }
}
