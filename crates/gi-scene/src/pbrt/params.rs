//! The parameters of a directive, with typed access. Each access marks the parameter as used.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::rc::Rc;

use glam::DVec3;

use super::types::{Text, Type, Values};
use crate::diagnostics::{Report, Span};

/// A parameter.
#[derive(Debug)]
pub(super) struct Param {
    pub(super) kind: Type,
    pub(super) name: String,
    pub(super) span: Span,
    pub(super) values: Values,
    used: Cell<bool>,
}

impl Param {
    pub(super) fn new(kind: Type, name: &str, span: Span, values: Values) -> Self {
        Param { kind, name: name.to_owned(), span, values, used: Cell::new(false) }
    }
}

/// A directive that makes something, such as `Shape "sphere"`, with its parameters.
#[derive(Debug)]
pub(super) struct Params {
    /// What it makes, for messages: `shape`.
    what: &'static str,
    /// Its name: `sphere`.
    pub(super) plugin: String,
    /// Where that name is.
    pub(super) span: Span,
    own: Vec<Rc<Param>>,
    /// Parameters of `Attribute` directives, which may stay unused.
    inherited: Rc<Vec<Rc<Param>>>,
    asked: RefCell<BTreeSet<&'static str>>,
}

impl Params {
    pub(super) fn new(
        what: &'static str,
        name: Text,
        own: Vec<Rc<Param>>,
        inherited: Rc<Vec<Rc<Param>>>,
    ) -> Self {
        let Text { text: plugin, span } = name;
        Params { what, plugin, span, own, inherited, asked: RefCell::default() }
    }

    /// The parameter of that name which passes a test.
    pub(super) fn find(
        &self,
        name: &'static str,
        wanted: impl Fn(&Param) -> bool,
    ) -> Option<&Param> {
        self.asked.borrow_mut().insert(name);
        let all = self.own.iter().rev().chain(self.inherited.iter().rev());
        let found = all.map(Rc::as_ref).find(|p| p.name == name && wanted(p))?;
        found.used.set(true);
        Some(found)
    }

    /// Whether any parameter passes a test.
    pub(super) fn find_any(&self, wanted: impl Fn(&Param) -> bool) -> bool {
        self.own.iter().chain(self.inherited.iter()).any(|p| wanted(p))
    }

    /// Whether a parameter is given.
    pub(super) fn has(&self, name: &'static str) -> bool {
        self.find(name, |_| true).is_some()
    }

