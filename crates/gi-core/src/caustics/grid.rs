//! A hash grid over the photons of a map.

use glam::{IVec3, Vec3};

use crate::math::floor_ivec3;

/// Photons sorted by the hash of the cell that contains them.
pub(super) struct Grid {
    /// Edge length of a cell, world units.
    pub(super) cell: f32,
    /// Index in `order` of each bucket's first photon, and the end of the last bucket.
    starts: Vec<u32>,
    /// Photon indices, bucket by bucket.
    order: Vec<u32>,
}

impl Grid {
    pub(super) fn new(positions: impl ExactSizeIterator<Item = Vec3>, cell: f32) -> Self {
        let count = positions.len();
        let buckets = count.next_power_of_two();
        let mut grid = Grid { cell, starts: vec![0; buckets + 1], order: vec![0; count] };
        let of: Vec<u32> = positions.map(|p| grid.bucket(grid.cell_of(p))).collect();
        of.iter().for_each(|&b| grid.starts[b as usize + 1] += 1);
        for b in 0..buckets {
            grid.starts[b + 1] += grid.starts[b];
        }
        let mut next = grid.starts.clone();
        for (k, &b) in of.iter().enumerate() {
            grid.order[next[b as usize] as usize] = k as u32;
            next[b as usize] += 1;
        }
        grid
    }

    /// The cell that contains a point.
    pub(super) fn cell_of(&self, p: Vec3) -> IVec3 {
        floor_ivec3(p / self.cell)
    }

    /// The bucket of a cell. Several cells may share one.
    pub(super) fn bucket(&self, cell: IVec3) -> u32 {
        let [x, y, z] = cell.to_array().map(|k| k as u32);
        let hash =
            x.wrapping_mul(0x8da6_b343) ^ y.wrapping_mul(0xd816_3841) ^ z.wrapping_mul(0xcb1a_b31f);
        let mixed = (hash ^ hash >> 15).wrapping_mul(0x2c1b_3c6d);
        (mixed ^ mixed >> 12) & (self.starts.len() as u32 - 2)
    }

    /// Indices of the photons in a cell's bucket. Some may be in other cells that share the bucket.
    pub(super) fn members(&self, cell: IVec3) -> &[u32] {
        let bucket = self.bucket(cell) as usize;
        let [from, to] = [0, 1].map(|k| self.starts[bucket + k] as usize);
        &self.order[from..to]
    }

    /// The eight cells that cover the ball of half a cell's width around a point.
    pub(super) fn near(&self, p: Vec3) -> impl Iterator<Item = IVec3> {
        let low = self.cell_of(p - Vec3::splat(0.5 * self.cell));
        (0..8).map(move |corner| low + corner_of(corner))
    }
}

/// The offset of one of the eight cells in a block of two by two by two.
pub(super) fn corner_of(corner: i32) -> IVec3 {
    IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2)
}
