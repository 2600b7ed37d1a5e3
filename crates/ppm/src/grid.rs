//! The photons of one pass in a grid.
//!
//! Photons are sorted into cubic cells. If their bounding box has few cells compared to the number of photons, the
//! cells form an array, and the cells of a row along x are adjacent. Otherwise cells are hashed, and several may share
//! a bucket. The build runs in parallel. The order is the same for any number of threads: by cell, and within a cell by
//! path.

mod build;

use std::ops::Range;

use gi_core::math::Bounds;
use glam::{IVec3, Vec3};
use rayon::prelude::*;

use crate::photons::{Arrival, Photon};

/// Photons sorted into cells.
pub struct Grid {
    /// Smallest corner of the bounding box of the photons, and number of cells per world unit.
    origin: Vec3,
    inverse_cell: f32,
    /// Last cell along each axis.
    last: IVec3,
    layout: Layout,
    /// First photon of each bucket; one entry more than buckets.
    start: Vec<u32>,
    /// Positions, one column per axis, so that several distances are computed at once.
    columns: [Vec<f32>; 3],
    arrivals: Vec<Arrival>,
}

/// How cells map to buckets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layout {
    /// Every cell has its own bucket: x + width (y + height z).
    Dense { width: usize, height: usize, depth: usize },
    /// 2^bits buckets.
    Hashed { bits: u32 },
}

/// The array is used up to this many cells per photon.
const CELLS_A_PHOTON: usize = 4;
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
                let mixed = x.wrapping_mul(0x9e37_79b1)
                    ^ y.wrapping_mul(0x85eb_ca77)
                    ^ z.wrapping_mul(0xc2b2_ae3d);
                (u64::from(mixed.wrapping_mul(0x27d4_eb2f)) >> (32 - bits)) as usize
            }
        }
    }
}

impl Grid {
    /// Sort photons into cells of about `cell` (world units). `chunks` are joined in order.
    pub fn build(chunks: &[Vec<Photon>], cell: f32) -> Self {
        let n = chunks.iter().map(Vec::len).sum::<usize>();
        let bounds = bounds(chunks);
        let (cell, last) = cells(bounds, cell);
        let [width, height, depth] = last.to_array().map(|c| c as usize + 1);
        let layout = match width.checked_mul(height).and_then(|area| area.checked_mul(depth)) {
            Some(cells) if cells <= CELLS_A_PHOTON * n.max(1) => {
                Layout::Dense { width, height, depth }
            }
            _ => Layout::Hashed { bits: n.max(2).next_power_of_two().ilog2().min(28) },
        };
        Self::with_layout(chunks, bounds.min, cell, last, layout)
    }

    fn with_layout(
        chunks: &[Vec<Photon>],
        origin: Vec3,
        cell: f32,
        last: IVec3,
        layout: Layout,
    ) -> Self {
        let n = chunks.iter().map(Vec::len).sum::<usize>();
        assert!(
            u32::try_from(n).is_ok(),
            "a pass of {n} photons exceeds the range of the grid's 32-bit indices"
        );
        let empty = || vec![0.0; n];
        let mut grid = Grid {
            origin,
            inverse_cell: 1.0 / cell,
            last,
            layout,
            start: vec![0; layout.buckets() + 1],
            columns: [empty(), empty(), empty()],
            arrivals: vec![Arrival::default(); n],
        };
        grid.sort(chunks);
        grid
    }

    /// Number of photons.
    pub fn len(&self) -> usize {
        self.arrivals.len()
    }

    /// Whether there are no photons.
    pub fn is_empty(&self) -> bool {
        self.arrivals.is_empty()
    }

