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
    if let [root, rest @ ..] = &mut nodes[..] {
        let extent = Extent::of(&refs);
        Splitter { input, method }.grow(root, rest, 1, &mut refs, 0, extent, 0);
    }
    input.refs = refs;
    nodes
}

struct Splitter<'a> {
    input: &'a Input<'a>,
    method: Method,
}

impl Splitter<'_> {
    /// Grow `node` over `refs`, whose first stands at `first`; `rest` is room for the descendants, from index `base` on.
    #[allow(clippy::too_many_arguments)]
    fn grow(
        &self,
        node: &mut BinaryNode,
        rest: &mut [BinaryNode],
        base: usize,
        refs: &mut [PrimRef],
        first: usize,
        extent: Extent,
        depth: u32,
    ) {
        let bounds = extent.bounds;
        node.min = bounds.min.truncate();
        node.max = bounds.max.truncate();
        if self.is_leaf(refs) {
            node.prim_count = refs.len() as u32;
            node.first_index = first as u32;
            rest.fill(hole());
            return;
        }
        node.prim_count = 0;
        node.first_index = base as u32;
        let ([left_extent, right_extent], middle) = self.split(refs, &extent, depth);
        let (left_refs, right_refs) = refs.split_at_mut(middle);
        let (children, rest) = rest.split_at_mut(2);
        let [left, right] = children else { unreachable!("two children") };
        let (left_rest, right_rest) = rest.split_at_mut(2 * middle - 2);
        let right_base = base + 2 * middle;
        let (right_first, parallel) = (first + middle, left_refs.len() + right_refs.len() > TASK);
        let mut grow_left =
            || self.grow(left, left_rest, base + 2, left_refs, first, left_extent, depth + 1);
        let mut grow_right = || {
            self.grow(
                right,
                right_rest,
                right_base,
                right_refs,
                right_first,
                right_extent,
                depth + 1,
            )
        };
        if parallel {
            rayon::join(grow_left, grow_right);
        } else {
            grow_left();
            grow_right();
        }
    }

    /// A leaf holds few references, all to triangles or all to solids.
    fn is_leaf(&self, refs: &[PrimRef]) -> bool {
        let solid = |r: &PrimRef| self.input.is_solid(r);
        refs.len() <= LEAF && refs.iter().all(|r| solid(r) == solid(&refs[0]))
    }

    /// Reorder `refs` into two parts; return their extents and where the second begins.
    fn split(&self, refs: &mut [PrimRef], extent: &Extent, depth: u32) -> ([Extent; 2], usize) {
        // Keep the depth in bounds: from here on, halving needs the logarithm of what is left.
        let halve = self.method == Method::Halves || depth + refs.len().ilog2() + 1 >= MAX_DEPTH;
        if !halve {
            let grid = Grid::new(refs.len(), &extent.centers);
            if let Some((axis, bin)) = cheapest(&bin_all(refs, &grid), grid.count) {
                let (parts, middle) = partition(refs, |r| grid.bin(r)[axis] <= bin);
                debug_assert!(middle > 0 && middle < refs.len());
                return (parts, middle);
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

/// The boxes and counts of all bins.
#[derive(Clone)]
struct Bins {
    bounds: [[Box4; BINS]; 3],
    count: [[u32; BINS]; 3],
}

impl Bins {
    const EMPTY: Bins = Bins { bounds: [[Box4::EMPTY; BINS]; 3], count: [[0; BINS]; 3] };

    fn add(&mut self, refs: &[PrimRef], grid: &Grid) {
        for r in refs {
            for (axis, bin) in grid.bin(r).into_iter().enumerate() {
                self.bounds[axis][bin].grow(r.min, r.max);
                self.count[axis][bin] += 1;
            }
        }
    }

    fn merged(mut self, other: &Bins) -> Self {
        for axis in 0..3 {
            for bin in 0..BINS {
                let b = &other.bounds[axis][bin];
                self.bounds[axis][bin].grow(b.min, b.max);
                self.count[axis][bin] += other.count[axis][bin];
            }
        }
        self
    }
}

fn bin_all(refs: &[PrimRef], grid: &Grid) -> Bins {
    let bin = |chunk: &[PrimRef]| {
        let mut bins = Bins::EMPTY;
        bins.add(chunk, grid);
        bins
    };
    if refs.len() <= BIN_CHUNK {
        return bin(refs);
    }
    refs.par_chunks(BIN_CHUNK).map(bin).reduce(|| Bins::EMPTY, |a, b| a.merged(&b))
}

/// The axis and the last left bin of the cheapest plane with references on both sides.
fn cheapest(bins: &Bins, count: usize) -> Option<(usize, usize)> {
    let mut best = (f32::INFINITY, None);
    for axis in 0..3 {
        let (bounds, counts) = (&bins.bounds[axis], &bins.count[axis]);
        let mut right_cost = [f32::INFINITY; BINS];
        let (mut b, mut n) = (Box4::EMPTY, 0);
        for i in (1..count).rev() {
            b.grow(bounds[i].min, bounds[i].max);
            n += counts[i];
            if n > 0 {
                right_cost[i] = b.half_area() * n as f32;
            }
        }
        let (mut b, mut n) = (Box4::EMPTY, 0);
        for i in 0..count - 1 {
            b.grow(bounds[i].min, bounds[i].max);
            n += counts[i];
            if n > 0 {
                let cost = b.half_area() * n as f32 + right_cost[i + 1];
                if cost < best.0 {
                    best = (cost, Some((axis, i)));
                }
            }
        }
    }
    best.1
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
