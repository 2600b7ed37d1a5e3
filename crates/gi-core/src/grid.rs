//! Points in a grid, for searches within a radius: the photons of a pass of progressive photon mapping, and the light vertices that
//! bidirectional paths merge with.
//!
//! Points are sorted into cubic cells. If their bounding box has few cells compared to the number of points, the
//! cells form an array. Otherwise rows of cells along x are hashed, and several cells may share a bucket. In both layouts
//! the cells of a row are adjacent in memory, because a query waits for memory most of its time. The build runs in
//! parallel. The order is the same for any number of threads: by cell, and within a cell as given.

mod build;
mod radius;

use std::ops::Range;

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use crate::math::{Bounds, floor_ivec3};
pub use radius::probabilistic_radius;

/// A point and what is stored there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item<T> {
    /// Position, world.
    pub p: Vec3,
    /// What is stored.
    pub value: T,
}

/// Points sorted into cells.
pub struct Grid<T> {
    /// Smallest corner of the bounding box of the points, and number of cells per world unit.
    origin: Vec3,
    inverse_cell: f32,
    /// Last cell along each axis.
    last: IVec3,
    layout: Layout,
    /// First point of each bucket; one entry more than buckets.
    start: Vec<u32>,
    /// Positions, one column per axis, so that several distances are computed at once.
    columns: [Vec<f32>; 3],
    values: Vec<T>,
}

/// How cells map to buckets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layout {
    /// Every cell has its own bucket: x + width (y + height z).
    Dense { width: usize, height: usize, depth: usize },
    /// 2^bits buckets: x plus a hash of y and z, modulo the number of buckets.
    Hashed { bits: u32 },
}

/// The array is used up to this many cells per point.
const CELLS_A_POINT: usize = 4;
/// Maximum number of cells along an axis. Floats still distinguish neighbouring cells, and coordinates cannot overflow.
const MOST_CELLS: f32 = (1 << 20) as f32;

impl Layout {
    fn buckets(self) -> usize {
        match self {
            Layout::Dense { width, height, depth } => width * height * depth,
            Layout::Hashed { bits } => 1 << bits,
        }
    }

    #[inline]
    fn bucket(self, c: IVec3) -> usize {
        match self {
            Layout::Dense { width, height, .. } => {
                (c.z as usize * height + c.y as usize) * width + c.x as usize
            }
            Layout::Hashed { bits } => {
                let [x, y, z] = c.to_array().map(|v| v as u32);
                let mixed = y.wrapping_mul(0x85eb_ca77) ^ z.wrapping_mul(0xc2b2_ae3d);
                let hash = (u64::from(mixed.wrapping_mul(0x27d4_eb2f)) >> (32 - bits)) as usize;
                (x as usize + hash) & ((1 << bits) - 1)
            }
        }
    }

    /// The buckets of `count` cells in a row along x, of which `c` is the first. The second range is empty unless the row
    /// wraps around.
    #[inline]
    fn row(self, c: IVec3, count: usize) -> [Range<usize>; 2] {
        let (first, buckets) = (self.bucket(c), self.buckets());
        match first + count {
            _ if count >= buckets => [0..buckets, 0..0],
            end if end > buckets => [first..buckets, 0..end - buckets],
            end => [first..end, 0..0],
        }
    }
}

impl<T: Copy + Default + Send + Sync> Grid<T> {
    /// Sort points into cells of about `cell` (world units). `chunks` are joined in order.
    pub fn build(chunks: &[Vec<Item<T>>], cell: f32) -> Self {
        let n = chunks.iter().map(Vec::len).sum::<usize>();
        let bounds = bounds(chunks);
        let (cell, last) = cells(bounds, cell);
        let [width, height, depth] = last.to_array().map(|c| c as usize + 1);
        let layout = match width.checked_mul(height).and_then(|area| area.checked_mul(depth)) {
            Some(cells) if cells <= CELLS_A_POINT * n.max(1) => {
                Layout::Dense { width, height, depth }
            }
            _ => Layout::Hashed { bits: n.max(2).next_power_of_two().ilog2().min(28) },
        };
        Self::with_layout(chunks, bounds.min, cell, last, layout)
    }

