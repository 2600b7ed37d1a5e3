//! The binary tree: split top-down at the cheapest of a few planes an axis, by the surface-area heuristic \[Wald07\].

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::input::{Box4, Input, PrimRef};
use super::optimise::{BinaryNode, hole, zeroed_nodes};

/// References that a leaf may hold.
const LEAF: usize = 4;
/// Most bins an axis.
const BINS: usize = 16;
/// Deepest leaf; where a range could grow deeper it is halved instead.
const MAX_DEPTH: u32 = 60;
/// Ranges above this are split by two tasks.
const TASK: usize = 1 << 12;
/// References that are looked at to choose a plane: in large ranges every n-th.
const SAMPLE: usize = 1 << 13;

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
        refs.par_chunks(TASK)
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
        Splitter { input, method }.grow(whole, &mut Bins::new());
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
            rayon::join(|| self.grow(left, bins), || self.grow(right, &mut Bins::new()));
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

    /// The bin numbers of doubled centres, in the low bits of floats.
    #[inline(always)]
    fn place(center2: Vec4, origin: Vec4, scale: Vec4) -> Vec4 {
        // Half a bin down, so that rounding to the nearest cuts at whole bins.
        (center2 - origin) * scale - Vec4::splat(0.5) + Vec4::splat(TO_BITS)
    }

    /// The bin of a reference on each axis.
    #[inline(always)]
    fn bin(&self, r: &PrimRef) -> [usize; 3] {
        let x = Self::place(r.center2(), self.origin, self.scale);
        [x.x, x.y, x.z].map(|x| x.to_bits() as usize & (BINS - 1))
    }
}

/// The boxes and counts of all bins, the three axes of a bin side by side.
struct Bins {
    bounds: [[Box4; 3]; BINS],
    count: [[u32; 3]; BINS],
}

impl Bins {
    fn new() -> Self {
        Bins { bounds: [[Box4::EMPTY; 3]; BINS], count: [[0; 3]; BINS] }
    }

    /// Forget what was there and sort references into the bins, a sample if there are many.
    fn fill(&mut self, refs: &[PrimRef], grid: &Grid) {
        self.bounds[..grid.count].fill([Box4::EMPTY; 3]);
        self.count[..grid.count].fill([0; 3]);
        for r in refs.iter().step_by(1 + refs.len() / SAMPLE) {
            self.add(r, grid);
        }
    }

    #[inline(always)]
    fn add(&mut self, r: &PrimRef, grid: &Grid) {
        for (axis, bin) in grid.bin(r).into_iter().enumerate() {
            self.bounds[bin][axis].grow(r.min, r.max);
            self.count[bin][axis] += 1;
        }
    }

    /// The cheapest plane with references on both sides.
    fn cheapest(&self, count: usize) -> Option<Plane> {
        let mut right_cost = [[f32::INFINITY; 3]; BINS];
        let (mut b, mut n) = ([Box4::EMPTY; 3], [0; 3]);
        for i in (1..count).rev() {
            for (axis, cost) in right_cost[i].iter_mut().enumerate() {
                *cost = self.sweep(i, axis, &mut b, &mut n);
            }
        }
        let mut best = (f32::INFINITY, None);
        let (mut b, mut n) = ([Box4::EMPTY; 3], [0; 3]);
        for i in 0..count - 1 {
            for (axis, right_cost) in right_cost[i + 1].iter().enumerate() {
                let cost = self.sweep(i, axis, &mut b, &mut n) + right_cost;
                if cost < best.0 {
                    best = (cost, Some(Plane { axis, bin: i }));
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

/// Where to split: behind a bin of an axis.
#[derive(Clone, Copy)]
struct Plane {
    axis: usize,
    bin: usize,
}

/// Move what belongs left of the plane to the front, without a branch that depends on it; measure both sides on the way.
fn partition<const AXIS: usize>(
    refs: &mut [PrimRef],
    grid: &Grid,
    bin: usize,
) -> ([Extent; 2], usize) {
    let lanes = |v: Vec4| Vec4::splat(v[AXIS]);
    let (origin, scale) = (lanes(grid.origin), lanes(grid.scale));
    // In the form that `Grid::bin` leaves its numbers in.
    let last = Vec4::splat(TO_BITS + bin as f32);
    let [mut left, mut right] = [Extent::EMPTY; 2];
    let mut middle = 0;
    for i in 0..refs.len() {
        let r = refs[i];
        let c = r.center2();
        let is_left = Grid::place(lanes(c), origin, scale).cmple(last);
        let pick =
            |v: Vec4, out: Vec4| (Vec4::select(is_left, v, out), Vec4::select(is_left, out, v));
        let (low, high) = (pick(r.min, Vec4::INFINITY), pick(r.max, Vec4::NEG_INFINITY));
        left.bounds.grow(low.0, high.0);
        right.bounds.grow(low.1, high.1);
        let (low, high) = (pick(c, Vec4::INFINITY), pick(c, Vec4::NEG_INFINITY));
        left.centers.grow(low.0, high.0);
        right.centers.grow(low.1, high.1);
        refs[i] = refs[middle];
        refs[middle] = r;
        middle += (is_left.bitmask() & 1) as usize;
    }
    ([left, right], middle)
}
