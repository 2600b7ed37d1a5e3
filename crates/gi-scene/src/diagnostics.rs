//! Errors and warnings about a scene: each error with its place, what was expected and the nearest known name.

mod alike;
mod words;

use std::cell::{Cell, RefCell};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::fmt;
use std::hash::{BuildHasher, RandomState};
use std::path::{Path, PathBuf};

use alike::{Alike, Limits, thousands};
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

use crate::budget::Budget;
use words::did_you_mean;

/// Number of errors that are shown in full: a file that is not a scene at all would otherwise fill many screens.
const MAX_SHOWN: usize = 40;
/// Length from which lines are not shown: a file of one line would be shown for each error.
const LONG: usize = 4096;
/// Errors and warnings of one kind that are kept; the others are counted.
const ERRORS: Limits = Limits { same: 8, like: 24 };
const WARNINGS: Limits = Limits { same: 3, like: 24 };
/// Number of comparisons of words for all suggestions. A scene with more misspelt names than this allows gets no more
/// suggestions: the time to find them would grow with the square of its size.
const MAX_COMPARISONS: usize = 100_000;

/// A range of bytes in one of the scene's text files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    /// Index of the file in the report, in the order in which files were added.
    pub(crate) file: usize,
    /// First byte.
    pub(crate) start: usize,
    /// One past the last byte.
    pub(crate) end: usize,
}

#[derive(Clone, Debug)]
struct SourceFile {
    name: String,
    text: String,
    line_starts: Vec<usize>,
}

#[derive(Clone, Debug)]
struct Problem {
    span: Option<Span>,
    message: String,
    expected: String,
    help: Option<String>,
}

/// All errors of a scene. `Display` shows each with its file, line, column, source line and caret.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    files: Vec<SourceFile>,
    problems: Vec<Problem>,
    /// Number of further errors, which are like others.
    hidden: usize,
    /// One line for each kind of them.
    counted: Vec<String>,
}

impl Diagnostics {
    /// Number of errors.
    pub fn len(&self) -> usize {
        self.problems.len() + self.hidden
    }

    /// Whether there are no errors.
    pub fn is_empty(&self) -> bool {
        self.problems.is_empty()
    }

    /// The errors as text, in colour if asked.
    pub fn render(&self, color: bool) -> String {
        let renderer = if color { Renderer::styled() } else { Renderer::plain() };
        let mut shown: Vec<String> =
            self.problems.iter().take(MAX_SHOWN).map(|p| self.render_one(p, &renderer)).collect();
        if self.problems.len() > MAX_SHOWN {
            shown.push(format!("error: and {} more", thousands(self.problems.len() - MAX_SHOWN)));
        }
        shown.extend(self.counted.iter().map(|line| format!("error: {line}")));
        shown.join("\n\n")
    }

