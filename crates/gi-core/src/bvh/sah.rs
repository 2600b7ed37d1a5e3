//! The binary tree: split top-down at the cheapest of a few planes an axis, by the surface-area heuristic [Wald07].

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::input::{Box4, Input, PrimRef};
use super::optimise::{BinaryNode, hole, zeroed_nodes};

/// References that a leaf may hold.
const LEAF: usize = 2;
/// Most bins an axis.
const BINS: usize = 16;
/// Deepest leaf; where a range could grow deeper it is halved instead.
const MAX_DEPTH: u32 = 60;
/// Ranges above this are split by two tasks.
const TASK: usize = 1 << 12;
/// Ranges above this are binned by several tasks, of this many references each.
const BIN_CHUNK: usize = 1 << 15;

/// A range's box, and the box of its doubled centres.
#[derive(Clone, Copy)]
struct Extent {
    bounds: Box4,
    centers: Box4,
}

impl Extent {
    const EMPTY: Extent = Extent { bounds: Box4::EMPTY, centers: Box4::EMPTY };

    #[inline(always)]
    fn grow(&mut self, r: &PrimRef) {
        self.bounds.grow(r.min, r.max);
        let c = r.center2();
        self.centers.grow(c, c);
    }

    fn of(refs: &[PrimRef]) -> Self {
        refs.par_chunks(BIN_CHUNK)
            .map(|chunk| {
                let mut e = Extent::EMPTY;
                chunk.iter().for_each(|r| e.grow(r));
                e
            })
            .reduce(
                || Extent::EMPTY,
                |mut a, b| {
                    a.bounds.grow(b.bounds.min, b.bounds.max);
                    a.centers.grow(b.centers.min, b.centers.max);
                    a
                },
            )
    }
}

/// How the tree is split.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Method {
    /// At the cheapest plane.
    Cheapest,
    /// At the middle reference: a balanced tree whatever the input.
    Halves,
}

/// The binary tree over `input.refs`, which it reorders. Siblings stand side by side, unused places hold holes.
pub(super) fn build(input: &mut Input, method: Method) -> Vec<BinaryNode> {
    let mut refs = std::mem::take(&mut input.refs);
    let mut nodes = zeroed_nodes(refs.len());
    if let [node, rest @ ..] = &mut nodes[..] {
        let extent = Extent::of(&refs);
        let whole = Range { node, rest, base: 1, refs: &mut refs, first: 0, extent, depth: 0 };
        Splitter { input, method }.grow(whole, &mut Bins::EMPTY);
    }
    input.refs = refs;
    nodes
}

/// References to grow a subtree over, and room for it.
struct Range<'a> {
    node: &'a mut BinaryNode,
    /// Room for the descendants.
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
    /// The two ranges below this one, of which the left has `middle` references.
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
    /// Grow a subtree; `bins` is scratch space.
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
            rayon::join(|| self.grow(left, bins), || self.grow(right, &mut Bins::EMPTY));
        } else {
            self.grow(left, bins);
            self.grow(right, bins);
        }
    }

    /// A leaf holds few references, all to triangles or all to solids.
    fn is_leaf(&self, refs: &[PrimRef]) -> bool {
        let solid = |r: &PrimRef| self.input.is_solid(r);
        refs.len() <= LEAF && refs.iter().all(|r| solid(r) == solid(&refs[0]))
    }

    /// Reorder `refs` into two parts; return their extents and where the second begins.
    fn split(
        &self,
        refs: &mut [PrimRef],
        extent: &Extent,
        depth: u32,
        bins: &mut Bins,
    ) -> ([Extent; 2], usize) {
        // Keep the depth in bounds: from here on, halving needs the logarithm of what is left.
        let halve = self.method == Method::Halves || depth + refs.len().ilog2() + 1 >= MAX_DEPTH;
        if !halve {
            let grid = Grid::new(refs.len(), &extent.centers);
            bins.fill(refs, &grid);
            if let Some((axis, bin)) = bins.cheapest(grid.count) {
                return partition(refs, |r| grid.bin(r)[axis] <= bin);
            }
        }
        let (left, right) = refs.split_at(refs.len() / 2);
        ([Extent::of(left), Extent::of(right)], refs.len() / 2)
    }
}

/// The bins' lattice over the centres.
struct Grid {
    origin: Vec4,
    scale: Vec4,
    count: usize,
}

/// 1.5 * 2^23: adding it to a small float leaves the rounded number in the low bits, a fast conversion.
const TO_BITS: f32 = 12_582_912.0;

