//! Sun and sky: the analytic sky of Hosek and Wilkie as a picture at infinity, the sun as a disc.

pub(crate) mod model;
pub(crate) mod sun;

use gi_core::light::LightSource;
use gi_core::math::Rgb;
use gi_core::texture::{Bitmap, Lookup, Texels, Wrap};
use glam::{Affine3A, Mat3, Vec3};
use hw_skymodel::rgb::{Channel, SkyParams, SkyState};

use crate::builder::Builder;
use crate::document::{Meaning, Node};
use crate::origins::LightOrigin;
use crate::rotation::rotation;
use crate::value::MAX_NUMBER;
use model::SunSky;
use sun::Moment;

/// Size of the sky's picture. Its finest feature, the glow around the sun, is a few degrees wide.
const SIZE: [usize; 2] = [512, 256];
/// Integral of the luminosity curve over nanometres. The model's radiance contains this factor; ours and Mitsuba's do
/// not.
const LUMINOSITY_INTEGRAL: f32 = 106.750_26;
/// Smallest angular radius of the sun: a sun of zero size would have infinite radiance.
const SMALLEST_RADIUS: f32 = 1e-4;

/// Add the lights of a `sun`, `sky` or `sunsky`.
pub(crate) fn add(builder: &mut Builder<'_>, node: Node<'_>) {
    let Some(sky) = SunSky::read(node) else { return };
    let sky_light = (sky.sky_scale > 0.0).then(|| sky.sky()).transpose();
    let lights = match sky_light {
        Ok(light) => [light, (sky.sun_scale > 0.0).then(|| sky.sun())],
        Err(why) => return node.error(why, ""),
    };
    let mut origin = LightOrigin::SunSky(sky);
    for light in lights.into_iter().flatten() {
        builder.push_light(light, origin);
        origin = LightOrigin::SameAsBefore;
    }
}

impl SunSky {
    /// The plugin's parameters. `None` if an error was reported, or at night (with a warning).
    fn read(node: Node<'_>) -> Option<SunSky> {
        node.ignore(&["resolution", "stretch", "complex_sun", "sampling_weight"]);
        let old = node.doc.version == 0;
        // Mitsuba 0.6 has +y up and +z south, Mitsuba 3 has +z up and +x south.
        let axes = if old { Mat3::from_cols(Vec3::Z, -Vec3::X, Vec3::Y) } else { Mat3::IDENTITY };
        let to_world = rotation(node) * Affine3A::from_mat3(axes);
        let turbidity = node.float("turbidity", 3.0);
        if !(1.0..=10.0).contains(&turbidity) {
            let span = node.span_of("turbidity");
            node.report.error(span, format!("turbidity {turbidity}"), "expected 1 to 10");
            return None;
        }
        let albedo = node.color("albedo", Meaning::Factor);
        let albedo = albedo.unwrap_or(Rgb::grey(if old { 0.15 } else { 0.3 }));
        if albedo.to_array().iter().any(|v| !(0.0..=1.0).contains(v)) {
            let [r, g, b] = albedo.to_array();
            let message = format!("the ground's albedo is {r} {g} {b}");
            node.report.error(node.place_of("albedo"), message, "expected 0 to 1");
            return None;
        }
        let local = sun::direction(&moment(node)).as_vec3();
        let sun_direction = match node.vector("sun_direction") {
            Some(Vec3::ZERO) => {
                node.error("the direction to the sun is zero", "");
                return None;
            }
            Some(world) => crate::transform::unit(world).0,
            None => to_world.transform_vector3(local).normalize(),
        };
        let scale = node.light_scale("scale", 1.0);
        // In Mitsuba 0.6, a specific scale replaces the common one.
        let (sun_scale, sky_scale) =
            (node.light_scale("sun_scale", scale), node.light_scale("sky_scale", scale));
        let given = node.has("sun_aperture").then(|| node.within("sun_aperture", 0.5, 0.0..=180.0));
        let given = given.map(|degrees| 0.5 * degrees.to_radians());
        let radius_scale = node.within("sun_radius_scale", 1.0, 0.0..=MAX_NUMBER);
        let radius = sun::ANGULAR_RADIUS * radius_scale;
        let sky = SunSky {
            turbidity,
            albedo,
            sun_direction,
            sun_scale: if node.plugin() == "sky" { 0.0 } else { sun_scale },
            sky_scale: if node.plugin() == "sun" { 0.0 } else { sky_scale },
            angular_radius: given.unwrap_or(radius).clamp(SMALLEST_RADIUS, 1.5),
            to_world,
            extend: node.bool("extend", false),
        };
        if sky.elevation() < 0.0 {
            node.warn("the sun is below the horizon: the sky is black");
            return None;
        }
        Some(sky)
    }