    /// Mark parameters as used although they have no effect.
    pub(super) fn ignore(&self, names: &[&'static str]) {
        names.iter().for_each(|name| {
            self.asked.borrow_mut().insert(name);
            self.own.iter().filter(|p| p.name == *name).for_each(|p| p.used.set(true));
        });
    }

    /// Warn that parameters have no effect here, if they are given.
    pub(super) fn note_ignored(&self, names: &[&'static str], why: &str, report: &Report) {
        for name in names {
            if let Some(p) = self.find(name, |_| true) {
                report.warn(p.span, format!("`{name}` is ignored: {why}"));
            }
        }
    }

    /// Place of a parameter, or of the directive's name if it is not given.
    pub(super) fn span_of(&self, name: &'static str) -> Span {
        self.find(name, |_| true).map_or(self.span, |p| p.span)
    }

    /// The numbers of a parameter that is neither a colour nor a texture.
    pub(super) fn numbers(&self, name: &'static str) -> Option<&[f64]> {
        let plain =
            |p: &Param| matches!(p.kind, Type::Integer | Type::Float | Type::Pair | Type::Triple);
        match &self.find(name, plain)?.values {
            Values::Numbers(all) => Some(all),
            _ => None,
        }
    }

    /// A single number, if given. An integer is accepted for a float, and `12.0` for an integer.
    pub(super) fn number(&self, name: &'static str, report: &Report) -> Option<f64> {
        match self.numbers(name)? {
            [one] => Some(*one),
            other => {
                let message = format!("`{name}` has {} values", other.len());
                report.error(self.span_of(name), message, "expected one");
                None
            }
        }
    }

    /// A single number in a range; the default if it is not given or outside, which is reported.
    pub(super) fn within(
        &self,
        name: &'static str,
        default: f64,
        [low, high]: [f64; 2],
        report: &Report,
    ) -> f64 {
        match self.number(name, report) {
            Some(v) if (low..=high).contains(&v) => v,
            Some(v) => {
                let expected = format!("expected {low} to {high}");
                report.error(self.span_of(name), format!("{name} {v}"), &expected);
                default
            }
            None => default,
        }
    }

    /// A whole number, if given.
    pub(super) fn integer(&self, name: &'static str, report: &Report) -> Option<i64> {
        let v = self.number(name, report)?;
        if v.fract() != 0.0 {
            report.error(self.span_of(name), format!("{name} {v}"), "expected a whole number");
            return None;
        }
        Some(v as i64)
    }

    /// A point or vector, if given.
    pub(super) fn triple(&self, name: &'static str, report: &Report) -> Option<DVec3> {
        match self.numbers(name)? {
            [x, y, z] => Some(DVec3::new(*x, *y, *z)),
            other => {
                let message = format!("`{name}` has {} values", other.len());
                report.error(self.span_of(name), message, "expected three");
                None
            }
        }
    }

    /// A boolean.
    pub(super) fn bool(&self, name: &'static str, default: bool, report: &Report) -> bool {
        match self.find(name, |p| p.kind == Type::Bool).map(|p| (&p.values, p.span)) {
            Some((Values::Bools(all), _)) if all.len() == 1 => all[0],
            Some((Values::Texts(all), _)) if all.len() == 1 && all[0].text == "true" => true,
            Some((Values::Texts(all), _)) if all.len() == 1 && all[0].text == "false" => false,
            Some((_, span)) => {
                let message = format!("`{name}` is not one boolean");
                report.error(span, message, "expected `true` or `false`");
                default
            }
            None => default,
        }
    }

    /// All strings of a parameter.
    pub(super) fn texts(&self, name: &'static str) -> Option<&[Text]> {
        match &self.find(name, |p| p.kind == Type::String)?.values {
            Values::Texts(all) => Some(all),
            _ => None,
        }
    }

    /// A string, if given.
    pub(super) fn text(&self, name: &'static str) -> Option<&Text> {
        self.texts(name)?.first()
    }

    /// The name of a texture, if a parameter is one.
    pub(super) fn texture(&self, name: &'static str) -> Option<&Text> {
        match &self.find(name, |p| p.kind == Type::Texture)?.values {
            Values::Texts(all) => all.first(),
            _ => None,
        }
    }

    /// Report a name that is not one of those that are known.
    pub(super) fn unknown_plugin(&self, known: &[&str], report: &Report) {
        let help = report
            .suggestion(&self.plugin, known.iter().copied())
            .or_else(|| Some(format!("known are: {}", known.join(", "))));
        let message = format!("unknown {} `{}`", self.what, self.plugin);
        report.error_help(self.span, message, &format!("expected a {}", self.what), help);
    }

    /// Warn about every parameter that was given but not used.
    pub(super) fn report_unused(&self, report: &Report) {
        let asked = self.asked.borrow();
        for p in self.own.iter().filter(|p| !p.used.get()) {
            let message = if asked.contains(p.name.as_str()) {
                format!("{} `{}`: `{}` has a type that is not used", self.what, self.plugin, p.name)
            } else {
                let hint = report.suggestion(&p.name, asked.iter().copied());
                let hint = hint.map(|hint| format!(", {hint}")).unwrap_or_default();
                let (what, plugin) = (self.what, &self.plugin);
                format!("{what} `{plugin}` has no parameter `{}`: ignored{hint}", p.name)
            };
            report.warn(p.span, message);
        }
    }
}
