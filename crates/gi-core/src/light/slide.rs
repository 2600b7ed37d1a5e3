//! The picture in front of a spot.

use glam::{Mat3, Vec2, Vec3};

use crate::math::Rgb;
use crate::texture::Texture;

/// The picture in front of a spot: a factor on its intensity.
#[derive(Clone, Debug)]
pub struct Slide {
    texture: Texture,
    /// From world directions to the directions in which the picture is at z = 1 over [-tan, tan]^2 of the cutoff.
    to_local: Mat3,
    tan_cutoff: f32,
}

impl Slide {
    /// A picture whose u, v and axis point along `axes`.
    pub(super) fn new(texture: Texture, axes: [Vec3; 3], cutoff: f32) -> Self {
        let [x, y, z] = axes.map(|axis| axis.normalize_or(Vec3::Z));
        Slide { texture, to_local: Mat3::from_cols(x, y, z).inverse(), tan_cutoff: cutoff.tan() }
    }

    /// The factor along world direction `d`.
    pub fn along(&self, d: Vec3) -> Rgb {
        let local = self.to_local * d;
        let at = Vec2::new(local.x, local.y) / (local.z * self.tan_cutoff);
        self.texture.eval(Vec2::splat(0.5) + 0.5 * at)
    }

    /// Mean of the picture.
    pub(super) fn mean(&self) -> Rgb {
        self.texture.mean()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Affine2;

    use super::*;
    use crate::texture::{Bitmap, Lookup, Texels, Wrap};

    /// Dark on the left, bright on the right; the lower row is half as bright.
    fn picture() -> Texture {
        let texels = [0.0, 1.0, 0.0, 0.5].map(Rgb::grey).to_vec();
        let bitmap = Bitmap::new(2, 2, Texels::Float(texels), Wrap::Clamp, Lookup::Nearest);
        Texture::Bitmap { bitmap: Arc::new(bitmap), to_uv: Affine2::IDENTITY, scale: Rgb::WHITE }
    }

    #[test]
    fn the_picture_covers_exactly_the_cone() {
        let cutoff = 0.5f32;
        let slide = Slide::new(picture(), [Vec3::X, Vec3::Y, Vec3::Z], cutoff);
        let along = |x: f32, y: f32| slide.along(Vec3::new(x, y, 1.0).normalize()).r;
        // v grows along y, and the first row of a picture is at v = 0.
        assert_eq!([along(-0.1, -0.1), along(0.1, -0.1), along(0.1, 0.1)], [0.0, 1.0, 0.5]);
        let edge = cutoff.tan();
        assert_eq!([along(0.99 * edge, -0.1), along(-0.99 * edge, -0.1)], [1.0, 0.0]);
        assert_eq!(slide.mean(), Rgb::grey(0.375));
    }

    #[test]
    fn a_mirrored_and_turned_spot_shows_a_mirrored_and_turned_picture() {
        let slide = Slide::new(picture(), [-2.0 * Vec3::Z, Vec3::Y, Vec3::X], 0.5);
        assert_eq!(slide.along(Vec3::new(1.0, -0.1, -0.1).normalize()).r, 1.0);
        assert_eq!(slide.along(Vec3::new(1.0, -0.1, 0.1).normalize()).r, 0.0);
    }
}
