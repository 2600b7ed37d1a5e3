//! A photon map: photons in a tree, whatever its layout.

use glam::Vec3;

pub use crate::params::Layout;

use crate::jensen::HeapTree;
use crate::kd::KdTree;
use crate::nearest::{Candidates, distance_sq, number};
pub use crate::order::Order;
use crate::photon::{Payload, Photon};
use crate::shoot::Stored;

/// A photon map.
pub struct PhotonMap {
    tree: Tree,
    /// Paths that were begun at the lights to fill the map.
    pub emitted: u64,
}

enum Tree {
    Jensen(HeapTree),
    Fast(KdTree),
}

/// What a search found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Found {
    /// How many photons; at most k.
    pub count: usize,
    /// Squared radius that holds them: the distance of the k-th, or the search's bound where there are fewer.
    pub radius_sq: f32,
}

impl PhotonMap {
    /// Build a map. Depths are kept where a search is to ask for them.
    pub fn build(
        photons: Vec<Stored>,
        emitted: u64,
        layout: Layout,
        order: Order,
        with_depths: bool,
    ) -> Self {
        let tree = match layout {
            Layout::Jensen => Tree::Jensen(HeapTree::build(photons, order, with_depths)),
            Layout::Fast => Tree::Fast(KdTree::build(photons, order, with_depths)),
        };
        PhotonMap { tree, emitted }
    }

    /// How many photons there are.
    pub fn len(&self) -> usize {
        match &self.tree {
            Tree::Jensen(tree) => tree.len(),
            Tree::Fast(tree) => tree.len(),
        }
    }

    /// Whether there are no photons.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How the photons lie in memory.
    pub fn layout(&self) -> Layout {
        match &self.tree {
            Tree::Jensen(_) => Layout::Jensen,
            Tree::Fast(_) => Layout::Fast,
        }
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        match &self.tree {
            Tree::Jensen(tree) => tree.bytes(),
            Tree::Fast(tree) => tree.bytes(),
        }
    }

