//! The picture in front of a spot.

use glam::{Mat3, Vec2, Vec3};

use crate::math::Rgb;
use crate::texture::Texture;

/// The picture in front of a spot or a projector: a factor on its intensity.
#[derive(Clone, Debug)]
pub struct Slide {
    texture: Texture,
    /// From world directions to the directions in which the picture is at z = 1.
    to_local: Mat3,
    /// Half the extent of the picture at z = 1. For a projector, both are negative: the picture is upright and not
    /// mirrored for an eye at its place.
    half: Vec2,
    /// Cosine of the angle between the axis and the corners of a projector's window; `None` for a spot.
    corner_cos: Option<f32>,
}

impl Slide {
    /// A picture whose u, v and axis point along `axes`, within a cone; or that of a projector, within a window.
    pub(super) fn new(
        texture: Texture,
        axes: [Vec3; 3],
        cutoff: f32,
        window: Option<Vec2>,
    ) -> Self {
        let [x, y, z] = axes.map(|axis| axis.normalize_or(Vec3::Z));
        let half = window.map_or(Vec2::splat(cutoff.tan()), |half| -half);
        let corner_cos = window.map(|half| (1.0 + half.length_squared()).sqrt().recip());
        Slide { texture, to_local: Mat3::from_cols(x, y, z).inverse(), half, corner_cos }
    }

    /// The factor along world direction `d`.
    pub fn along(&self, d: Vec3) -> Rgb {
        let local = self.to_local * d;
        let at = Vec2::new(local.x, local.y) / (local.z * self.half);
        let color = || self.texture.eval(Vec2::splat(0.5) + 0.5 * at);
        let Some(corner_cos) = self.corner_cos else { return color() };
        if local.z <= 0.0 || at.abs().max_element() > 1.0 {
            return Rgb::BLACK;
        }
        // The irradiance of a plane at distance z is I cos^3 / z^2.
        color() * (corner_cos * local.length() / local.z).powi(3)
    }

    /// Mean over the cone, whose solid angle is given.
    pub(super) fn mean(&self, solid_angle: f32) -> Rgb {
        let mean = self.texture.mean();
        match self.corner_cos {
            None => mean,
            Some(cos) => mean * (4.0 * self.half.x * self.half.y * cos.powi(3) / solid_angle),
        }
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
        let slide = Slide::new(picture(), [Vec3::X, Vec3::Y, Vec3::Z], cutoff, None);
        let along = |x: f32, y: f32| slide.along(Vec3::new(x, y, 1.0).normalize()).r;
        // v grows along y, and the first row of a picture is at v = 0.
        assert_eq!([along(-0.1, -0.1), along(0.1, -0.1), along(0.1, 0.1)], [0.0, 1.0, 0.5]);
        let edge = cutoff.tan();
        assert_eq!([along(0.99 * edge, -0.1), along(-0.99 * edge, -0.1)], [1.0, 0.0]);
        assert_eq!(slide.mean(1.0), Rgb::grey(0.375));
    }

    #[test]
    fn a_mirrored_and_turned_spot_shows_a_mirrored_and_turned_picture() {
        let slide = Slide::new(picture(), [-2.0 * Vec3::Z, Vec3::Y, Vec3::X], 0.5, None);
        assert_eq!(slide.along(Vec3::new(1.0, -0.1, -0.1).normalize()).r, 1.0);
        assert_eq!(slide.along(Vec3::new(1.0, -0.1, 0.1).normalize()).r, 0.0);
    }

    #[test]
    fn a_projector_shines_evenly_on_a_plane_within_its_window() {
        let window = Vec2::new(0.6, 0.3);
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        let slide = Slide::new(Texture::grey(1.0), axes, 0.0, Some(window));
        // Irradiance of the plane z = 1 for an intensity of one toward the corners.
        let irradiance = |x: f32, y: f32| {
            let p = Vec3::new(x, y, 1.0);
            let cos = 1.0 / p.length();
            slide.along(p.normalize()).r * cos.powi(3)
        };
        let corner = (1.0 + window.length_squared()).powf(-1.5);
        for [x, y] in [[0.0, 0.0], [0.59, 0.29], [-0.3, 0.1]] {
            assert!((irradiance(x, y) / corner - 1.0).abs() < 1e-5);
        }
        assert_eq!([irradiance(0.61, 0.0), irradiance(0.0, -0.31)], [0.0; 2]);
        assert_eq!(slide.along(-Vec3::Z), Rgb::BLACK);
        let power = slide.mean(2.0) * 2.0;
        assert!((power.r / (4.0 * 0.6 * 0.3 * corner) - 1.0).abs() < 1e-5, "area times irradiance");
        // The left of the picture is on the side of +x, its top on that of +y.
        let slide = Slide::new(picture(), axes, 0.0, Some(window));
        let along = |x: f32, y: f32| slide.along(Vec3::new(x, y, 1.0).normalize()).r;
        assert_eq!(along(0.3, 0.1), 0.0);
        assert!(along(-0.3, 0.1) > along(-0.3, -0.1) && along(-0.3, -0.1) > 0.0);
    }
}
