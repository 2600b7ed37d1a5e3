//! Textures that are pictures, and how coordinates lead to them.

use gi_core::math::Rgb;
use glam::{DAffine3, DMat3, DVec3};

use super::Translator;
use super::params::Params;
use super::types::Type;
use crate::document::{Class, ObjectId, Value};

impl Translator<'_> {
    /// `imagemap`: a picture.
    pub(super) fn imagemap(&mut self, params: &Params) -> Option<ObjectId> {
        let Some(file) = params.text("filename") else {
            self.report.error(params.span, "`imagemap` without a `filename`", "");
            return None;
        };
        let (report, span) = (self.report, params.span);
        let texture = self.doc.add(Class::Texture, "texture", "bitmap", span);
        self.doc.set(texture, "filename", file.span, Value::Text(file.text.clone()));
        let to_uv = self.mapping(params, true);
        self.doc.set(texture, "to_uv", span, Value::transform(to_uv));
        params.ignore(&["maxanisotropy", "trilinear"]);
        if let Some(wrap) = params.text("wrap") {
            let mode = match wrap.text.as_str() {
                "repeat" => "repeat",
                "clamp" | "black" => "clamp",
                "octahedralsphere" => "repeat",
                other => {
                    let message = format!("unknown wrap mode `{other}`");
                    report.error(wrap.span, message, "expected repeat, clamp or black");
                    "repeat"
                }
            };
            if wrap.text == "black" {
                report.warn(wrap.span, "wrap mode `black` is read as `clamp`");
            }
            self.doc.set(texture, "wrap_mode", wrap.span, Value::Text(mode.into()));
        }
        if params.text("filter").is_some_and(|f| f.text == "point") {
            self.doc.set(texture, "filter_type", span, Value::Text("nearest".into()));
        }
        let encoding = params.text("encoding");
        if let Some(gamma) = encoding.filter(|e| e.text.starts_with("gamma")) {
            report.warn(gamma.span, format!("encoding `{}` is read as sRGB", gamma.text));
        }
        let is_linear = encoding.is_some_and(|e| e.text == "linear");
        let gamma = params.find("gamma", |p| p.kind == Type::Bool).is_some();
        if is_linear || (gamma && !params.bool("gamma", true, report)) {
            self.doc.set(texture, "raw", span, Value::Bool(true));
        }
        let scale = params.number("scale", report).unwrap_or(1.0) as f32;
        if params.bool("invert", false, report) {
            // The picture is scaled first.
            self.doc.set(texture, "invert", params.span_of("invert"), Value::Bool(true));
            self.doc.set(texture, "scale", params.span_of("scale"), Value::Float(scale));
            return Some(texture);
        }
        Some(if scale == 1.0 { texture } else { self.scaled(texture, Rgb::grey(scale), span) })
    }

    /// From a surface's coordinates to those of a texture. A picture's second coordinate runs downward.
    pub(super) fn mapping(&self, params: &Params, picture: bool) -> DAffine3 {
        if let Some(kind) = params.text("mapping").filter(|kind| kind.text != "uv") {
            let message =
                format!("the mapping `{}` is ignored: the surface's own is used", kind.text);
            self.report.warn(kind.span, message);
            params.ignore(&["v1", "v2"]);
        }
        let number = |name, default| params.number(name, self.report).unwrap_or(default);
        let (u, v) = (number("uscale", 1.0), number("vscale", 1.0));
        let (du, dv) = (number("udelta", 0.0), number("vdelta", 0.0));
        let own = DAffine3 {
            matrix3: DMat3::from_diagonal(DVec3::new(u, v, 1.0)),
            translation: DVec3::new(du, dv, 0.0),
        };
        if picture { downward() * own } else { own }
    }
}

/// From pbrt's coordinates, whose second one runs upward, to those of a picture.
pub(super) fn downward() -> DAffine3 {
    DAffine3 { matrix3: DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0)), translation: DVec3::Y }
}
