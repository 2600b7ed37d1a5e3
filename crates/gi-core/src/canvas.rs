//! Drawing over a picture: dots, rings, lines with soft edges and text, colours for numbers, and legends that explain them.

mod legend;
mod text;

pub use legend::{Colours, Legend, number, ticks};
pub use text::text_width;

use glam::{Vec2, Vec3};

use crate::bsdf::Transport;
use crate::camera::Camera;
use crate::math::Rgb;
use crate::scene::Scene;

/// A picture to draw on, linear; positions are in pixels from the top left corner.
#[derive(Clone, Debug)]
pub struct Canvas {
    size: [usize; 2],
    pixels: Vec<Rgb>,
}

impl Canvas {
    /// Draw on `pixels`, row by row from the top.
    pub fn over(size: [usize; 2], pixels: Vec<Rgb>) -> Self {
        assert_eq!(pixels.len(), size[0] * size[1], "one colour per pixel");
        Canvas { size, pixels }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// The pixels, row by row.
    pub fn into_pixels(self) -> Vec<Rgb> {
        self.pixels
    }

    /// A filled disc of `radius` pixels.
    pub fn disc(&mut self, at: Vec2, radius: f32, colour: Rgb) {
        self.cover(at, at, radius, colour, |p| radius - (p - at).length());
    }

    /// A circle of `radius` pixels, `width` pixels thick.
    pub fn ring(&mut self, at: Vec2, radius: f32, width: f32, colour: Rgb) {
        let half = 0.5 * width;
        self.cover(at, at, radius + half, colour, |p| half - ((p - at).length() - radius).abs());
    }

    /// A straight line `width` pixels thick.
    pub fn line(&mut self, a: Vec2, b: Vec2, width: f32, colour: Rgb) {
        let (half, along) = (0.5 * width, b - a);
        let length_sq = along.length_squared().max(f32::MIN_POSITIVE);
        self.cover(a, b, half, colour, |p| {
            let t = ((p - a).dot(along) / length_sq).clamp(0.0, 1.0);
            half - (p - a - along * t).length()
        });
    }

    /// Blend `colour` into pixels. `inside` gives the distance of a pixel's centre from the edge, positive inside
    /// (pixels). Only pixels within `reach` of the box around `a` and `b` change.
    fn cover(&mut self, a: Vec2, b: Vec2, reach: f32, colour: Rgb, inside: impl Fn(Vec2) -> f32) {
        let (low, high) = (a.min(b) - (reach + 1.0), a.max(b) + (reach + 1.0));
        if !(low.is_finite() && high.is_finite()) {
            return;
        }
        let range = |axis: usize| {
            let end = self.size[axis] as f32;
            low[axis].clamp(0.0, end) as usize..high[axis].clamp(0.0, end).ceil() as usize
        };
        let (columns, rows) = (range(0), range(1));
        for y in rows {
            for x in columns.clone() {
                let share =
                    (inside(Vec2::new(x as f32 + 0.5, y as f32 + 0.5)) + 0.5).clamp(0.0, 1.0);
                let pixel = &mut self.pixels[y * self.size[0] + x];
                *pixel = pixel.lerp(colour, share);
            }
        }
    }
}

/// The position in the picture of the world point `p` on a surface with normal `n`. `None` if it is outside the
/// picture, seen from behind, or occluded.
pub fn seen_at(scene: &Scene, camera: &Camera, p: Vec3, n: Vec3) -> Option<Vec2> {
    let c = camera.connect(p, [0.5; 2], 0.0)?;
    let facing = c.wi.dot(n) > 0.0;
    let ray = scene.tree().shadow_ray(p, n, c.end);
    (facing && !scene.transmittance(ray).is_black()).then(|| Vec2::from_array(c.film))
}

/// The position in the picture of the world point `p`, which is not on a surface. `None` if it is outside the picture,
/// or if an opaque surface occludes it. Refraction is ignored.
pub fn seen_within(scene: &Scene, camera: &Camera, p: Vec3) -> Option<Vec2> {
    let c = camera.connect(p, [0.5; 2], 0.0)?;
    let mut ray = scene.tree().shadow_ray(p, Vec3::ZERO, c.end);
    while let Some((surface, t)) = scene.intersect(&ray) {
        if scene.bsdf(&surface, -c.wi, Transport::Radiance).is_opaque() {
            return None;
        }
        ray = scene.tree().beyond(&ray, t);
    }
    Some(Vec2::from_array(c.film))
}

/// Give one channel of a picture `value` in the pixels whose centres are in the rectangle from `low` to `high` (pixels).
pub fn fill(channel: &mut [f32], [width, height]: [usize; 2], low: Vec2, high: Vec2, value: f32) {
    let range = |axis: usize, end: usize| {
        let pixel = |edge: f32| ((edge - 0.5).ceil().max(0.0) as usize).min(end);
        pixel(low[axis])..pixel(high[axis]).max(pixel(low[axis]))
    };
    for y in range(1, height) {
        for x in range(0, width) {
            channel[y * width + x] = value;
        }
    }
}

/// The colour of a number in [0, 1]: viridis, from violet over green to yellow. It is readable in grey and for
/// colour-blind readers.
pub fn viridis(t: f32) -> Rgb {
    let colour = colorous::VIRIDIS.eval_continuous(f64::from(t.clamp(0.0, 1.0)));
    Rgb::from([colour.r, colour.g, colour.b].map(srgb_to_linear))
}

fn srgb_to_linear(byte: u8) -> f32 {
    let s = f32::from(byte) / 255.0;
    if s <= 0.040_45 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::CameraSpec;
    use crate::geometry::{Geometry, Shape};
    use crate::material::Material;
    use crate::math::Frame;
    use crate::scene::SceneParts;
    use crate::texture::Texture;

    #[test]
    fn rectangles_next_to_each_other_share_no_pixel_and_leave_no_gap() {
        let mut channel = vec![0.0; 12];
        for (low, high, value) in [(-3.0, 1.5, 1.0), (1.5, 2.4, 2.0), (2.4, 9.0, 3.0)] {
            fill(&mut channel, [4, 3], Vec2::new(low, -1.0), Vec2::new(high, 2.0), value);
        }
        assert_eq!(channel, [1.0, 2.0, 3.0, 3.0, 1.0, 2.0, 3.0, 3.0, 0.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn points_in_glass_are_visible_and_points_behind_walls_are_not() {
        let sphere = |x: f32, material| {
            let (center, axes) = (Vec3::X * x, Frame::from_normal(Vec3::Z));
            Shape::new("ball", Geometry::Sphere { center, radius: 1.0, axes }, material)
        };
        let (reflectance, transmittance) = (Texture::grey(1.0), Texture::grey(1.0));
        let parts = SceneParts {
            shapes: vec![sphere(-1.5, 0), sphere(1.5, 1)],
            materials: vec![
                Material::Dielectric { eta: 1.5, reflectance, transmittance, roughness: None },
                Material::Diffuse { reflectance: Texture::grey(0.5) },
            ],
            ..SceneParts::default()
        };
        let scene = Scene::new(parts).expect("a scene");
        let eye = Vec3::new(0.0, 0.0, 8.0);
        let camera = Camera::new(&CameraSpec::look_at(eye, Vec3::ZERO, Vec3::Y, 0.8, [64, 64]));
        for (x, z, seen) in [
            (-1.5, 0.0, true),
            (1.5, 0.0, false),
            (-1.5, -2.0, true),
            (1.5, -2.0, false),
            (1.5, 2.0, true),
            (0.0, 0.0, true),
            (30.0, 0.0, false),
        ] {
            let at = seen_within(&scene, &camera, Vec3::new(x, 0.0, z));
            assert_eq!(at.is_some(), seen, "at {x}, {z}");
        }
    }

    #[test]
    fn shapes_cover_their_area_and_stay_on_the_canvas() {
        let covered = |draw: &dyn Fn(&mut Canvas)| {
            let mut canvas = Canvas::over([64, 64], vec![Rgb::BLACK; 64 * 64]);
            draw(&mut canvas);
            canvas.into_pixels().iter().map(|c| c.r).sum::<f32>()
        };
        let middle = Vec2::new(31.3, 30.8);
        let disc = covered(&|c| c.disc(middle, 10.0, Rgb::WHITE));
        assert!((disc / (std::f32::consts::PI * 100.0) - 1.0).abs() < 0.01, "{disc}");
        let ring = covered(&|c| c.ring(middle, 10.0, 2.0, Rgb::WHITE));
        assert!((ring / (std::f32::consts::TAU * 20.0) - 1.0).abs() < 0.01, "{ring}");
        let line = covered(&|c| c.line(middle, middle + Vec2::new(30.0, 0.0), 2.0, Rgb::WHITE));
        assert!((line / (30.0 * 2.0 + std::f32::consts::PI) - 1.0).abs() < 0.02, "{line}");
        // A disc at the corner covers a quarter of its area; shapes far outside, or at positions that are not finite,
        // cover nothing.
        let corner = covered(&|c| c.disc(Vec2::ZERO, 10.0, Rgb::WHITE));
        assert!((corner / (std::f32::consts::PI * 25.0) - 1.0).abs() < 0.02, "{corner}");
        assert_eq!(covered(&|c| c.disc(Vec2::splat(1e30), 5.0, Rgb::WHITE)), 0.0);
        assert_eq!(covered(&|c| c.disc(Vec2::splat(f32::NAN), 5.0, Rgb::WHITE)), 0.0);
    }
}
