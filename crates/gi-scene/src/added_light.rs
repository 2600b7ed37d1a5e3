//! Lights that the user adds to a scene that has none, such as most OBJ files.

use std::f32::consts::{PI, TAU};

use gi_core::camera::CameraSpec;
use gi_core::light::LightSource;
use gi_core::math::Rgb;
use gi_core::texture::{Bitmap, Lookup, Texels, Wrap};
use glam::{Affine3A, Mat3, Vec3};

use crate::diagnostics::Report;
use crate::framing::bounds_of;
use crate::hash::Hash;
use crate::options::{AddedLight, Loaded};
use crate::origins::LightOrigin;
use crate::sky::{self, model::SunSky};

/// Factor on the sky and the sun, whose units are physical: white paper on the ground is then about 1.
const SKY_SCALE: f32 = 3.0;
/// Sine of the sun's elevation.
const SUN_HEIGHT: f32 = 0.7;
/// Size of the studio's picture.
const STUDIO: [usize; 2] = [256, 128];
/// Radiance of the studio's walls.
const WALLS: f32 = 0.3;

/// Add a light to a loaded scene.
pub(crate) fn add(loaded: &mut Loaded, light: AddedLight, report: &Report) {
    let axes = Axes::of(&loaded.camera);
    loaded.world = world_with(loaded, light, &axes);
    let lights = match light {
        AddedLight::Headlight => vec![(headlight(loaded), LightOrigin::Itself)],
        AddedLight::Studio => vec![(studio(&axes), LightOrigin::Itself)],
        AddedLight::Sky => {
            let sky = sun_and_sky(&axes);
            match sky.sky() {
                Ok(light) => vec![
                    (light, LightOrigin::SunSky(sky.clone())),
                    (sky.sun(), LightOrigin::SameAsBefore),
                ],
                Err(why) => return report.error_nowhere(format!("--light sky: {why}")),
            }
        }
    };
    for (light, origin) in lights {
        loaded.parts.lights.push(light);
        loaded.origins.lights.push(origin);
    }
}

/// The hash of the world with a light added, and of where it is.
fn world_with(loaded: &Loaded, light: AddedLight, axes: &Axes) -> u64 {
    let place = match light {
        AddedLight::Headlight => vec![Vec3::from(loaded.camera.to_world.translation)],
        AddedLight::Sky | AddedLight::Studio => vec![axes.up, axes.front],
    };
    let mut hash = Hash::default();
    hash.word(loaded.world);
    hash.word(light as u64);
    place.iter().flat_map(|v| v.to_array()).for_each(|x| hash.word(x.to_bits().into()));
    hash.value()
}

/// The directions that added lights are placed by: up, toward the camera, and to the camera's right. They are
/// perpendicular, and of unit length.
struct Axes {
    up: Vec3,
    front: Vec3,
    right: Vec3,
}

impl Axes {
    /// Up is the coordinate axis that the camera's own up direction is nearest to.
    fn of(camera: &CameraSpec) -> Axes {
        let m = camera.to_world.matrix3;
        let (camera_up, view) = (Vec3::from(m.y_axis), Vec3::from(m.z_axis));
        let axes = [Vec3::Y, Vec3::Z, Vec3::X];
        let along = |axis: &Vec3| axis.dot(camera_up).abs();
        let axis = axes.into_iter().reduce(|a, b| if along(&b) > along(&a) + 1e-6 { b } else { a });
        let axis = axis.expect("three axes");
        let up = if axis.dot(camera_up) < 0.0 { -axis } else { axis };
        let front = (-view).reject_from_normalized(up).try_normalize();
        let front = front.unwrap_or_else(|| up.any_orthonormal_vector());
        Axes { up, front, right: up.cross(front) }
    }

    /// The unit vector with these components to the right, up and toward the camera.
    fn toward(&self, right: f32, up: f32, front: f32) -> Vec3 {
        (self.right * right + self.up * up + self.front * front).normalize()
    }
}

