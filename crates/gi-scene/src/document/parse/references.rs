//! References to objects by id: `ref` and `alias`.

use std::cell::Cell;

use super::{Element, Parser};
use crate::diagnostics::Span;
use crate::document::{Child, ObjectId, Target};
use crate::value;

impl Parser<'_> {
    pub(super) fn alias(&mut self, element: &Element) {
        let (Some(id), Some(new)) = (element.get("id"), element.get("as")) else {
            return self.report.error(element.span, "`alias` needs `id` and `as`", "");
        };
        self.aliases.push((id.value.clone(), new.value.clone(), id.span));
    }

    pub(super) fn reference(&mut self, element: &Element, parent: ObjectId) {
        let Some(id) = element.get("id") else {
            return self.report.error(element.span, "`ref` needs `id`", "");
        };
        let name = value::snake_case(element.text("name").unwrap_or_default());
        let child = Child {
            name,
            span: id.span,
            target: Target::Ref(id.value.clone()),
            used: Cell::new(false),
        };
        self.doc.objects[parent].children.push(child);
    }

    /// Resolve aliases and report references to ids that do not exist.
    pub(super) fn check_references(&mut self) {
        for (id, new, span) in std::mem::take(&mut self.aliases) {
            match self.doc.ids.get(&id).copied() {
                Some(object) => drop(self.doc.ids.insert(new, object)),
                None => self.unknown_id(&id, span),
            }
        }
        let mut missing = Vec::new();
        for (o, object) in self.doc.objects.iter().enumerate() {
            for (c, child) in object.children.iter().enumerate() {
                if let Target::Ref(id) = &child.target
                    && !self.doc.ids.contains_key(id)
                {
                    missing.push((o, c));
                    self.unknown_id(id, child.span);
                }
            }
        }
        for (o, c) in missing {
            self.doc.objects[o].children[c].target = Target::Missing;
        }
    }

    /// Report a reference to an unknown id.
    fn unknown_id(&self, id: &str, span: Span) {
        let message = format!("nothing has the id `{id}`");
        let help = self.report.suggestion(id, self.doc.ids.keys().map(String::as_str));
        self.report.error_help(span, message, "referred to here", help);
    }
}