    fn with_layout(
        chunks: &[Vec<Item<T>>],
        origin: Vec3,
        cell: f32,
        last: IVec3,
        layout: Layout,
    ) -> Self {
        let n = chunks.iter().map(Vec::len).sum::<usize>();
        assert!(
            u32::try_from(n).is_ok(),
            "{n} points exceed the range of the grid's 32-bit indices"
        );
        let empty = || vec![0.0; n];
        let mut grid = Grid {
            origin,
            inverse_cell: 1.0 / cell,
            last,
            layout,
            start: vec![0; layout.buckets() + 1],
            columns: [empty(), empty(), empty()],
            values: vec![T::default(); n],
        };
        grid.sort(chunks);
        grid
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Memory of the points and buckets.
    pub fn memory_bytes(&self) -> usize {
        let columns: usize = self.columns.iter().map(|c| size_of_val(&c[..])).sum();
        columns + size_of_val(&self.values[..]) + size_of_val(&self.start[..])
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Call `visit` once for every point nearer to `p` than `radius`, with its position and squared distance.
    #[inline]
    pub fn within(&self, p: Vec3, radius: f32, mut visit: impl FnMut(Vec3, &T, f32)) {
        let (low, high) = (self.cell_at(p - radius), self.cell_at(p + radius));
        let outside = high.cmplt(IVec3::ZERO).any() || low.cmpgt(self.last).any();
        if self.is_empty() || outside {
            return;
        }
        let (low, high) = (low.max(IVec3::ZERO), high.min(self.last));
        let extent = (high - low + 1).as_u64vec3();
        let hashed = matches!(self.layout, Layout::Hashed { .. });
        if hashed && extent.x * extent.y * extent.z >= self.len() as u64 {
            // The query covers more cells than there are points.
            return self.scan(0..self.len(), p, radius, visit);
        }
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                // Other rows share the buckets, and this query may visit those too. So in each visit, only the points of
                // the visited row count.
                let mut own = |at, value: &T, d| {
                    let cell = self.cell_of(at);
                    if !hashed || (cell.y, cell.z) == (y, z) {
                        visit(at, value, d);
                    }
                };
                for buckets in self.layout.row(IVec3::new(low.x, y, z), extent.x as usize) {
                    self.scan(self.points(buckets), p, radius, &mut own);
                }
            }
        }
    }

    /// The points of a range of buckets.
    #[inline]
    fn points(&self, buckets: Range<usize>) -> Range<usize> {
        self.start[buckets.start] as usize..self.start[buckets.end] as usize
    }

    /// Visit the points of a range that are near. Distances are computed per block first.
    #[inline]
    fn scan(
        &self,
        range: Range<usize>,
        p: Vec3,
        radius: f32,
        mut visit: impl FnMut(Vec3, &T, f32),
    ) {
        const BLOCK: usize = 32;
        let radius_sq = radius * radius;
        let [x, y, z] = &self.columns;
        let (x, y, z) = (&x[range.clone()], &y[range.clone()], &z[range.clone()]);
        let values = &self.values[range];
        for first in (0..values.len()).step_by(BLOCK) {
            let end = (first + BLOCK).min(values.len());
            let (x, y, z) = (&x[first..end], &y[first..end], &z[first..end]);
            let mut distances = [0f32; BLOCK];
            for (((d, x), y), z) in distances.iter_mut().zip(x).zip(y).zip(z) {
                let (dx, dy, dz) = (x - p.x, y - p.y, z - p.z);
                *d = dx * dx + dy * dy + dz * dz;
            }
            let (mut near, mut count) = ([0u8; BLOCK], 0);
            for (i, d) in distances[..end - first].iter().enumerate() {
                near[count % BLOCK] = i as u8;
                count += usize::from(*d < radius_sq);
            }
            for &i in &near[..count.min(BLOCK)] {
                let i = usize::from(i);
                visit(Vec3::new(x[i], y[i], z[i]), &values[first + i], distances[i]);
            }
        }
    }

    /// The cell that contains a point; its coordinates are outside the grid if the point is outside the box.
    #[inline]
    fn cell_at(&self, p: Vec3) -> IVec3 {
        floor_ivec3((p - self.origin) * self.inverse_cell)
    }

    /// The cell of a point.
    #[inline]
    fn cell_of(&self, p: Vec3) -> IVec3 {
        self.cell_at(p).clamp(IVec3::ZERO, self.last)
    }
}

/// Bounding box of all points; one point if there are none.
fn bounds<T: Sync>(chunks: &[Vec<Item<T>>]) -> Bounds {
    let of = |chunk: &Vec<Item<T>>| Bounds::of(chunk.iter().map(|p| p.p));
    let bounds = chunks.par_iter().map(of).reduce(|| Bounds::EMPTY, Bounds::union);
    if bounds.is_empty() { Bounds::of([Vec3::ZERO]) } else { bounds }
}

/// The side of a cell, large enough for floats to distinguish cells, and the last cell along each axis.
fn cells(bounds: Bounds, cell: f32) -> (f32, IVec3) {
    let extent = bounds.extent();
    let cell = cell.max(extent.max_element() / MOST_CELLS).max(f32::MIN_POSITIVE);
    (cell, floor_ivec3(extent / cell))
}

#[cfg(test)]
mod tests;
