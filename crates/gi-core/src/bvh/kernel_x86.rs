//! The walk in AVX2 and AVX-512: all eight children at once, branch-free push in the ray's octant order
//! [Fuetterling17], watertight triangles four at a time [Woop13].

use std::arch::x86_64::*;
use std::mem::MaybeUninit;

use super::kernel_portable::FOUND;
use super::layout::{
    Block, LANES, Node, SENTINEL, STACK, Tree, WIDTH, is_leaf, is_solid, leaf_range,
};
use super::walk::Walk;
use crate::ray::{Hit, Ray};

/// The ray in all lanes.
struct Wide {
    /// 1 / d.
    inv: [__m256; 3],
    /// o / d.
    scaled: [__m256; 3],
    tmin: __m256,
    /// How far to shift [`Node::order`].
    order_shift: __m128i,
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn widen(ray: &Ray, walk: &Walk) -> Wide {
    let scaled = |k: usize| _mm256_set1_ps(ray.o[k] * walk.inv[k]);
    Wide {
        inv: [
            _mm256_set1_ps(walk.inv[0]),
            _mm256_set1_ps(walk.inv[1]),
            _mm256_set1_ps(walk.inv[2]),
        ],
        scaled: [scaled(0), scaled(1), scaled(2)],
        tmin: _mm256_set1_ps(ray.tmin),
        order_shift: _mm_cvtsi32_si128(walk.order_shift as i32),
    }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn load(row: &[f32; WIDTH]) -> __m256 {
    // SAFETY: the reference covers the 32 bytes that are read.
    unsafe { _mm256_loadu_ps(row.as_ptr()) }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn load_words(row: &[u32; WIDTH]) -> __m256i {
    // SAFETY: the reference covers the 32 bytes that are read.
    unsafe { _mm256_loadu_si256(row.as_ptr().cast()) }
}

/// Where the ray enters each child, and a mask of the children that it meets within (tmin, tmax].
#[inline]
#[target_feature(enable = "avx2,fma")]
fn slabs(node: &Node, walk: &Walk, wide: &Wide, tmax: f32) -> (__m256, __m256) {
    let plane = |axis: usize, side: usize| {
        // SAFETY: axis <= 2 and side <= 1, so that the row is one of the six.
        let row = unsafe { node.bounds.get_unchecked(2 * axis + side) };
        _mm256_fmsub_ps(load(row), wide.inv[axis], wide.scaled[axis])
    };
    let [nx, ny, nz] = walk.negative;
    let near = _mm256_max_ps(
        _mm256_max_ps(plane(0, nx), plane(1, ny)),
        _mm256_max_ps(plane(2, nz), wide.tmin),
    );
    let far = _mm256_min_ps(
        _mm256_min_ps(plane(0, 1 - nx), plane(1, 1 - ny)),
        _mm256_min_ps(plane(2, 1 - nz), _mm256_set1_ps(tmax)),
    );
    (near, _mm256_cmp_ps::<_CMP_LE_OQ>(near, far))
}

/// For every mask, the lanes that are set, in order.
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

/// The lanes of `hits`, brought to the front.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn front(hits: __m256) -> __m256i {
    // SAFETY: the mask of eight lanes is below 256.
    load_words(unsafe { COMPRESS.0.get_unchecked(_mm256_movemask_ps(hits) as usize) })
}

/// Store the children that are hit at `words`, the nearest last, and where they begin at `dists`.
///
/// # Safety
/// Both pointers must have room for eight more entries.
#[inline]
#[target_feature(enable = "avx2,fma")]
unsafe fn push_avx2<const ANY: bool>(
    node: &Node,
    wide: &Wide,
    near: __m256,
    hits: __m256,
    words: *mut u32,
    dists: *mut f32,
) {
    let children = load_words(&node.child);
    // SAFETY: the caller gives the room.
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

/// [`push_avx2`] with the compressing moves of AVX-512.
///
/// # Safety
/// Both pointers must have room for eight more entries.
#[inline]
#[target_feature(enable = "avx2,fma,avx512f,avx512vl,avx512dq")]
unsafe fn push_avx512<const ANY: bool>(
    node: &Node,
    wide: &Wide,
    near: __m256,
    hits: __m256,
    words: *mut u32,
    dists: *mut f32,
) {
    let children = load_words(&node.child);
    // SAFETY: the caller gives the room.
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

/// Bring what a word points at into the cache.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn prefetch(tree: &Tree, word: u32) {
    let (first, _) = leaf_range(word);
    let start: *const i8 = if is_leaf(word) {
        tree.blocks.as_ptr().wrapping_add(first).cast()
    } else {
        tree.nodes.as_ptr().wrapping_add(word as usize).cast()
    };
    for line in 0..4 {
        _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(64 * line));
    }
}

/// Test four triangles; a hit shortens `hit`.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn triangles<const ANY: bool>(block: &Block, ray: &Ray, walk: &Walk, hit: &mut Hit) -> bool {
    let [kx, ky, kz] = walk.axes;
    let row = |k: usize| {
        // SAFETY: k = 3 * vertex + axis < 9, and the row is 16 bytes.
        unsafe { _mm_loadu_ps(block.rows.get_unchecked(k).as_ptr()) }
    };
    let o = ray.o.to_array();
    // SAFETY: the axes are a permutation of 0, 1, 2.
    let (ox, oy, oz) =
        unsafe { (*o.get_unchecked(kx), *o.get_unchecked(ky), *o.get_unchecked(kz)) };
    let (ox, oy, oz) = (_mm_set1_ps(ox), _mm_set1_ps(oy), _mm_set1_ps(oz));
    let (sx, sy) = (_mm_set1_ps(walk.shear[0]), _mm_set1_ps(walk.shear[1]));
    // Move the vertices to where the ray is the z axis.
    let vertex = |v: usize| {
        let z = _mm_sub_ps(row(3 * v + kz), oz);
        let x = _mm_fnmadd_ps(sx, z, _mm_sub_ps(row(3 * v + kx), ox));
        let y = _mm_fnmadd_ps(sy, z, _mm_sub_ps(row(3 * v + ky), oy));
        (x, y, z)
    };
    let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (vertex(0), vertex(1), vertex(2));
    // Edge functions without fused operations: exactly opposite for the two triangles of an edge.
    let u = _mm_sub_ps(_mm_mul_ps(cx, by), _mm_mul_ps(cy, bx));
    let v = _mm_sub_ps(_mm_mul_ps(ax, cy), _mm_mul_ps(ay, cx));
    let w = _mm_sub_ps(_mm_mul_ps(bx, ay), _mm_mul_ps(by, ax));
    let zero = _mm_setzero_ps();
    let least = _mm_min_ps(u, _mm_min_ps(v, w));
    let most = _mm_max_ps(u, _mm_max_ps(v, w));
    let inside = _mm_or_ps(_mm_cmpge_ps(least, zero), _mm_cmple_ps(most, zero));
    let det = _mm_add_ps(u, _mm_add_ps(v, w));
    // Compare t * |det| first: most blocks end here, without a division.
    let sign = _mm_and_ps(det, _mm_set1_ps(-0.0));
    let size = _mm_xor_ps(det, sign);
    let along = _mm_fmadd_ps(u, az, _mm_fmadd_ps(v, bz, _mm_mul_ps(w, cz)));
    let scaled = _mm_xor_ps(_mm_mul_ps(along, _mm_set1_ps(walk.shear[2])), sign);
    let (tmin, tmax) = (_mm_set1_ps(ray.tmin), _mm_set1_ps(hit.t));
    let between = _mm_and_ps(
        _mm_cmpgt_ps(scaled, _mm_mul_ps(size, tmin)),
        _mm_cmple_ps(scaled, _mm_mul_ps(size, tmax)),
    );
    let met = _mm_and_ps(_mm_and_ps(inside, _mm_cmpgt_ps(size, zero)), between);
    if _mm_movemask_ps(met) == 0 {
        return false;
    }
    // Now exactly: the reported t itself must lie in the interval.
    let inv = _mm_div_ps(_mm_set1_ps(1.0), size);
    let t = _mm_mul_ps(scaled, inv);
    let met = _mm_and_ps(met, _mm_and_ps(_mm_cmpgt_ps(t, tmin), _mm_cmple_ps(t, tmax)));
    let mask = _mm_movemask_ps(met);
    if ANY || mask == 0 {
        return mask != 0;
    }
    let inv = _mm_xor_ps(inv, sign);
    record(block, met, [t, _mm_mul_ps(v, inv), _mm_mul_ps(w, inv)], hit);
    true
}

/// Take over the nearest of the lanes that are met.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn record(block: &Block, met: __m128, [t, u, v]: [__m128; 3], hit: &mut Hit) {
    let t = _mm_blendv_ps(_mm_set1_ps(f32::INFINITY), t, met);
    let pairs = _mm_min_ps(t, _mm_shuffle_ps::<0b10_11_00_01>(t, t));
    let least = _mm_min_ps(pairs, _mm_shuffle_ps::<0b01_00_11_10>(pairs, pairs));
    let nearest = _mm_movemask_ps(_mm_and_ps(_mm_cmpeq_ps(t, least), met));
    let lane = nearest.trailing_zeros() as usize & (LANES - 1);
    let mut uv = [[0.0f32; LANES]; 2];
    // SAFETY: each array is 16 bytes.
    unsafe {
        _mm_storeu_ps(uv[0].as_mut_ptr(), u);
        _mm_storeu_ps(uv[1].as_mut_ptr(), v);
    }
    *hit = Hit {
        t: _mm_cvtss_f32(least),
        u: uv[0][lane],
        v: uv[1][lane],
        prim: block.id[lane],
        instance: Hit::NO_INSTANCE,
    };
}

