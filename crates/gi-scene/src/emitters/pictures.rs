//! pbrt's point lights whose intensity is a picture: `projection` and `goniometric`.

use std::f32::consts::PI;
use std::sync::Arc;

use gi_core::light::{LightSource, Window};
use gi_core::math::Rgb;
use gi_core::texture::{Bitmap, Lookup, Texels, Texture, Wrap};
use gi_core::warp;
use glam::{Affine2, Vec2, Vec3};

use super::light_color;
use crate::builder::Builder;
use crate::document::Node;

impl Builder<'_> {
    /// Light through a window, with the picture as its intensity.
    pub(super) fn projection(&mut self, node: Node<'_>) -> Option<LightSource> {
        let (picture, bitmap) = self.picture_of_light(node)?;
        let (w, h) = (bitmap.width() as f32, bitmap.height() as f32);
        // The field of view is that of the shorter side.
        let half = Vec2::new(w, h) / w.min(h) * (0.5 * node.float("fov", 90.0).to_radians()).tan();
        let unit = node.has("power").then(|| power_through(&bitmap, half));
        let cutoff = half.length().atan();
        self.pictured(node, picture, Window::Intensity(half), cutoff, unit)
    }

    /// Light in all directions, with the picture as its intensity.
    pub(super) fn goniometric(&mut self, node: Node<'_>) -> Option<LightSource> {
        let (_, bitmap) = self.picture_of_light(node)?;
        let square = self.square_picture(node, &bitmap)?;
        let unit = node.has("power").then(|| 4.0 * PI * square.mean().luminance());
        self.pictured(node, square, Window::Sphere, PI, unit)
    }

    /// A light with this picture. `unit` is the power that the picture gives for an intensity of one, if the light's
    /// power is given.
    fn pictured(
        &mut self,
        node: Node<'_>,
        picture: Texture,
        window: Window,
        cutoff: f32,
        unit: Option<f32>,
    ) -> Option<LightSource> {
        let (picture, most) = self.at_most_one(node, picture)?;
        let factor = match unit {
            Some(unit) if unit > 0.0 => node.float("power", 0.0) / unit,
            _ => 1.0,
        };
        let m = node.transform("to_world");
        Some(LightSource::Projector {
            position: node.to_world().translation.as_vec3(),
            axes: [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis].map(Vec3::from),
            intensity: light_color(node, "intensity") * (factor * most),
            cutoff,
            beam: cutoff,
            picture,
            window,
        })
    }

    /// The picture of a light; `None` if an error was reported.
    fn picture_of_light(&mut self, node: Node<'_>) -> Option<(Texture, Arc<Bitmap>)> {
        let texture = self.light_texture(node, "picture");
        match &texture {
            Texture::Bitmap { bitmap, .. } => {
                let bitmap = bitmap.clone();
                Some((texture, bitmap))
            }
            _ => None,
        }
    }

    /// The grey picture of a goniometric light, as the square of [`warp::unfolded_sphere`].
    fn square_picture(&mut self, node: Node<'_>, picture: &Bitmap) -> Option<Texture> {
        let (w, h) = (picture.width(), picture.height());
        let is_flat = node.bool("latitude_longitude", false);
        if w != h && !is_flat {
            node.error(
                format!("the light's picture has {w} x {h} pixels"),
                "expected a square: pbrt-v4 unfolds all directions to a square of equal area",
            );
            return None;
        }
        let side = if is_flat { 2 * w } else { w };
        let claim = node.report.budget.claim("the picture of a goniometric light");
        if let Err(why) = claim.keep((side * side * size_of::<Rgb>()) as u64) {
            node.error(format!("cannot copy the light's picture: {why}"), "");
            return None;
        }
        let texel = |i: usize| {
            let [x, y] = [i % side, i / side];
            if is_flat {
                let p = (Vec2::new(x as f32, y as f32) + 0.5) / side as f32;
                return flat_texel(picture, warp::folded_sphere(p));
            }
            // pbrt-v4 takes the mean of the colours.
            Rgb::grey(picture.texel(x, y).mean())
        };
        let texels = Texels::Float((0..side * side).map(texel).collect());
        let bitmap = Bitmap::new(side, side, texels, Wrap::Clamp, Lookup::Nearest);
        let (bitmap, to_uv) = (Arc::new(bitmap), Affine2::IDENTITY);
        Some(Texture::Bitmap { bitmap, to_uv, scale: Rgb::WHITE })
    }
}

/// The texel of a picture of latitude and longitude for a unit direction; +z is at its top, and its columns start at +x.
fn flat_texel(picture: &Bitmap, d: Vec3) -> Rgb {
    let turn = (d.y.atan2(d.x) / (2.0 * PI)).rem_euclid(1.0);
    let [w, h] = [picture.width(), picture.height()];
    let x = (turn * w as f32) as usize;
    let y = (d.z.clamp(-1.0, 1.0).acos() / PI * h as f32) as usize;
    picture.texel(x.min(w - 1), y.min(h - 1))
}

/// The power, as luminance, that a picture gives through a window at distance one for an intensity of one. A texel's direction is that
/// of its centre, as in pbrt-v4.
fn power_through(picture: &Bitmap, half: Vec2) -> f32 {
    let (w, h) = (picture.width(), picture.height());
    let size = Vec2::new(w as f32, h as f32);
    let sum: f64 = (0..w * h)
        .map(|i| {
            let cell = (Vec2::new((i % w) as f32, (i / w) as f32) + 0.5) / size;
            let on_plane = ((2.0 * cell - 1.0) * half).extend(1.0);
            f64::from(picture.texel(i % w, i / w).luminance() * on_plane.length().powi(-3))
        })
        .sum();
    4.0 * half.x * half.y * (sum / (w * h) as f64) as f32
}
