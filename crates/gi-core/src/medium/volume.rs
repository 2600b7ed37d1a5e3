//! Quantities that vary in space: grids of values.

use std::ops::RangeInclusive;
use std::sync::Arc;

use glam::{Affine3A, Vec3};

use crate::math::Rgb;

/// The value of a grid outside its unit cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// That of the nearest point of the cube.
    Clamp,
    /// The grid is repeated.
    Repeat,
    /// The grid is repeated; every second copy is mirrored.
    Mirror,
    /// Zero. The values next to the faces are interpolated toward zero.
    Zero,
}

/// The value between the centres of the cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// That of the nearest centre.
    Nearest,
    /// Trilinear interpolation.
    Trilinear,
}

/// The values of a grid's cells. The first coordinate varies fastest.
#[derive(Clone, Debug)]
pub enum Cells {
    /// One value per cell, for all channels.
    Grey(Arc<[f32]>),
    /// A colour per cell.
    Color(Arc<[Rgb]>),
}

impl Cells {
    /// Number of cells.
    pub fn len(&self) -> usize {
        match self {
            Cells::Grey(values) => values.len(),
            Cells::Color(values) => values.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    #[inline]
    fn get(&self, index: usize) -> Rgb {
        match self {
            Cells::Grey(values) => Rgb::grey(values[index]),
            Cells::Color(values) => values[index],
        }
    }
}

impl PartialEq for Cells {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Cells::Grey(a), Cells::Grey(b)) => Arc::ptr_eq(a, b) || a == b,
            (Cells::Color(a), Cells::Color(b)) => Arc::ptr_eq(a, b) || a == b,
            _ => false,
        }
    }
}

/// A grid over the unit cube: cell (i, j, k) of n has its centre at ((i, j, k) + 1/2) / n.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    size: [usize; 3],
    cells: Cells,
    outside: Outside,
    between: Between,
}

impl Grid {
    /// A grid of `size` cells. `None` if there are not as many values, or none at all.
    pub fn new(size: [usize; 3], cells: Cells, outside: Outside, between: Between) -> Option<Self> {
        let count = size.iter().try_fold(1usize, |n, s| n.checked_mul(*s))?;
        // Indices outside the grid must fit into an i32 too.
        let fits = size.iter().all(|n| *n < 1 << 24);
        (count > 0 && count == cells.len() && fits).then_some(Grid {
            size,
            cells,
            outside,
            between,
        })
    }

    /// Number of cells along each axis.
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// The values.
    pub fn cells(&self) -> &Cells {
        &self.cells
    }

    /// The value outside.
    pub fn outside(&self) -> Outside {
        self.outside
    }

    /// The value between the centres.
    pub fn between(&self) -> Between {
        self.between
    }

    /// The index of cell `i` along an axis of `n` cells, which may be outside. `None` stands for zero.
    #[inline]
    fn wrap(&self, i: i32, n: usize) -> Option<usize> {
        let n = n as i32;
        if (0..n).contains(&i) {
            return Some(i as usize);
        }
        let inside = match self.outside {
            Outside::Clamp => i.clamp(0, n - 1),
            Outside::Repeat => i.rem_euclid(n),
            Outside::Mirror => {
                let m = i.rem_euclid(2 * n);
                m.min(2 * n - 1 - m)
            }
            Outside::Zero => return None,
        };
        Some(inside as usize)
    }

    /// The index of a cell in the list of values. `None` stands for zero.
    #[inline]
    fn index(&self, at: [i32; 3]) -> Option<usize> {
        let [x, y, z] = [0, 1, 2].map(|axis| self.wrap(at[axis], self.size[axis]));
        Some((z? * self.size[1] + y?) * self.size[0] + x?)
    }

    /// The value at `p`.
    #[inline]
    pub fn at(&self, p: Vec3) -> Rgb {
        match &self.cells {
            Cells::Grey(values) => Rgb::grey(self.sample(values, p, |a, b, t| a + (b - a) * t)),
            Cells::Color(values) => self.sample(values, p, |a, b, t| a + (b - a) * t),
        }
    }

