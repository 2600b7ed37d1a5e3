//! Tests four triangles at once, watertight \[Woop13\].

use std::arch::x86_64::*;

use super::super::layout::{Block, LANES};
use super::super::walk::main_axes;
use super::coordinates;
use crate::ray::{Hit, Ray};

/// The shear that maps the ray to the z axis, broadcast to all lanes.
pub(super) struct Shear {
    /// Axes permuted so that the last one is the main direction of the ray.
    axes: [usize; 3],
    origin: [__m128; 3],
    factor: [__m128; 3],
    tmin: __m128,
}

#[inline]
#[target_feature(enable = "sse2")]
pub(super) fn shear(ray: &Ray) -> Shear {
    let [dx, dy, dz] = coordinates(&ray.d);
    let d = _mm_set_ps(0.0, dz, dy, dx);
    let size = _mm_andnot_ps(_mm_set1_ps(-0.0), d);
    let larger = _mm_movemask_ps(_mm_cmpgt_ps(size, _mm_shuffle_ps::<0b11_00_10_01>(size, size)));
    let axes = main_axes(larger as usize);
    let at = |v: &[f32; 3], k: usize| {
        // SAFETY: the axes are a permutation of 0, 1, 2.
        _mm_set1_ps(unsafe { *v.get_unchecked(axes[k]) })
    };
    let (o, d) = (ray.o.as_ref(), ray.d.as_ref());
    let sz = _mm_div_ps(_mm_set1_ps(1.0), at(d, 2));
    Shear {
        axes,
        origin: [at(o, 0), at(o, 1), at(o, 2)],
        factor: [_mm_mul_ps(at(d, 0), sz), _mm_mul_ps(at(d, 1), sz), sz],
        tmin: _mm_set1_ps(ray.tmin),
    }
}

macro_rules! triangles {
    ($name:ident, $add_product:ident, $sub_product:ident, $features:literal) => {
        /// Test four triangles; a hit shortens `hit`.
        #[inline]
        #[target_feature(enable = $features)]
        pub(super) fn $name<const ANY: bool>(block: &Block, shear: &Shear, hit: &mut Hit) -> bool {
            let row = |k: usize| {
                // SAFETY: k = 3 * vertex + axis < 9, and the row is 16 bytes.
                unsafe { _mm_loadu_ps(block.rows.get_unchecked(k).as_ptr()) }
            };
            let [kx, ky, kz] = shear.axes;
            let [ox, oy, oz] = shear.origin;
            let [sx, sy, sz] = shear.factor;
            // Transform the vertices so that the ray is the z axis.
            let vertex = |v: usize| {
                let z = _mm_sub_ps(row(3 * v + kz), oz);
                let x = $sub_product(_mm_sub_ps(row(3 * v + kx), ox), sx, z);
                let y = $sub_product(_mm_sub_ps(row(3 * v + ky), oy), sy, z);
                (x, y, z)
            };
            let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (vertex(0), vertex(1), vertex(2));
            // Edge functions without fused operations: exactly opposite for the two triangles that share an edge.
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
            let along = $add_product($add_product(_mm_mul_ps(w, cz), v, bz), u, az);
            let scaled = _mm_xor_ps(_mm_mul_ps(along, sz), sign);
            let (tmin, tmax) = (shear.tmin, _mm_set1_ps(hit.t));
            let between = _mm_and_ps(
                _mm_cmpgt_ps(scaled, _mm_mul_ps(size, tmin)),
                _mm_cmple_ps(scaled, _mm_mul_ps(size, tmax)),
            );
            let met = _mm_and_ps(_mm_and_ps(inside, _mm_cmpgt_ps(size, zero)), between);
            if _mm_movemask_ps(met) == 0 {
                return false;
            }
            // Compare exactly: the reported t itself must be in the interval.
            let inv = _mm_div_ps(_mm_set1_ps(1.0), size);
            let t = _mm_mul_ps(scaled, inv);
            let met = _mm_and_ps(met, _mm_and_ps(_mm_cmpgt_ps(t, tmin), _mm_cmple_ps(t, tmax)));
            let mask = _mm_movemask_ps(met);
            if mask == 0 {
                return false;
            }
            if ANY {
                hit.prim = block.id[mask.trailing_zeros() as usize & (LANES - 1)];
                return true;
            }
            let inv = _mm_xor_ps(inv, sign);
            record(block, met, [t, _mm_mul_ps(v, inv), _mm_mul_ps(w, inv)], hit);
            true
        }
    };
}

triangles!(triangles_sse2, add_product, sub_product, "sse2");
triangles!(triangles_fma, add_product_fma, sub_product_fma, "avx2,fma");

/// a + b c.
#[inline]
#[target_feature(enable = "sse2")]
fn add_product(a: __m128, b: __m128, c: __m128) -> __m128 {
    _mm_add_ps(a, _mm_mul_ps(b, c))
}

/// a - b c.
#[inline]
#[target_feature(enable = "sse2")]
fn sub_product(a: __m128, b: __m128, c: __m128) -> __m128 {
    _mm_sub_ps(a, _mm_mul_ps(b, c))
}

/// a + b c, rounded once.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn add_product_fma(a: __m128, b: __m128, c: __m128) -> __m128 {
    _mm_fmadd_ps(b, c, a)
}

/// a - b c, rounded once.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn sub_product_fma(a: __m128, b: __m128, c: __m128) -> __m128 {
    _mm_fnmadd_ps(b, c, a)
}

/// Store the nearest of the lanes that are hit.
#[inline]
#[target_feature(enable = "sse2")]
fn record(block: &Block, met: __m128, [t, u, v]: [__m128; 3], hit: &mut Hit) {
    let t = _mm_or_ps(_mm_and_ps(met, t), _mm_andnot_ps(met, _mm_set1_ps(f32::INFINITY)));
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