    /// All photons with their depths (0 where they were not kept), in the tree's order.
    pub fn photons(&self) -> impl Iterator<Item = Stored> + '_ {
        (0..self.len()).map(|k| self.stored(k))
    }

    /// Photon `k` in the tree's order.
    pub(crate) fn stored(&self, k: usize) -> Stored {
        let (photon, depths, k): (Photon, &[u8], usize) = match &self.tree {
            Tree::Jensen(tree) => (tree.photons[k + 1], &tree.depths, k + 1),
            Tree::Fast(tree) => (tree.photon(k), &tree.depths, k),
        };
        Stored { photon, depth: depths.get(k).copied().unwrap_or(0) }
    }

    /// Find the `k` photons nearest to `p`, nearer than `radius_sq` (squared), among those that `accept` takes by payload
    /// and depth; `visit` gets each with its squared distance and the squared radius of all, in no order.
    #[inline]
    pub fn nearest(
        &self,
        p: Vec3,
        k: usize,
        radius_sq: f32,
        accept: impl Fn(&Payload, u8) -> bool + Copy,
        mut visit: impl FnMut(&Payload, f32, f32),
    ) -> Found {
        let visit = |_, photon: &Payload, d2, r2| visit(photon, d2, r2);
        self.nearest_places(p, k, radius_sq, accept, visit)
    }

    /// As [`PhotonMap::nearest`]; `visit` gets the place of each photon first.
    #[inline]
    pub(crate) fn nearest_places(
        &self,
        p: Vec3,
        k: usize,
        radius_sq: f32,
        accept: impl Fn(&Payload, u8) -> bool + Copy,
        mut visit: impl FnMut(Vec3, &Payload, f32, f32),
    ) -> Found {
        if k == 0 {
            return Found { count: 0, radius_sq: 0.0 };
        }
        Candidates::search(k, radius_sq, |found| match &self.tree {
            Tree::Jensen(tree) => {
                let payload = |i: usize| &tree.photons[i].payload;
                tree.search(p, found, |i| {
                    accept(payload(i as usize), tree.depths.get(i as usize).copied().unwrap_or(0))
                });
                let (keys, radius_sq) = found.finish();
                for &key in keys {
                    let q = tree.photons[number(key)].p();
                    visit(q, payload(number(key)), distance_sq(key), radius_sq);
                }
                Found { count: keys.len(), radius_sq }
            }
            Tree::Fast(tree) => {
                tree.search(p, found, |i| {
                    let i = i as usize;
                    accept(&tree.payloads[i], tree.depths.get(i).copied().unwrap_or(0))
                });
                let (keys, radius_sq) = found.finish();
                for &key in keys {
                    let q = tree.place(number(key));
                    visit(q, &tree.payloads[number(key)], distance_sq(key), radius_sq);
                }
                Found { count: keys.len(), radius_sq }
            }
        })
    }

    /// A photon near `p`, nearer than `radius_sq` (squared), that `accept` takes, and its place: at most twice as far as
    /// the nearest.
    #[inline]
    pub fn near_one(
        &self,
        p: Vec3,
        radius_sq: f32,
        accept: impl Fn(&Payload) -> bool + Copy,
    ) -> Option<(Vec3, Payload)> {
        match &self.tree {
            Tree::Fast(tree) => {
                let (_, i) = tree.near_one(p, radius_sq, |i| {
                    tree.payloads.get(i as usize).is_some_and(accept)
                })?;
                Some((tree.place(i as usize), tree.payloads[i as usize]))
            }
            Tree::Jensen(tree) => Candidates::search(1, radius_sq, |found| {
                tree.search(p, found, |i| accept(&tree.photons[i as usize].payload));
                let key = *found.finish().0.first()?;
                let photon = tree.photons[number(key)];
                Some((photon.p(), photon.payload))
            }),
        }
    }

    /// The boxes that the tree's planes part `bounds` into, `depth` levels down; for pictures.
    pub fn cells(&self, bounds: gi_core::math::Bounds, depth: u32) -> Vec<gi_core::math::Bounds> {
        match &self.tree {
            Tree::Jensen(tree) => tree.cells(bounds, depth),
            Tree::Fast(tree) => tree.cells(bounds, depth),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photon::{PhotonKind, Rgbe};
    use gi_core::math::Rgb;
    use gi_core::rng::Pcg;

    /// Photons on two walls, in a cluster, and some twice; the power says the number.
    fn photons(n: usize) -> Vec<Stored> {
        let mut rng = Pcg::new(9, n as u64);
        (0..n)
            .map(|k| {
                let [u, v] = rng.next_2d();
                let p = match k % 4 {
                    0 => Vec3::new(u, 0.0, v),
                    1 => Vec3::new(0.0, u, v),
                    2 => Vec3::new(0.4, 0.4, 0.4) + Vec3::new(u, v, u * v) * 0.01,
                    _ => Vec3::splat((8.0 * u).floor() / 8.0),
                };
                let n = if k % 3 == 0 { Vec3::Y } else { -Vec3::Y };
                let photon = Photon::new(
                    p,
                    Rgbe::nearest(Rgb::WHITE),
                    Vec3::from_array([u, v, 0.1]).normalize(),
                    n,
                    PhotonKind::Indirect,
                );
                Stored { photon, depth: (k % 5) as u8 }
            })
            .collect()
    }

    #[test]
    fn the_nearest_are_what_sorting_finds_in_both_layouts() {
        for n in [0, 1, 2, 31, 32, 33, 64, 65, 1000, 5000] {
            let all = photons(n);
            for layout in [Layout::Jensen, Layout::Fast] {
                let map = PhotonMap::build(all.clone(), 1, layout, Order::Any, true);
                assert_eq!(map.len(), n);
                let mut rng = Pcg::new(4, 0);
                for case in 0..100 {
                    // Inside, and outside of the box of all photons but within reach.
                    let u: [f32; 3] = std::array::from_fn(|_| rng.next_f32() * 1.4 - 0.2);
                    let p = Vec3::from_array(u);
                    let (k, radius_sq) = (1 + case % 60, [0.01, 0.3, f32::INFINITY][case % 3]);
                    let accept = |p: &Payload, depth: u8| p.normal().y > 0.0 && depth < 4;
                    let mut expected: Vec<f32> = all
                        .iter()
                        .filter(|s| accept(&s.photon.payload, s.depth))
                        .map(|s| s.photon.p().distance_squared(p))
                        .filter(|d2| *d2 < radius_sq)
                        .collect();
                    expected.sort_by(f32::total_cmp);
                    expected.truncate(k);
                    let mut got = Vec::new();
                    let found = map.nearest(p, k, radius_sq, accept, |_, d2, _| got.push(d2));
                    got.sort_by(f32::total_cmp);
                    assert_eq!(got.len(), expected.len(), "{layout:?}, {n} photons, case {case}");
                    for (a, b) in got.iter().zip(&expected) {
                        assert!((a - b).abs() <= 1e-6 * b, "{layout:?}, {n}: {a} is not {b}");
                    }
                    assert_eq!(found.count, got.len());
                    let last = if got.len() == k { got[k - 1] } else { radius_sq };
                    assert_eq!(found.radius_sq, last, "{layout:?}, {n}");
                }
            }
        }
    }

    #[test]
    fn one_near_is_at_most_twice_as_far_as_the_nearest() {
        let all = photons(3000);
        let mut rng = Pcg::new(5, 0);
        for layout in [Layout::Jensen, Layout::Fast] {
            let map = PhotonMap::build(all.clone(), 1, layout, Order::Any, false);
            for case in 0..500 {
                let u: [f32; 3] = std::array::from_fn(|_| rng.next_f32());
                let (p, radius_sq) = (Vec3::from_array(u), [1e-3, 1e-2, 9.0][case % 3]);
                let accept = |p: &Payload| p.normal().y > 0.0;
                let mut nearest = radius_sq;
                map.nearest(p, 1, radius_sq, |p, _| accept(p), |_, d2, _| nearest = d2);
                // Directions tell the photons apart.
                let found = map.near_one(p, radius_sq, accept).map(|(_, payload)| payload);
                let is = |s: &&Stored| {
                    found.is_some_and(|f| {
                        f.direction() == s.photon.payload.direction() && accept(&f)
                    })
                };
                let least = all.iter().filter(is).map(|s| s.photon.p().distance_squared(p));
                let least = least.fold(f32::INFINITY, f32::min);
                assert!(found.is_none() == (nearest == radius_sq), "{layout:?}, case {case}");
                assert!(
                    found.is_none() || least <= 4.0 * nearest,
                    "{layout:?}: {least}, {nearest}"
                );
            }
        }
    }

    #[test]
    fn no_photon_is_lost_and_the_trees_are_small() {
        let all = photons(10_000);
        let sum = |photons: &mut dyn Iterator<Item = Stored>| {
            photons.map(|s| f64::from(s.photon.p().dot(Vec3::new(1.0, 3.0, 7.0)))).sum::<f64>()
        };
        let expected = sum(&mut all.iter().copied());
        for layout in [Layout::Jensen, Layout::Fast] {
            let map = PhotonMap::build(all.clone(), 1, layout, Order::Any, false);
            assert!((sum(&mut map.photons()) - expected).abs() < 1e-6 * expected);
            let in_order: Vec<Stored> = map.photons().collect();
            let again = PhotonMap::build(in_order.clone(), 1, layout, Order::Tree, false);
            assert!(again.photons().eq(in_order), "{layout:?}: the order was not kept");
            let same = |p: Vec3| {
                let mut sums = [&map, &again].map(|map| {
                    let mut sum = 0.0;
                    map.nearest(p, 40, 1.0, |_, _| true, |_, d2, _| sum += d2);
                    sum
                });
                sums[0] -= sums[1];
                sums[0] == 0.0
            };
            assert!(all.iter().step_by(97).all(|s| same(s.photon.p())), "{layout:?}");
            // 20 bytes and at most a tenth.
            assert!(map.bytes() as f64 <= 22.0 * all.len() as f64, "{layout:?}: {}", map.bytes());
        }
    }
}
