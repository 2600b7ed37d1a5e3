//! Files that a scene includes, and the folders where they are searched.

use super::{Element, Parser};
use crate::document::ObjectId;
use crate::files;
use crate::texts::Cost;

/// Largest depth of nested includes (Mitsuba's limit).
const MAX_INCLUDE_DEPTH: usize = 15;
/// Largest number of files that one scene may include, counting repeats. Without this limit, fifteen files
/// that each include the next one ten times would be read 10^15 times.
const MAX_INCLUDES: usize = 1000;
/// Largest length of all included text, counting repeats.
const MAX_INCLUDED: u64 = 1 << 28;
/// Largest number of `<path>`s: each missing file is searched in all these folders.
const MAX_FOLDERS: usize = 16;
/// What elements cost, apart from long texts.
pub(super) const COST: Cost =
    Cost { most_included: MAX_INCLUDED, mark: (b'<', 1, "elements"), part: 400 };

impl Parser<'_> {
    pub(super) fn include(&mut self, element: &Element, parent: ObjectId) {
        let Some(name) = element.get("filename") else {
            return self.report.error(element.span, "`include` needs `filename`", "");
        };
        self.includes += 1;
        if self.stack.len() > MAX_INCLUDE_DEPTH || self.includes > MAX_INCLUDES {
            return self.report.error(name.span, "too many files include each other", "");
        }
        let folder = files::folder_of(self.stack.last().expect("a file is being read"));
        let found = match self.doc.folders.find(&name.value, &folder, &self.doc.search) {
            files::Found::Exact(path) => path,
            files::Found::OtherCase(path) => {
                self.report
                    .warn(name.span, format!("`{}` is read as `{}`", name.value, path.display()));
                path
            }
            files::Found::No => {
                let message = format!("cannot find `{}`", name.value);
                return self.report.error(name.span, message, "included here");
            }
        };
        let canonical = found.canonicalize().unwrap_or_else(|_| found.clone());
        if self.stack.contains(&canonical) {
            let message = format!("`{}` includes itself", name.value);
            return self.report.error(name.span, message, "this completes the cycle");
        }
        self.file(&found, Some(parent), name.span);
    }

    pub(super) fn search_path(&mut self, element: &Element, parent: ObjectId) {
        let Some(value) = element.get("value") else {
            return self.report.error(element.span, "`path` needs `value`", "");
        };
        if self.doc.search.len() >= MAX_FOLDERS {
            let message = format!("more than {MAX_FOLDERS} `path`s");
            return self.report.error(element.span, message, "");
        }
        self.doc.search.push(self.doc.objects[parent].folder.join(&value.value));
    }
}
