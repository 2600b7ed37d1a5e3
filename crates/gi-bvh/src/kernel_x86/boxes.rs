//! Tests eight boxes at once, and pushes those that are hit in the ray's octant order \[Fuetterling17\].

use std::arch::x86_64::*;

use super::super::layout::{Node, WIDTH};
use super::super::walk::SMALLEST_STEP;
use super::coordinates;
use crate::ray::Ray;

/// Bytes per row of [`Node::bounds`].
const ROW: usize = 4 * WIDTH;

/// The ray, broadcast to all lanes.
pub(super) struct Wide {
    /// 1 / d.
    inv: [__m256; 3],
    /// o / d.
    scaled: [__m256; 3],
    tmin: __m256,
    /// Byte offsets of the rows of near planes; the far planes are the other rows of each pair.
    near: [usize; 3],
    /// How far to shift [`Node::order`].
    order_shift: __m128i,
}

/// Compute [`Walk`](super::super::walk::Walk)'s values in SIMD registers.
#[inline]
#[target_feature(enable = "avx2,fma")]
pub(super) fn widen(ray: &Ray) -> Wide {
    let ([ox, oy, oz], [dx, dy, dz]) = (coordinates(&ray.o), coordinates(&ray.d));
    let (o, d) = (_mm_set_ps(0.0, oz, oy, ox), _mm_set_ps(1.0, dz, dy, dx));
    let sign = _mm_set1_ps(-0.0);
    let small = _mm_cmplt_ps(_mm_andnot_ps(sign, d), _mm_set1_ps(SMALLEST_STEP));
    let longest = _mm_or_ps(_mm_set1_ps(1.0 / SMALLEST_STEP), _mm_and_ps(sign, d));
    let inv = _mm_blendv_ps(_mm_div_ps(_mm_set1_ps(1.0), d), longest, small);
    let scaled = _mm_mul_ps(o, inv);
    // Take signs from the reciprocal's bits: -0.0 must choose the same side everywhere.
    let octant = _mm_movemask_ps(inv) as usize & 7;
    let lanes = |v: __m128| {
        [
            _mm256_broadcastss_ps(v),
            _mm256_broadcastss_ps(_mm_permute_ps::<0b01_01_01_01>(v)),
            _mm256_broadcastss_ps(_mm_permute_ps::<0b10_10_10_10>(v)),
        ]
    };
    Wide {
        inv: lanes(inv),
        scaled: lanes(scaled),
        tmin: _mm256_set1_ps(ray.tmin),
        near: [(octant & 1) * ROW, (2 + (octant >> 1 & 1)) * ROW, (4 + (octant >> 2)) * ROW],
        order_shift: _mm_cvtsi32_si128(3 * octant as i32),
    }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn load_words(row: &[u32; WIDTH]) -> __m256i {
    // SAFETY: the reference covers the 32 bytes that are read.
    unsafe { _mm256_loadu_si256(row.as_ptr().cast()) }
}

/// Where the ray enters each child, and a mask of the children that it intersects within (tmin, tmax].
#[inline]
#[target_feature(enable = "avx2,fma")]
pub(super) fn slabs(node: &Node, wide: &Wide, tmax: f32) -> (__m256, __m256) {
    let plane = |axis: usize, row: usize| {
        // SAFETY: `row` is the byte offset of one of the six rows of 32 bytes.
        let bounds = unsafe { _mm256_loadu_ps(node.bounds.as_ptr().byte_add(row).cast()) };
        _mm256_fmsub_ps(bounds, wide.inv[axis], wide.scaled[axis])
    };
    let [x, y, z] = wide.near;
    let near = _mm256_max_ps(
        _mm256_max_ps(plane(0, x), plane(1, y)),
        _mm256_max_ps(plane(2, z), wide.tmin),
    );
    let far = _mm256_min_ps(
        _mm256_min_ps(plane(0, x ^ ROW), plane(1, y ^ ROW)),
        _mm256_min_ps(plane(2, z ^ ROW), _mm256_set1_ps(tmax)),
    );
    (near, _mm256_cmp_ps::<_CMP_LE_OQ>(near, far))
}

/// The number of children that are hit.
#[inline]
#[target_feature(enable = "avx2,fma,popcnt")]
pub(super) fn count(hits: __m256) -> usize {
    _mm256_movemask_ps(hits).count_ones() as usize
}

/// For each mask, the indices of its set lanes, in order.
#[repr(align(64))]
struct Compress([[u32; WIDTH]; 256]);
static COMPRESS: Compress = {
    let mut table = [[0; WIDTH]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut k, mut lane) = (0, 0);
        while lane < WIDTH {
            if mask >> lane & 1 == 1 {
                table[mask][k] = lane as u32;
                k += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    Compress(table)
};

/// The lanes of `hits`, moved to the front.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn front(hits: __m256) -> __m256i {
    // SAFETY: the mask of eight lanes is below 256.
    load_words(unsafe { COMPRESS.0.get_unchecked(_mm256_movemask_ps(hits) as usize) })
}

/// Store the hit children at `words`, the nearest last, and their entry distances at `dists`.
///
/// # Safety
/// Both pointers must have room for eight more entries.
#[inline]
#[target_feature(enable = "avx2,fma")]
pub(super) unsafe fn push_avx2<const ANY: bool>(
    node: &Node,
    wide: &Wide,
    near: __m256,
    hits: __m256,
    words: *mut u32,
    dists: *mut f32,
) {
    let children = load_words(&node.child);
    // SAFETY: the caller guarantees the room.
    unsafe {
        if ANY {
            _mm256_storeu_si256(words.cast(), _mm256_permutevar8x32_epi32(children, front(hits)));
        } else {
            let order = _mm256_srl_epi32(load_words(&node.order), wide.order_shift);
            let kept =
                _mm256_permutevar8x32_epi32(order, front(_mm256_permutevar8x32_ps(hits, order)));
            _mm256_storeu_si256(words.cast(), _mm256_permutevar8x32_epi32(children, kept));
            _mm256_storeu_ps(dists, _mm256_permutevar8x32_ps(near, kept));
        }
    }
}

/// [`push_avx2`] with the compress instructions of AVX-512.
///
/// # Safety
/// Both pointers must have room for eight more entries.
#[inline]
#[target_feature(enable = "avx2,fma,avx512f,avx512vl,avx512dq")]
pub(super) unsafe fn push_avx512<const ANY: bool>(
    node: &Node,
    wide: &Wide,
    near: __m256,
    hits: __m256,
    words: *mut u32,
    dists: *mut f32,
) {
    let children = load_words(&node.child);
    // SAFETY: the caller guarantees the room.
    unsafe {
        if ANY {
            let mask = _mm256_movepi32_mask(_mm256_castps_si256(hits));
            _mm256_storeu_si256(words.cast(), _mm256_maskz_compress_epi32(mask, children));
        } else {
            let order = _mm256_srl_epi32(load_words(&node.order), wide.order_shift);
            let mask =
                _mm256_movepi32_mask(_mm256_permutevar8x32_epi32(_mm256_castps_si256(hits), order));
            let (children, near) = (
                _mm256_permutevar8x32_epi32(children, order),
                _mm256_permutevar8x32_ps(near, order),
            );
            _mm256_storeu_si256(words.cast(), _mm256_maskz_compress_epi32(mask, children));
            _mm256_storeu_ps(dists, _mm256_maskz_compress_ps(mask, near));
        }
    }
}
