//! Lights at points whose intensity is a picture: `goniometric` and `projection`.

use gi_core::math::Rgb;
use glam::{DAffine3, DMat3, DVec3};

use super::Translator;
use super::params::Params;
use super::types::Text;
use crate::document::{Class, ObjectId, Value};

impl Translator<'_> {
    /// A point light whose intensity is a picture of all directions.
    pub(super) fn goniometric(&mut self, params: &Params) -> ObjectId {
        let Some(file) = picture_file(params) else {
            let name = self.picture_name();
            let effect = "its intensity is the same in all directions";
            self.report.warn(params.span, format!("`goniometric` without a `{name}`: {effect}"));
            return self.point(params);
        };
        let light = self.emitter(params, "goniometric");
        let intensity = self.emission(params, "I");
        self.doc.set(light, "intensity", params.span_of("I"), Value::Color(intensity));
        self.doc.set(light, "latitude_longitude", params.span, Value::Bool(self.is_v3));
        self.light_picture(light, &file, params, DAffine3::from_mat3(ASIDE));
        light
    }

    /// The parameter that names the picture of a light.
    fn picture_name(&self) -> &'static str {
        if self.is_v3 { "mapname" } else { "filename" }
    }

    /// A point light whose intensity is a picture within a window.
    pub(super) fn projection(&mut self, params: &Params) -> Option<ObjectId> {
        let Some(file) = picture_file(params) else {
            let message = format!("`projection` without a `{}`", self.picture_name());
            self.report.error(params.span, message, "expected the file of a picture");
            return None;
        };
        let light = self.emitter(params, "projection");
        // pbrt-v4 shows the picture as a camera would see it; pbrt-v3 shows it upside down.
        let (fov, up) = if self.is_v3 { (45.0, -1.0) } else { (90.0, 1.0) };
        let intensity = match self.is_v3 {
            true => self.emission(params, "I"),
            false => Rgb::grey(self.scale(params) as f32),
        };
        self.doc.set(light, "intensity", params.span_of("scale"), Value::Color(intensity));
        let fov = params.within("fov", fov, [1e-3, 179.0], self.report);
        self.doc.set(light, "fov", params.span_of("fov"), Value::Float(fov as f32));
        // The axes of a picture in a window run to the left and downward.
        let axes = DMat3::from_diagonal(DVec3::new(-1.0, up, 1.0));
        self.light_picture(light, &file, params, DAffine3::from_mat3(axes));
        Some(light)
    }

    /// The picture of a light, its axes, and the power that it gives the light.
    fn light_picture(&mut self, light: ObjectId, file: &Text, params: &Params, axes: DAffine3) {
        let picture = self.doc.add(Class::Texture, "light", "bitmap", file.span);
        self.doc.set(picture, "filename", file.span, Value::Text(file.text.clone()));
        if !self.is_v3 {
            self.doc.set(picture, "wrap_mode", file.span, Value::Text("clamp".into()));
            self.doc.set(picture, "filter_type", file.span, Value::Text("nearest".into()));
        }
        self.doc.nest(light, "picture", picture);
        let to_world = Value::transform(self.state.now.ctm * axes);
        self.doc.set(light, "to_world", params.span, to_world);
        let power = if self.is_v3 { None } else { params.number("power", self.report) };
        if let Some(power) = power.filter(|power| *power > 0.0) {
            self.doc.set(light, "power", params.span_of("power"), Value::Float(power as f32));
        }
    }
}

/// The file of a light's picture.
pub(super) fn picture_file(params: &Params) -> Option<Text> {
    let file = params.text("filename").or_else(|| params.text("mapname"));
    file.filter(|file| !file.text.is_empty()).cloned()
}

/// The axes of a goniometric light: y and z are exchanged.
const ASIDE: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y);
