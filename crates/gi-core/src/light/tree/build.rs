//! Builds the light tree: binned, top-down, by the orientation heuristic of \[Conty18\].

use glam::Vec3;

use super::bounds::LightBounds;
use super::node::{Link, Node};
use crate::math::Bounds;

/// A light while the tree is built.
pub(super) struct Leaf {
    pub(super) of: LightBounds,
    pub(super) light: u32,
    /// The way from the root to the light: bit k is set if the second child is taken at depth k.
    pub(super) trail: u64,
}

/// Number of bins per axis.
const BINS: usize = 12;
/// Clusters of at least this many lights are built in parallel.
const PARALLEL: usize = 4096;
/// From this depth on, clusters are halved by count. The trail then has enough bits for any number of lights.
const HALVING_DEPTH: u32 = 30;

/// Place of a cluster in the tree.
#[derive(Clone, Copy)]
struct Place {
    /// Index of the first of its descendants.
    first: u32,
    depth: u32,
    trail: u64,
}

/// Build the tree of some lights: all nodes, the root first. Index 1 is unused, so that pairs of siblings start at even
/// indices.
pub(super) fn build(leaves: &mut [Leaf]) -> Vec<Node> {
    if leaves.is_empty() {
        return Vec::new();
    }
    let mut nodes = vec![Node::default(); 2 * leaves.len()];
    let (root, below) = nodes.split_at_mut(2);
    root[0] = fill(leaves, below, Place { first: 2, depth: 0, trail: 0 }).1;
    nodes
}

/// Write the descendants of a cluster to `below`. Returns the bounds and the node of the cluster.
fn fill(leaves: &mut [Leaf], below: &mut [Node], at: Place) -> (LightBounds, Node) {
    if let [leaf] = leaves {
        leaf.trail = at.trail;
        return (leaf.of, Node::new(&leaf.of, Link::Light(leaf.light)));
    }
    let middle = split(leaves, at.depth);
    let count = leaves.len();
    let (left, right) = leaves.split_at_mut(middle);
    let (pair, below) = below.split_at_mut(2);
    let descendants = 2 * (left.len() - 1);
    let (below_left, below_right) = below.split_at_mut(descendants);
    let depth = at.depth + 1;
    let first = Place { first: at.first + 2, depth, trail: at.trail };
    let second =
        Place { first: first.first + descendants as u32, depth, trail: at.trail | 1 << at.depth };
    let (a, b) = if count >= PARALLEL {
        rayon::join(|| fill(left, below_left, first), || fill(right, below_right, second))
    } else {
        (fill(left, below_left, first), fill(right, below_right, second))
    };
    (pair[0], pair[1]) = (a.1, b.1);
    let of = a.0.union(&b.0);
    (of, Node::new(&of, Link::Children(at.first)))
}

/// Sort the lights of a cluster into two parts. Returns the size of the first part; neither is empty.
fn split(leaves: &mut [Leaf], depth: u32) -> usize {
    let centers = Bounds::of(leaves.iter().map(|l| l.of.bounds.center()));
    if leaves.len() == 2 {
        let axis = longest(centers);
        let along = |l: &Leaf| l.of.bounds.center()[axis];
        if along(&leaves[0]) > along(&leaves[1]) {
            leaves.swap(0, 1);
        }
        return 1;
    }
    let best = if depth < HALVING_DEPTH { best_plane(leaves, centers) } else { None };
    let Some((axis, plane)) = best else {
        let (half, axis) = (leaves.len() / 2, longest(centers));
        let along = |l: &Leaf| l.of.bounds.center()[axis];
        leaves.select_nth_unstable_by(half, |a, b| {
            along(a).total_cmp(&along(b)).then(a.light.cmp(&b.light))
        });
        return half;
    };
    let scale = bin_scale(centers);
    partition(leaves, |l| bin(l, centers.min, scale)[axis] < plane)
}

fn longest(bounds: Bounds) -> usize {
    let extent = bounds.extent();
    (0..3).fold(0, |a, b| if extent[b] > extent[a] { b } else { a })
}

/// Factor from a position to a bin.
fn bin_scale(centers: Bounds) -> Vec3 {
    centers.extent().map(|e| if e > 0.0 { BINS as f32 / e } else { 0.0 })
}

/// The bins of a light's centre along the three axes.
#[inline]
fn bin(leaf: &Leaf, min: Vec3, scale: Vec3) -> [usize; 3] {
    let at = (leaf.of.bounds.center() - min) * scale;
    [at.x, at.y, at.z].map(|x| (x as usize).min(BINS - 1))
}

/// The axis and the bin before which the cheapest split lies; `None` if all centres coincide.
fn best_plane(leaves: &[Leaf], centers: Bounds) -> Option<(usize, usize)> {
    let scale = bin_scale(centers);
    let mut bins = [[LightBounds::EMPTY; BINS]; 3];
    for leaf in leaves {
        for (bins, k) in bins.iter_mut().zip(bin(leaf, centers.min, scale)) {
            bins[k] = bins[k].union(&leaf.of);
        }
    }
    let extent = centers.extent();
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
        // Thin slices are expensive [Conty18, 4.2].
        let regularity = extent.max_element() / extent[axis];
        let mut below = [0.0; BINS];
        let mut all = LightBounds::EMPTY;
        for k in 1..BINS {
            all = all.union(&bins[axis][k - 1]);
            below[k] = if all.intensity > 0.0 { all.cost() } else { f32::INFINITY };
        }
        let mut all = LightBounds::EMPTY;
        for k in (1..BINS).rev() {
            all = all.union(&bins[axis][k]);
            let above = if all.intensity > 0.0 { all.cost() } else { f32::INFINITY };
            let cost = regularity * (below[k] + above);
            if cost.is_finite() && best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, k));
            }
        }
    }
    best.map(|(_, axis, plane)| (axis, plane))
}

/// Move the elements that satisfy `is_first` to the front. Returns their number.
fn partition<T>(items: &mut [T], is_first: impl Fn(&T) -> bool) -> usize {
    let mut first = 0;
    for k in 0..items.len() {
        if is_first(&items[k]) {
            items.swap(first, k);
            first += 1;
        }
    }
    first
}
