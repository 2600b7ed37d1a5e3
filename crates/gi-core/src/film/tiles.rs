//! Tiles: the order that pixels lie in.

use rayon::prelude::*;

/// Side of a tile in pixels.
pub(super) const TILE: usize = 16;
/// Pixels of a tile.
pub(super) const AREA: usize = TILE * TILE;

/// Tiles of 16 x 16 pixels over a picture, in Morton order.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    pub(super) size: [usize; 2],
    /// Corners of the tiles, in Morton order.
    pub(super) corners: Vec<[usize; 2]>,
    /// Which tile, in that order, covers a place of the grid of tiles.
    pub(super) at: Vec<u32>,
}

impl Tiles {
    pub(super) fn new(size: [usize; 2]) -> Self {
        let grid = size.map(|n| n.div_ceil(TILE));
        let mut corners: Vec<[usize; 2]> =
            (0..grid[0] * grid[1]).map(|i| [i % grid[0], i / grid[0]]).collect();
        corners.sort_by_key(|&[x, y]| morton(x as u32, y as u32));
        let mut at = vec![0; corners.len()];
        for (k, [x, y]) in corners.iter().enumerate() {
            at[y * grid[0] + x] = k as u32;
        }
        let corners = corners.into_iter().map(|t| t.map(|c| c * TILE)).collect();
        Tiles { size, corners, at }
    }

    /// Pixels of all tiles, those outside of the picture counted.
    pub(super) fn pixels(&self) -> usize {
        self.corners.len() * AREA
    }

    /// Where the pixel at (x, y) lies in memory.
    #[inline]
    pub(super) fn place(&self, [x, y]: [usize; 2]) -> usize {
        let tile = self.at[(y / TILE) * self.size[0].div_ceil(TILE) + x / TILE] as usize;
        tile * AREA + (y % TILE) * TILE + x % TILE
    }

    /// The pixels of the tile at `corner` that are in the picture, with their numbers in the tile.
    #[inline]
    pub(super) fn inside(
        &self,
        [x0, y0]: [usize; 2],
    ) -> impl Iterator<Item = (usize, [usize; 2])> + Clone + use<> {
        let [w, h] = self.size;
        let all = (0..AREA).map(move |i| (i, [x0 + i % TILE, y0 + i / TILE]));
        all.filter(move |&(_, [x, y])| x < w && y < h)
    }
}

/// Interleave the bits of two coordinates.
fn morton(x: u32, y: u32) -> u64 {
    let spread = |v: u32| (0..32).fold(0u64, |m, b| m | (u64::from(v >> b & 1) << (2 * b)));
    spread(x) | spread(y) << 1
}

/// Data that a technique keeps per pixel from pass to pass, in the order of the film's pixels. Threads own disjoint pieces.
#[derive(Clone, Debug)]
pub struct PerPixel<T> {
    pub(super) tiles: Tiles,
    pub(super) values: Vec<T>,
}

impl<T: Default + Send + Sync> PerPixel<T> {
    /// Values for a picture of `size` pixels, made in parallel. `make` must be a pure function of the pixel.
    pub fn new(size: [usize; 2], make: impl Fn([usize; 2]) -> T + Sync) -> Self {
        let tiles = Tiles::new(size);
        let mut values = Vec::new();
        values.resize_with(tiles.pixels(), T::default);
        let pieces = values.par_chunks_mut(AREA).zip(&tiles.corners).with_max_len(1);
        pieces.for_each(|(values, &corner)| {
            tiles.inside(corner).for_each(|(i, at)| values[i] = make(at));
        });
        PerPixel { tiles, values }
    }

    /// The value of a pixel.
    pub fn get(&self, at: [usize; 2]) -> &T {
        &self.values[self.tiles.place(at)]
    }

    /// The value of a pixel, to be changed.
    pub fn get_mut(&mut self, at: [usize; 2]) -> &mut T {
        let place = self.tiles.place(at);
        &mut self.values[place]
    }

    /// The values in row order.
    pub fn rows(&self) -> impl Iterator<Item = &T> {
        let [w, h] = self.tiles.size;
        (0..w * h).map(move |i| self.get([i % w, i / w]))
    }

    /// The values in row order, to be changed; for one thread.
    pub fn for_each_row_mut(&mut self, mut change: impl FnMut(&mut T)) {
        let [w, h] = self.tiles.size;
        for i in 0..w * h {
            let place = self.tiles.place([i % w, i / w]);
            change(&mut self.values[place]);
        }
    }

    /// The sum of `value` over the picture, in an order that does not depend on threads.
    pub fn sum(&self, value: impl Fn(&T) -> f64 + Sync) -> f64 {
        let pieces = self.values.par_chunks(AREA).zip(&self.tiles.corners);
        let sums: Vec<f64> = pieces
            .map(|(values, &corner)| {
                self.tiles.inside(corner).map(|(i, _)| value(&values[i])).sum()
            })
            .collect();
        sums.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_has_its_own_value_and_sums_leave_the_outside_out() {
        let size = [37, 21];
        let mut all = PerPixel::new(size, |[x, y]| (x + 100 * y) as f64);
        assert!(all.rows().enumerate().all(|(i, v)| *v == (i % 37 + 100 * (i / 37)) as f64));
        let expected: f64 = all.rows().sum();
        assert_eq!(all.sum(|v| *v), expected);
        all.for_each_row_mut(|v| *v += 1.0);
        assert_eq!(*all.get([3, 2]), 204.0);
        assert_eq!(all.sum(|v| *v), expected + (37 * 21) as f64);
    }
}
