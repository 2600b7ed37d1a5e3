//! What the numbers of textures may be; looked at once, when they are read.

use std::path::Path;
use std::sync::Arc;

use gi_core::math::Rgb;
use gi_core::texture::{Bitmap, Texels, Texture};

use crate::build::Origins;
use crate::textures::BitmapFile;
use crate::value::MAX_NUMBER;

/// Whether a picture's format can hold numbers outside of [0, 1].
fn holds_floats(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    ["exr", "hdr", "pfm"].iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// Refuse a picture with texels that no light can be computed with.
pub(crate) fn check(bitmap: &Bitmap, path: &Path) -> Result<(), String> {
    if !holds_floats(path) {
        return Ok(());
    }
    let bad = |t: Rgb| !t.to_array().iter().all(|v| v.abs() <= MAX_NUMBER);
    match find(bitmap, bad) {
        None => Ok(()),
        Some((x, y, t)) if t.is_finite() => {
            Err(format!("texel ({x}, {y}) is too large: {} {} {}, at most 1e15", t.r, t.g, t.b))
        }
        Some((x, y, t)) => Err(format!("texel ({x}, {y}) is not finite: {} {} {}", t.r, t.g, t.b)),
    }
}

/// The first texel of a kind, row by row from the top.
fn find(bitmap: &Bitmap, wanted: impl Fn(Rgb) -> bool) -> Option<(usize, usize, Rgb)> {
    let all = (0..bitmap.height()).flat_map(|y| (0..bitmap.width()).map(move |x| (x, y)));
    all.map(|(x, y)| (x, y, bitmap.texel(x, y))).find(|t| wanted(t.2))
}

/// A picture of light: texels below zero become zero. Also the first such texel, if there is one.
pub(crate) fn as_light(
    bitmap: &Arc<Bitmap>,
    file: &BitmapFile,
) -> (Arc<Bitmap>, Option<(usize, usize)>) {
    let negative = |t: Rgb| t.to_array().iter().any(|v| *v < 0.0);
    let first = if holds_floats(&file.path) { find(bitmap, negative) } else { None };
    let Some((x, y, _)) = first else { return (bitmap.clone(), None) };
    let rows = (0..bitmap.height()).flat_map(|y| (0..bitmap.width()).map(move |x| (x, y)));
    let texels = rows.map(|(x, y)| bitmap.texel(x, y).map(|v| v.max(0.0))).collect();
    let (w, h) = (bitmap.width(), bitmap.height());
    let clamped = Bitmap::new(w, h, Texels::Float(texels), file.wrap, file.lookup);
    (Arc::new(clamped), Some((x, y)))
}

/// The largest number of a picture.
pub(crate) fn brightest(bitmap: &Bitmap, path: &Path) -> f32 {
    if !holds_floats(path) {
        return 1.0;
    }
    let all = (0..bitmap.height()).flat_map(|y| (0..bitmap.width()).map(move |x| (x, y)));
    all.map(|(x, y)| bitmap.texel(x, y).max()).fold(0.0, f32::max)
}

/// Of what a texture gives, the least and the largest number.
pub(crate) fn range(texture: &Texture, origins: &Origins) -> [f32; 2] {
    let join = |a: [f32; 2], b: [f32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
    let of = |c: Rgb| c.to_array().map(|v| [v, v]).into_iter().reduce(join).expect("three numbers");
    match texture {
        Texture::Constant(c) => of(*c),
        Texture::Checkerboard { color0, color1, .. } => {
            join(range(color0, origins), range(color1, origins))
        }
        Texture::Bitmap { bitmap, scale, .. } => {
            let floats = origins.bitmap_file(bitmap).is_none_or(|f| holds_floats(&f.path));
            if !floats {
                return join([0.0, 0.0], of(*scale));
            }
            let rows = (0..bitmap.height()).flat_map(|y| (0..bitmap.width()).map(move |x| (x, y)));
            rows.map(|(x, y)| of(bitmap.texel(x, y) * *scale)).reduce(join).expect("texels")
        }
    }
}
