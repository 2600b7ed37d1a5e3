//! Vectors come from `glam`. This module adds what a renderer needs: radiance, orthonormal frames, boxes.

mod cone;
mod frame;
mod rgb;
mod trig;

pub use cone::Cone;
pub use frame::Frame;
pub use gi_bvh::Bounds;
pub use rgb::Rgb;
pub use trig::{sin_cos_eighth, sin_cos_turns};

/// 1 / pi.
pub const INV_PI: f32 = std::f32::consts::FRAC_1_PI;

/// The square of a number.
#[inline]
pub fn sqr(x: f32) -> f32 {
    x * x
}

/// 1 - cos of an angle in radians, exact for small angles too.
#[inline]
pub fn one_minus_cos(angle: f32) -> f32 {
    2.0 * sqr((0.5 * angle).sin())
}

/// Square root that treats negative rounding errors as zero.
#[inline]
pub fn safe_sqrt(x: f32) -> f32 {
    x.max(0.0).sqrt()
}

/// The middle one of some values, the upper of the two if their number is even; `None` of none.
pub fn median(values: impl Iterator<Item = f32>) -> Option<f32> {
    let mut values: Vec<f32> = values.collect();
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f32::total_cmp).1)
}
