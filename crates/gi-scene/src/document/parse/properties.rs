use std::cell::Cell;

use glam::{DAffine3, DVec3};

use super::substitute::Element;
use super::{Parser, XmlNode};
use crate::document::{ObjectId, Property, Value};
use crate::files;
use crate::spectrum::Spectrum;
use crate::{transform, value};

/// Tags of plain values.
const TAGS: [&str; 12] = [
    "boolean",
    "integer",
    "float",
    "string",
    "rgb",
    "srgb",
    "color",
    "spectrum",
    "blackbody",
    "point",
    "vector",
    "transform",
];

impl Parser<'_> {
    pub(super) fn transform(
        &mut self,
        node: XmlNode<'_, '_>,
        element: &Element,
        file: usize,
        parent: ObjectId,
    ) {
        let mut m = DAffine3::IDENTITY;
        for op in node.children().filter(|n| n.is_element()) {
            let op = self.element(op, file);
            let tag = if op.tag == "look_at" { "lookat" } else { op.tag.as_str() };
            if !transform::OPERATIONS.contains(&tag) {
                let help = self.report.suggestion(tag, transform::OPERATIONS);
                let message = format!("unknown operation `{}`", op.tag);
                self.report.error_help(op.span, message, "expected an operation", help);
                continue;
            }
            match transform::operation(tag, &|name| op.text(name)) {
                Ok(next) => m = next * m,
                Err(why) => self.report.error(op.empty().map_or(op.span, |a| a.span), why, ""),
            }
        }
        if !m.to_cols_array().iter().all(|x| x.abs() <= f64::from(value::MAX_NUMBER)) {
            let expected = "expected numbers up to 1e15";
            self.report.error(element.span, "this transform's product is too large", expected);
            m = DAffine3::IDENTITY;
        }
        self.add(element, parent, Value::transform(m));
    }

    /// Read a plain value; warn about other tags and ignore them.
    pub(super) fn property(&mut self, element: &Element, parent: ObjectId) {
        if !TAGS.contains(&element.tag.as_str()) {
            self.note_unknown(element, parent);
            let hint = self.report.suggestion(&element.tag, TAGS);
            let hint = hint.map(|hint| format!(", {hint}")).unwrap_or_default();
            self.report.warn(element.span, format!("unknown tag `{}`: ignored{hint}", element.tag));
            return;
        }
        match self.value(element) {
            Ok(value) => self.add(element, parent, value),
            Err(why) => {
                let expected = format!("expected {}", expectation(&element.tag));
                let span = element.empty().map_or(element.span_of("value"), |a| a.span);
                self.report.error(span, why, &expected);
            }
        }
    }

    /// Remember an unknown tag that is directly inside the scene.
    fn note_unknown(&mut self, element: &Element, parent: ObjectId) {
        const MAX_NAMED: usize = 8;
        if parent != 0 {
            return;
        }
        self.doc.unknown_things |= element.get("type").is_some();
        let unknown = &mut self.doc.unknown_tags;
        if unknown.len() < MAX_NAMED && !unknown.contains(&element.tag) {
            unknown.push(element.tag.clone());
        }
    }

    fn value(&mut self, element: &Element) -> Result<Value, String> {
        let text = element.text("value").ok_or("`value` is missing");
        Ok(match element.tag.as_str() {
            "boolean" => Value::Bool(value::boolean(text?)?),
            "integer" => Value::Integer(value::integer(text?)?),
            "float" => Value::Float(value::number(text?)?),
            "string" => Value::Text(text?.to_owned()),
            "rgb" | "color" => Value::Color(value::color(text?, false)?),
            "srgb" => Value::Color(value::color(text?, true)?),
            "blackbody" => {
                let kelvin = element.text("temperature").ok_or("`temperature` is missing")?;
                let kelvin = value::number(kelvin.trim_end_matches(['K', 'k']))?;
                let scale = element.text("scale").map_or(Ok(1.0), value::number)?;
                Value::Spectrum(Spectrum::Blackbody { kelvin, scale })
            }
            "spectrum" => self.spectrum(element)?,
            _ => match element.text("value") {
                Some(text) => Value::Vector(value::triple64(text)?),
                None => {
                    let axis = |name| element.text(name).map_or(Ok(0.0), value::number64);
                    Value::Vector(DVec3::new(axis("x")?, axis("y")?, axis("z")?))
                }
            },
        })
    }

    fn spectrum(&mut self, element: &Element) -> Result<Value, String> {
        if let Some(name) = element.text("filename") {
            let folder = files::folder_of(self.stack.last().expect("a file is being read"));
            let (files::Found::Exact(path) | files::Found::OtherCase(path)) =
                self.doc.folders.find(name, &folder, &self.doc.search)
            else {
                return Err(format!("cannot find `{name}`"));
            };
            self.report.reads(&path);
            let mut claim = self.report.budget.claim(path.display());
            let text = files::read_text(&path, &mut claim)?;
            self.doc.hash.bytes(text.as_bytes());
            let lines = text.lines().map(|l| l.split('#').next().unwrap_or_default().trim());
            let lines = lines.filter(|l| !l.is_empty());
            let joined: Vec<String> =
                lines.map(|l| value::words(l).collect::<Vec<_>>().join(":")).collect();
            return Ok(Value::Spectrum(Spectrum::Pairs(value::pairs(&joined.join(" "))?)));
        }
        let text = element.text("value").ok_or("`value` is missing")?;
        if text.contains(':') {
            return Ok(Value::Spectrum(Spectrum::Pairs(value::pairs(text)?)));
        }
        match value::numbers(text)?.as_slice() {
            [v] => Ok(Value::Spectrum(Spectrum::Flat(*v))),
            [_, _, _] => Ok(Value::Color(value::color(text, false)?)),
            other => Err(format!("{} numbers without wavelengths", other.len())),
        }
    }

    fn add(&mut self, element: &Element, parent: ObjectId, value: Value) {
        let Some(name) = element.get("name") else {
            // No known Mitsuba format has values without a name, except as children of `<spectrum>` and similar tags.
            return self.report.error(
                element.span,
                format!("`{}` without a name", element.tag),
                "",
            );
        };
        let property = Property {
            name: value::snake_case(&name.value),
            span: element.span_of("value"),
            value,
            used: Cell::new(false),
        };
        self.doc.objects[parent].properties.push(property);
    }
}

/// The form of a tag's value, for messages.
fn expectation(tag: &str) -> &'static str {
    match tag {
        "boolean" => "`true` or `false`",
        "integer" => "a whole number",
        "float" => "a number",
        "rgb" | "srgb" | "color" => "one number, three, or #rrggbb",
        "spectrum" => "one number or nm:value pairs",
        "point" | "vector" => "three numbers",
        "blackbody" => "a temperature in kelvin",
        _ => "a value",
    }
}
