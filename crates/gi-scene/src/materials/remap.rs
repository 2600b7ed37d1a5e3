//! pbrt's maps from a roughness to the width of the facets, and inverted textures.

use std::sync::Arc;

use gi_core::math::Rgb;
use gi_core::texture::Texture;

use crate::builder::Builder;
use crate::document::Node;

/// pbrt-v4: the square root.
fn version_4(roughness: f32) -> f32 {
    roughness.max(0.0).sqrt()
}

/// pbrt-v3: a polynomial of the logarithm.
fn version_3(roughness: f32) -> f32 {
    let x = roughness.max(1e-3).ln();
    1.621_42 + x * (0.819_955 + x * (0.173_4 + x * (0.017_120_1 + x * 0.000_640_711)))
}

impl Builder<'_> {
    /// The facets' width that a scene's roughness means: itself, unless the material asks for one of pbrt's maps.
    pub(super) fn remapped(&mut self, node: Node<'_>, alpha: Texture) -> Texture {
        match node.text("remap") {
            Some("pbrt-v4") => self.map_texture(node, alpha, version_4),
            Some("pbrt-v3") => self.map_texture(node, alpha, version_3),
            _ => alpha,
        }
    }

    /// One minus a texture, at least zero.
    pub(crate) fn inverted(&mut self, node: Node<'_>, texture: Texture) -> Texture {
        self.map_texture(node, texture, |v| (1.0 - v).max(0.0))
    }

    fn map_texture(&mut self, node: Node<'_>, texture: Texture, map: fn(f32) -> f32) -> Texture {
        match texture {
            Texture::Constant(c) => Texture::Constant(c.map(map)),
            Texture::Checkerboard { color0, color1, to_uv } => Texture::Checkerboard {
                color0: Box::new(self.map_texture(node, *color0, map)),
                color1: Box::new(self.map_texture(node, *color1, map)),
                to_uv,
            },
            Texture::Grid { squares, lines, half_width, to_uv } => Texture::Grid {
                squares: Box::new(self.map_texture(node, *squares, map)),
                lines: Box::new(self.map_texture(node, *lines, map)),
                half_width,
                to_uv,
            },
            Texture::Bitmap { bitmap, to_uv, scale } => {
                let (w, h) = (bitmap.width(), bitmap.height());
                let claim = node.report.budget.claim("changed pictures");
                if let Err(why) = claim.keep((w * h * size_of::<Rgb>()) as u64) {
                    node.error(why, "");
                    return Texture::grey(0.5);
                }
                let bitmap = Arc::new(bitmap.map(|texel| (texel * scale).map(map)));
                Texture::Bitmap { bitmap, to_uv, scale: Rgb::WHITE }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_maps_rise() {
        assert_eq!(version_4(0.25), 0.5);
        let steps: Vec<f32> = (1..=100).map(|k| version_3(k as f32 / 100.0)).collect();
        assert!(steps.is_sorted(), "{steps:?}");
        assert!((version_3(1.0) - 1.62142).abs() < 1e-6 && version_3(0.0) > 0.0);
    }
}