    /// Call `visit` once for every photon nearer to `p` than `radius`, with its position and squared distance.
    #[inline]
    pub fn within(&self, p: Vec3, radius: f32, mut visit: impl FnMut(Vec3, &Arrival, f32)) {
        let (low, high) = (self.cell_at(p - radius), self.cell_at(p + radius));
        let outside = high.cmplt(IVec3::ZERO).any() || low.cmpgt(self.last).any();
        if self.is_empty() || outside {
            return;
        }
        let (low, high) = (low.max(IVec3::ZERO), high.min(self.last));
        let extent = (high - low + 1).as_u64vec3();
        match self.layout {
            Layout::Dense { .. } => {
                for z in low.z..=high.z {
                    for y in low.y..=high.y {
                        // Neighbours along x are adjacent.
                        let first = self.layout.bucket(IVec3::new(low.x, y, z));
                        let buckets = first..first + extent.x as usize;
                        self.scan(self.photons(buckets), p, radius, |at, a, d| visit(at, a, d));
                    }
                }
            }
            // The query covers more cells than there are photons: scan all photons.
            Layout::Hashed { .. } if extent.x * extent.y * extent.z >= self.len() as u64 => {
                self.scan(0..self.len(), p, radius, visit);
            }
            Layout::Hashed { .. } => {
                for z in low.z..=high.z {
                    for y in low.y..=high.y {
                        for x in low.x..=high.x {
                            let cell = IVec3::new(x, y, z);
                            let bucket = self.layout.bucket(cell);
                            // Other cells share the bucket, and this query may visit those too. So in each visit, only
                            // the photons of the visited cell count.
                            let own = |at, a: &Arrival, d| {
                                if self.cell_of(at) == cell {
                                    visit(at, a, d);
                                }
                            };
                            self.scan(self.photons(bucket..bucket + 1), p, radius, own);
                        }
                    }
                }
            }
        }
    }

    /// The photons of a range of buckets.
    #[inline]
    fn photons(&self, buckets: Range<usize>) -> Range<usize> {
        self.start[buckets.start] as usize..self.start[buckets.end] as usize
    }

    /// Visit the photons of a range that are near. Distances are computed per block first.
    #[inline]
    fn scan(
        &self,
        range: Range<usize>,
        p: Vec3,
        radius: f32,
        mut visit: impl FnMut(Vec3, &Arrival, f32),
    ) {
        const BLOCK: usize = 32;
        let radius_sq = radius * radius;
        let [x, y, z] = [0, 1, 2].map(|axis| &self.columns[axis][range.clone()]);
        let arrivals = &self.arrivals[range];
        for first in (0..arrivals.len()).step_by(BLOCK) {
            let end = (first + BLOCK).min(arrivals.len());
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
                visit(Vec3::new(x[i], y[i], z[i]), &arrivals[first + i], distances[i]);
            }
        }
    }

    /// The cell that contains a point; its coordinates are outside the grid if the point is outside the box.
    #[inline]
    fn cell_at(&self, p: Vec3) -> IVec3 {
        ((p - self.origin) * self.inverse_cell).floor().as_ivec3()
    }

    /// The cell of a photon.
    #[inline]
    fn cell_of(&self, p: Vec3) -> IVec3 {
        self.cell_at(p).clamp(IVec3::ZERO, self.last)
    }
}

/// Bounding box of all photons; a point if there are none.
fn bounds(chunks: &[Vec<Photon>]) -> Bounds {
    let of = |chunk: &Vec<Photon>| Bounds::of(chunk.iter().map(|p| p.p));
    let bounds = chunks.par_iter().map(of).reduce(|| Bounds::EMPTY, Bounds::union);
    if bounds.is_empty() { Bounds::of([Vec3::ZERO]) } else { bounds }
}

/// The side of a cell, large enough for floats to distinguish cells, and the last cell along each axis.
fn cells(bounds: Bounds, cell: f32) -> (f32, IVec3) {
    let extent = bounds.extent();
    let cell = cell.max(extent.max_element() / MOST_CELLS).max(f32::MIN_POSITIVE);
    (cell, (extent / cell).floor().as_ivec3())
}

#[cfg(test)]
mod tests {
    use super::*;
    use gi_core::math::Rgb;
    use gi_core::rng::Pcg;

    /// Photons on the walls of the unit cube and in a cluster, in chunks of different sizes; the power is the photon's
    /// index.
    fn photons(n: usize) -> Vec<Vec<Photon>> {
        let mut rng = Pcg::new(5, 1);
        let mut chunks = vec![Vec::new()];
        for i in 0..n {
            let mut p = Vec3::from_array([rng.next_f32(), rng.next_f32(), rng.next_f32()]);
            if i % 3 == 0 {
                p = p * 0.02 + Vec3::new(0.4, 0.0, 0.7);
            } else {
                p[i % 3] = (i % 2) as f32;
            }
            let arrival = Arrival { power: Rgb::grey(i as f32), ..Arrival::default() };
            if rng.next_below(700) == 0 {
                chunks.push(Vec::new());
            }
            chunks.last_mut().expect("a chunk").push(Photon { p, arrival });
        }
        chunks
    }

    fn found(grid: &Grid, p: Vec3, radius: f32) -> Vec<u32> {
        let mut found = Vec::new();
        grid.within(p, radius, |_, a, _| found.push(a.power.r as u32));
        found.sort_unstable();
        found
    }

