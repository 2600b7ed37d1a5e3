//! The camera, its film and filter, and the integrator's longest path.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::Translator;
use super::params::Params;
use crate::diagnostics::Span;
use crate::document::{Class, ObjectId, Value};

/// The cameras that are read, and the one that is not.
const KNOWN: [&str; 5] = ["perspective", "orthographic", "realistic", "spherical", "environment"];
/// Default size of the film, in pbrt-v4 and in pbrt-v3.
const SIZES: [[i64; 2]; 2] = [[1280, 720], [640, 480]];
/// Default of the longest path in pbrt, in bounces.
const MAX_DEPTH: i64 = 5;
/// Film diagonal of pbrt's realistic camera, millimetres.
const DIAGONAL: f64 = 35.0;

impl Translator<'_> {
    /// `Camera`: the current transform leads from the world to the camera.
    pub(super) fn camera(&mut self, params: Params) {
        let to_world = self.state.now.ctm.inverse();
        if !to_world.is_finite() {
            let message = "the camera's transform cannot be inverted";
            return self.report.error(params.span, message, "");
        }
        self.state.name_this("camera", to_world);
        self.camera = Some((params, to_world));
    }

    /// Add the sensor, once all directives are read.
    pub(super) fn add_sensor(&mut self) {
        let Some((params, to_world)) = self.camera.take() else { return };
        let size = self.film_size();
        let aspect = size[0] as f64 / size[1] as f64;
        if let Some(sensor) = self.sensor(&params, to_world, aspect) {
            let film = self.add_film(size, params.span);
            self.doc.nest(sensor, "", film);
            self.doc.nest(self.scene, "", sensor);
        }
        params.report_unused(self.report);
    }

    fn sensor(&mut self, params: &Params, to_world: DAffine3, aspect: f64) -> Option<ObjectId> {
        let (report, span) = (self.report, params.span);
        params.ignore(&["shutteropen", "shutterclose"]);
        let (half, center) = self.screen(params, aspect);
        // pbrt's camera has +x to the right, ours to the left.
        let mut scale = DVec3::new(-1.0, 1.0, 1.0);
        let mut offset = DVec3::ZERO;
        let plugin = match params.plugin.as_str() {
            "perspective" | "realistic" => "thinlens",
            "orthographic" => {
                scale *= DVec3::new(half.x, half.x, 1.0);
                offset = center.extend(0.0);
                "orthographic"
            }
            kind @ ("spherical" | "environment") => {
                report.error(
                    span,
                    format!("camera `{kind}` is not supported"),
                    "expected perspective",
                );
                return None;
            }
            _ => {
                params.unknown_plugin(&KNOWN, report);
                return None;
            }
        };
        let sensor = self.doc.add(Class::Sensor, "camera", plugin, span);
        let axes = DAffine3 { matrix3: DMat3::from_diagonal(scale), translation: offset };
        self.doc.set(sensor, "to_world", span, Value::transform(to_world * axes));
        if plugin == "thinlens" {
            self.perspective(sensor, params, half, center);
        } else {
            params.note_ignored(&["lensradius"], "everything is sharp", report);
            params.ignore(&["focaldistance", "fov"]);
        }
        Some(sensor)
    }

    /// Half the extent of the picture on the plane at distance one, for an angle of view of 90 degrees, and its centre.
    fn screen(&self, params: &Params, aspect: f64) -> (DVec2, DVec2) {
        let frame = match params.number("frameaspectratio", self.report) {
            Some(ratio) if ratio > 0.0 => ratio,
            _ => aspect,
        };
        let shorter =
            if frame > 1.0 { DVec2::new(frame, 1.0) } else { DVec2::new(1.0, 1.0 / frame) };
        let (half, center) = match params.numbers("screenwindow") {
            Some(&[x0, x1, y0, y1]) if x0 < x1 && y0 < y1 => {
                (DVec2::new(x1 - x0, y1 - y0) * 0.5, DVec2::new(x0 + x1, y0 + y1) * 0.5)
            }
            Some(_) => {
                let span = params.span_of("screenwindow");
                let message = "`screenwindow` is not a window";
                self.report.error(
                    span,
                    message,
                    "expected the least and largest x, then those of y",
                );
                (shorter, DVec2::ZERO)
            }
            None => (shorter, DVec2::ZERO),
        };
        if (half.x / half.y / aspect - 1.0).abs() > 1e-3 {
            let message =
                "pixels are not square: the picture keeps its width, and its height changes";
            self.report.warn(params.span, message);
        }
        (half, center)
    }

    fn perspective(&mut self, sensor: ObjectId, params: &Params, half: DVec2, center: DVec2) {
        let report = self.report;
        let degrees = if params.plugin == "realistic" {
            self.realistic_fov(params)
        } else {
            let fov = params.number("fov", report).unwrap_or(90.0);
            let from_half = params.number("halffov", report).map(|half| 2.0 * half);
            let fov = from_half.unwrap_or(fov);
            if !(0.0 < fov && fov < 180.0) {
                report.error(params.span_of("fov"), format!("fov {fov}"), "expected 0 to 180");
                return;
            }
            fov
        };
        // The angle of pbrt is that of a picture from -1 to 1, the shorter side unless `screenwindow` says otherwise.
        let tangent = (0.5 * degrees.to_radians()).tan();
        let fov_x = 2.0 * (half.x * tangent).atan().to_degrees();
        let span = params.span_of("fov");
        self.doc.set(sensor, "fov", span, Value::Float(fov_x as f32));
        self.doc.set(sensor, "fov_axis", span, Value::Text("x".into()));
        let offset = center / (2.0 * half);
        let offsets =
            [("principal_point_offset_x", offset.x), ("principal_point_offset_y", -offset.y)];
        for (name, v) in offsets.into_iter().filter(|(_, v)| *v != 0.0) {
            self.doc.set(sensor, name, span, Value::Float(v as f32));
        }
        let lens = params.number("lensradius", report).unwrap_or(0.0) as f32;
        let focus = params.number("focaldistance", report).unwrap_or(1e6) as f32;
        self.doc.set(sensor, "aperture_radius", params.span_of("lensradius"), Value::Float(lens));
        self.doc.set(
            sensor,
            "focus_distance",
            params.span_of("focaldistance"),
            Value::Float(focus),
        );
    }

    /// The angle of view of a realistic camera, from the focal length in the name of its lens file.
    fn realistic_fov(&self, params: &Params) -> f64 {
        params.ignore(&["aperturediameter", "focusdistance", "aperture", "simpleweighting"]);
        let file = params.text("lensfile");
        let length = file.and_then(|file| {
            let stem = file.text.split("mm").next()?;
            let digits = stem.rfind(|c: char| !c.is_ascii_digit()).map_or(0, |i| i + 1);
            stem[digits..].parse::<f64>().ok().filter(|mm| *mm >= 1.0)
        });
        let length = length.unwrap_or(50.0);
        let message = format!("camera `realistic` is approximated by a pinhole of {length} mm");
        self.report.warn(params.span, message);
        // Half of the shorter side of a film of 3 : 2.
        let half = 0.5 * DIAGONAL * 2.0 / 13f64.sqrt();
        2.0 * (half / length).atan().to_degrees()
    }

    fn film_size(&self) -> [i64; 2] {
        let default = SIZES[usize::from(self.is_v3)];
        let Some(film) = &self.film else { return default };
        let side = |name, default| film.integer(name, self.report).unwrap_or(default);
        let size = [side("xresolution", default[0]), side("yresolution", default[1])];
        if size.iter().all(|side| (1..=1 << 15).contains(side)) {
            return size;
        }
        let message = format!("a film of {} x {}", size[0], size[1]);
        self.report.error(film.span, message, "expected 1 to 32768");
        default
    }

    fn add_film(&mut self, size: [i64; 2], camera: Span) -> ObjectId {
        let span = self.film.as_ref().map_or(camera, |film| film.span);
        let film = self.doc.add(Class::Film, "film", "hdrfilm", span);
        for (name, side) in ["width", "height"].into_iter().zip(size) {
            self.doc.set(film, name, span, Value::Integer(side));
        }
        if let Some(params) = self.film.take() {
            self.note_exposure(&params);
            let why = "the whole picture is rendered";
            params.note_ignored(&["cropwindow", "pixelbounds"], why, self.report);
            params.ignore(&["xresolution", "yresolution", "filename", "diagonal", "savefp16"]);
            params.ignore(&[
                "maxcomponentvalue",
                "maxsampleluminance",
                "scale",
                "coordinatesystem",
            ]);
            params.report_unused(self.report);
        }
        let filter = self.add_filter(span);
        self.doc.nest(film, "", filter);
        film
    }

    /// Our pictures are linear radiance. pbrt multiplies by the exposure, and balances the sensor's colours.
    fn note_exposure(&self, film: &Params) {
        film.ignore(&["iso", "exposuretime", "whitebalance", "sensor"]);
        let iso = film.number("iso", self.report).unwrap_or(100.0);
        let time = film.number("exposuretime", self.report).unwrap_or(1.0);
        let sensor = film.text("sensor").map_or("cie1931", |sensor| &sensor.text);
        let ratio = iso / 100.0 * time;
        if ratio != 1.0 || sensor != "cie1931" || film.has("whitebalance") {
            let message = format!(
                "the film's exposure, sensor and white balance are ignored: the picture is linear radiance, \
                 which pbrt multiplies by {ratio}"
            );
            self.report.warn(film.span, message);
        }
    }

    fn add_filter(&mut self, film: Span) -> ObjectId {
        let report = self.report;
        let Some(params) = self.filter.take() else {
            let plugin = if self.is_v3 { "box" } else { "gaussian" };
            return self.doc.add(Class::Filter, "filter", plugin, film);
        };
        let number = |name, default: f64| params.number(name, report).unwrap_or(default);
        let (plugin, values): (&str, Vec<(&str, f64)>) = match params.plugin.as_str() {
            "box" => ("box", vec![]),
            "triangle" => ("tent", vec![]),
            "gaussian" => {
                // pbrt-v3's exponent is 1 / (2 sigma^2).
                let old = params.number("alpha", report).filter(|alpha| *alpha > 0.0);
                let default = if self.is_v3 { 2.0 } else { 0.0 };
                let sigma = match old.unwrap_or(default) {
                    0.0 => number("sigma", 0.5),
                    alpha => (0.5 / alpha).sqrt(),
                };
                ("gaussian", vec![("stddev", sigma)])
            }
            "mitchell" => {
                let third = 1.0 / 3.0;
                ("mitchell", vec![("b", number("B", third)), ("c", number("C", third))])
            }
            "sinc" => ("lanczos", vec![("lobes", number("tau", 3.0).round())]),
            _ => {
                let known = ["box", "triangle", "gaussian", "mitchell", "sinc"];
                params.unknown_plugin(&known, report);
                ("box", vec![])
            }
        };
        if let ("box", Some(r)) = (plugin, params.number("xradius", report).filter(|r| *r != 0.5)) {
            report.warn(
                params.span_of("xradius"),
                format!("a box of radius {r} is read as one pixel"),
            );
        }
        params.ignore(&["xradius", "yradius", "xwidth", "ywidth"]);
        params.report_unused(report);
        let filter = self.doc.add(Class::Filter, "filter", plugin, params.span);
        for (name, v) in values {
            self.doc.set(filter, name, params.span, Value::Float(v as f32));
        }
        filter
    }

    /// Add the integrator. Its depth counts bounces, ours segments.
    pub(super) fn add_integrator(&mut self) {
        let Some(params) = self.integrator.take() else { return };
        let depth = params.integer("maxdepth", self.report).unwrap_or(MAX_DEPTH);
        let object = self.doc.add(Class::Ignored, "integrator", &params.plugin, params.span);
        let depth = Value::Integer(depth.clamp(0, 1 << 20) + 1);
        self.doc.set(object, "max_depth", params.span_of("maxdepth"), depth);
        self.doc.nest(self.scene, "", object);
    }
}
