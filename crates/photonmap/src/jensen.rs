//! The lecture's layout: a left-balanced kd-tree in one array, the children of entry i at 2i and 2i + 1 [slide 25].
//!
//! \[Jensen01, 6.2 and appendix B\]: every photon is a node, the split axis is in its flags, and the array has no gaps.

use gi_core::math::Bounds;
use glam::Vec3;

use crate::kd::longest_axis;
use crate::nearest::Candidates;
use crate::order::Order;
use crate::photon::{Payload, Photon};
use crate::shoot::Stored;

/// The tree. Entry 0 is empty, so that the root is 1.
pub(crate) struct HeapTree {
    pub(crate) photons: Vec<Photon>,
    /// Depths of the photons, if they are to be known.
    pub(crate) depths: Vec<u8>,
}

const NOTHING: Photon = Photon {
    position: [0.0; 3],
    payload: Payload { power: crate::photon::Rgbe::BLACK, phi: 0, theta: 0, flags: 0 },
};

impl HeapTree {
    /// Balance photons into a tree.
    pub(crate) fn build(mut photons: Vec<Stored>, order: Order, with_depths: bool) -> Self {
        let n = photons.len();
        let depths = vec![0; if with_depths { n + 1 } else { 0 }];
        let mut tree = HeapTree { photons: vec![NOTHING; n + 1], depths };
        match order {
            Order::Any => tree.balance(&mut photons, 1),
            Order::Tree => photons.iter().enumerate().for_each(|(k, s)| tree.put(k + 1, *s)),
        }
        tree
    }

    /// How many photons there are.
    pub(crate) fn len(&self) -> usize {
        self.photons.len() - 1
    }

    /// Bytes in memory.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.photons[..]) + self.depths.len()
    }

    /// Put the median of `photons` at entry `i`, and the others below it.
    fn balance(&mut self, photons: &mut [Stored], i: usize) {
        if photons.is_empty() {
            return;
        }
        let axis = longest_axis(photons.iter());
        let median = left_size(photons.len());
        let coordinate = |s: &Stored| s.photon.position[axis];
        photons.select_nth_unstable_by(median, |a, b| coordinate(a).total_cmp(&coordinate(b)));
        let Stored { photon, depth } = photons[median];
        let photon = Photon { payload: photon.payload.with_axis(axis), ..photon };
        self.put(i, Stored { photon, depth });
        let (left, right) = photons.split_at_mut(median);
        self.balance(left, 2 * i);
        self.balance(&mut right[1..], 2 * i + 1);
    }

    fn put(&mut self, i: usize, Stored { photon, depth }: Stored) {
        self.photons[i] = photon;
        if let Some(slot) = self.depths.get_mut(i) {
            *slot = depth;
        }
    }

    /// The number of photons in the subtree of entry `i`.
    fn below(&self, i: usize) -> usize {
        let (mut first, mut last, mut count) = (i, i, 0);
        while first <= self.len() {
            count += last.min(self.len()) - first + 1;
            (first, last) = (2 * first, 2 * last + 1);
        }
        count
    }

    /// All cells down to `depth` levels with their numbers of photons, for pictures.
    pub(crate) fn cells(&self, bounds: Bounds, depth: u32) -> Vec<(Bounds, usize)> {
        let mut cells = vec![(bounds, 1)];
        for _ in 0..depth {
            let halves = |(cell, i): (Bounds, usize)| {
                let Some(photon) = self.photons.get(i) else { return vec![(cell, i)] };
                let (axis, mut a, mut b) = (photon.payload.axis() % 3, cell, cell);
                a.max[axis] = photon.position[axis];
                b.min[axis] = photon.position[axis];
                vec![(a, 2 * i), (b, 2 * i + 1)]
            };
            cells = cells.into_iter().flat_map(halves).collect();
        }
        cells.into_iter().map(|(cell, i)| (cell, self.below(i))).collect()
    }

    /// Offer `found` all photons that may be among the nearest to `p`.
    pub(crate) fn search(
        &self,
        p: Vec3,
        found: &mut Candidates,
        accept: impl Fn(u32) -> bool + Copy,
    ) {
        if self.len() > 0 {
            self.locate(1, p, found, accept);
        }
    }

    fn locate(
        &self,
        i: usize,
        p: Vec3,
        found: &mut Candidates,
        accept: impl Fn(u32) -> bool + Copy,
    ) {
        let photon = &self.photons[i];
        if 2 * i < self.photons.len() {
            let axis = photon.payload.axis() % 3;
            let across = p[axis] - photon.position[axis];
            let (near, far) = if across < 0.0 { (2 * i, 2 * i + 1) } else { (2 * i + 1, 2 * i) };
            if near < self.photons.len() {
                self.locate(near, p, found, accept);
            }
            if across * across < found.bound() && far < self.photons.len() {
                self.locate(far, p, found, accept);
            }
        }
        let d2 = photon.p().distance_squared(p);
        if d2 < found.bound() && accept(i as u32) {
            found.offer(d2, i as u32);
        }
    }
}

/// Photons in the left subtree of a left-balanced tree of `n`: all levels are full but the last, which fills from
/// the left.
fn left_size(n: usize) -> usize {
    let height = n.ilog2();
    let above = (1usize << height) - 1; // in the full levels
    let half = (1usize << height) / 2; // places in the last level under the left child
    (above - above.min(1)) / 2 + (n - above).min(half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn left_balanced_sizes() {
        // Counted by hand: 1; 2 = root + left; 3 full; 4 has one on the third level, and so on.
        let sizes: Vec<usize> = (1..=10).map(left_size).collect();
        assert_eq!(sizes, [0, 1, 1, 2, 3, 3, 3, 4, 5, 6]);
    }
}
