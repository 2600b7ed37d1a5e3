//! A balanced binary tree of points, without pointers.
//!
//! Points are stored in the order of the tree. Node i covers a range of them, which is halved down to leaves of at most [`LEAF`]
//! points. Node 1 is the root; the children of i are 2 i and 2 i + 1. Data of the nodes is stored in lists by that number.

use gi_core::math::Bounds;
use glam::Vec3;

/// Maximum number of points of a leaf.
const LEAF: usize = 8;

/// The shape of the tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heap {
    len: usize,
    levels: u32,
}

/// A node and its range of points.
#[derive(Clone, Copy)]
pub(crate) struct Node {
    pub(crate) index: usize,
    from: usize,
    to: usize,
    level: u32,
}

impl Node {
    pub(crate) fn run(self) -> std::ops::Range<usize> {
        self.from..self.to
    }

    pub(crate) fn halves(self) -> [Node; 2] {
        let Node { index, from, to, level } = self;
        let (middle, level) = ((from + to) / 2, level + 1);
        [
            Node { index: 2 * index, from, to: middle, level },
            Node { index: 2 * index + 1, from: middle, to, level },
        ]
    }
}

impl Heap {
    /// The shape of a tree over `len` points.
    pub(crate) fn over(len: usize) -> Self {
        let mut levels = 0;
        while len >> levels > LEAF {
            levels += 1;
        }
        Heap { len, levels }
    }

    /// Sort points into the order of the tree: split at the median along the longest side, recursively.
    pub(crate) fn order<T: Send>(points: &mut [T], p: impl Fn(&T) -> Vec3 + Copy + Sync) -> Self {
        let heap = Heap::over(points.len());
        halve(points, p, heap.levels);
        heap
    }

    pub(crate) fn root(&self) -> Node {
        Node { index: 1, from: 0, to: self.len, level: 0 }
    }

    pub(crate) fn is_leaf(&self, node: Node) -> bool {
        node.level == self.levels
    }

    /// Compute data for every node: `leaf` from its range, inner nodes from their children.
    pub(crate) fn sum_up<S: Clone>(
        &self,
        leaf: impl Fn(std::ops::Range<usize>) -> S,
        join: impl Fn(&S, &S) -> S,
    ) -> Vec<S> {
        // Number 0 stands for nothing, like a leaf without points.
        let mut sums = vec![leaf(0..0); 2 << self.levels];
        let mut leaves = Vec::with_capacity(1 << self.levels);
        self.visit_leaves(self.root(), &mut |node| leaves.push(node));
        for node in leaves {
            sums[node.index] = leaf(node.run());
        }
        for k in (1..1usize << self.levels).rev() {
            sums[k] = join(&sums[2 * k], &sums[2 * k + 1]);
        }
        sums
    }

    fn visit_leaves(&self, node: Node, visit: &mut impl FnMut(Node)) {
        if self.is_leaf(node) {
            return visit(node);
        }
        node.halves().into_iter().for_each(|half| self.visit_leaves(half, visit));
    }
}

fn halve<T: Send>(points: &mut [T], p: impl Fn(&T) -> Vec3 + Copy + Sync, levels: u32) {
    if levels == 0 {
        return;
    }
    let axis = Bounds::of(points.iter().map(p)).extent().max_position();
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| p(a)[axis].total_cmp(&p(b)[axis]));
    let (a, b) = points.split_at_mut(middle);
    rayon::join(|| halve(a, p, levels - 1), || halve(b, p, levels - 1));
}
