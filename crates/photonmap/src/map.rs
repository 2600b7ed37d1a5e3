//! A photon map: photons in a tree, whatever its layout.

use gi_core::math::Bounds;
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

    /// The boxes that the tree's planes part `bounds` into, `depth` levels down, with their numbers of photons; for pictures.
    pub fn cells(&self, bounds: Bounds, depth: u32) -> Vec<(Bounds, usize)> {
        match &self.tree {
            Tree::Jensen(tree) => tree.cells(bounds, depth),
            Tree::Fast(tree) => tree.cells(bounds, depth),
        }
    }
}

#[cfg(test)]
mod tests;
