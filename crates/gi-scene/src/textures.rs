//! Textures: pictures, checkerboards and scaled textures.

use gi_core::math::Rgb;
use gi_core::texture::Texture;
use glam::{Affine2, Affine3A, Mat2, Vec2};

use crate::builder::Builder;
use crate::document::{Class, Meaning, Node};
use crate::texels::BitmapFile;

/// The supported plugins.
const KNOWN: [&str; 6] =
    ["bitmap", "checkerboard", "scale", "rawconstant", "mesh_attribute", "gridtexture"];

/// Largest depth of nested textures. A texture that refers to the next one twice doubles the size at each level.
const MAX_NESTING: usize = 6;

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

    /// A fraction of light (a reflectance, an opacity, a weight): like [`Builder::texture`], but clamped to [0, 1].
    pub(crate) fn share(&mut self, node: Node<'_>, name: &'static str, default: f32) -> Texture {
        let texture = self.texture(node, name, Texture::grey(default), Meaning::Factor);
        let [least, most] = self.origins.range(&texture);
        if least >= 0.0 && most <= 1.0 {
            return texture;
        }
        let span = node.place_of(name);
        match texture {
            Texture::Constant(c) => {
                node.report.warn(span, format!("`{name}` is outside [0, 1]: clamped"));
                Texture::Constant(c.map(|v| v.clamp(0.0, 1.0)))
            }
            texture => {
                let message =
                    format!("the texture of `{name}` is outside [0, 1]: {least} to {most}");
                node.report.warn(span, message);
                texture
            }
        }
    }

    /// A fraction of which one channel is used: an opacity, a weight, a roughness.
    pub(crate) fn one_channel_share(
        &mut self,
        node: Node<'_>,
        name: &'static str,
        default: f32,
    ) -> Texture {
        one_channel(node, self.share(node, name, default))
    }

    /// Emitted light that may vary over a surface; negative texels count as zero.
    pub(crate) fn light_texture(&mut self, node: Node<'_>, name: &'static str) -> Texture {
        let white = Texture::Constant(Rgb::WHITE);
        let mut texture = self.texture(node, name, white.clone(), Meaning::Light);
        self.lift_texels(node, &mut texture);
        let [least, most] = self.origins.range(&texture);
        let fine =
            node.check_light(name, Rgb::grey(least)) && node.check_light(name, Rgb::grey(most));
        if fine { texture } else { white }
    }

    fn lift_texels(&mut self, node: Node<'_>, texture: &mut Texture) {
        match texture {
            Texture::Constant(_) => {}
            Texture::Checkerboard { color0, color1, .. } => {
                self.lift_texels(node, color0);
                self.lift_texels(node, color1);
            }
            Texture::Grid { squares, lines, .. } => {
                self.lift_texels(node, squares);
                self.lift_texels(node, lines);
            }
            Texture::Bitmap { bitmap, .. } => {
                let Some(file) = self.origins.bitmap_file(bitmap).cloned() else { return };
                let (lifted, first) = self.origins.as_light(bitmap, &file, node.report);
                if let Some(at) = first {
                    warn_negative(node, &file, at);
                    *bitmap = lifted;
                }
            }
        }
    }

    /// A `<texture>`; `None` if an error was reported.
    pub(crate) fn texture_object(&mut self, node: Node<'_>, depth: usize) -> Option<Texture> {
        if depth > MAX_NESTING {
            node.error("textures are nested too deeply", "");
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
            "gridtexture" => Some(Texture::Grid {
                squares: Box::new(nested(self, "color0", 0.2)?),
                lines: Box::new(nested(self, "color1", 0.4)?),
                half_width: node.within("line_width", 0.01, 0.0..=0.5),
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
            "mesh_attribute" => self.attribute_texture(node),
            "rawconstant" => {
                let value = node.raw("value");
                if value.is_none() {
                    node.error("`rawconstant` without a `value`", "expected one or three numbers");
                }
                value.map(Texture::Constant)
            }
            _ => {
                node.unknown_plugin(&KNOWN);
                None
            }
        }
    }

    fn bitmap(&mut self, node: Node<'_>) -> Option<Texture> {
        node.ignore(&["filename", "max_anisotropy", "cache", "format", "accel"]);
        note_wrapping(node);
        note_gamma(node);
        if let Some(channel) = node.text("channel") {
            let message =
                format!("`channel` is ignored: all channels are read, not only `{channel}`");
            node.report.warn(node.span_of("channel"), message);
        }
        let bitmap = self.assets.bitmap(node.id)?;
        self.origins.note_bitmap(&bitmap, self.assets.bitmap_file(node.id)?);
        let texture = Texture::Bitmap { bitmap, to_uv: to_uv(node), scale: Rgb::WHITE };
        let is_inverted = node.doc.is_pbrt && node.bool("invert", false);
        if !is_inverted {
            return Some(texture);
        }
        let scale = Rgb::grey(node.float("scale", 1.0));
        Some(self.inverted(node, texture.scaled(scale)))
    }
}

/// A texture of which one channel is used. Mitsuba 2 and 3 swap the colours of a checkerboard there.
pub(crate) fn one_channel(node: Node<'_>, texture: Texture) -> Texture {
    if node.doc.version >= 2 && !node.doc.is_pbrt { swapped(texture) } else { texture }
}

/// The texture with the colours of its checkerboards swapped.
pub(crate) fn swapped(texture: Texture) -> Texture {
    match texture {
        Texture::Checkerboard { color0, color1, to_uv } => Texture::Checkerboard {
            color0: Box::new(swapped(*color1)),
            color1: Box::new(swapped(*color0)),
            to_uv,
        },
        other => other,
    }
}

/// Warn if a picture's gamma is not supported. (1 means linear; negative means that the file decides.)
pub(crate) fn note_gamma(node: Node<'_>) {
    if let Some(gamma) = node.float_opt("gamma").filter(|g| *g != 1.0 && *g > 0.0) {
        let message = format!("gamma {gamma} is read as the sRGB curve");
        node.report.warn(node.span_of("gamma"), message);
    }
}

/// Warn about wrap modes that are not supported.
fn note_wrapping(node: Node<'_>) {
    let modes = ["wrap_mode", "wrap_mode_u", "wrap_mode_v"].map(|name| (name, node.text(name)));
    for (name, mode) in modes {
        if let Some(mode @ ("zero" | "one" | "black" | "white")) = mode {
            let message = format!("wrap mode `{mode}` is read as `clamp`");
            node.report.warn(node.span_of(name), message);
        }
    }
    let [(_, both), (_, u), (name, v)] = modes;
    if v.is_some() && v != both.or(u).or(Some("repeat")) {
        let message = "a different wrap mode along v is ignored: that of u is used for both";
        node.report.warn(node.span_of(name), message);
    }
}

/// Warn about negative texels in a picture of light.
pub(crate) fn warn_negative(node: Node<'_>, file: &BitmapFile, (x, y): (usize, usize)) {
    let path = file.path.display();
    let message = format!("`{path}`: texel ({x}, {y}) and maybe others are negative: set to zero");
    node.warn(message);
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
