//! Writes parameters that may be textures.

use gi_core::image_io::{ImageFile, Layers, write_file};
use gi_core::math::Rgb;
use gi_core::texture::{Bitmap, Lookup, Texture, Wrap};
use glam::{Affine2, Affine3A, Mat3, Vec2, Vec3};

use super::{Exporter, channels};
use crate::textures::swapped;

impl Exporter<'_> {
    /// Write a factor whose default is one.
    pub(super) fn factor(&mut self, name: &str, texture: &Texture) -> Result<(), String> {
        match texture {
            Texture::Constant(c) if *c == Rgb::WHITE => Ok(()),
            _ => self.texture(name, texture),
        }
    }

    /// Write a parameter of one channel: a number if it is constant, a texture otherwise.
    pub(super) fn scalar(&mut self, name: &str, texture: &Texture) -> Result<(), String> {
        match texture {
            Texture::Constant(c) => {
                let v = if c.r == c.g && c.g == c.b { c.r } else { c.luminance() };
                self.xml.value("float", name, &v.to_string());
                Ok(())
            }
            // Mitsuba 3 swaps the colours of a checkerboard here.
            _ => self.texture(name, &swapped(texture.clone())),
        }
    }

    /// Write a parameter that must be a texture.
    pub(super) fn map(&mut self, name: &str, texture: &Texture) -> Result<(), String> {
        let Texture::Constant(c) = texture else { return self.texture(name, texture) };
        // Mitsuba has no plugin for a constant texture, so write a checkerboard of one colour.
        self.xml.open("texture", &[("type", "checkerboard"), ("name", name)]);
        self.xml.value("rgb", "color0", &channels(*c));
        self.xml.value("rgb", "color1", &channels(*c));
        self.xml.close();
        Ok(())
    }

    /// Write a colour or a texture.
    pub(super) fn texture(&mut self, name: &str, texture: &Texture) -> Result<(), String> {
        match texture {
            Texture::Constant(c) => self.xml.color(name, *c),
            Texture::Checkerboard { color0, color1, to_uv } => {
                self.xml.open("texture", &[("type", "checkerboard"), ("name", name)]);
                self.texture("color0", color0)?;
                self.texture("color1", color1)?;
                self.xml.transform("to_uv", &spatial(to_uv));
                self.xml.close();
            }
            Texture::Grid { to_uv, .. } => {
                self.warn(
                    "Mitsuba 3 has no `gridtexture`: a picture of 1024 x 1024 texels replaces it",
                );
                let file = self.sampled(texture, to_uv)?;
                self.xml.open("texture", &[("type", "bitmap"), ("name", name)]);
                self.xml.value("string", "filename", &file);
                self.xml.value("boolean", "raw", "true");
                self.xml.value("string", "filter_type", "nearest");
                self.xml.transform("to_uv", &spatial(to_uv));
                self.xml.close();
            }
            Texture::Bitmap { bitmap, to_uv, scale } => {
                let origin = self.loaded.origins.bitmap_file(bitmap);
                let (file, raw) = match origin.filter(|_| *scale == Rgb::WHITE) {
                    Some(file) => (self.file_name(&file.path), file.raw),
                    None => (self.bake(bitmap, *scale)?, true),
                };
                self.xml.open("texture", &[("type", "bitmap"), ("name", name)]);
                self.xml.value("string", "filename", &file);
                if raw {
                    self.xml.value("boolean", "raw", "true");
                }
                if bitmap.lookup() == Lookup::Nearest {
                    self.xml.value("string", "filter_type", "nearest");
                }
                match bitmap.wrap() {
                    Wrap::Mirror => self.xml.value("string", "wrap_mode", "mirror"),
                    Wrap::Clamp => self.xml.value("string", "wrap_mode", "clamp"),
                    Wrap::Repeat => {}
                }
                self.xml.transform("to_uv", &spatial(to_uv));
                self.xml.close();
            }
        }
        Ok(())
    }

    /// Write the unit square of a texture's own coordinates as a picture.
    fn sampled(&mut self, texture: &Texture, to_uv: &Affine2) -> Result<String, String> {
        const SIDE: usize = 1024;
        let back = to_uv.inverse();
        let center = |i: usize| (i as f32 + 0.5) / SIDE as f32;
        let texel = |i: usize| {
            let p = Vec2::new(center(i % SIDE), center(i / SIDE));
            texture.eval(back.transform_point2(p)).to_array()
        };
        let layers = Layers::of_rgb([SIDE; 2], (0..SIDE * SIDE).map(texel));
        self.side_file("exr", |path| write_file(path, ImageFile::Exr, &layers))
    }

    /// Write a picture times a factor to a file, because Mitsuba 3 cannot multiply pictures.
    pub(super) fn bake(&mut self, bitmap: &Bitmap, scale: Rgb) -> Result<String, String> {
        let size = [bitmap.width(), bitmap.height()];
        let texel = |i: usize| (bitmap.texel(i % size[0], i / size[0]) * scale).to_array();
        let layers = Layers::of_rgb(size, (0..size[0] * size[1]).map(texel));
        self.side_file("exr", |path| write_file(path, ImageFile::Exr, &layers))
    }
}

/// A transform of texture coordinates as the 3D transform that Mitsuba expects.
fn spatial(m: &Affine2) -> Affine3A {
    let (x, y) = (m.matrix2.x_axis, m.matrix2.y_axis);
    let linear = Mat3::from_cols(x.extend(0.0), y.extend(0.0), Vec3::Z);
    Affine3A::from_mat3_translation(linear, m.translation.extend(0.0))
}
