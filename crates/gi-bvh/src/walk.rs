//! Values that a kernel computes once per ray.

use crate::ray::Ray;

/// Smaller direction components are replaced by this, so that their reciprocal stays finite.
pub(super) const SMALLEST_STEP: f32 = 1e-18;

/// The ray's reciprocal direction, octant, and the shear of the watertight triangle test \[Woop13\].
pub(super) struct Walk {
    pub inv: [f32; 3],
    /// 1 if the ray runs toward smaller coordinates.
    pub negative: [usize; 3],
    /// Bit position of this ray's octant in [`Node::order`](super::layout::Node::order).
    pub order_shift: u32,
    /// Axes permuted so that the last one is the main direction of the ray.
    pub axes: [usize; 3],
    /// The shear that maps the ray to (0, 0, 1) in the permuted axes.
    pub shear: [f32; 3],
}

impl Walk {
    #[inline(always)]
    pub(super) fn new(ray: &Ray) -> Self {
        let d = ray.d.to_array();
        let inv = d.map(reciprocal);
        // Take signs from the reciprocal's bits: -0.0 must choose the same side everywhere.
        let negative = inv.map(|x| (x.to_bits() >> 31) as usize);
        let a = d.map(f32::abs);
        let larger = usize::from(a[0] > a[1])
            | usize::from(a[1] > a[2]) << 1
            | usize::from(a[2] > a[0]) << 2;
        let [kx, ky, kz] = main_axes(larger);
        let sz = 1.0 / d[kz];
        Walk {
            inv,
            negative,
            order_shift: 3 * (negative[0] | negative[1] << 1 | negative[2] << 2) as u32,
            axes: [kx, ky, kz],
            shear: [d[kx] * sz, d[ky] * sz, sz],
        }
    }
}

#[inline(always)]
fn reciprocal(x: f32) -> f32 {
    if x.abs() < SMALLEST_STEP { (1.0 / SMALLEST_STEP).copysign(x) } else { 1.0 / x }
}

/// The axes in cyclic order, with the largest component of the direction last. Bit k of `larger`: component k is larger
/// than the next. It is a table because directions are random, so branches on them are mispredicted.
#[inline(always)]
pub(super) fn main_axes(larger: usize) -> [usize; 3] {
    const X: [usize; 3] = [1, 2, 0];
    const Y: [usize; 3] = [2, 0, 1];
    const Z: [usize; 3] = [0, 1, 2];
    const LAST: [[usize; 3]; 8] = [Z, X, Y, X, Z, Z, Y, Z];
    LAST[larger & 7]
}
