//! The picture in front of a point light.

use glam::{Mat3, Vec2, Vec3};

use super::source::Window;
use crate::math::{INV_PI, Rgb};
use crate::texture::Texture;
use crate::warp;

/// The picture in front of a point light: a factor on its intensity.
#[derive(Clone, Debug)]
pub struct Slide {
    texture: Texture,
    /// From world directions to those along the axes.
    to_local: Mat3,
    window: Window,
    /// Half the extent of the picture at z = 1. For a rectangle, both are negative: the picture is upright and not
    /// mirrored for an eye at its place.
    half: Vec2,
    /// For a rectangle, the flux through it where the picture is one.
    flux: f32,
}

impl Slide {
    /// A picture that covers `window`; its u, v and axis point along `axes`.
    pub(super) fn new(texture: Texture, axes: [Vec3; 3], cutoff: f32, window: Window) -> Self {
        let [x, y, z] = match window {
            Window::Unfolded | Window::Latitudes => axes,
            _ => axes.map(|axis| axis.normalize_or(Vec3::Z)),
        };
        let (half, flux) = match window {
            Window::Cone => (Vec2::splat(cutoff.tan()), 0.0),
            Window::Irradiance(half) => (-half, 4.0 * half.x * half.y * corner_cos(half).powi(3)),
            Window::Intensity(half) => {
                let corner = |u: f32, v: f32| (x * (u * half.x) + y * (v * half.y) + z).normalize();
                let [a, b, c, d] = [[-1, -1], [1, -1], [1, 1], [-1, 1]]
                    .map(|signs| signs.map(|k| k as f32))
                    .map(|[u, v]| corner(u, v));
                (-half, warp::solid_angle(a, b, c) + warp::solid_angle(a, c, d))
            }
            Window::Unfolded | Window::Latitudes => (Vec2::ONE, 0.0),
        };
        Slide { texture, to_local: Mat3::from_cols(x, y, z).inverse(), window, half, flux }
    }

    /// The factor along world direction `d`.
    pub fn along(&self, d: Vec3) -> Rgb {
        let local = self.to_local * d;
        let at = Vec2::new(local.x, local.y) / (local.z * self.half);
        let is_inside = local.z > 0.0 && at.abs().max_element() <= 1.0;
        let at_plane = || self.texture.eval(Vec2::splat(0.5) + 0.5 * at);
        match self.window {
            Window::Cone => at_plane(),
            Window::Intensity(_) if is_inside => at_plane(),
            // The irradiance of a plane at distance z is I cos^3 / z^2.
            Window::Irradiance(half) if is_inside => {
                at_plane() * (corner_cos(half) * local.length() / local.z).powi(3)
            }
            Window::Irradiance(_) | Window::Intensity(_) => Rgb::BLACK,
            Window::Unfolded => {
                self.texture.eval(warp::unfolded_sphere(local.normalize_or(Vec3::Z)))
            }
            Window::Latitudes => {
                let d = local.normalize_or(Vec3::Z);
                let turn = (d.y.atan2(d.x) * 0.5 * INV_PI).rem_euclid(1.0);
                self.texture.eval(Vec2::new(turn, d.z.clamp(-1.0, 1.0).acos() * INV_PI))
            }
        }
    }

    /// Mean over the cone, whose solid angle is given. For [`Window::Intensity`], it is that of a picture which has its mean
    /// everywhere; for [`Window::Latitudes`], the mean of the texels.
    pub(super) fn mean(&self, solid_angle: f32) -> Rgb {
        let mean = self.texture.mean();
        match self.window {
            Window::Cone | Window::Unfolded | Window::Latitudes => mean,
            Window::Irradiance(_) | Window::Intensity(_) => mean * (self.flux / solid_angle),
        }
    }
}

