//! Lights: those at points, those at infinity, and area lights.

use std::rc::Rc;

use gi_core::math::Rgb;
use glam::{DAffine3, DMat3, DVec3};

use super::Translator;
use super::params::Params;
use super::pictured_lights::picture_file;
use super::types::Text;
use crate::diagnostics::Span;
use crate::document::{Class, Meaning, ObjectId, Value};

/// The lights of pbrt, and the one that pbrt-v3 has besides.
const KNOWN: [&str; 7] =
    ["point", "spot", "distant", "infinite", "goniometric", "projection", "exinfinite"];

/// What an `AreaLightSource` gives to the shapes after it.
#[derive(Debug)]
pub(super) struct AreaLight {
    span: Span,
    radiance: Rgb,
    /// The picture of the radiance.
    picture: Option<Text>,
    scale: f64,
    /// The power that the shape emits in all, instead of its radiance.
    power: Option<f64>,
    two_sided: bool,
}

impl AreaLight {
    pub(super) fn has_picture(&self) -> bool {
        self.picture.is_some()
    }
}

impl Translator<'_> {
    /// `LightSource`.
    pub(super) fn light(&mut self, params: &Params) {
        if self.group.is_some() {
            self.report.warn(params.span, "a light inside `ObjectBegin`: it is not repeated");
        }
        let light = match params.plugin.as_str() {
            "point" => Some(self.point(params)),
            "goniometric" => Some(self.goniometric(params)),
            "spot" => self.spot(params),
            "distant" => self.distant(params),
            "infinite" | "exinfinite" => Some(self.infinite(params)),
            "projection" => self.projection(params),
            _ => {
                params.unknown_plugin(&KNOWN, self.report);
                return;
            }
        };
        params.report_unused(self.report);
        if let Some(light) = light {
            self.doc.nest(self.scene, "", light);
        }
    }

    pub(super) fn emitter(&mut self, params: &Params, plugin: &str) -> ObjectId {
        self.doc.add(Class::Emitter, "light", plugin, params.span)
    }

    /// The light's colour times its scale. A scale may be a colour in pbrt-v3.
    pub(super) fn emission(&self, params: &Params, name: &'static str) -> Rgb {
        let default = self.state.now.color_space.white();
        let color = self.color(params, name, Meaning::Light).unwrap_or(default);
        let factor = self.color(params, "scale", Meaning::Factor).unwrap_or(Rgb::WHITE);
        color * factor * self.scale(params) as f32
    }

    pub(super) fn scale(&self, params: &Params) -> f64 {
        params.number("scale", self.report).unwrap_or(1.0)
    }

    /// The factor that gives a light its `power`, if that is given: pbrt divides by that of a unit of the light.
    fn power_factor(&self, params: &Params, of_a_unit: f64) -> f32 {
        match params.number("power", self.report) {
            Some(power) if power > 0.0 => (power / of_a_unit) as f32,
            _ => 1.0,
        }
    }

    pub(super) fn point(&mut self, params: &Params) -> ObjectId {
        let span = params.span;
        let factor = self.power_factor(params, 4.0 * std::f64::consts::PI);
        let intensity = self.emission(params, "I") * factor;
        let light = self.emitter(params, "point");
        let from = params.triple("from", self.report).unwrap_or(DVec3::ZERO);
        self.doc.set(light, "position", params.span_of("from"), Value::Vector(from));
        self.doc.set(light, "to_world", span, Value::transform(self.state.now.ctm));
        self.doc.set(light, "intensity", params.span_of("I"), Value::Color(intensity));
        light
    }

    /// The direction from `from` to `to`; reports an error if they are the same.
    fn direction(&self, params: &Params) -> Option<(DVec3, DVec3)> {
        let from = params.triple("from", self.report).unwrap_or(DVec3::ZERO);
        let to = params.triple("to", self.report).unwrap_or(DVec3::Z);
        let direction = (to - from).try_normalize();
        if direction.is_none() {
            self.report.error(params.span_of("to"), "`from` and `to` are the same point", "");
        }
        Some((from, direction?))
    }

    /// A spot light. pbrt's cone fades smoothly in the cosine, ours linearly in the angle.
    fn spot(&mut self, params: &Params) -> Option<ObjectId> {
        let (report, span) = (self.report, params.span);
        let (from, direction) = self.direction(params)?;
        let cone = params.within("coneangle", 30.0, [1e-3, 180.0], report);
        let delta = params.within("conedeltaangle", 5.0, [0.0, 180.0], report);
        let beam = (cone - delta).max(0.0);
        let [end, start] = [cone, beam].map(|degrees| degrees.to_radians().cos());
        let unit = std::f64::consts::TAU * ((1.0 - start) + 0.5 * (start - end));
        let intensity = self.emission(params, "I") * self.power_factor(params, unit);
        let light = self.emitter(params, "spot");
        let place = self.state.now.ctm * DAffine3::from_translation(from);
        self.doc.set(light, "to_world", span, Value::transform(place));
        self.doc.set(light, "direction", span, Value::Vector(direction));
        self.doc.set(light, "intensity", params.span_of("I"), Value::Color(intensity));
        let cone = cone as f32;
        self.doc.set(light, "cutoff_angle", params.span_of("coneangle"), Value::Float(cone));
        self.doc.set(light, "beam_width", span, Value::Float((beam as f32).min(cone)));
        Some(light)
    }

    fn distant(&mut self, params: &Params) -> Option<ObjectId> {
        let (_, direction) = self.direction(params)?;
        let mut irradiance = self.emission(params, "L");
        if let Some(lux) = params.number("illuminance", self.report).filter(|e| *e > 0.0) {
            irradiance *= lux as f32;
        }
        let light = self.emitter(params, "directional");
        let to_world = Value::transform(self.state.now.ctm);
        self.doc.set(light, "to_world", params.span, to_world);
        self.doc.set(light, "direction", params.span, Value::Vector(direction));
        self.doc.set(light, "irradiance", params.span_of("L"), Value::Color(irradiance));
        Some(light)
    }

    fn infinite(&mut self, params: &Params) -> ObjectId {
        let (report, span) = (self.report, params.span);
        params.note_ignored(&["portal"], "light from all directions is sampled", report);
        params.ignore(&["nsamples", "samples"]);
        let lux = params.number("illuminance", report).filter(|e| *e > 0.0);
        let Some(file) = picture_file(params) else {
            let factor = lux.map_or(1.0, |e| e / std::f64::consts::PI) as f32;
            let radiance = self.emission(params, "L") * factor;
            let light = self.emitter(params, "constant");
            self.doc.set(light, "radiance", params.span_of("L"), Value::Color(radiance));
            return light;
        };
        if lux.is_some() {
            let message = "`illuminance` of a picture is ignored: its radiance counts";
            report.warn(params.span_of("illuminance"), message);
        }
        let light = self.emitter(params, "envmap");
        self.doc.set(light, "filename", file.span, Value::Text(file.text.clone()));
        let scale = if self.is_v3 {
            let color = self.emission(params, "L");
            let most = color.max();
            if most > 0.0 {
                let tint = Value::Color(color * (1.0 / most));
                self.doc.set(light, "tint", params.span_of("L"), tint);
            }
            most
        } else {
            self.doc.set(light, "equal_area", span, Value::Bool(true));
            self.scale(params) as f32
        };
        self.doc.set(light, "scale", params.span_of("scale"), Value::Float(scale));
        let to_world = self.state.now.ctm * DAffine3::from_mat3(UPRIGHT);
        self.doc.set(light, "to_world", span, Value::transform(to_world));
        light
    }

    /// `AreaLightSource`: the emission of the shapes that follow.
    pub(super) fn area_light(&mut self, params: &Params) {
        if !["diffuse", "area"].contains(&params.plugin.as_str()) {
            params.unknown_plugin(&["diffuse"], self.report);
            return;
        }
        params.ignore(&["nsamples", "samples"]);
        let picture = params.text("filename").filter(|file| !file.text.is_empty()).cloned();
        let light = AreaLight {
            span: params.span_of("L"),
            radiance: self.emission(params, "L"),
            picture,
            scale: self.scale(params),
            power: params.number("power", self.report).filter(|power| *power > 0.0),
            two_sided: params.bool("twosided", false, self.report),
        };
        params.report_unused(self.report);
        self.state.now.area_light = Some(Rc::new(light));
    }

    /// Make a shape emit as the current area light says.
    pub(super) fn attach_area_light(&mut self, shape: ObjectId, params: &Params) {
        let Some(light) = self.state.now.area_light.clone() else { return };
        if self.group.is_some() {
            let message = "an area light inside `ObjectBegin` is ignored";
            return self.report.warn(params.span, message);
        }
        let emitter = self.doc.add(Class::Emitter, "area light", "area", light.span);
        match &light.picture {
            Some(file) => {
                let picture = self.doc.add(Class::Texture, "area light", "bitmap", file.span);
                self.doc.set(picture, "filename", file.span, Value::Text(file.text.clone()));
                let to_uv = Value::transform(super::pictures::downward());
                self.doc.set(picture, "to_uv", file.span, to_uv);
                let scale = self.doc.add(Class::Texture, "area light", "scale", file.span);
                let factor = Value::Color(Rgb::grey(light.scale as f32));
                self.doc.set(scale, "scale", file.span, factor);
                self.doc.nest(scale, "", picture);
                self.doc.nest(emitter, "radiance", scale);
            }
            None => self.doc.set(emitter, "radiance", light.span, Value::Color(light.radiance)),
        }
        if let Some(power) = light.power {
            self.doc.set(emitter, "power", light.span, Value::Float(power as f32));
        }
        if light.two_sided {
            self.doc.set(emitter, "two_sided", light.span, Value::Bool(true));
        }
        self.doc.nest(shape, "", emitter);
    }
}

/// From Mitsuba's local axes of a picture at infinity (+y up, u from -z toward +x) to those of pbrt (+z up, u from +x
/// toward +y). It mirrors, because the two run in opposite directions.
const UPRIGHT: DMat3 = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::NEG_X);
