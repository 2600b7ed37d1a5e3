//! pbrt-v4's pictures at infinity: the sphere of directions unfolded to a square, in which equal areas are equal solid
//! angles \[Clarberg08\].

use std::f32::consts::PI;

use gi_core::math::Rgb;
use gi_core::texture::{Bitmap, Lookup, Texels, Wrap};
use gi_core::warp::unfolded_sphere;
use glam::{Vec2, Vec3};

/// The memory that the resampled picture takes.
pub(crate) fn bytes(image: &Bitmap) -> u64 {
    (2 * image.width() * image.height().max(2) * size_of::<Rgb>()) as u64
}

/// The mean of the square's texels around a point: bilinear, folded at the borders.
fn lookup(image: &Bitmap, p: Vec2) -> Rgb {
    let (w, h) = (image.width(), image.height());
    let at = p * Vec2::new(w as f32, h as f32) - 0.5;
    let low = at.floor();
    let part = at - low;
    let texel = |dx: f32, dy: f32| {
        let q = (low + Vec2::new(dx, dy) + 0.5) / Vec2::new(w as f32, h as f32);
        // Beyond a border lies the direction that is folded there.
        let inside = q.clamp(Vec2::ZERO, Vec2::ONE);
        let mirrored = if q.x != inside.x { Vec2::new(inside.x, 1.0 - q.y) } else { q };
        let q = if q.y != inside.y { Vec2::new(1.0 - mirrored.x, inside.y) } else { mirrored };
        let [x, y] = [(q.x * w as f32) as usize, (q.y * h as f32) as usize];
        image.texel(x.min(w - 1), y.min(h - 1))
    };
    let top = texel(0.0, 0.0).lerp(texel(1.0, 0.0), part.x);
    top.lerp(texel(0.0, 1.0).lerp(texel(1.0, 1.0), part.x), part.y)
}

/// The same picture as latitude and longitude, whose rows go from +z to -z and whose columns start at +x.
pub(crate) fn resampled(image: &Bitmap) -> Bitmap {
    // As many columns per turn as the square has around its equator, which its inner diagonals are.
    let (width, height) = (2 * image.width(), image.height().max(2));
    let mut texels = Vec::with_capacity(width * height);
    for y in 0..height {
        let theta = PI * y as f32 / (height - 1) as f32;
        for x in 0..width {
            let phi = 2.0 * PI * (x as f32 + 0.5) / width as f32;
            let side = theta.sin();
            let d = Vec3::new(side * phi.cos(), side * phi.sin(), theta.cos());
            texels.push(lookup(image, unfolded_sphere(d)));
        }
    }
    Bitmap::new(width, height, Texels::Float(texels), Wrap::Repeat, Lookup::Bilinear)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gi_core::warp::folded_sphere;

    /// The error is that of linear interpolation: less than a texel's share of the picture's range of two.
    #[test]
    fn the_resampled_picture_has_the_same_radiance() {
        let n = 64;
        let value = |x: usize, y: usize| {
            let d = folded_sphere(Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / n as f32);
            Rgb::new(1.0 + d.x, 1.0 + d.y, 1.0 + d.z)
        };
        let texels = (0..n * n).map(|i| value(i % n, i / n)).collect();
        let square = Bitmap::new(n, n, Texels::Float(texels), Wrap::Clamp, Lookup::Bilinear);
        let flat = resampled(&square);
        let (w, h) = (flat.width(), flat.height());
        for (x, y) in (0..w).flat_map(|x| (0..h).map(move |y| (x, y))) {
            let (phi, theta) =
                (2.0 * PI * (x as f32 + 0.5) / w as f32, PI * y as f32 / (h - 1) as f32);
            let d = Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            let expected = Rgb::new(1.0 + d.x, 1.0 + d.y, 1.0 + d.z);
            let got = flat.texel(x, y);
            for (a, b) in got.to_array().into_iter().zip(expected.to_array()) {
                assert!((a - b).abs() < 2.0 / n as f32, "({x}, {y}): {got:?} is not {expected:?}");
            }
        }
    }
}