impl Grid {
    fn new(refs: usize, centers: &Box4) -> Self {
        // Few references deserve few bins.
        let count = BINS.min(4 + refs / 20 + 2);
        let extent = (centers.max - centers.min).truncate();
        let scale = extent
            .to_array()
            .map(|e| if e > f32::MIN_POSITIVE { count as f32 * 0.9999 / e } else { 0.0 });
        let finite = Vec3::from_array(scale.map(|s| if s.is_finite() { s } else { 0.0 }));
        Grid { origin: centers.min.with_w(0.0), scale: finite.extend(0.0), count }
    }

    /// The bin of a reference on each axis.
    #[inline(always)]
    fn bin(&self, r: &PrimRef) -> [usize; 3] {
        // Half a bin down, so that rounding to the nearest cuts at whole bins.
        let x = (r.center2() - self.origin) * self.scale - Vec4::splat(0.5) + Vec4::splat(TO_BITS);
        [x.x, x.y, x.z].map(|x| x.to_bits() as usize & (BINS - 1))
    }
}

/// The boxes and counts of all bins, the three axes of a bin side by side.
struct Bins {
    bounds: [[Box4; 3]; BINS],
    count: [[u32; 3]; BINS],
}

impl Bins {
    const EMPTY: Bins = Bins { bounds: [[Box4::EMPTY; 3]; BINS], count: [[0; 3]; BINS] };

    /// Forget what was there and sort references into the bins.
    fn fill(&mut self, refs: &[PrimRef], grid: &Grid) {
        if refs.len() > BIN_CHUNK {
            let parts = refs.par_chunks(BIN_CHUNK).map(|chunk| {
                let mut part = Bins::EMPTY;
                part.add(chunk, grid);
                part
            });
            *self = parts.reduce(|| Bins::EMPTY, Bins::merged);
            return;
        }
        self.bounds[..grid.count].fill([Box4::EMPTY; 3]);
        self.count[..grid.count].fill([0; 3]);
        self.add(refs, grid);
    }

    fn add(&mut self, refs: &[PrimRef], grid: &Grid) {
        for r in refs {
            for (axis, bin) in grid.bin(r).into_iter().enumerate() {
                self.bounds[bin][axis].grow(r.min, r.max);
                self.count[bin][axis] += 1;
            }
        }
    }

    fn merged(mut self, other: Bins) -> Self {
        for bin in 0..BINS {
            for axis in 0..3 {
                let b = &other.bounds[bin][axis];
                self.bounds[bin][axis].grow(b.min, b.max);
                self.count[bin][axis] += other.count[bin][axis];
            }
        }
        self
    }

    /// The axis and the last left bin of the cheapest plane with references on both sides.
    fn cheapest(&self, count: usize) -> Option<(usize, usize)> {
        let mut right_cost = [[f32::INFINITY; 3]; BINS];
        let (mut b, mut n) = ([Box4::EMPTY; 3], [0; 3]);
        for i in (1..count).rev() {
            for axis in 0..3 {
                right_cost[i][axis] = self.sweep(i, axis, &mut b, &mut n);
            }
        }
        let mut best = (f32::INFINITY, None);
        let (mut b, mut n) = ([Box4::EMPTY; 3], [0; 3]);
        for i in 0..count - 1 {
            for axis in 0..3 {
                let cost = self.sweep(i, axis, &mut b, &mut n) + right_cost[i + 1][axis];
                if cost < best.0 {
                    best = (cost, Some((axis, i)));
                }
            }
        }
        best.1
    }

    /// Add a bin to the boxes and counts of one side; what this side then costs, infinite while it is empty.
    #[inline(always)]
    fn sweep(&self, bin: usize, axis: usize, bounds: &mut [Box4; 3], count: &mut [u32; 3]) -> f32 {
        let b = &self.bounds[bin][axis];
        bounds[axis].grow(b.min, b.max);
        count[axis] += self.count[bin][axis];
        if count[axis] == 0 { f32::INFINITY } else { bounds[axis].half_area() * count[axis] as f32 }
    }
}

/// Move what belongs left to the front, without a branch that depends on it; measure both sides on the way.
fn partition(refs: &mut [PrimRef], is_left: impl Fn(&PrimRef) -> bool) -> ([Extent; 2], usize) {
    let mut sides = [Extent::EMPTY; 2];
    let mut middle = 0;
    for i in 0..refs.len() {
        let r = refs[i];
        let left = is_left(&r);
        sides[usize::from(!left)].grow(&r);
        refs[i] = refs[middle];
        refs[middle] = r;
        middle += usize::from(left);
    }
    (sides, middle)
}