    /// The sun's elevation above the horizon, radians.
    fn elevation(&self) -> f32 {
        let local = self.to_world.inverse().transform_vector3(self.sun_direction).normalize();
        local.z.clamp(-1.0, 1.0).asin()
    }

    /// The sun as a light.
    pub(crate) fn sun(&self) -> LightSource {
        // A larger disc is dimmer, so that the irradiance stays the same.
        let solid_angle = |radius: f32| 1.0 - f64::from(radius).cos();
        let ratio = solid_angle(sun::ANGULAR_RADIUS) / solid_angle(self.angular_radius);
        let radiance = sun::radiance(self.elevation(), self.turbidity);
        LightSource::DistantDisc {
            direction: self.sun_direction,
            angular_radius: self.angular_radius,
            radiance: radiance * (self.sun_scale * ratio as f32),
        }
    }

    /// The sky as a light.
    pub(crate) fn sky(&self) -> Result<LightSource, String> {
        let params = SkyParams {
            elevation: self.elevation(),
            turbidity: self.turbidity,
            albedo: self.albedo.to_array(),
        };
        let state = SkyState::new(&params).map_err(|e| e.to_string())?;
        let sun = self.to_world.inverse().transform_vector3(self.sun_direction).normalize();
        let [width, height] = SIZE;
        let mut texels = Vec::with_capacity(width * height);
        for row in 0..height {
            // The first and last rows are at the poles, as in any environment map.
            let theta = std::f32::consts::PI * row as f32 / (height - 1) as f32;
            for column in 0..width {
                let phi = std::f32::consts::TAU * (column as f32 + 0.5) / width as f32;
                texels.push(self.radiance(&state, theta, phi, sun));
            }
        }
        let texels = Texels::Float(texels);
        let image = Bitmap::new(width, height, texels, Wrap::Repeat, Lookup::Bilinear);
        // The picture's up is +y and its middle column looks along +z.
        let from_picture = Mat3::from_cols(Vec3::Y, Vec3::Z, Vec3::X);
        let to_world = self.to_world * Affine3A::from_mat3(from_picture);
        Ok(LightSource::Environment { image, scale: self.sky_scale, to_world })
    }

    /// The sky's radiance at polar angle `theta` from the zenith; `phi` is the picture's u as an angle.
    fn radiance(&self, state: &SkyState, theta: f32, phi: f32, sun: Vec3) -> Rgb {
        let theta = match (theta.cos() >= 0.0, self.extend) {
            (true, _) => theta,
            (false, true) => std::f32::consts::FRAC_PI_2,
            (false, false) => return Rgb::BLACK,
        };
        // Picture (x, y, z) = (sin u, cos, -cos u) is local (z, x, y).
        let (sin, cos) = theta.sin_cos();
        let local = Vec3::new(-phi.cos() * sin, phi.sin() * sin, cos);
        let gamma = local.dot(sun).clamp(-1.0, 1.0).acos();
        let channel = |c| state.radiance(theta, gamma, c).max(0.0) / LUMINOSITY_INTEGRAL;
        Rgb::new(channel(Channel::R), channel(Channel::G), channel(Channel::B))
    }
}

