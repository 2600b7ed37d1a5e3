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

use glam::{IVec3, Vec3};

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

/// The largest integer up to `x`. Numbers outside the range of the type give its nearest end, and NaN gives 0. It is faster than
/// [`f32::floor`], which is a function call if the compiler may use only SSE2.
#[inline]
pub fn floor_i32(x: f32) -> i32 {
    let toward_zero = x as i32;
    toward_zero.saturating_sub(i32::from(toward_zero as f32 > x))
}

/// [`floor_i32`] of each coordinate.
#[inline]
pub fn floor_ivec3(v: Vec3) -> IVec3 {
    IVec3::new(floor_i32(v.x), floor_i32(v.y), floor_i32(v.z))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_below_a_number_agree_with_the_standard_library() {
        let numbers = [0.0, -0.0, 0.5, -0.5, 1.0, -1.0, 7.999_999_5, -8.000_001, 1e9, -1e9];
        let far = [3e9, -3e9, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1e-40, -1e-40];
        for x in numbers.into_iter().chain(far) {
            assert_eq!(floor_i32(x), x.floor() as i32, "{x}");
        }
    }
}
