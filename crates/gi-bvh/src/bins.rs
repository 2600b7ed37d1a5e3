//! Chooses where to split a range of references, and splits it.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::input::{Box4, PrimRef};

/// Largest number of bins per axis.
const BINS: usize = 16;
/// Number of references that are examined to choose a plane; in larger ranges, every n-th one is.
const SAMPLE: usize = 1 << 13;
/// Smallest number of references per task.
const CHUNK: usize = 1 << 12;

/// A range's box, and the box of its doubled centres.
#[derive(Clone, Copy)]
pub(super) struct Extent {
    pub bounds: Box4,
    pub centers: Box4,
}

impl Extent {
    pub(super) const EMPTY: Extent = Extent { bounds: Box4::EMPTY, centers: Box4::EMPTY };

    #[inline(always)]
    fn grow(&mut self, r: &PrimRef) {
        self.bounds.grow(r.min, r.max);
        let c = r.center2();
        self.centers.grow(c, c);
    }

    pub(super) fn of(refs: &[PrimRef]) -> Self {
        refs.par_chunks(CHUNK)
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

/// The grid of bins over the centres.
pub(super) struct Grid {
    origin: Vec4,
    scale: Vec4,
    pub count: usize,
}

/// 1.5 * 2^23: adding it to a small float leaves the rounded number in the low bits, which is a fast conversion.
const TO_BITS: f32 = 12_582_912.0;

impl Grid {
    pub(super) fn new(refs: usize, centers: &Box4) -> Self {
        // Use fewer bins for few references.
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
        // Shift by half a bin, so that rounding to nearest cuts at whole bins.
        (center2 - origin) * scale - Vec4::splat(0.5) + Vec4::splat(TO_BITS)
    }

    /// The bin of a reference on each axis.
    #[inline(always)]
    fn bin(&self, r: &PrimRef) -> [usize; 3] {
        let x = Self::place(r.center2(), self.origin, self.scale);
        [x.x, x.y, x.z].map(|x| x.to_bits() as usize & (BINS - 1))
    }
}

/// The boxes and counts of all bins; the three axes of a bin are adjacent.
pub(super) struct Bins {
    bounds: [[Box4; 3]; BINS],
    count: [[u32; 3]; BINS],
}

impl Bins {
    pub(super) fn new() -> Self {
        Bins { bounds: [[Box4::EMPTY; 3]; BINS], count: [[0; 3]; BINS] }
    }

    /// Clear the bins and sort references into them, only a sample if there are many.
    pub(super) fn fill(&mut self, refs: &[PrimRef], grid: &Grid) {
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
    pub(super) fn cheapest(&self, count: usize) -> Option<Plane> {
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

    /// Add a bin to the boxes and counts of one side, and return this side's cost: infinite while it is empty.
    #[inline(always)]
    fn sweep(&self, bin: usize, axis: usize, bounds: &mut [Box4; 3], count: &mut [u32; 3]) -> f32 {
        let b = &self.bounds[bin][axis];
        bounds[axis].grow(b.min, b.max);
        count[axis] += self.count[bin][axis];
        if count[axis] == 0 { f32::INFINITY } else { bounds[axis].half_area() * count[axis] as f32 }
    }
}

/// A plane to split at: the upper boundary of a bin on an axis.
#[derive(Clone, Copy)]
pub(super) struct Plane {
    pub axis: usize,
    pub bin: usize,
}

/// Move the references left of the plane to the front, without a data-dependent branch, and measure both sides.
pub(super) fn partition<const AXIS: usize>(
    refs: &mut [PrimRef],
    grid: &Grid,
    bin: usize,
) -> ([Extent; 2], usize) {
    let lanes = |v: Vec4| Vec4::splat(v[AXIS]);
    let (origin, scale) = (lanes(grid.origin), lanes(grid.scale));
    // The same representation as the bin numbers in `Grid::bin`.
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
