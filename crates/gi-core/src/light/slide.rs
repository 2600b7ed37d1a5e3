//! The picture in front of a spot.

use glam::{Mat3, Vec2, Vec3};

use crate::math::Rgb;
use crate::texture::Texture;

/// The picture in front of a spot: a factor on its intensity.
#[derive(Clone, Debug)]
pub struct Slide {
    texture: Texture,
    /// From world directions to those in which the picture stands at z = 1 over [-tan, tan]^2 of the cutoff.
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
