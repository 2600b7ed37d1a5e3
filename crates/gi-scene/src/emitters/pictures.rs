//! pbrt's point lights whose intensity is a picture: `projection` and `goniometric`.

use std::f32::consts::PI;
use std::sync::Arc;

use gi_core::light::{LightSource, Window};
use gi_core::math::Rgb;
use gi_core::texture::{Bitmap, Texture};
use glam::{Affine2, Vec2, Vec3};

use super::light_color;
use crate::builder::Builder;
use crate::document::Node;

impl Builder<'_> {
    /// Light through a window, with the picture as its intensity.
    pub(super) fn projection(&mut self, node: Node<'_>) -> Option<LightSource> {
        let (picture, bitmap) = self.picture_of_light(node)?;
        let axes = axes(node)?;
        let (w, h) = (bitmap.width() as f32, bitmap.height() as f32);
        // The field of view is that of the shorter side.
        let half = Vec2::new(w, h) / w.min(h) * (0.5 * node.float("fov", 90.0).to_radians()).tan();
        let unit = node.has("power").then(|| power_through(&bitmap, half));
        // Axes of other lengths stretch the window. Beyond the limits, squares of its sides would overflow.
        let [x, y, z] = axes.map(Vec3::length);
        let window = (half * Vec2::new(x, y) / z).clamp(Vec2::splat(1e-6), Vec2::splat(1e6));
        let cutoff = corner_angle(axes.map(Vec3::normalize), window);
        self.pictured(node, (picture, axes), Window::Intensity(window), cutoff, unit)
    }

    /// Light in all directions, with the picture as its intensity.
    pub(super) fn goniometric(&mut self, node: Node<'_>) -> Option<LightSource> {
        let (picture, bitmap) = self.picture_of_light(node)?;
        let axes = axes(node)?;
        if node.bool("latitude_longitude", false) {
            return self.pictured(node, (picture, axes), Window::Latitudes, PI, None);
        }
        let (w, h) = (bitmap.width(), bitmap.height());
        if w != h {
            node.error(
                format!("the light's picture has {w} x {h} pixels"),
                "expected a square: pbrt-v4 unfolds all directions to a square of equal area",
            );
            return None;
        }
        let unit = node.has("power").then(|| 4.0 * PI * bitmap.mean().mean());
        let grey = self.origins.as_grey(&bitmap, node.report);
        let (bitmap, to_uv) = (grey, Affine2::IDENTITY);
        let picture = Texture::Bitmap { bitmap, to_uv, scale: Rgb::WHITE };
        self.pictured(node, (picture, axes), Window::Unfolded, PI, unit)
    }

    /// A light with this picture along these axes. `unit` is the power that the picture gives for an intensity of one, if the
    /// light's power is given.
    fn pictured(
        &mut self,
        node: Node<'_>,
        (picture, axes): (Texture, [Vec3; 3]),
        window: Window,
        cutoff: f32,
        unit: Option<f32>,
    ) -> Option<LightSource> {
        let (picture, most) = self.at_most_one(node, picture)?;
        let factor = match unit {
            Some(unit) if unit > 0.0 => node.float("power", 0.0) / unit,
            _ => 1.0,
        };
        Some(LightSource::Projector {
            position: node.to_world().translation.as_vec3(),
            axes,
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
}

/// The axes of a light's picture; `None` if they lie in one plane, which is reported.
fn axes(node: Node<'_>) -> Option<[Vec3; 3]> {
    let m = node.transform("to_world").matrix3;
    let axes = [m.x_axis, m.y_axis, m.z_axis].map(Vec3::from);
    let [x, y, z] = axes.map(Vec3::normalize_or_zero);
    if x.cross(y).dot(z).abs() > 1e-6 {
        return Some(axes);
    }
    node.error("the transform flattens the light's picture", "expected one that can be inverted");
    None
}

/// The largest angle between the axis and a corner of a window at distance one, radians. The axes have unit length.
fn corner_angle([x, y, z]: [Vec3; 3], half: Vec2) -> f32 {
    let corner = |u: f32, v: f32| x * (u * half.x) + y * (v * half.y) + z;
    let angles = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, -1.0), corner(1.0, 1.0)]
        .map(|corner| z.angle_between(corner));
    // A little more, because rounding may put a corner outside of the cone.
    1.0001 * angles.into_iter().fold(0.0, f32::max)
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
