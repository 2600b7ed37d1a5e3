//! Picture files of textures. Their texel values are checked once, when they are read.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gi_core::image_io::{Encoding, read_bitmap_within};
use gi_core::math::Rgb;
use gi_core::texture::{Bitmap, Lookup, Wrap};

use crate::budget::Budget;
use crate::document::Node;
use crate::files;
use crate::origins::Lifted;
use crate::value::MAX_NUMBER;

/// A picture file and its reading options: pictures with equal keys are read once.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct BitmapFile {
    pub(crate) path: PathBuf,
    pub(crate) raw: bool,
    pub(crate) wrap: Wrap,
    pub(crate) lookup: Lookup,
}

impl BitmapFile {
    /// Read the picture, if the budget allows the memory that the decoder takes.
    pub(crate) fn read(&self, budget: &Budget) -> Result<Bitmap, String> {
        files::refuse_pointer_file(&self.path)?;
        let encoding = if self.raw { Encoding::Raw } else { Encoding::Auto };
        let claim = RefCell::new(budget.claim(self.path.display()));
        let allow = |bytes: u64| claim.borrow_mut().set(bytes);
        let bitmap = read_bitmap_within(&self.path, encoding, self.wrap, self.lookup, &allow)?;
        check(&bitmap, &self.path)?;
        claim.into_inner().keep(bitmap.bytes())?;
        Ok(bitmap)
    }

    /// The file and its options, from a `bitmap`'s properties. (Called twice: when files are collected and when they
    /// are used.)
    pub(crate) fn of(node: Node<'_>, path: PathBuf) -> BitmapFile {
        let wrap = match node.text("wrap_mode").or(node.text("wrap_mode_u")) {
            Some("mirror") => Wrap::Mirror,
            Some("clamp" | "zero" | "one" | "black" | "white") => Wrap::Clamp,
            _ => Wrap::Repeat,
        };
        let lookup = match node.text("filter_type") {
            Some("nearest") => Lookup::Nearest,
            _ => Lookup::Bilinear,
        };
        let raw = node.bool("raw", false) || node.float_opt("gamma") == Some(1.0);
        BitmapFile { path, raw, wrap, lookup }
    }
}

/// Whether a picture's format can contain numbers outside [0, 1].
pub(crate) fn holds_floats(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    ["exr", "hdr", "pfm"].iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// Refuse a picture whose texels are too large or not finite.
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

/// The first matching texel, row by row from the top.
fn find(bitmap: &Bitmap, wanted: impl Fn(Rgb) -> bool) -> Option<(usize, usize, Rgb)> {
    let (i, texel) = bitmap.texels().enumerate().find(|(_, texel)| wanted(*texel))?;
    Some((i % bitmap.width(), i / bitmap.width(), texel))
}

/// Prepare a picture of emitted light: negative texels become zero. Also returns the first such texel, if any.
pub(crate) fn as_light(
    bitmap: &Arc<Bitmap>,
    file: &BitmapFile,
    budget: &Budget,
) -> Result<Lifted, String> {
    let negative = |t: Rgb| t.to_array().iter().any(|v| *v < 0.0);
    let some = holds_floats(&file.path) && negative(bitmap.range()[0]);
    let first = if some { find(bitmap, negative) } else { None };
    let Some((x, y, _)) = first else { return Ok((bitmap.clone(), None)) };
    budget.claim(file.path.display()).keep(bitmap.bytes())?;
    let clamped = bitmap.map(|texel| texel.map(|v| v.max(0.0)));
    Ok((Arc::new(clamped), Some((x, y))))
}

/// The largest number in a picture.
pub(crate) fn brightest(bitmap: &Bitmap, path: &Path) -> f32 {
    if !holds_floats(path) {
        return 1.0;
    }
    bitmap.range()[1].max().max(0.0)
}
