//! A picture at infinity.

use std::f32::consts::PI;

use glam::{Mat3, Vec2, Vec3};

use super::distribution::Grid;
use crate::math::{INV_PI, Rgb, safe_sqrt, sin_cos_turns};
use crate::texture::Bitmap;

/// An environment map, prepared for sampling.
#[derive(Clone, Debug)]
pub struct Environment {
    image: Bitmap,
    scale: f32,
    to_world: Mat3,
    to_local: Mat3,
    density: Grid,
    /// Integral of the luminance over all directions.
    flux: f32,
}

impl Environment {
    /// Prepare `image` (u = atan2(x, -z) / 2 pi, v = acos(y) / pi of local directions); `to_world` is a rotation.
    pub(crate) fn new(image: Bitmap, scale: f32, to_world: Mat3) -> Self {
        let (w, h) = (image.width(), image.height());
        let luminance: Vec<f32> = image.texels().map(|texel| texel.luminance().max(0.0)).collect();
        let at = |x: usize, y: usize| luminance[y * w + x];
        let density = density(&luminance, w, h);
        let flux =
            (0..h).map(|y| row_measure(y, h) * (0..w).map(|x| at(x, y)).sum::<f32>()).sum::<f32>();
        let flux = scale * flux * 2.0 * PI / w as f32;
        Environment { image, scale, to_world, to_local: to_world.transpose(), density, flux }
    }

    /// Radiance from the unit direction `d`, which points toward where the light comes from.
    #[inline]
    pub fn radiance(&self, d: Vec3) -> Rgb {
        // As in Mitsuba: the first and the last row are at the poles, and columns are at the centres of their cells.
        let [u, v] = self.to_uv(d);
        let h = self.image.height() as f32;
        self.image.eval(Vec2::new(u, (v * (h - 1.0) + 0.5) / h)) * self.scale
    }

    /// A direction and its density per solid angle.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Option<(Vec3, f32)> {
        let ([u, v], pdf) = self.density.sample(u)?;
        let (sin_theta, cos_theta) = sin_cos_turns(0.5 * v);
        let (sin_phi, cos_phi) = sin_cos_turns(u);
        let local = Vec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta);
        (sin_theta > 0.0).then(|| (self.to_world * local, pdf / (2.0 * PI * PI * sin_theta)))
    }

    /// Density per solid angle with which [`Environment::sample`] returns `d`.
    #[inline]
    pub fn pdf_w(&self, d: Vec3) -> f32 {
        let uv = self.to_uv(d);
        let cos = (self.to_local * d).y;
        let sin_theta = safe_sqrt(1.0 - cos * cos);
        if sin_theta > 0.0 { self.density.pdf(uv) / (2.0 * PI * PI * sin_theta) } else { 0.0 }
    }

    /// Integral of the luminance over all directions.
    pub(crate) fn flux(&self) -> f32 {
        self.flux
    }

    #[inline]
    fn to_uv(&self, d: Vec3) -> [f32; 2] {
        let l = self.to_local * d;
        let u = l.x.atan2(-l.z) * 0.5 * INV_PI;
        [if u < 0.0 { u + 1.0 } else { u }, l.y.clamp(-1.0, 1.0).acos() * INV_PI]
    }
}

/// A density over the unit square in proportion to the luminance around each cell. Cells are as large as the picture
/// allows: a table that fits into a cache is more useful than the last per cent of variance.
fn density(luminance: &[f32], w: usize, h: usize) -> Grid {
    /// Largest allowed ratio of a cell's brightest texel to the cell's mean, averaged over the picture.
    const CONTRAST: f32 = 1.15;
    let at = |x: usize, y: usize| luminance[y * w + x];
    // Interpolation, and rows that are offset by up to half a row, use the eight neighbours: if one of them emits
    // light, the cell may too.
    let around = |x: usize, y: usize| {
        let columns = [(x + w - 1) % w, x, (x + 1) % w];
        let rows = [y.saturating_sub(1), y, (y + 1).min(h - 1)];
        let sum: f32 = rows.iter().flat_map(|&y| columns.map(|x| at(x, y))).sum();
        0.5 * at(x, y) + 0.5 * sum / 9.0
    };
    let texels: Vec<f32> =
        (0..w * h).map(|i| row_measure(i / w, h) * around(i % w, i / w)).collect();
    for side in [16, 8, 4, 2] {
        if !w.is_multiple_of(side) || !h.is_multiple_of(side) || w / side < 64 {
            continue;
        }
        let cells = (w / side) * (h / side);
        let (mut sums, mut peaks) = (vec![0.0f32; cells], vec![0.0f32; cells]);
        for (i, &v) in texels.iter().enumerate() {
            let cell = (i / w / side) * (w / side) + i % w / side;
            sums[cell] += v;
            peaks[cell] = peaks[cell].max(v);
        }
        let peak: f32 = peaks.iter().sum::<f32>() * (side * side) as f32;
        if peak <= CONTRAST * sums.iter().sum::<f32>() {
            return Grid::new(w / side, &sums);
        }
    }
    Grid::new(w, &texels)
}

/// Difference of the cosines at a row's borders: half of it is the row's fraction of the sphere.
fn row_measure(y: usize, h: usize) -> f32 {
    let cos = |y: usize| (PI * y as f32 / h as f32).cos();
    cos(y) - cos(y + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::{Lookup, Texels, Wrap};

    #[test]
    fn the_zenith_does_not_mix_with_the_nadir() {
        let texels = (0..4).flat_map(|y| [Rgb::grey(if y == 0 { 8.0 } else { 0.0 }); 8]).collect();
        let image = Bitmap::new(8, 4, Texels::Float(texels), Wrap::Repeat, Lookup::Bilinear);
        let map = Environment::new(image, 1.0, Mat3::IDENTITY);
        assert_eq!(map.radiance(Vec3::Y).r, 8.0);
        assert_eq!(map.radiance(-Vec3::Y).r, 0.0);
    }
}
