//! Builds the binary tree: splits top-down at the cheapest of a few planes per axis, by the surface-area heuristic
//! \[Wald07\].

use super::bins::{Bins, Extent, Grid, partition};
use super::input::{Input, PrimRef};
use super::optimise::{BinaryNode, hole, zeroed_nodes};

/// Most references in a leaf.
const LEAF: usize = 4;
/// Largest depth of a leaf; ranges that could become deeper are split in the middle.
const MAX_DEPTH: u32 = 60;
/// Ranges with more references are processed by two tasks.
const TASK: usize = 1 << 12;

/// How ranges are split.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Method {
    /// At the cheapest plane.
    Cheapest,
    /// At the middle reference: gives a balanced tree for any input.
    Halves,
}

/// The binary tree over `input.refs`, which are reordered. Siblings are adjacent; unused places contain holes.
pub(super) fn build(input: &mut Input, method: Method) -> Vec<BinaryNode> {
    let mut refs = std::mem::take(&mut input.refs);
    let mut nodes = zeroed_nodes(refs.len());
    if let [node, rest @ ..] = &mut nodes[..] {
        let extent = Extent::of(&refs);
        let whole = Range { node, rest, base: 1, refs: &mut refs, first: 0, extent, depth: 0 };
        Splitter { input, method }.grow(whole, &mut Bins::new());
    }
    input.refs = refs;
    nodes
}

/// References to build a subtree from, and memory for its nodes.
struct Range<'a> {
    node: &'a mut BinaryNode,
    /// Memory for the descendants.
    rest: &'a mut [BinaryNode],
    /// The index of the first node of `rest`.
    base: usize,
    refs: &'a mut [PrimRef],
    /// The index of the first of `refs`.
    first: usize,
    extent: Extent,
    depth: u32,
}

impl<'a> Range<'a> {
    /// The two ranges below this one; the left one has `middle` references.
    fn halves(self, middle: usize, [left_extent, right_extent]: [Extent; 2]) -> [Range<'a>; 2] {
        let (left_refs, right_refs) = self.refs.split_at_mut(middle);
        let (children, rest) = self.rest.split_at_mut(2);
        let (left, right) = children.split_at_mut(1);
        let (left_rest, right_rest) = rest.split_at_mut(2 * middle - 2);
        let (base, first, depth) = (self.base, self.first, self.depth + 1);
        [
            Range {
                node: &mut left[0],
                rest: left_rest,
                base: base + 2,
                refs: left_refs,
                first,
                extent: left_extent,
                depth,
            },
            Range {
                node: &mut right[0],
                rest: right_rest,
                base: base + 2 * middle,
                refs: right_refs,
                first: first + middle,
                extent: right_extent,
                depth,
            },
        ]
    }
}

struct Splitter<'a> {
    input: &'a Input<'a>,
    method: Method,
}

impl Splitter<'_> {
    /// Build a subtree; `bins` is scratch space.
    fn grow(&self, range: Range, bins: &mut Bins) {
        let bounds = range.extent.bounds;
        range.node.min = bounds.min.truncate();
        range.node.max = bounds.max.truncate();
        if self.is_leaf(range.refs) {
            range.node.prim_count = range.refs.len() as u32;
            range.node.first_index = range.first as u32;
            range.rest.fill(hole());
            return;
        }
        range.node.prim_count = 0;
        range.node.first_index = range.base as u32;
        let parallel = range.refs.len() > TASK;
        let (extents, middle) = self.split(range.refs, &range.extent, range.depth, bins);
        let [left, right] = range.halves(middle, extents);
        if parallel {
            rayon::join(|| self.grow(left, bins), || self.grow(right, &mut Bins::new()));
        } else {
            self.grow(left, bins);
            self.grow(right, bins);
        }
    }

    /// Whether the references may be a leaf: they must be few, and all triangles or all solids.
    fn is_leaf(&self, refs: &[PrimRef]) -> bool {
        let solid = |r: &PrimRef| self.input.is_solid(r);
        refs.len() <= LEAF && refs.iter().all(|r| solid(r) == solid(&refs[0]))
    }

    /// Reorder `refs` into two parts; returns their extents and the start of the second.
    fn split(
        &self,
        refs: &mut [PrimRef],
        extent: &Extent,
        depth: u32,
        bins: &mut Bins,
    ) -> ([Extent; 2], usize) {
        // Bound the depth: halving needs log2(refs) more levels, so it starts early enough.
        let halve = self.method == Method::Halves || depth + refs.len().ilog2() + 1 >= MAX_DEPTH;
        if !halve {
            let grid = Grid::new(refs.len(), &extent.centers);
            bins.fill(refs, &grid);
            if let Some(plane) = bins.cheapest(grid.count) {
                return match plane.axis {
                    0 => partition::<0>(refs, &grid, plane.bin),
                    1 => partition::<1>(refs, &grid, plane.bin),
                    _ => partition::<2>(refs, &grid, plane.bin),
                };
            }
        }
        let (left, right) = refs.split_at(refs.len() / 2);
        ([Extent::of(left), Extent::of(right)], refs.len() / 2)
    }
}
