//! Homogeneous media, and those of a uniform grid.

use gi_core::math::Rgb;
use gi_core::medium::Cells;
use glam::{DAffine3, DVec3};

use super::Translator;
use super::params::Params;
use super::types::Text;
use crate::diagnostics::Span;
use crate::document::{Class, Meaning, ObjectId, Value};
use crate::hash::Hash;
use crate::media::InlineGrid;
use crate::volumes::is_valid;

/// The media that are read. `heterogeneous` is the name of `uniformgrid` in pbrt-v3.
const KNOWN: [&str; 3] = ["homogeneous", "uniformgrid", "heterogeneous"];

/// The media that are refused, with the reason and what to use instead.
const REFUSED: [(&str, &str, &str); 3] = [
    ("rgbgrid", "each coefficient has a grid of its own", "use `uniformgrid` with one density"),
    ("cloud", "its density is a procedure", "sample it into a `uniformgrid`"),
    ("nanovdb", "the NanoVDB format is not read", "convert the file's grid to a `uniformgrid`"),
];

/// Reduced scattering and absorption coefficients per millimetre \[Jensen01\].
const PRESETS: [(&str, [f32; 3], [f32; 3]); 12] = [
    ("Apple", [2.29, 2.39, 1.97], [0.0030, 0.0034, 0.046]),
    ("Chicken1", [0.15, 0.21, 0.38], [0.015, 0.077, 0.19]),
    ("Chicken2", [0.19, 0.25, 0.32], [0.018, 0.088, 0.20]),
    ("Cream", [7.38, 5.47, 3.15], [0.0002, 0.0028, 0.0163]),
    ("Ketchup", [0.18, 0.07, 0.03], [0.061, 0.97, 1.45]),
    ("Marble", [2.19, 2.62, 3.00], [0.0021, 0.0041, 0.0071]),
    ("Potato", [0.68, 0.70, 0.55], [0.0024, 0.0090, 0.12]),
    ("Skimmilk", [0.70, 1.22, 1.90], [0.0014, 0.0025, 0.0142]),
    ("Skin1", [0.74, 0.88, 1.01], [0.032, 0.17, 0.48]),
    ("Skin2", [1.09, 1.59, 1.79], [0.013, 0.070, 0.145]),
    ("Spectralon", [11.6, 20.4, 14.9], [0.00, 0.00, 0.00]),
    ("Wholemilk", [2.55, 3.21, 3.77], [0.0011, 0.0024, 0.014]),
];

/// The scattering and absorption coefficients of a preset.
pub(super) fn preset(name: &str) -> Option<(Rgb, Rgb)> {
    let (_, s, a) = PRESETS.iter().find(|(known, ..)| *known == name)?;
    Some((Rgb::from(*s), Rgb::from(*a)))
}

