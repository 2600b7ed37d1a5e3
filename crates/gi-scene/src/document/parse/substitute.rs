use std::cell::Cell;

use super::defines::Define;
use super::{Parser, XmlNode};
use crate::diagnostics::Span;
use crate::value;

/// Longest attribute after substitution: with `$a` = `$b$b`, `$b` = `$c$c`, ... the length doubles at each level.
const MAX_ATTRIBUTE: usize = 1 << 16;
/// Longest name that a `<default>` may define: each `$` in the scene is compared with the names of each length.
const MAX_NAME: usize = 128;

pub(super) struct Attribute {
    pub(super) name: String,
    pub(super) value: String,
    pub(super) span: Span,
}

pub(super) struct Element {
    pub(super) tag: String,
    pub(super) span: Span,
    pub(super) attributes: Vec<Attribute>,
}

impl Element {
    pub(super) fn get(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|a| a.name == name)
    }

    pub(super) fn text(&self, name: &str) -> Option<&str> {
        self.get(name).map(|a| a.value.as_str())
    }

    /// The first attribute that is empty, if there is one.
    pub(super) fn empty(&self) -> Option<&Attribute> {
        self.attributes.iter().find(|a| a.value.is_empty())
    }

    /// Place of an attribute's value, or of the tag if the attribute is missing.
    pub(super) fn span_of(&self, name: &str) -> Span {
        self.get(name).map_or(self.span, |a| a.span)
    }
}

impl Parser<'_> {
    pub(super) fn default(&mut self, element: &Element) {
        let (Some(name), Some(value)) = (element.text("name"), element.text("value")) else {
            return self.report.error(element.span, "`default` needs `name` and `value`", "");
        };
        if name.len() > MAX_NAME {
            let message = format!("a name of {} bytes: at most {MAX_NAME}", name.len());
            return self.report.error(element.span, message, "");
        }
        if let Some(known) = self.defines.get(name) {
            known.used.set(true);
        } else {
            let (name, value) = (name.to_owned(), value.to_owned());
            if name.starts_with("gi.") {
                self.doc.presets.insert(name.clone(), value.clone());
            }
            self.defines.add(Define { name, value, forced: false, used: Cell::new(true) });
        }
    }

    /// An element's tag and attributes, with all `$name`s substituted.
    pub(super) fn element(&self, node: XmlNode<'_, '_>, file: usize) -> Element {
        let start = node.range().start + 1; // past the angle bracket
        let tag = node.tag_name().name();
        let span = Span { file, start, end: start + tag.len() };
        let attributes = node.attributes().map(|a| {
            let range = a.range_value();
            let span = Span { file, start: range.start, end: range.end };
            let value = self.substitute(a.value(), span);
            Attribute { name: a.name().to_owned(), value, span }
        });
        let attributes = attributes.collect();
        Element { tag: value::snake_case(tag), span, attributes }
    }

    fn substitute(&self, text: &str, span: Span) -> String {
        let Some(first) = text.find('$') else { return text.to_owned() };
        let mut out = text[..first].to_owned();
        let mut rest = &text[first..];
        while let Some(after) = rest.strip_prefix('$') {
            if let Some(define) = self.defines.at_start_of(after) {
                define.used.set(true);
                out.push_str(&define.value);
                rest = &after[define.name.len()..];
            } else {
                let end = after.find(|c: char| !c.is_alphanumeric() && c != '_');
                let name = &after[..end.unwrap_or(after.len())];
                let names = self.defines.iter().map(|d| d.name.as_str());
                let help = self.report.suggestion(name, names);
                let message = format!("`${name}` is not defined");
                self.report.error_undefined(span, message, help);
                return String::new();
            }
            let end = rest.find('$').unwrap_or(rest.len());
            out.push_str(&rest[..end]);
            rest = &rest[end..];
            if out.len() > MAX_ATTRIBUTE {
                self.report.error(span, "substitution makes this attribute too long", "");
                return String::new();
            }
        }
        let claim = self.report.budget.claim("text that replaces names");
        if let Err(why) = claim.keep(out.len() as u64) {
            self.report.error(span, why, "");
            return String::new();
        }
        out
    }

    /// Warn about each `-D` that the scene does not use: it is probably misspelt.
    pub(super) fn check_defines(&self) {
        for define in self.defines.iter().filter(|d| d.forced && !d.used.get()) {
            let names = self.defines.iter().filter(|d| d.used.get()).map(|d| d.name.as_str());
            let hint = self.report.suggestion(&define.name, names);
            let hint = hint.map(|hint| format!(", {hint}")).unwrap_or_default();
            self.report.warn_nowhere(format!(
                "-D {}: the scene does not use this name{hint}",
                define.name
            ));
        }
    }
}