/// A clear afternoon; the sun is behind the camera, on its left.
fn sun_and_sky(axes: &Axes) -> SunSky {
    let side = (1.0 - SUN_HEIGHT * SUN_HEIGHT).sqrt();
    let to_world = Mat3::from_cols(axes.front, axes.up.cross(axes.front), axes.up);
    SunSky {
        turbidity: 3.0,
        albedo: Rgb::grey(0.3),
        sun_direction: axes.toward(-0.6 * side, SUN_HEIGHT, 0.8 * side),
        sun_scale: SKY_SCALE,
        sky_scale: SKY_SCALE,
        angular_radius: sky::sun::ANGULAR_RADIUS,
        to_world: Affine3A::from_mat3(to_world),
        extend: true,
    }
}

/// A light at the camera. A white surface that faces it at the distance of the scene's centre is 1.
fn headlight(loaded: &Loaded) -> LightSource {
    let position = Vec3::from(loaded.camera.to_world.translation);
    let bounds = bounds_of(&loaded.parts);
    let (center, radius) = match bounds.is_empty() {
        true => (position, 1.0),
        false => (bounds.center(), 0.5 * bounds.extent().length()),
    };
    let distance = position.distance(center).max(0.5 * radius).max(1e-6);
    LightSource::Point { position, intensity: Rgb::grey(PI * distance * distance) }
}

/// Bright walls, and three soft boxes: a key light on the left, a weaker one on the right, and one from behind.
fn studio(axes: &Axes) -> LightSource {
    // Direction, radiance, and cosine of the angular radius.
    let boxes = [
        (axes.toward(-0.8, 0.7, 0.9), 9.0, 0.94),
        (axes.toward(1.0, 0.3, 0.6), 2.0, 0.92),
        (axes.toward(0.4, 0.9, -1.0), 5.0, 0.95),
    ];
    let [width, height] = STUDIO;
    let texel = |i: usize| {
        let theta = PI * (i / width) as f32 / (height - 1) as f32;
        let phi = TAU * ((i % width) as f32 + 0.5) / width as f32;
        let d = Vec3::new(phi.sin() * theta.sin(), theta.cos(), -phi.cos() * theta.sin());
        let light = boxes.iter().map(|&(center, radiance, edge)| {
            // The border of a box is soft, so that the picture's texels do not show in reflections.
            let inside = ((d.dot(center) - edge) / (0.3 * (1.0 - edge))).clamp(0.0, 1.0);
            radiance * inside * inside * (3.0 - 2.0 * inside)
        });
        Rgb::grey(WALLS + light.sum::<f32>())
    };
    let texels = Texels::Float((0..width * height).map(texel).collect());
    let image = Bitmap::new(width, height, texels, Wrap::Repeat, Lookup::Bilinear);
    LightSource::Environment { image, scale: 1.0, to_world: Affine3A::IDENTITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lights_are_placed_by_the_camera_and_the_nearest_axis() {
        let at = |origin: Vec3, up: Vec3| {
            Axes::of(&CameraSpec::look_at(origin, Vec3::ZERO, up, 1.0, [8, 8]))
        };
        let axes = at(Vec3::new(0.0, 3.0, 4.0), Vec3::Y);
        assert_eq!([axes.up, axes.front, axes.right], [Vec3::Y, Vec3::Z, Vec3::X]);
        let axes = at(Vec3::new(5.0, 0.0, 2.0), Vec3::Z);
        assert!((axes.up - Vec3::Z).length() < 1e-6 && (axes.front - Vec3::X).length() < 1e-6);
        let sky = sun_and_sky(&axes);
        assert!((sky.sun_direction.z - SUN_HEIGHT).abs() < 1e-5, "as high above the ground");
        assert!(sky.sun_direction.dot(axes.front) > 0.0 && sky.sun_direction.dot(axes.right) < 0.0);
        assert!((sky.to_world.transform_vector3(Vec3::Z) - Vec3::Z).length() < 1e-6);
        // Straight down: up is the axis that is upward in the picture.
        assert_eq!(at(Vec3::Y, Vec3::NEG_Z).up, Vec3::NEG_Z);
    }
}