/// Cosine of the angle between the axis and the direction to a corner of a rectangle at distance one. `half` is half its width
/// and half its height.
fn corner_cos(half: Vec2) -> f32 {
    (1.0 + half.length_squared()).sqrt().recip()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Affine2;

    use super::*;
    use crate::texture::{Bitmap, Lookup, Texels, Wrap};

    /// Dark on the left, bright on the right; the lower row is half as bright.
    fn picture() -> Texture {
        let texels = [0.0, 1.0, 0.0, 0.5].map(Rgb::grey).to_vec();
        let bitmap = Bitmap::new(2, 2, Texels::Float(texels), Wrap::Clamp, Lookup::Nearest);
        Texture::Bitmap { bitmap: Arc::new(bitmap), to_uv: Affine2::IDENTITY, scale: Rgb::WHITE }
    }

    #[test]
    fn the_picture_covers_exactly_the_cone() {
        let cutoff = 0.5f32;
        let slide = Slide::new(picture(), [Vec3::X, Vec3::Y, Vec3::Z], cutoff, Window::Cone);
        let along = |x: f32, y: f32| slide.along(Vec3::new(x, y, 1.0).normalize()).r;
        // v grows along y, and the first row of a picture is at v = 0.
        assert_eq!([along(-0.1, -0.1), along(0.1, -0.1), along(0.1, 0.1)], [0.0, 1.0, 0.5]);
        let edge = cutoff.tan();
        assert_eq!([along(0.99 * edge, -0.1), along(-0.99 * edge, -0.1)], [1.0, 0.0]);
        assert_eq!(slide.mean(1.0), Rgb::grey(0.375));
    }

    #[test]
    fn a_mirrored_and_turned_spot_shows_a_mirrored_and_turned_picture() {
        let slide = Slide::new(picture(), [-2.0 * Vec3::Z, Vec3::Y, Vec3::X], 0.5, Window::Cone);
        assert_eq!(slide.along(Vec3::new(1.0, -0.1, -0.1).normalize()).r, 1.0);
        assert_eq!(slide.along(Vec3::new(1.0, -0.1, 0.1).normalize()).r, 0.0);
    }

    #[test]
    fn a_projector_shines_evenly_on_a_plane_within_its_window() {
        let window = Vec2::new(0.6, 0.3);
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        let slide = Slide::new(Texture::grey(1.0), axes, 0.0, Window::Irradiance(window));
        // Irradiance of the plane z = 1 for an intensity of one toward the corners.
        let irradiance = |x: f32, y: f32| {
            let p = Vec3::new(x, y, 1.0);
            let cos = 1.0 / p.length();
            slide.along(p.normalize()).r * cos.powi(3)
        };
        let corner = (1.0 + window.length_squared()).powf(-1.5);
        for [x, y] in [[0.0, 0.0], [0.59, 0.29], [-0.3, 0.1]] {
            assert!((irradiance(x, y) / corner - 1.0).abs() < 1e-5);
        }
        assert_eq!([irradiance(0.61, 0.0), irradiance(0.0, -0.31)], [0.0; 2]);
        assert_eq!(slide.along(-Vec3::Z), Rgb::BLACK);
        let power = slide.mean(2.0) * 2.0;
        assert!((power.r / (4.0 * 0.6 * 0.3 * corner) - 1.0).abs() < 1e-5, "area times irradiance");
        // The left of the picture is on the side of +x, its top on that of +y.
        let slide = Slide::new(picture(), axes, 0.0, Window::Irradiance(window));
        let along = |x: f32, y: f32| slide.along(Vec3::new(x, y, 1.0).normalize()).r;
        assert_eq!(along(0.3, 0.1), 0.0);
        assert!(along(-0.3, 0.1) > along(-0.3, -0.1) && along(-0.3, -0.1) > 0.0);
    }

    /// The solid angle of a rectangle, and the mean of a picture that is the same everywhere.
    #[test]
    fn the_picture_of_a_window_of_intensity_is_the_intensity() {
        let window = Vec2::new(2.0, 0.5);
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        let slide = Slide::new(Texture::grey(0.25), axes, 0.0, Window::Intensity(window));
        let along = |x: f32, y: f32| slide.along(Vec3::new(x, y, 1.0).normalize()).r;
        assert_eq!([along(0.0, 0.0), along(1.9, -0.4), along(2.1, 0.0)], [0.25, 0.25, 0.0]);
        assert_eq!(slide.along(-Vec3::Z), Rgb::BLACK);
        let n = 400;
        let cell = |i: i32| (i as f32 + 0.5) / n as f32 * 2.0 - 1.0;
        let area = 4.0 * window.x * window.y / (n * n) as f32;
        let mut solid_angle = 0.0f64;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let p = (Vec2::new(cell(i), cell(j)) * window).extend(1.0);
            solid_angle += f64::from(area * p.length().powi(-3));
        }
        let flux = f64::from(slide.mean(2.0).r * 2.0);
        assert!((flux / (0.25 * solid_angle) - 1.0).abs() < 1e-4, "{flux} {solid_angle}");
    }

    /// A sheared window: the solid angle from directions that are evenly spread.
    #[test]
    fn the_mean_of_a_sheared_window_is_its_solid_angle() {
        let axes = [Vec3::X, Vec3::new(0.6, 0.8, 0.0), Vec3::new(0.3, 0.0, 1.0)];
        let window = Window::Intensity(Vec2::new(0.7, 0.4));
        let slide = Slide::new(Texture::grey(1.0), axes, 0.0, window);
        let n = 400_000;
        let inside = |k: &usize| {
            let u = [(*k as f32 + 0.5) / n as f32, (*k as f32 * 0.618_034).fract()];
            slide.along(crate::warp::sphere(u)).r > 0.0
        };
        let share = (0..n).filter(inside).count() as f32 / n as f32;
        let solid_angle = share * 4.0 * std::f32::consts::PI;
        assert!((slide.mean(1.0).r / solid_angle - 1.0).abs() < 5e-3, "{solid_angle}");
    }

    #[test]
    fn a_picture_of_latitudes_has_its_first_row_at_the_axis() {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        let slide = Slide::new(picture(), axes, std::f32::consts::PI, Window::Latitudes);
        let along = |x: f32, y: f32, z: f32| slide.along(Vec3::new(x, y, z).normalize()).r;
        // The picture has one turn in two columns, and two rows.
        assert_eq!([along(0.3, 0.1, 1.0), along(0.3, -0.1, 1.0)], [0.0, 1.0]);
        assert_eq!([along(0.3, 0.1, -1.0), along(0.3, -0.1, -1.0)], [0.0, 0.5]);
    }

    #[test]
    fn a_goniometric_picture_covers_all_directions() {
        // The upper half of the square is on the side of local -y.
        let texels = [1.0, 1.0, 0.25, 0.25].map(Rgb::grey).to_vec();
        let bitmap = Bitmap::new(2, 2, Texels::Float(texels), Wrap::Clamp, Lookup::Nearest);
        let picture = Texture::Bitmap {
            bitmap: Arc::new(bitmap),
            to_uv: Affine2::IDENTITY,
            scale: Rgb::WHITE,
        };
        let axes = [Vec3::X, Vec3::Z, Vec3::Y];
        let slide = Slide::new(picture, axes, std::f32::consts::PI, Window::Unfolded);
        let along = |d: Vec3| slide.along(d.normalize()).r;
        assert_eq!(
            [along(Vec3::new(0.3, 5.0, -0.2)), along(Vec3::new(0.3, -5.0, 0.2))],
            [1.0, 0.25]
        );
        assert_eq!(slide.mean(4.0 * std::f32::consts::PI), Rgb::grey(0.625));
    }
}