    fn brute_force(chunks: &[Vec<Photon>], p: Vec3, radius: f32) -> Vec<u32> {
        let near = |q: &&Photon| {
            let d = q.p - p;
            d.x * d.x + d.y * d.y + d.z * d.z < radius * radius
        };
        chunks.iter().flatten().filter(near).map(|q| q.arrival.power.r as u32).collect()
    }

    /// Test queries in and around the box of the photons, with radii from far below to far above the cell size.
    fn assert_finds_each_once(name: &str, grid: &Grid, chunks: &[Vec<Photon>]) {
        let mut rng = Pcg::new(9, 2);
        let mut total = 0;
        for case in 0..400 {
            let mut p = Vec3::from_array([rng.next_f32(), rng.next_f32(), rng.next_f32()]);
            match case % 4 {
                0 => p = p * 0.02 + Vec3::new(0.4, 0.0, 0.7),
                1 => p[case % 3] = 1.0,
                // Outside the box, but within reach of photons.
                2 => p[case % 3] = 1.02,
                _ => {}
            }
            let radius = 0.003 * 300f32.powf(rng.next_f32());
            let (got, expected) = (found(grid, p, radius), brute_force(chunks, p, radius));
            assert_eq!(got, expected, "{name}, case {case}: {p}, radius {radius}");
            total += got.len();
        }
        assert!(total > 10_000, "{name}: only {total} photons were found");
    }

    #[test]
    fn a_query_finds_the_same_photons_as_a_linear_scan() {
        let chunks = photons(6000);
        for cell in [0.5, 0.08, 0.01, 0.001] {
            let grid = Grid::build(&chunks, cell);
            assert_eq!(grid.len(), 6000);
            let dense = matches!(grid.layout, Layout::Dense { .. });
            assert_eq!(dense, cell > 0.05, "cells of {cell}");
            assert_finds_each_once(&format!("cells of {cell}"), &grid, &chunks);
        }
    }

    #[test]
    fn cells_that_share_a_bucket_do_not_count_a_photon_twice() {
        let chunks = photons(6000);
        for bits in [0, 1, 4, 8] {
            let (cell, last) = cells(bounds(&chunks), 0.05);
            let layout = Layout::Hashed { bits };
            let grid = Grid::with_layout(&chunks, bounds(&chunks).min, cell, last, layout);
            assert_finds_each_once(&format!("{} buckets", 1 << bits), &grid, &chunks);
        }
        // With 16 buckets, some of the 27 cells of a query share a bucket: without the check, photons would count
        // twice.
        let layout = Layout::Hashed { bits: 4 };
        let mut buckets: Vec<usize> = (0..27)
            .map(|k| layout.bucket(IVec3::new(4 + k % 3, 4 + k / 3 % 3, 4 + k / 9)))
            .collect();
        buckets.sort_unstable();
        buckets.dedup();
        assert!(buckets.len() < 27);
    }

    #[test]
    fn the_order_is_by_path_within_a_cell_for_any_number_of_threads_and_any_chunks() {
        let chunks = photons(5000);
        let one: Vec<Photon> = chunks.iter().flatten().copied().collect();
        for cell in [0.08, 0.01] {
            let expected = Grid::build(std::slice::from_ref(&one), cell);
            for threads in [1, 2, 4] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                let grid = pool.expect("threads").install(|| Grid::build(&chunks, cell));
                assert!(grid.start == expected.start && grid.columns == expected.columns);
                assert!(grid.arrivals == expected.arrivals, "{threads} threads");
            }
            for bucket in expected.start.windows(2) {
                let order: Vec<f32> = expected.arrivals[bucket[0] as usize..bucket[1] as usize]
                    .iter()
                    .map(|a| a.power.r)
                    .collect();
                assert!(order.is_sorted(), "{order:?}");
            }
        }
    }

    #[test]
    fn no_photons_one_photon_and_photons_in_one_place() {
        let at = |p| Photon { p, arrival: Arrival::default() };
        let none = Grid::build(&[], 0.1);
        assert_eq!((none.len(), found(&none, Vec3::ZERO, 9.0).len()), (0, 0));
        let one = Grid::build(&[vec![at(Vec3::ONE)], Vec::new()], 0.1);
        assert_eq!(found(&one, Vec3::ONE, 1e-3).len(), 1);
        assert_eq!(found(&one, Vec3::ZERO, 1.7).len(), 0);
        let many = Grid::build(&[vec![at(Vec3::ONE); 100]], 0.1);
        assert_eq!(found(&many, Vec3::new(1.0, 1.0, 1.05), 0.06).len(), 100);
    }
}