impl Translator<'_> {
    /// `MakeNamedMedium`.
    pub(super) fn named_medium(&mut self, params: &Params) {
        let name = params.plugin.as_str();
        let Some(kind) = params.text("type").cloned() else {
            return self.report.error(params.span, "a medium without a `string type`", "");
        };
        if self.media.contains_key(name) && !self.is_v3 {
            let message = format!("a medium named `{name}` exists already");
            return self.report.error(params.span, message, "");
        }
        let medium = match kind.text.as_str() {
            "homogeneous" => Some(self.homogeneous(params)),
            "uniformgrid" | "heterogeneous" => self.uniform_grid(params),
            other => {
                self.refuse_medium(other, kind.span);
                None
            }
        };
        if medium.is_some() {
            params.report_unused(self.report);
        }
        let key = medium.map(|medium| {
            let key = format!("medium {} {name}", self.next_number());
            self.doc.register(medium, &key, Some(name));
            self.doc.nest(self.scene, "", medium);
            key
        });
        self.media.insert(name.to_owned(), key);
    }

    /// Report a medium that is unknown, or known and not supported.
    fn refuse_medium(&self, name: &str, span: Span) {
        if let Some((_, why, instead)) = REFUSED.iter().find(|(known, ..)| *known == name) {
            let message = format!("medium `{name}` is not supported");
            return self.report.error_help(span, message, why, Some((*instead).to_owned()));
        }
        let help = self.report.suggestion(name, KNOWN);
        self.report.error_help(span, format!("unknown medium `{name}`"), "expected a medium", help);
    }

    fn homogeneous(&mut self, params: &Params) -> ObjectId {
        let medium = self.doc.add(Class::Medium, "medium", "homogeneous", params.span);
        self.coefficients(medium, params);
        medium
    }

    /// A medium whose density is a grid inside the scene file.
    fn uniform_grid(&mut self, params: &Params) -> Option<ObjectId> {
        let (report, span) = (self.report, params.span);
        let size = ["nx", "ny", "nz"].map(|name| params.integer(name, report).unwrap_or(1));
        let why = "only scattering and absorption are simulated";
        params.note_ignored(&["temperature", "LeScale", "Lescale"], why, report);
        params.ignore(&["temperaturescale", "temperaturecutoff", "temperatureoffset"]);
        let Some(density) = params.numbers("density") else {
            report.error(span, "a grid without `float density`", "");
            return None;
        };
        let count = size.iter().try_fold(1i64, |n, s| n.checked_mul((*s).max(0)));
        if count != i64::try_from(density.len()).ok()
            || !size.iter().all(|n| (1..1 << 24).contains(n))
        {
            let shown = size.map(|n| n.to_string()).join(" x ");
            let message = format!("{} values for {shown} cells", density.len());
            report.error(params.span_of("density"), message, "expected one value per cell");
            return None;
        }
        if let Some(bad) = density.iter().find(|v| !is_valid(**v as f32)) {
            let message = format!("a density of {bad}");
            report.error(params.span_of("density"), message, "expected 0 to 1e15");
            return None;
        }
        let claim = report.budget.claim("media inside the scene file");
        if let Err(why) = claim.keep(4 * density.len() as u64) {
            report.error(span, why, "");
            return None;
        }
        let cells = Cells::Grey(density.iter().map(|v| *v as f32).collect());
        let mut hash = Hash::default();
        size.iter().for_each(|n| hash.word(*n as u64));
        density.iter().for_each(|v| hash.word(v.to_bits()));
        let medium = self.doc.add(Class::Medium, "medium", "heterogeneous", span);
        self.coefficients(medium, params);
        let [from, to] = [("p0", DVec3::ZERO), ("p1", DVec3::ONE)]
            .map(|(name, default)| params.triple(name, report).unwrap_or(default));
        let (from, to) = (from.min(to), from.max(to));
        let cube = DAffine3::from_translation(from) * DAffine3::from_scale(to - from);
        self.doc.set(medium, "to_world", span, Value::transform(self.state.now.ctm * cube));
        self.doc.set(medium, "contents", span, Value::Integer(hash.value() as i64));
        let grid = InlineGrid { size: size.map(|n| n as usize), cells };
        self.doc.inline_grids.borrow_mut().insert(medium, grid);
        Some(medium)
    }

    /// The coefficients and the phase function of a medium.
    fn coefficients(&mut self, medium: ObjectId, params: &Params) {
        let (report, span) = (self.report, params.span);
        let preset = params.text("preset").and_then(|name| {
            let found = preset(&name.text);
            if found.is_none() {
                let help = report.suggestion(&name.text, PRESETS.iter().map(|(n, ..)| *n));
                let message = format!("unknown preset `{}`", name.text);
                report.error_help(name.span, message, "expected a preset", help);
            }
            found
        });
        let milk = (Rgb::new(2.55, 3.21, 3.77), Rgb::new(0.0011, 0.0024, 0.014));
        let default = if self.is_v3 { milk } else { (Rgb::WHITE, Rgb::WHITE) };
        let (s, a) = preset.unwrap_or(default);
        let given = |name, default| match preset {
            Some(_) => default,
            None => self.color(params, name, Meaning::Factor).unwrap_or(default),
        };
        let coefficients = [("sigma_s", given("sigma_s", s)), ("sigma_a", given("sigma_a", a))];
        for (name, color) in coefficients {
            self.doc.set(medium, name, params.span_of(name), Value::Color(color));
        }
        let scale = params.within("scale", 1.0, [0.0, 1e15], report) as f32;
        self.doc.set(medium, "scale", span, Value::Float(scale));
        if self.color(params, "Le", Meaning::Light).is_some_and(|le| !le.is_black()) {
            report.warn(params.span_of("Le"), "the emission of a medium is ignored");
        }
        params.ignore(&["Lescale"]);
        let g = params.number("g", report).unwrap_or(0.0) as f32;
        if g != 0.0 {
            let phase = self.doc.add(Class::Phase, "medium", "hg", span);
            self.doc.set(phase, "g", params.span_of("g"), Value::Float(g));
            self.doc.nest(medium, "", phase);
        }
    }

    /// `MediumInterface`: the media inside and outside of the shapes that follow.
    pub(super) fn medium_interface(&mut self, inside: &Text, outside: &Text) {
        for name in [inside, outside].into_iter().filter(|name| !name.text.is_empty()) {
            self.wanted_media.push(name.clone());
        }
        self.state.now.media = [inside, outside].map(|name| name.text.as_str().into());
    }

    /// Report media that are used and never defined.
    pub(super) fn check_media(&self) {
        for name in self.wanted_media.iter().filter(|name| !self.media.contains_key(&name.text)) {
            let help = self.report.suggestion(&name.text, self.media.keys().map(String::as_str));
            let message = format!("no medium is named `{}`", name.text);
            if self.is_v3 {
                self.report.warn(name.span, message);
                continue;
            }
            self.report.error_help(name.span, message, "referred to here", help);
        }
    }

    /// Attach the current media to a shape.
    pub(super) fn attach_media(&mut self, shape: ObjectId, params: &Params) {
        let media = self.state.now.media.clone();
        for (side, name) in ["interior", "exterior"].into_iter().zip(&media) {
            if let Some(Some(key)) = self.media.get(&**name) {
                self.doc.refer(shape, side, params.span, key);
            }
        }
    }
}
