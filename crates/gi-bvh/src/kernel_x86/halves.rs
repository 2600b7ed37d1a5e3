//! Tests eight boxes as two halves of four, for processors without wider vectors.

use std::arch::x86_64::*;

use super::super::layout::{Node, WIDTH};
use super::super::walk::Walk;
use crate::ray::Ray;

const HALF: usize = WIDTH / 2;

/// The ray, broadcast to all lanes.
pub(super) struct Wide {
    origin: [__m128; 3],
    inv: [__m128; 3],
    tmin: __m128,
    negative: [usize; 3],
    order_shift: u32,
}

#[inline]
#[target_feature(enable = "sse2")]
pub(super) fn widen(ray: &Ray) -> Wide {
    let walk = Walk::new(ray);
    Wide {
        origin: ray.o.to_array().map(|x| _mm_set1_ps(x)),
        inv: walk.inv.map(|x| _mm_set1_ps(x)),
        tmin: _mm_set1_ps(ray.tmin),
        negative: walk.negative,
        order_shift: walk.order_shift,
    }
}

/// Where the ray enters each child, and a mask of the children that it intersects within (tmin, tmax].
#[inline]
#[target_feature(enable = "sse2")]
pub(super) fn slabs(node: &Node, wide: &Wide, tmax: f32) -> ([f32; WIDTH], u32) {
    let tmax = _mm_set1_ps(tmax);
    let mut entry = [0.0f32; WIDTH];
    let mut mask = 0;
    for half in 0..2 {
        let plane = |axis: usize, side: usize| {
            // SAFETY: axis <= 2 and side <= 1 name one of the six rows, of which a half is 16 bytes.
            let bounds = unsafe {
                let row = node.bounds.get_unchecked(2 * axis + side);
                _mm_loadu_ps(row.as_ptr().add(HALF * half))
            };
            _mm_mul_ps(_mm_sub_ps(bounds, wide.origin[axis]), wide.inv[axis])
        };
        let [x, y, z] = wide.negative;
        let near =
            _mm_max_ps(_mm_max_ps(plane(0, x), plane(1, y)), _mm_max_ps(plane(2, z), wide.tmin));
        let far = _mm_min_ps(
            _mm_min_ps(plane(0, 1 - x), plane(1, 1 - y)),
            _mm_min_ps(plane(2, 1 - z), tmax),
        );
        // SAFETY: half of the array is 16 bytes.
        unsafe { _mm_storeu_ps(entry.as_mut_ptr().add(HALF * half), near) };
        mask |= (_mm_movemask_ps(_mm_cmple_ps(near, far)) as u32) << (HALF * half);
    }
    (entry, mask)
}

/// The number of children that are hit.
#[inline]
#[target_feature(enable = "sse2")]
pub(super) fn count(mask: u32) -> usize {
    mask.count_ones() as usize
}

/// Store the hit children at `words`, the nearest last, and their entry distances at `dists`.
///
/// # Safety
/// Both pointers must have room for eight more entries.
#[inline]
#[target_feature(enable = "sse2")]
pub(super) unsafe fn push<const ANY: bool>(
    node: &Node,
    wide: &Wide,
    near: [f32; WIDTH],
    mask: u32,
    words: *mut u32,
    dists: *mut f32,
) {
    if mask & (mask - 1) == 0 {
        let slot = mask.trailing_zeros() as usize % WIDTH;
        // SAFETY: the caller guarantees the room.
        unsafe {
            *words = node.child[slot];
            *dists = near[slot];
        }
        return;
    }
    let mut top = 0;
    for order in node.order {
        let slot = (order >> wide.order_shift) as usize % WIDTH;
        // SAFETY: at most eight entries are written. The entry of a child that is not hit is overwritten by the next
        // one.
        unsafe {
            *words.add(top) = node.child[slot];
            *dists.add(top) = near[slot];
        }
        top += (mask >> slot & 1) as usize;
    }
}