/// Test a leaf of solids; kept out of the walk, which is for triangles.
#[cold]
#[inline(never)]
fn solids<const ANY: bool>(tree: &Tree, word: u32, ray: &Ray, hit: &mut Hit) -> bool {
    let (first, count) = leaf_range(word);
    let mut found = false;
    for solid in &tree.solids[first..first + count] {
        let ray = Ray { tmax: hit.t, ..*ray };
        if ANY {
            found |= solid.occluded(&ray);
        } else if let Some(h) = solid.closest(&ray) {
            (*hit, found) = (h, true);
        }
    }
    found
}

macro_rules! trace {
    ($name:ident, $push:ident, $features:literal) => {
        /// The nearest hit, or with `ANY` the first one found; `SOLIDS` if the tree has any.
        #[target_feature(enable = $features)]
        pub(super) fn $name<const ANY: bool, const SOLIDS: bool>(
            tree: &Tree,
            ray: &Ray,
        ) -> Option<Hit> {
            let walk = Walk::new(ray);
            let wide = widen(ray, &walk);
            let mut hit = Hit { t: ray.tmax, ..FOUND };
            let mut any = false;
            let mut words = [MaybeUninit::<u32>::uninit(); STACK];
            let mut dists = [MaybeUninit::<f32>::uninit(); STACK];
            words[0].write(SENTINEL);
            dists[0].write(f32::NEG_INFINITY);
            let (words, dists): (*mut u32, *mut f32) =
                (words.as_mut_ptr().cast(), dists.as_mut_ptr().cast());
            // The next free entry; everything below it is written.
            let mut top = 1;
            let mut word = 0;
            loop {
                while !is_leaf(word) {
                    // SAFETY: `Tree::checked_depth` has seen every inner word inside the nodes.
                    let node = unsafe { tree.nodes.get_unchecked(word as usize) };
                    let (near, hits) = slabs(node, &walk, &wide, hit.t);
                    let count = _mm256_movemask_ps(hits).count_ones() as usize;
                    if count == 0 {
                        break;
                    }
                    // SAFETY: the builder bounds the depth so that eight more entries always fit.
                    unsafe {
                        $push::<ANY>(node, &wide, near, hits, words.add(top), dists.add(top));
                        top += count - 1;
                        word = *words.add(top);
                        prefetch(tree, *words.add(top - 1));
                    }
                }
                if is_leaf(word) {
                    if word == SENTINEL {
                        break;
                    }
                    if SOLIDS && is_solid(word) {
                        any |= solids::<ANY>(tree, word, ray, &mut hit);
                    } else {
                        let (first, count) = leaf_range(word);
                        for k in first..first + count {
                            // SAFETY: `Tree::checked_depth` has seen every leaf word inside the blocks.
                            let block = unsafe { tree.blocks.get_unchecked(k) };
                            any |= triangles::<ANY>(block, ray, &walk, &mut hit);
                            if ANY && any {
                                break;
                            }
                        }
                    }
                    if ANY && any {
                        break;
                    }
                }
                // SAFETY: the sentinel at the bottom is never behind a hit and ends the walk before it is passed.
                word = unsafe {
                    loop {
                        top -= 1;
                        if ANY || *dists.add(top) <= hit.t {
                            break *words.add(top);
                        }
                    }
                };
            }
            any.then_some(hit)
        }
    };
}

trace!(trace_avx2, push_avx2, "avx2,fma,bmi1,bmi2,lzcnt,popcnt");
trace!(trace_avx512, push_avx512, "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq");