    fn render_one(&self, problem: &Problem, renderer: &Renderer) -> String {
        let title = Level::ERROR.primary_title(problem.message.as_str());
        let mut groups = match problem.span {
            None => vec![Group::with_title(title)],
            Some(span) => {
                let file = &self.files[span.file];
                // Pass only the lines concerned: otherwise the whole text would be scanned for each error.
                let (first, line) = (file.line_of(span.start), file.line_of(span.end));
                let base = file.line_starts[first];
                let end = file.line_starts.get(line + 1).map_or(file.text.len(), |e| e - 1);
                let text = &file.text[base..end];
                if text.len() > LONG {
                    let column = file.text[base..span.start].chars().count() + 1;
                    let place = format!("{}:{}:{column}", file.name, first + 1);
                    let expected = match problem.expected.as_str() {
                        "" => place,
                        expected => format!("{place}: {expected}"),
                    };
                    let note = Level::NOTE.secondary_title(expected);
                    let groups = [Group::with_title(title), Group::with_title(note)];
                    return renderer.render(&groups).to_string();
                }
                let mut mark = AnnotationKind::Primary.span(span.start - base..span.end - base);
                if !problem.expected.is_empty() {
                    mark = mark.label(problem.expected.as_str());
                }
                let snippet = Snippet::source(text)
                    .line_start(first + 1)
                    .path(file.name.as_str())
                    .annotation(mark);
                vec![title.element(snippet)]
            }
        };
        if problem.span.is_none() && !problem.expected.is_empty() {
            groups.push(Group::with_title(Level::NOTE.secondary_title(&problem.expected)));
        }
        if let Some(help) = &problem.help {
            groups.push(Group::with_title(Level::HELP.secondary_title(help)));
        }
        renderer.render(&groups).to_string()
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Diagnostics {}

impl SourceFile {
    /// Index of the line that holds byte `at`.
    fn line_of(&self, at: usize) -> usize {
        self.line_starts.partition_point(|&s| s <= at) - 1
    }
}

/// Collects errors and warnings while a scene is read; shared by reference. Also counts the memory that the scene takes.
#[derive(Debug)]
pub(crate) struct Report {
    pub(crate) budget: Budget,
    inner: RefCell<Diagnostics>,
    alike_errors: RefCell<Alike>,
    warnings: RefCell<Vec<String>>,
    alike_warnings: RefCell<Alike>,
    /// Hashes of all warnings with their places: none is given twice.
    said: RefCell<HashSet<u64>>,
    hasher: RandomState,
    /// File and start of each attribute that uses an undefined name: other errors there only follow from it.
    undefined: RefCell<HashSet<(usize, usize)>>,
    /// Number of comparisons that are left for suggestions.
    comparisons: Cell<usize>,
    read: RefCell<BTreeSet<PathBuf>>,
    file_of: RefCell<HashMap<PathBuf, usize>>,
}

impl Default for Report {
    fn default() -> Self {
        Report::new(u64::MAX)
    }
}

impl Report {
    /// No messages yet; the scene may take `max_memory` bytes.
    pub(crate) fn new(max_memory: u64) -> Self {
        Report {
            budget: Budget::new(max_memory),
            inner: RefCell::default(),
            alike_errors: RefCell::new(Alike::new(ERRORS)),
            warnings: RefCell::default(),
            alike_warnings: RefCell::new(Alike::new(WARNINGS)),
            said: RefCell::default(),
            hasher: RandomState::new(),
            undefined: RefCell::default(),
            comparisons: Cell::new(MAX_COMPARISONS),
            read: RefCell::default(),
            file_of: RefCell::default(),
        }
    }

    /// Record that the scene reads a file.
    pub(crate) fn reads(&self, path: &Path) {
        self.read.borrow_mut().insert(path.to_owned());
    }

    /// The files that the scene reads.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        self.read.borrow().iter().cloned().collect()
    }

    /// Add the text of a file and return its index, which spans use. A file that is included many times is added once.
    pub(crate) fn add_file(&self, path: &Path, text: &str) -> usize {
        let known = self.file_of.borrow().get(path).copied();
        if let Some(known) = known.filter(|known| self.inner.borrow().files[*known].text == text) {
            return known;
        }
        self.reads(path);
        let line_starts =
            std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect();
        let file =
            SourceFile { name: path.display().to_string(), text: text.to_owned(), line_starts };
        let files = &mut self.inner.borrow_mut().files;
        files.push(file);
        self.file_of.borrow_mut().insert(path.to_owned(), files.len() - 1);
        files.len() - 1
    }

    /// Report an error at a place; `expected` is shown beside the caret.
    pub(crate) fn error(&self, span: Span, message: impl Into<String>, expected: &str) {
        self.push(Some(span), message.into(), expected, None);
    }

    /// Report an error at a place, with a suggestion.
    pub(crate) fn error_help(
        &self,
        span: Span,
        message: impl Into<String>,
        expected: &str,
        help: Option<String>,
    ) {
        self.push(Some(span), message.into(), expected, help);
    }

    /// Report that an attribute uses an undefined name. Later errors at the same place are dropped.
    pub(crate) fn error_undefined(&self, span: Span, message: String, help: Option<String>) {
        self.error_help(span, message, "expected a <default> or -D", help);
        self.undefined.borrow_mut().insert((span.file, span.start));
    }

    /// Report an error that has no place in a text.
    pub(crate) fn error_nowhere(&self, message: impl Into<String>) {
        self.push(None, message.into(), "", None);
    }

    fn push(&self, span: Option<Span>, message: String, expected: &str, help: Option<String>) {
        let is_undefined = |s: Span| self.undefined.borrow().contains(&(s.file, s.start));
        if span.is_some_and(is_undefined) {
            return;
        }
        if self.alike_errors.borrow_mut().keep(&message) {
            let problem = Problem { span, message, expected: expected.to_owned(), help };
            self.inner.borrow_mut().problems.push(problem);
        }
    }

    /// Warn that something was approximated or ignored; shown as `file:line: text`.
    pub(crate) fn warn(&self, span: Span, message: impl AsRef<str>) {
        self.push_warning(Some(span), message.as_ref());
    }

    fn push_warning(&self, span: Option<Span>, message: &str) {
        let line = span.map(|span| (span.file, self.line(span)));
        let hash = self.hasher.hash_one((line, message));
        if self.said.borrow_mut().insert(hash) && self.alike_warnings.borrow_mut().keep(message) {
            let place = span.map(|span| format!("{}: ", self.place(span))).unwrap_or_default();
            self.warnings.borrow_mut().push(format!("{place}{message}"));
        }
    }

    /// Index of the line where a span starts.
    fn line(&self, span: Span) -> usize {
        self.inner.borrow().files[span.file].line_of(span.start)
    }

    /// The place of a span as `file:line`.
    pub(crate) fn place(&self, span: Span) -> String {
        let inner = self.inner.borrow();
        let file = &inner.files[span.file];
        format!("{}:{}", file.name, file.line_of(span.start) + 1)
    }

    /// Warn without a place.
    pub(crate) fn warn_nowhere(&self, message: impl AsRef<str>) {
        self.push_warning(None, message.as_ref());
    }

    /// Whether any error was reported.
    pub(crate) fn has_errors(&self) -> bool {
        !self.inner.borrow().problems.is_empty()
    }

    /// "did you mean `x`?", if a similar candidate exists, and if the scene had not too many misspelt names before.
    pub(crate) fn suggestion<'a>(
        &self,
        word: &str,
        candidates: impl IntoIterator<Item = &'a str>,
    ) -> Option<String> {
        let left = self.comparisons.get();
        let candidates: Vec<&str> = candidates.into_iter().take(left + 1).collect();
        self.comparisons.set(left.saturating_sub(candidates.len()));
        if candidates.len() > left {
            return None;
        }
        did_you_mean(word, candidates).map(|c| format!("did you mean `{c}`?"))
    }

    /// The warnings, of which many similar ones are counted instead of shown; or the errors if there are any.
    pub(crate) fn finish(self) -> Result<Vec<String>, Diagnostics> {
        let mut inner = self.inner.into_inner();
        // Sort by position in the text: files may have been read in any order.
        inner.problems.sort_by_key(|p| p.span.map_or((usize::MAX, 0), |s| (s.file, s.start)));
        if inner.problems.is_empty() {
            return Ok(self.alike_warnings.into_inner().insert_into(self.warnings.into_inner()));
        }
        let alike = self.alike_errors.into_inner();
        inner.hidden = alike.hidden();
        inner.counted = alike.counted().into_iter().map(|(_, line)| line).collect();
        Err(inner)
    }
}

#[cfg(test)]
mod tests;
