use gi_core::light::{LightSource, Window};
use gi_core::math::{Frame, Rgb};
use gi_core::texture::{Bitmap, Texels, Texture, Wrap};
use glam::{Affine2, Affine3A, Mat3, Vec2, Vec3};
use std::f32::consts::PI;
use std::sync::Arc;

use super::{Exporter, degrees, numbers};
use crate::origins::LightOrigin;
use crate::sky::model::SunSky;

impl Exporter<'_> {
    /// Write all lights that are not surfaces.
    pub(super) fn lights(&mut self) -> Result<(), String> {
        let loaded = self.loaded;
        let at_infinity = |light: &&LightSource| {
            matches!(light, LightSource::Environment { .. } | LightSource::Constant { .. })
        };
        if loaded.parts.lights.iter().filter(at_infinity).count() > 1 {
            self.warn("several lights at infinity are exported: Mitsuba 3 accepts only one");
        }
        for (light, origin) in loaded.parts.lights.iter().zip(&loaded.origins.lights) {
            match origin {
                LightOrigin::SunSky(sky) => self.sun_and_sky(sky),
                LightOrigin::SameAsBefore => {}
                LightOrigin::Picture(path) => {
                    let file = self.file_name(path);
                    self.light(light, Some(&file))?;
                }
                LightOrigin::Itself => self.light(light, None)?,
            }
        }
        Ok(())
    }

    fn light(&mut self, light: &LightSource, file: Option<&str>) -> Result<(), String> {
        let xml = &mut self.xml;
        match light {
            LightSource::Point { position, intensity } => {
                xml.open("emitter", &[("type", "point")]);
                xml.value("point", "position", &numbers(&position.to_array()));
                xml.color("intensity", *intensity);
            }
            LightSource::Spot { position, direction, intensity, cutoff, beam } => {
                xml.open("emitter", &[("type", "spot")]);
                let f = Frame::from_normal(*direction);
                let rotation = Mat3::from_cols(f.s, f.t, f.n);
                xml.transform("to_world", &Affine3A::from_mat3_translation(rotation, *position));
                xml.color("intensity", *intensity);
                xml.value("float", "cutoff_angle", &degrees(*cutoff));
                xml.value("float", "beam_width", &degrees(*beam));
            }
            LightSource::Projector { position, axes, intensity, cutoff, beam, picture, window } => {
                let [x, y, z] = axes.map(Vec3::normalize_or_zero);
                let to_world = Affine3A::from_mat3_translation(Mat3::from_cols(x, y, z), *position);
                match window {
                    Window::Cone => {}
                    Window::Irradiance(half) => {
                        // Mitsuba multiplies the irradiance by pi; ours is the intensity toward the corners times cos^3.
                        let factor = *intensity * ((1.0 + half.length_squared()).powf(-1.5) / PI);
                        let picture = picture.clone().scaled(factor);
                        return self.projector(&to_world, *half, &picture);
                    }
                    Window::Intensity(half) => {
                        let picture = as_irradiance(picture, *half).scaled(*intensity * (1.0 / PI));
                        return self.projector(&to_world, *half, &picture);
                    }
                    Window::Unfolded | Window::Latitudes => {
                        return self.as_point(*position, *intensity * picture.mean());
                    }
                }
                xml.open("emitter", &[("type", "spot")]);
                xml.transform("to_world", &to_world);
                xml.color("intensity", *intensity);
                xml.value("float", "cutoff_angle", &degrees(*cutoff));
                xml.value("float", "beam_width", &degrees(*beam));
                self.texture("texture", picture)?;
            }
            LightSource::Directional { direction, irradiance } => {
                xml.open("emitter", &[("type", "directional")]);
                xml.value("vector", "direction", &numbers(&direction.to_array()));
                xml.color("irradiance", *irradiance);
            }
            LightSource::Constant { radiance } => {
                xml.open("emitter", &[("type", "constant")]);
                xml.color("radiance", *radiance);
            }
            LightSource::Environment { image, scale, to_world } => {
                let file = match file {
                    Some(file) => file.to_owned(),
                    None => self.bake(image, Rgb::WHITE)?,
                };
                let xml = &mut self.xml;
                xml.open("emitter", &[("type", "envmap")]);
                xml.value("string", "filename", &file);
                xml.value("float", "scale", &scale.to_string());
                xml.transform("to_world", to_world);
            }
            LightSource::DistantDisc { .. } => {
                return Err("a sun that comes from no `sunsky`".into());
            }
        }
        self.xml.close();
        Ok(())
    }

    /// Mitsuba has no goniometric light: a point light with the mean intensity.
    fn as_point(&mut self, position: Vec3, intensity: Rgb) -> Result<(), String> {
        self.warn("a goniometric light is exported as a point light: Mitsuba 3 has none");
        self.light(&LightSource::Point { position, intensity }, None)
    }

    fn projector(
        &mut self,
        to_world: &Affine3A,
        half: Vec2,
        irradiance: &Texture,
    ) -> Result<(), String> {
        self.xml.open("emitter", &[("type", "projector")]);
        self.xml.transform("to_world", to_world);
        self.xml.value("float", "fov", &degrees(2.0 * half.x.atan()));
        self.texture("irradiance", irradiance)?;
        self.xml.close();
        Ok(())
    }

    fn sun_and_sky(&mut self, sky: &SunSky) {
        if sky.extend {
            self.warn("`extend` is not exported: Mitsuba 3's sky ends at the horizon");
        }
        let xml = &mut self.xml;
        xml.open("emitter", &[("type", "sunsky")]);
        xml.value("float", "turbidity", &sky.turbidity.to_string());
        xml.color("albedo", Rgb::clone(&sky.albedo));
        xml.value("vector", "sun_direction", &numbers(&sky.sun_direction.to_array()));
        xml.value("float", "sun_scale", &sky.sun_scale.to_string());
        xml.value("float", "sky_scale", &sky.sky_scale.to_string());
        xml.value("float", "sun_aperture", &degrees(2.0 * sky.angular_radius));
        xml.transform("to_world", &sky.to_world);
        xml.close();
    }
}

/// Smallest number of texels along a side of an exported projection.
const FINE: usize = 512;

/// The irradiance of a window at distance one whose picture is the intensity. Each texel becomes as many as it takes for the
/// cosine to be nearly the same within one.
fn as_irradiance(picture: &Texture, half: Vec2) -> Texture {
    let Texture::Bitmap { bitmap, .. } = picture else { return picture.clone() };
    let [w, h] = [bitmap.width(), bitmap.height()].map(|n| n * FINE.div_ceil(n));
    let size = Vec2::new(w as f32, h as f32);
    let texel = |i: usize| {
        let at = (Vec2::new((i % w) as f32, (i / w) as f32) + 0.5) / size;
        let on_plane = ((2.0 * at - 1.0) * half).extend(1.0);
        picture.eval(at) * on_plane.length().powi(-3)
    };
    let texels = Texels::Float((0..w * h).map(texel).collect());
    let bitmap = Arc::new(Bitmap::new(w, h, texels, Wrap::Clamp, bitmap.lookup()));
    Texture::Bitmap { bitmap, to_uv: Affine2::IDENTITY, scale: Rgb::WHITE }
}
