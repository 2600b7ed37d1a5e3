use glam::{Affine3A, DAffine3, DVec3, Vec3};

use super::refused;
use super::{Child, Class, Document, Object, ObjectId, Property, Target, Value};
use crate::diagnostics::{Report, Span};
use crate::spectrum::Spectrum;

/// An object of a document, with typed access to its properties. Each access marks the property as used.
/// A value of the wrong kind is reported, and the default is returned.
#[derive(Clone, Copy)]
pub(crate) struct Node<'a> {
    pub(crate) doc: &'a Document,
    pub(crate) report: &'a Report,
    pub(crate) id: ObjectId,
}

impl<'a> Node<'a> {
    pub(super) fn new(doc: &'a Document, report: &'a Report, id: ObjectId) -> Self {
        Node { doc, report, id }
    }

    pub(crate) fn object(self) -> &'a Object {
        &self.doc.objects[self.id]
    }

    pub(crate) fn class(self) -> Class {
        self.object().class
    }

    pub(crate) fn plugin(self) -> &'a str {
        &self.object().plugin
    }

    /// Where the plugin's name is in the text.
    pub(crate) fn span(self) -> Span {
        self.object().plugin_span
    }

    /// Report an error about the whole object.
    pub(crate) fn error(self, message: impl Into<String>, expected: &str) {
        self.report.error(self.span(), message, expected);
    }

    /// Warn about the whole object.
    pub(crate) fn warn(self, message: impl AsRef<str>) {
        self.report.warn(self.span(), message);
    }

    /// Report an unknown plugin and suggest the nearest known one, or what replaces it.
    pub(crate) fn unknown_plugin(self, known: &[&str]) {
        let object = self.object();
        if let Some((why, instead)) = refused::reason(object.class.tag(), &object.plugin) {
            let message = format!("{} `{}` is not supported", object.class.tag(), object.plugin);
            return self.report.error_help(object.plugin_span, message, why, Some(instead.into()));
        }
        let help = self
            .report
            .suggestion(&object.plugin, known.iter().copied())
            .or_else(|| Some(format!("known are: {}", known.join(", "))));
        let tag = object.class.tag();
        let message = format!("unknown {tag} `{}`", object.plugin);
        self.report.error_help(
            object.plugin_span,
            message,
            &format!("expected a {tag} plugin"),
            help,
        );
    }

    pub(super) fn find(self, name: &'static str) -> Option<&'a Property> {
        let object = self.object();
        object.touched.set(true);
        object.ask(name);
        let found = object.properties.iter().rev().find(|p| p.name == name)?;
        found.used.set(true);
        Some(found)
    }

    /// Mark properties as used although they have no effect here.
    pub(crate) fn ignore(self, names: &[&'static str]) {
        for name in names {
            self.find(name);
            self.child(name);
        }
    }

    /// Whether the property is given.
    pub(crate) fn has(self, name: &'static str) -> bool {
        self.find(name).is_some()
    }

    /// Place of a property, or of the object if the property is not given.
    pub(crate) fn span_of(self, name: &'static str) -> Span {
        self.find(name).map_or(self.span(), |p| p.span)
    }

    pub(super) fn wrong_kind(self, p: &Property, expected: &str) {
        let message = format!("`{}` is {}", p.name, p.value.kind());
        self.report.error(p.span, message, &format!("expected {expected}"));
    }

    fn get<T>(
        self,
        name: &'static str,
        expected: &str,
        read: impl Fn(&Value) -> Option<T>,
    ) -> Option<T> {
        let p = self.find(name)?;
        let value = read(&p.value);
        if value.is_none() {
            self.wrong_kind(p, expected);
        }
        value
    }

    pub(crate) fn float_opt(self, name: &'static str) -> Option<f32> {
        self.get(name, "a float", |v| match v {
            Value::Float(x) | Value::Spectrum(Spectrum::Flat(x)) => Some(*x),
            Value::Integer(i) => Some(*i as f32),
            Value::Text(t) => crate::value::number(t).ok(),
            _ => None,
        })
    }

    pub(crate) fn float(self, name: &'static str, default: f32) -> f32 {
        self.float_opt(name).unwrap_or(default)
    }

    /// An integer, if given.
    pub(crate) fn int_opt(self, name: &'static str) -> Option<i64> {
        self.get(name, "an integer", |v| match v {
            Value::Integer(i) => Some(*i),
            Value::Float(x) if x.fract() == 0.0 => Some(*x as i64),
            _ => None,
        })
    }

    pub(crate) fn bool(self, name: &'static str, default: bool) -> bool {
        let read = |v: &Value| match v {
            Value::Bool(b) => Some(*b),
            Value::Text(t) => crate::value::boolean(t).ok(),
            _ => None,
        };
        self.get(name, "a boolean", read).unwrap_or(default)
    }

    /// A string, if given.
    pub(crate) fn text(self, name: &'static str) -> Option<&'a str> {
        let p = self.find(name)?;
        match &p.value {
            Value::Text(t) => Some(t),
            _ => {
                self.wrong_kind(p, "a string");
                None
            }
        }
    }

    /// A string, if the value is one: for properties that accept a name or a number.
    pub(crate) fn text_opt(self, name: &'static str) -> Option<&'a str> {
        match &self.find(name)?.value {
            Value::Text(t) => Some(t),
            _ => None,
        }
    }

    pub(crate) fn vector(self, name: &'static str) -> Option<Vec3> {
        self.point(name).map(|p| p.as_vec3())
    }

    /// The same in double precision.
    pub(crate) fn point(self, name: &'static str) -> Option<DVec3> {
        self.get(name, "a point or vector", |v| match v {
            Value::Vector(p) => Some(*p),
            Value::Color(c) => Some(Vec3::from(c.to_array()).as_dvec3()),
            _ => None,
        })
    }

    /// A transform; the identity if not given.
    pub(crate) fn transform(self, name: &'static str) -> Affine3A {
        self.transform64(name).as_affine3a()
    }

    fn transform64(self, name: &'static str) -> DAffine3 {
        let read = |v: &Value| match v {
            Value::Transform(m) => Some(**m),
            _ => None,
        };
        self.get(name, "a transform", read).unwrap_or(DAffine3::IDENTITY)
    }

    /// The object's `to_world`. In a scene far from the origin of its coordinates, it leads to the scene's own origin
    /// instead; that of a shape in a group leads to the group's.
    pub(crate) fn to_world(self) -> DAffine3 {
        let local = self.doc.local.borrow();
        let origin = if local.in_groups.contains(&self.id) { DVec3::ZERO } else { local.origin };
        DAffine3::from_translation(-origin) * self.transform64("to_world")
    }

    /// The object that a child is or refers to.
    fn resolve(self, child: &Child) -> Option<Node<'a>> {
        let id = match &child.target {
            Target::Here(id) => *id,
            Target::Ref(name) => *self.doc.ids.get(name)?,
            Target::Missing => return None,
        };
        Some(Node { id, ..self })
    }

    /// The child of that name, if any.
    pub(crate) fn child(self, name: &'static str) -> Option<Node<'a>> {
        self.child_if(name, |_| true)
    }

    /// The child of that name, if any passes a test.
    pub(crate) fn child_if(
        self,
        name: &'static str,
        wanted: impl Fn(Node<'a>) -> bool,
    ) -> Option<Node<'a>> {
        let object = self.object();
        object.touched.set(true);
        object.ask(name);
        let mut named = object.children.iter().filter(|c| c.name == name);
        named.find_map(|c| {
            let node = self.resolve(c).filter(|n| wanted(*n))?;
            c.used.set(true);
            Some(node)
        })
    }

    /// Read a property without marking it as used.
    pub(crate) fn peek(self, name: &str) -> Option<(&'a Value, Span)> {
        let found = self.object().properties.iter().rev().find(|p| p.name == name)?;
        Some((&found.value, found.span))
    }

    /// The children of a class in document order, whatever their names.
    pub(crate) fn children(self, class: Class) -> Vec<Node<'a>> {
        let object = self.object();
        object.touched.set(true);
        let mut out = Vec::new();
        for child in &object.children {
            let Some(node) = self.resolve(child).filter(|n| n.class() == class) else {
                if matches!(child.target, Target::Missing) {
                    child.used.set(true);
                }
                continue;
            };
            child.used.set(true);
            out.push(node);
        }
        out
    }

    /// Report a wrong number of children, unless a reference that was reported already may be one of them.
    pub(crate) fn wrong_count(self, kind: &str, count: usize, expected: &str) {
        if self.object().children.iter().all(|c| self.resolve(c).is_some()) {
            self.error(format!("`{}` has {count} {kind}", self.plugin()), expected);
        }
    }

    /// All children in document order, without marking them as used.
    pub(crate) fn all_children(self) -> impl Iterator<Item = Node<'a>> {
        self.object().children.iter().filter_map(move |c| self.resolve(c))
    }
}
