//! Textures: pictures, checkerboards, scaled textures.

use std::path::PathBuf;

use gi_core::image_io::{Encoding, read_bitmap};
use gi_core::math::Rgb;
use gi_core::texture::{Bitmap, Lookup, Texture, Wrap};
use glam::{Affine2, Affine3A, Mat2, Vec2};

use crate::build::Builder;
use crate::document::{Class, Meaning, Node};

/// How deep textures may be nested. They are trees, and one that refers to the next twice doubles each time.
const MAX_NESTING: usize = 6;

/// A picture file and how it is read: pictures with equal keys are read once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct BitmapFile {
    pub(crate) path: PathBuf,
    pub(crate) raw: bool,
    pub(crate) wrap: Wrap,
    pub(crate) lookup: Lookup,
}

impl BitmapFile {
    /// Read the picture.
    pub(crate) fn read(&self) -> Result<Bitmap, String> {
        let encoding = if self.raw { Encoding::Raw } else { Encoding::Auto };
        read_bitmap(&self.path, encoding, self.wrap, self.lookup)
    }

    /// How a `bitmap` says that its file is to be read. (Asked twice: when files are gathered and when used.)
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

impl Builder<'_> {
    /// A parameter that may vary over the surface: a number, a colour or a texture.
    pub(crate) fn texture(
        &mut self,
        node: Node<'_>,
        name: &'static str,
        default: Texture,
        meaning: Meaning,
    ) -> Texture {
        if let Some(child) = node.child_if(name, |n| n.class() == Class::Texture) {
            return self.texture_object(child, 0).unwrap_or(default);
        }
        node.color(name, meaning).map_or(default, Texture::Constant)
    }

    /// A reflectance: as [`Builder::texture`], and not above one.
    pub(crate) fn reflectance(
        &mut self,
        node: Node<'_>,
        name: &'static str,
        default: f32,
    ) -> Texture {
        match self.texture(node, name, Texture::grey(default), Meaning::Factor) {
            Texture::Constant(c) if c.max() > 1.0 || c.to_array().iter().any(|v| *v < 0.0) => {
                let message = format!("`{name}` is outside of [0, 1]: clamped");
                node.report.warn(node.span_of(name), message);
                Texture::Constant(c.map(|v| v.clamp(0.0, 1.0)))
            }
            texture => texture,
        }
    }

    /// A `<texture>`; `None` after a reported problem.
    pub(crate) fn texture_object(&mut self, node: Node<'_>, depth: usize) -> Option<Texture> {
        const KNOWN: [&str; 3] = ["bitmap", "checkerboard", "scale"];
        if depth > MAX_NESTING {
            node.error("textures are nested too deep", "");
            return None;
        }
        let nested = |builder: &mut Self, name: &'static str, default: f32| match node
            .child_if(name, |n| n.class() == Class::Texture)
        {
            Some(child) => builder.texture_object(child, depth + 1),
            None => {
                let color = node.color(name, Meaning::Factor).unwrap_or(Rgb::grey(default));
                Some(Texture::Constant(color))
            }
        };
        match node.plugin() {
            "bitmap" => self.bitmap(node),
            "checkerboard" => Some(Texture::Checkerboard {
                color0: Box::new(nested(self, "color0", 0.4)?),
                color1: Box::new(nested(self, "color1", 0.2)?),
                to_uv: to_uv(node),
            }),
            "scale" => {
                let factor = node.color("scale", Meaning::Factor).unwrap_or(Rgb::WHITE);
                let inner = match node.children(Class::Texture).first() {
                    Some(child) => self.texture_object(*child, depth + 1)?,
                    None => Texture::Constant(node.color("value", Meaning::Factor)?),
                };
                Some(inner.scaled(factor))
            }
            _ => {
                node.unknown_plugin(&KNOWN);
                None
            }
        }
    }

    fn bitmap(&mut self, node: Node<'_>) -> Option<Texture> {
        node.ignore(&["filename", "max_anisotropy", "cache", "channel", "format", "accel"]);
        node.ignore(&["wrap_mode_v", "wrap_mode_u"]);
        if let Some(gamma) = node.float_opt("gamma").filter(|g| *g != 1.0 && *g > 0.0) {
            let message = format!("gamma {gamma} is read as the sRGB curve");
            node.report.warn(node.span_of("gamma"), message);
        }
        let bitmap = self.assets.bitmap(node.id)?;
        self.origins.note_bitmap(&bitmap, self.assets.bitmap_file(node.id)?);
        Some(Texture::Bitmap { bitmap, to_uv: to_uv(node), scale: Rgb::WHITE })
    }
}

/// From surface to texture coordinates: `to_uv`, or the scales and offsets of Mitsuba 0.6.
fn to_uv(node: Node<'_>) -> Affine2 {
    let (both, offset) = (node.float("uvscale", 1.0), node.float("uvoffset", 0.0));
    let scale = Vec2::new(node.float("uscale", both), node.float("vscale", both));
    let offset = Vec2::new(node.float("uoffset", offset), node.float("voffset", offset));
    let old = Affine2::from_mat2_translation(Mat2::from_diagonal(scale), offset);
    old * flatten(&node.transform("to_uv"))
}

/// The part of a transform that acts on the plane z = 0.
fn flatten(m: &Affine3A) -> Affine2 {
    Affine2::from_cols(
        Vec2::new(m.x_axis.x, m.x_axis.y),
        Vec2::new(m.y_axis.x, m.y_axis.y),
        Vec2::new(m.translation.x, m.translation.y),
    )
}
