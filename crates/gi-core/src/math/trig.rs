//! Sine and cosine without the range reduction of the standard library, which costs more than the polynomials.

use std::f32::consts::FRAC_PI_2;

/// Sine and cosine of an angle of at most an eighth of a turn, in radians; error below 1e-7 (polynomials of Cephes).
#[inline]
pub fn sin_cos_eighth(x: f32) -> (f32, f32) {
    let z = x * x;
    let sin = ((-1.951_529_6e-4 * z + 8.332_161e-3) * z - 1.666_665_5e-1) * z * x + x;
    let cos = ((2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z - 0.5 * z + 1.0;
    (sin, cos)
}

/// Sine and cosine of `x` turns, for x from 0 to 1.
#[inline]
pub fn sin_cos_turns(x: f32) -> (f32, f32) {
    // The nearest quarter turn, and the angle from there.
    let quarter = (4.0 * x + 0.5) as i32;
    let (sin, cos) = sin_cos_eighth((4.0 * x - quarter as f32) * FRAC_PI_2);
    let (sin, cos) = if quarter & 1 == 0 { (sin, cos) } else { (cos, -sin) };
    if quarter & 2 == 0 { (sin, cos) } else { (-sin, -cos) }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn sines_and_cosines_are_accurate_all_round() {
        for i in 0..=100_000 {
            let x = i as f32 / 100_000.0;
            let (sin, cos) = sin_cos_turns(x);
            let (exact_sin, exact_cos) = (f64::from(x) * TAU).sin_cos();
            let error = (f64::from(sin) - exact_sin).abs().max((f64::from(cos) - exact_cos).abs());
            assert!(error < 2e-7, "{x}: {sin}, {cos}");
        }
    }
}
