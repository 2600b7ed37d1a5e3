//! Textures: the value of a material parameter at a point of a surface.

mod bitmap;

use glam::{Affine2, Vec2};

use crate::math::Rgb;
pub use bitmap::{Bitmap, Lookup, Texels, Wrap, srgb_to_linear};
use std::sync::Arc;

/// A colour or number that may vary over a surface.
#[derive(Clone, Debug)]
pub enum Texture {
    /// The same value everywhere.
    Constant(Rgb),
    /// A picture.
    Bitmap {
        /// Texels, shared between the materials that use them.
        bitmap: Arc<Bitmap>,
        /// From surface to texture coordinates.
        to_uv: Affine2,
        /// Factor on the texels.
        scale: Rgb,
    },
    /// Alternating squares, four per unit square of texture coordinates (two by two).
    Checkerboard {
        /// Squares that touch the origin.
        color0: Box<Texture>,
        /// The other squares.
        color1: Box<Texture>,
        /// From surface to texture coordinates.
        to_uv: Affine2,
    },
    /// Lines along the borders of the unit squares of texture coordinates.
    Grid {
        /// The squares.
        squares: Box<Texture>,
        /// The lines.
        lines: Box<Texture>,
        /// Half the width of a line, in texture coordinates.
        half_width: f32,
        /// From surface to texture coordinates.
        to_uv: Affine2,
    },
}

impl Texture {
    /// A grey constant.
    pub fn grey(v: f32) -> Self {
        Texture::Constant(Rgb::grey(v))
    }

    /// The value at surface coordinates `uv`.
    #[inline]
    pub fn eval(&self, uv: Vec2) -> Rgb {
        match self {
            Texture::Constant(value) => *value,
            Texture::Bitmap { bitmap, to_uv, scale } => {
                bitmap.eval(to_uv.transform_point2(uv)) * *scale
            }
            Texture::Checkerboard { color0, color1, to_uv } => {
                let p = to_uv.transform_point2(uv);
                let half = |x: f32| (x - x.floor()) >= 0.5;
                if half(p.x) == half(p.y) { color0.eval(uv) } else { color1.eval(uv) }
            }
            Texture::Grid { squares, lines, half_width, to_uv } => {
                let p = to_uv.transform_point2(uv);
                let to_line = (p - p.round()).abs().min_element();
                if to_line < *half_width { lines.eval(uv) } else { squares.eval(uv) }
            }
        }
    }

    /// The value as one number: the luminance, which is the number itself for greys.
    #[inline]
    pub fn scalar(&self, uv: Vec2) -> f32 {
        match self {
            Texture::Constant(value) if value.r == value.g && value.g == value.b => value.r,
            _ => self.eval(uv).luminance(),
        }
    }

    /// Derivatives of [`Texture::scalar`] along u and v, for bump mapping.
    pub fn scalar_gradient(&self, uv: Vec2) -> Vec2 {
        match self {
            Texture::Constant(_) => Vec2::ZERO,
            Texture::Bitmap { bitmap, to_uv, scale } => {
                let slopes = bitmap.gradient(to_uv.transform_point2(uv));
                let [du, dv] = slopes.map(|slope| (slope * *scale).luminance());
                to_uv.matrix2.transpose() * Vec2::new(du, dv)
            }
            Texture::Checkerboard { .. } | Texture::Grid { .. } => {
                const STEP: f32 = 1e-3;
                let slope = |axis: Vec2| {
                    (self.scalar(uv + axis * STEP) - self.scalar(uv - axis * STEP)) / (2.0 * STEP)
                };
                Vec2::new(slope(Vec2::X), slope(Vec2::Y))
            }
        }
    }

    /// Mean over the unit square of texture coordinates; exact for constants, from the texels for pictures.
    pub fn mean(&self) -> Rgb {
        match self {
            Texture::Constant(value) => *value,
            Texture::Bitmap { bitmap, scale, .. } => bitmap.mean() * *scale,
            Texture::Checkerboard { color0, color1, .. } => (color0.mean() + color1.mean()) * 0.5,
            Texture::Grid { squares, lines, half_width, .. } => {
                let side = 1.0 - 2.0 * half_width.clamp(0.0, 0.5);
                lines.mean().lerp(squares.mean(), side * side)
            }
        }
    }

    /// Multiply every value by `factor`.
    pub fn scaled(self, factor: Rgb) -> Self {
        match self {
            Texture::Constant(value) => Texture::Constant(value * factor),
            Texture::Bitmap { bitmap, to_uv, scale } => {
                Texture::Bitmap { bitmap, to_uv, scale: scale * factor }
            }
            Texture::Checkerboard { color0, color1, to_uv } => Texture::Checkerboard {
                color0: Box::new(color0.scaled(factor)),
                color1: Box::new(color1.scaled(factor)),
                to_uv,
            },
            Texture::Grid { squares, lines, half_width, to_uv } => Texture::Grid {
                squares: Box::new(squares.scaled(factor)),
                lines: Box::new(lines.scaled(factor)),
                half_width,
                to_uv,
            },
        }
    }

    /// Whether the value is the same everywhere.
    pub fn is_constant(&self) -> bool {
        matches!(self, Texture::Constant(_))
    }

    /// Whether the value is zero everywhere.
    pub fn is_black(&self) -> bool {
        matches!(self, Texture::Constant(value) if value.is_black())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_has_lines_around_whole_coordinates() {
        let (squares, lines) = (Box::new(Texture::grey(0.2)), Box::new(Texture::grey(0.4)));
        let to_uv = Affine2::from_scale(Vec2::splat(2.0));
        let grid = Texture::Grid { squares, lines, half_width: 0.1, to_uv };
        let at = |x: f32, y: f32| grid.eval(Vec2::new(x, y)).r;
        assert_eq!([at(0.02, 0.2), at(0.2, 0.48), at(-0.04, 0.3)], [0.4; 3]);
        assert_eq!([at(0.06, 0.2), at(0.25, 0.25), at(-0.3, -0.2)], [0.2; 3]);
        // Mean over one square, by points in the middle of small cells.
        let n = 200;
        let point = |i: usize| 0.5 * (i as f32 + 0.5) / n as f32;
        let sum: f64 = (0..n * n).map(|k| f64::from(at(point(k % n), point(k / n)))).sum();
        assert!((f64::from(grid.mean().r) - sum / (n * n) as f64).abs() < 1e-4);
        assert_eq!(grid.scaled(Rgb::grey(2.0)).eval(Vec2::ZERO).r, 0.8);
    }
}
