//! The traversal in SSE2, AVX2 and AVX-512: all children of a node at once, and triangles four at a time.

mod boxes;
mod halves;
mod triangles;

use std::arch::x86_64::*;
use std::mem::MaybeUninit;

use glam::Vec3;

use super::layout::{SENTINEL, STACK, Tree, is_leaf, is_solid, leaf_range};
use super::portable::FOUND;
use crate::ray::{Hit, Ray};
use triangles::{shear, triangles_fma, triangles_sse2};

/// The origin or the direction of a ray, loaded one coordinate at a time: the loads are volatile, so that the compiler does not
/// combine them. Callers have just stored the coordinates one by one. The processor forwards each store to a load of the same
/// coordinate. A load of several would stall until the stores have reached the cache.
#[inline]
fn coordinates(v: &Vec3) -> [f32; 3] {
    // SAFETY: the references are valid.
    [&v.x, &v.y, &v.z].map(|x| unsafe { std::ptr::read_volatile(x) })
}

/// Prefetch the node or leaf that a word points at.
#[inline]
#[target_feature(enable = "sse2")]
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

/// Test a leaf of solids. It is a separate function, so that the traversal is optimised for triangles.
#[cold]
#[inline(never)]
fn solids<const ANY: bool>(tree: &Tree, word: u32, ray: &Ray, hit: &mut Hit) -> bool {
    let (first, count) = leaf_range(word);
    let mut found = false;
    for solid in &tree.solids[first..first + count] {
        let ray = Ray { tmax: hit.t, ..*ray };
        if ANY {
            if let Some(prim) = solid.any(&ray) {
                (hit.prim, found) = (prim, true);
            }
        } else if let Some(h) = solid.closest(&ray) {
            (*hit, found) = (h, true);
        }
    }
    found
}

macro_rules! trace {
    ($name:ident, $boxes:ident, $push:ident, $triangles:ident, $features:literal) => {
        /// The nearest hit, or with `ANY` the first one found; `SOLIDS` if the tree has any.
        #[target_feature(enable = $features)]
        pub(super) fn $name<const ANY: bool, const SOLIDS: bool>(
            tree: &Tree,
            ray: &Ray,
        ) -> Option<Hit> {
            let (wide, shear) = ($boxes::widen(ray), shear(ray));
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
                    // SAFETY: `Tree::checked_depth` has checked that every inner word is a valid index of `nodes`.
                    let node = unsafe { tree.nodes.get_unchecked(word as usize) };
                    let (near, hits) = $boxes::slabs(node, &wide, hit.t);
                    let count = $boxes::count(hits);
                    if count == 0 {
                        break;
                    }
                    // SAFETY: the builder limits the depth so that eight more entries always fit.
                    unsafe {
                        $boxes::$push::<ANY>(
                            node,
                            &wide,
                            near,
                            hits,
                            words.add(top),
                            dists.add(top),
                        );
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
                            // SAFETY: `Tree::checked_depth` has checked that every leaf word is a valid range of
                            // `blocks`.
                            let block = unsafe { tree.blocks.get_unchecked(k) };
                            any |= $triangles::<ANY>(block, &shear, &mut hit);
                            if ANY && any {
                                break;
                            }
                        }
                    }
                    if ANY && any {
                        break;
                    }
                }
                // SAFETY: the sentinel at the bottom has an entry distance that is never beyond a hit, so the loop
                // stops there.
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

trace!(trace_sse2, halves, push, triangles_sse2, "sse2");
trace!(trace_avx2, boxes, push_avx2, triangles_fma, "avx2,fma,bmi1,bmi2,lzcnt,popcnt");
trace!(
    trace_avx512,
    boxes, push_avx512, triangles_fma, "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq"
);
