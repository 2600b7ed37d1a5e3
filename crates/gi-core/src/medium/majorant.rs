//! A coarse grid of bounds on the extinction of a medium. A ray crosses it block by block \[Amanatides87\], so that
//! empty space costs little.

use std::cmp::Ordering;

use glam::{Affine3A, Vec3};

use super::volume::Volume;
use crate::math::{Bounds, Rgb};

/// Cells of the fine grid per block, along each axis.
const CELLS: f32 = 4.0;
/// Largest number of blocks along an axis.
const MOST: f32 = 64.0;

/// Bounds on a volume's values inside a box.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Majorants {
    /// World space to the space of the blocks, in which the box begins at the origin and blocks are unit cubes.
    to_blocks: Affine3A,
    /// Number of blocks along each axis.
    size: [usize; 3],
    /// The smallest and the largest value in each block.
    blocks: Vec<[Rgb; 2]>,
    /// A box in world space that rays are clipped to as well.
    clip: Option<Bounds>,
}

/// A part of a ray inside one block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) from: f32,
    pub(super) to: f32,
    /// Smallest value on this part.
    pub(super) least: Rgb,
    /// Largest value on this part.
    pub(super) most: Rgb,
}

impl Majorants {
    /// Bounds of `volume` in the box `local` of the space that `to_local` leads to. Rays are clipped to that box, and to
    /// `clip` in world space.
    pub(super) fn new(
        volume: &Volume,
        to_local: &Affine3A,
        local: Bounds,
        clip: Option<Bounds>,
    ) -> Self {
        let extent = local.extent();
        let cells = match volume {
            Volume::Constant(_) => Vec3::ONE,
            Volume::Grid { grid, .. } => Vec3::from_array(grid.size().map(|n| n as f32)),
        };
        let size = (extent * cells / CELLS).ceil().clamp(Vec3::ONE, Vec3::splat(MOST));
        let step = extent / size;
        let size = size.as_uvec3().to_array().map(|n| n as usize);
        let corner = |at: [usize; 3]| local.min + Vec3::from_array(at.map(|i| i as f32)) * step;
        let mut blocks = Vec::with_capacity(size.iter().product());
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let [min, max] = [corner([x, y, z]), corner([x + 1, y + 1, z + 1])];
                    blocks.push(match volume {
                        Volume::Constant(value) => [*value; 2],
                        Volume::Grid { grid, factor, .. } => {
                            grid.bounds(min, max).map(|b| b * *factor)
                        }
                    });
                }
            }
        }
        let scale =
            Affine3A::from_scale(lengths(size) / extent.max(Vec3::splat(f32::MIN_POSITIVE)));
        let to_blocks = scale * Affine3A::from_translation(-local.min) * *to_local;
        Majorants { to_blocks, size, blocks, clip }
    }

    /// Largest memory of such a grid, in bytes.
    pub(super) const MAX_BYTES: u64 = (MOST * MOST * MOST) as u64 * size_of::<[Rgb; 2]>() as u64;

    /// The pieces of a ray from `o` along the unit vector `d`, up to the distance `reach`, in order.
    #[inline]
    pub(super) fn pieces(&self, o: Vec3, d: Vec3, reach: f32) -> Pieces<'_> {
        let (mut from, mut to) = (0.0, reach);
        if let Some(clip) = &self.clip {
            (from, to) = clipped(o, d, clip.min, clip.max, from, to);
        }
        let (o, d) = (self.to_blocks.transform_point3(o), self.to_blocks.transform_vector3(d));
        let size = lengths(self.size);
        (from, to) = clipped(o, d, Vec3::ZERO, size, from, to);
        let start = (o + d * from).floor().clamp(Vec3::ZERO, size - 1.0);
        let at = start.as_ivec3().to_array();
        let (mut next, mut delta) = ([f32::INFINITY; 3], [f32::INFINITY; 3]);
        for axis in 0..3 {
            if d[axis] != 0.0 {
                let face = start[axis] + if d[axis] > 0.0 { 1.0 } else { 0.0 };
                next[axis] = (face - o[axis]) / d[axis];
                delta[axis] = 1.0 / d[axis].abs();
            }
        }
        let step = d.to_array().map(|d| if d > 0.0 { 1 } else { -1 });
        Pieces { majorants: self, at, step, next, delta, from, to }
    }

    /// Translate everything by `by`.
    pub(super) fn shift(&mut self, by: Vec3) {
        self.to_blocks *= Affine3A::from_translation(-by);
        self.clip = self.clip.map(|b| Bounds { min: b.min + by, max: b.max + by });
    }
}

fn lengths(size: [usize; 3]) -> Vec3 {
    Vec3::from_array(size.map(|n| n as f32))
}

/// The part of the interval from `from` to `to` in which a ray is inside the box from `min` to `max`. It is empty if its start is not
/// below its end.
#[inline]
fn clipped(o: Vec3, d: Vec3, min: Vec3, max: Vec3, mut from: f32, mut to: f32) -> (f32, f32) {
    for axis in 0..3 {
        if d[axis] == 0.0 {
            if o[axis] < min[axis] || o[axis] > max[axis] {
                return (0.0, 0.0);
            }
            continue;
        }
        let (a, b) = ((min[axis] - o[axis]) / d[axis], (max[axis] - o[axis]) / d[axis]);
        (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
    }
    (from, to)
}

/// See [`Majorants::pieces`].
pub(super) struct Pieces<'m> {
    majorants: &'m Majorants,
    at: [i32; 3],
    step: [i32; 3],
    /// For each axis, the distance to the next face of a block, and the distance between two faces.
    next: [f32; 3],
    delta: [f32; 3],
    from: f32,
    to: f32,
}

impl Iterator for Pieces<'_> {
    type Item = Piece;

    #[inline]
    fn next(&mut self) -> Option<Piece> {
        // A ray whose numbers are NaN ends too.
        if self.from.partial_cmp(&self.to) != Some(Ordering::Less) {
            return None;
        }
        let Majorants { size, blocks, .. } = self.majorants;
        let inside = (0..3).all(|axis| (0..size[axis] as i32).contains(&self.at[axis]));
        if !inside {
            return None;
        }
        let [x, y, z] = self.at.map(|i| i as usize);
        let [least, most] = blocks[(z * size[1] + y) * size[0] + x];
        let [a, b, c] = self.next;
        let axis = if a <= b && a <= c {
            0
        } else if b <= c {
            1
        } else {
            2
        };
        let piece =
            Piece { from: self.from, to: self.next[axis].clamp(self.from, self.to), least, most };
        self.at[axis] += self.step[axis];
        self.next[axis] += self.delta[axis];
        self.from = piece.to;
        Some(piece)
    }
}