    /// The value at `p` of cells of any type.
    #[inline]
    fn sample<T: Copy + Default>(&self, values: &[T], p: Vec3, lerp: impl Fn(T, T, f32) -> T) -> T {
        let cell = |at| self.index(at).map_or(T::default(), |i| values[i]);
        match self.between {
            Between::Nearest => cell(whole((p * self.extent()).floor())),
            Between::Trilinear => {
                let q = p * self.extent() - 0.5;
                let first = q.floor();
                let f = q - first;
                let [x, y, z] = whole(first);
                let row = |y, z| lerp(cell([x, y, z]), cell([x + 1, y, z]), f.x);
                let plane = |z| lerp(row(y, z), row(y + 1, z), f.y);
                lerp(plane(z), plane(z + 1), f.z)
            }
        }
    }

    /// Number of cells along each axis.
    #[inline]
    fn extent(&self) -> Vec3 {
        Vec3::from_array(self.size.map(|n| n as f32))
    }

    /// Bounds of the values in the box from `min` to `max`: the smallest and the largest of each channel.
    pub(super) fn bounds(&self, min: Vec3, max: Vec3) -> [Rgb; 2] {
        // Points that rounding moves out of the box belong to it.
        const MARGIN: f32 = 1e-3;
        let (shift, more) = match self.between {
            Between::Nearest => (0.0, 0),
            Between::Trilinear => (0.5, 1),
        };
        let first = whole((min * self.extent() - shift - MARGIN).floor());
        let last = whole((max * self.extent() - shift + MARGIN).floor());
        let [x, y, z] =
            [0, 1, 2].map(|axis| self.range(first[axis], last[axis] + more, self.size[axis]));
        let (mut least, mut most) = (Rgb::grey(f32::INFINITY), Rgb::BLACK);
        for z in z.clone() {
            for y in y.clone() {
                for x in x.clone() {
                    let value = self.index([x, y, z]).map_or(Rgb::BLACK, |i| self.cells.get(i));
                    (least, most) = (least.zip(value, f32::min), most.zip(value, f32::max));
                }
            }
        }
        [least, most]
    }

    /// A short range of indices that has the same values as `first` to `last` along an axis of `n` cells.
    fn range(&self, first: i32, last: i32, n: usize) -> RangeInclusive<i32> {
        let n = n as i32;
        match self.outside {
            Outside::Clamp => first.clamp(0, n - 1)..=last.clamp(0, n - 1),
            Outside::Zero => first.clamp(-1, n)..=last.clamp(-1, n),
            Outside::Repeat | Outside::Mirror if last - first >= 2 * n => 0..=n - 1,
            Outside::Repeat | Outside::Mirror => first..=last,
        }
    }

    /// The largest value of each channel.
    fn most(&self) -> Rgb {
        (0..self.cells.len()).map(|i| self.cells.get(i)).fold(Rgb::BLACK, |a, b| a.zip(b, f32::max))
    }
}

/// Whole numbers as integers. Those that are too large are limited.
#[inline]
fn whole(v: Vec3) -> [i32; 3] {
    const MOST: f32 = 1e9;
    v.clamp(Vec3::splat(-MOST), Vec3::splat(MOST)).as_ivec3().to_array()
}

/// A colour at every point of space.
#[derive(Clone, Debug, PartialEq)]
pub enum Volume {
    /// The same everywhere.
    Constant(Rgb),
    /// The values of a grid, times a factor.
    Grid {
        /// The grid.
        grid: Arc<Grid>,
        /// World space to the grid's unit cube.
        to_local: Affine3A,
        /// Factor on all values.
        factor: Rgb,
    },
}

impl Volume {
    /// The value at a point of world space.
    #[inline]
    pub fn at(&self, p: Vec3) -> Rgb {
        match self {
            Volume::Constant(value) => *value,
            Volume::Grid { grid, to_local, factor } => {
                grid.at(to_local.transform_point3(p)) * *factor
            }
        }
    }

    /// The largest value of each channel.
    pub fn most(&self) -> Rgb {
        match self {
            Volume::Constant(value) => *value,
            Volume::Grid { grid, factor, .. } => grid.most() * *factor,
        }
    }

    /// Translate everything by `by`.
    pub(super) fn shift(&mut self, by: Vec3) {
        if let Volume::Grid { to_local, .. } = self {
            *to_local *= Affine3A::from_translation(-by);
        }
    }
}

#[cfg(test)]
mod tests;