/// Time and place; the default is an afternoon in Tokyo, as in Mitsuba.
fn moment(node: Node<'_>) -> Moment {
    let number = |name, default: f32| f64::from(node.float(name, default));
    // Keep damaged numbers from overflowing: no calendar is this long.
    let integer = |name, default| node.int_opt(name).unwrap_or(default).clamp(-100_000, 100_000);
    Moment {
        year: integer("year", 2010),
        month: integer("month", 7),
        day: integer("day", 10),
        hours: number("hour", 15.0) + (number("minute", 0.0) + number("second", 0.0) / 60.0) / 60.0,
        timezone: number("timezone", 9.0),
        latitude: number("latitude", 35.6894),
        longitude: number("longitude", 139.6917),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky(direction: Vec3) -> SunSky {
        SunSky {
            turbidity: 3.0,
            albedo: Rgb::grey(0.3),
            sun_direction: direction.normalize(),
            sun_scale: 1.0,
            sky_scale: 1.0,
            angular_radius: sun::ANGULAR_RADIUS,
            to_world: Affine3A::IDENTITY,
            extend: false,
        }
    }

    fn look(light: &LightSource, world: Vec3) -> Rgb {
        let LightSource::Environment { image, scale, to_world } = light else { panic!() };
        let d = to_world.inverse().transform_vector3(world.normalize());
        let u = d.x.atan2(-d.z) / std::f32::consts::TAU;
        let (v, h) = (d.y.clamp(-1.0, 1.0).acos() / std::f32::consts::PI, SIZE[1] as f32);
        let v = (v * (h - 1.0) + 0.5) / h;
        image.eval(glam::Vec2::new(u, v)) * *scale
    }

    #[test]
    fn the_sky_has_mitsubas_radiance() {
        // Mitsuba 3.9.1, `sunsky` with sun_scale 0, turbidity 3, albedo 0.3, the sun 35 degrees high at -y.
        let (sin, cos) = 35f32.to_radians().sin_cos();
        let light = sky(Vec3::new(0.0, -cos, sin)).sky().unwrap();
        let expected = [
            (Vec3::Z, [0.018_780, 0.034_681, 0.069_905]),
            (Vec3::new(1.0, 0.0, 0.1), [0.101_506, 0.151_692, 0.200_568]),
            (Vec3::new(0.0, 1.0, 0.5), [0.041_790, 0.074_806, 0.129_520]),
        ];
        for (direction, want) in expected {
            let got = look(&light, direction).to_array();
            for k in 0..3 {
                // The picture is interpolated between texels 0.7 degrees apart.
                assert!((got[k] / want[k] - 1.0).abs() < 0.01, "{direction}: {got:?} {want:?}");
            }
        }
        assert!(look(&light, -Vec3::Z).is_black());
    }

    #[test]
    fn the_sky_is_brightest_around_the_sun() {
        for direction in [Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.3, -0.8, 0.4)] {
            let light = sky(direction).sky().unwrap();
            let at = look(&light, direction).luminance();
            for other in [Vec3::Z, Vec3::new(-1.0, 0.0, 1.0), Vec3::new(0.0, 1.0, 0.5)] {
                assert!(look(&light, other).luminance() < at);
            }
        }
    }

    #[test]
    fn a_larger_sun_gives_the_same_light() {
        let flux = |radius: f32| {
            let light = SunSky { angular_radius: radius, ..sky(Vec3::ONE) }.sun();
            let LightSource::DistantDisc { radiance, angular_radius, .. } = light else { panic!() };
            radiance.g * (0.5 * angular_radius).sin().powi(2)
        };
        assert!((flux(sun::ANGULAR_RADIUS) / flux(0.1) - 1.0).abs() < 1e-4);
    }
}
