//! A bounding volume hierarchy over the photons of a medium, to find those whose discs a ray pierces.

use gi_core::math::Bounds;
use gi_core::ray::Ray;
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::PI;

use crate::heap::{Heap, Node};
use crate::order::Order;
use crate::photon::Photon;

/// A photon in a medium: [`Photon`] without a normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumePhoton {
    /// Position, scattered power (already divided by the number of emitted paths), and direction.
    pub photon: Photon,
    /// Segments from the light to here, 255 standing for more.
    pub depth: u8,
}

/// The hierarchy.
pub(super) struct Hierarchy {
    photons: Vec<VolumePhoton>,
    /// Squared radius of each photon, world units.
    radius_sq: Vec<f32>,
    heap: Heap,
    /// The box round the spheres of each node's photons.
    boxes: Vec<Bounds>,
}

impl Hierarchy {
    /// Sort the photons, and give each the radius of the sphere that contains its `k` nearest neighbours.
    pub(super) fn build(mut photons: Vec<VolumePhoton>, k: usize, found: Order) -> Self {
        let heap = match found {
            Order::Any => Heap::order(&mut photons, |s| s.photon.p()),
            Order::Tree => Heap::over(photons.len()),
        };
        let radius_sq = vec![0.0; photons.len()];
        let mut tree = Hierarchy { photons, radius_sq, heap, boxes: Vec::new() };
        tree.enclose();
        let radii = (0..tree.photons.len()).into_par_iter();
        tree.radius_sq = radii.map(|i| tree.kth_nearest(tree.photons[i].photon.p(), k)).collect();
        tree.enclose();
        tree
    }

    /// The photons in the order of the tree.
    pub(super) fn photons(&self) -> &[VolumePhoton] {
        &self.photons
    }

    pub(super) fn len(&self) -> usize {
        self.photons.len()
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.photons[..])
            + size_of_val(&self.radius_sq[..])
            + size_of_val(&self.boxes[..])
    }

    /// Boxes round the spheres.
    fn enclose(&mut self) {
        let sphere = |bounds: Bounds, i: usize| {
            let (p, r) = (self.photons[i].photon.p(), self.radius_sq[i].sqrt());
            bounds.with(p - r).with(p + r)
        };
        let leaf = |run: std::ops::Range<usize>| run.fold(Bounds::EMPTY, sphere);
        self.boxes = self.heap.sum_up(leaf, |&a, &b| a.union(b));
    }

    /// Squared distance of the `k`-th nearest photon to `p`, without the photon at `p`; of the farthest if there are fewer.
    fn kth_nearest(&self, p: Vec3, k: usize) -> f32 {
        // The nearest k + 1 so far, nearest first: the photon itself is among them.
        let mut nearest: Vec<f32> = Vec::with_capacity(k + 2);
        let mut stack = vec![(0.0, self.heap.root())];
        while let Some((far, node)) = stack.pop() {
            if nearest.len() > k && far >= nearest[k] {
                continue;
            }
            if !self.heap.is_leaf(node) {
                let mut halves = node.halves().map(|h| (distance_sq(&self.boxes[h.index], p), h));
                if halves[0].0 < halves[1].0 {
                    halves.swap(0, 1);
                }
                stack.extend(halves);
                continue;
            }
            for stored in &self.photons[node.run()] {
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

    /// Visit the photons whose disc perpendicular to `ray` (unit direction) the ray pierces, with the distance along the ray and the
    /// photon's density per area there: 2 (1 - d^2 / r^2) / (pi r^2), Epanechnikov's kernel.
    ///
    /// Discs that the ray would pierce shortly beyond its end at a surface, `reach` away, count as if the ray were reflected there; the
    /// same holds at its start. This replaces the discs of photons that are missing behind the surface.
    pub(super) fn pierced(
        &self,
        ray: &Ray,
        reach: f32,
        from_surface: bool,
        mut visit: impl FnMut(&VolumePhoton, f32, f32),
    ) {
        let inverse = ray.d.recip();
        // No level leaves more than one node behind.
        let mut stack: [Node; 64] = [self.heap.root(); 64];
        let mut count = usize::from(!self.photons.is_empty());
        while count > 0 {
            count -= 1;
            let node = stack[count];
            if !meets(&self.boxes[node.index], ray.o, inverse, reach) {
                continue;
            }
            if !self.heap.is_leaf(node) {
                let [a, b] = node.halves();
                (stack[count], stack[count + 1]) = (b, a);
                count += 2;
                continue;
            }
            let run = node.run();
            for (stored, &r2) in self.photons[run.clone()].iter().zip(&self.radius_sq[run]) {
                let to = stored.photon.p() - ray.o;
                let t = to.dot(ray.d);
                let d2 = (to - ray.d * t).length_squared();
                if d2 >= r2 {
                    continue;
                }
                // Beyond an end, photons count whose sphere holds it.
                let t = if t > 0.0 && t < reach {
                    t
                } else if t <= 0.0 && from_surface && d2 + t * t < r2 {
                    (-t).min(reach)
                } else if t >= reach && d2 + (t - reach) * (t - reach) < r2 {
                    (2.0 * reach - t).max(0.0)
                } else {
                    continue;
                };
                visit(stored, t, 2.0 * (1.0 - d2 / r2) / (PI * r2));
            }
        }
    }
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
    use crate::photon::{Photon, PhotonKind, Rgbe};
    use gi_core::rng::Pcg;
    use gi_core::warp;

    fn strewn(n: usize) -> Vec<VolumePhoton> {
        let mut rng = Pcg::new(4, 2);
        let mut photon = |_| {
            let p = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32() * 0.5);
            let photon = Photon::new(p, Rgbe::BLACK, Vec3::X, Vec3::X, PhotonKind::Indirect);
            VolumePhoton { photon, depth: 2 }
        };
        (0..n).map(&mut photon).collect()
    }

    #[test]
    fn radii_reach_to_the_kth_nearest_as_sorting_finds_it() {
        for (n, k) in [(1, 5), (7, 3), (9, 20), (1000, 12)] {
            let tree = Hierarchy::build(strewn(n), k, Order::Any);
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
            let tree = Hierarchy::build(strewn(n), 10, Order::Any);
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
                tree.pierced(&ray, reach, k % 2 == 0, |s, _, _| {
                    found.push(s.photon.position.map(f32::to_bits))
                });
                let mut expected: Vec<[u32; 3]> = tree
                    .photons
                    .iter()
                    .zip(&tree.radius_sq)
                    .filter(|(s, r2)| {
                        let to = s.photon.p() - o;
                        let t = to.dot(d);
                        let holds = |end: Vec3| s.photon.p().distance_squared(end) < **r2;
                        let counts = match t {
                            _ if t <= 0.0 => k % 2 == 0 && holds(o),
                            _ if t >= reach => holds(o + d * reach),
                            _ => true,
                        };
                        counts && (to - d * t).length_squared() < **r2
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
        let tree = Hierarchy::build(strewn(n), 4, Order::Any);
        assert!((tree.bytes() as f64 / n as f64) < 42.0, "{}", tree.bytes());
    }
}
