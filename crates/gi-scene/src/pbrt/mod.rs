//! Reads pbrt-v4's format, and pbrt-v3's, into the same tree as Mitsuba's XML.
//!
//! `lexer` and `reader` turn text into directives with parameters, each with its place. `state` is the graphics state that
//! directives change. The other modules add objects of Mitsuba's kinds to the [`Document`], from which the scene is
//! built. World coordinates stay as they are: pbrt calls them left-handed and Mitsuba right-handed, but only the camera
//! tells the difference, whose x axis points to the right in pbrt and to the left in Mitsuba.

mod bsdfs;
mod camera;
mod directives;
mod lexer;
mod lights;
mod materials;
mod media;
mod meshes;
mod params;
mod pictured_lights;
mod pictures;
mod reader;
mod shapes;
mod spectra;
mod state;
mod textures;
mod types;
mod v3;

use std::cell::{Cell, RefCell};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use glam::DAffine3;

use crate::diagnostics::{Report, Span};
use crate::document::{Class, Document, ObjectId};
use crate::hash::Hash;
use crate::texts::{Cost, Texts};
use lexer::{Kind, Lexer};
use params::Params;
use reader::Reader;
use state::State;
use textures::Known;
use types::Text;

/// Largest depth of nested includes.
const MAX_INCLUDE_DEPTH: usize = 15;
/// Largest number of files that one scene may include, counting repeats.
const MAX_INCLUDES: usize = 10_000;
/// Largest length of all included text, counting repeats.
const MAX_INCLUDED: u64 = 1 << 30;
/// What parameters cost, apart from their numbers.
const COST: Cost = Cost { most_included: MAX_INCLUDED, mark: (b'"', 2, "parameters"), part: 200 };

/// Read a scene file and all files that it includes.
pub(crate) fn parse(
    path: &Path,
    defines: &[(String, String)],
    report: &Report,
) -> Option<Document> {
    let mut translator = Translator::new(path, report);
    for (name, value) in defines {
        translator.doc.hash.bytes(name.as_bytes());
        translator.doc.hash.bytes(value.as_bytes());
        if name.starts_with("gi.") {
            translator.doc.presets.insert(name.clone(), value.clone());
        } else {
            report.warn_nowhere(format!("-D {name}: a pbrt file has no names to define"));
        }
    }
    translator.file(path, None);
    if !translator.in_world && !report.has_errors() {
        report.error_nowhere(format!("`{}` has no `WorldBegin`", path.display()));
    }
    translator.finish()
}

/// A scene that is being read.
struct Translator<'r> {
    report: &'r Report,
    doc: Document,
    /// The scene's own object.
    scene: ObjectId,
    state: State,
    /// Whether the file is pbrt-v3's: only that has `WorldEnd`.
    is_v3: bool,
    in_world: bool,
    /// Files that are open, outermost first.
    open: Vec<PathBuf>,
    includes: usize,
    texts: Texts,
    camera: Option<(Params, DAffine3)>,
    film: Option<Params>,
    filter: Option<Params>,
    integrator: Option<Params>,
    /// Ids of the named materials.
    materials: HashMap<String, Rc<str>>,
    /// Ids of the materials that have textures.
    textured: HashSet<Rc<str>>,
    /// Textures of colours and textures of numbers, by name.
    textures: [HashMap<String, Known>; 2],
    /// Ids of the named media; `None` for those that are not supported.
    media: HashMap<String, Option<String>>,
    wanted_media: Vec<Text>,
    /// Ids that were referred to before they were known, with their names and kinds.
    wanted: Vec<(String, Text, &'static str)>,
    /// Named groups of shapes, and the one that is open.
    groups: HashMap<String, ObjectId>,
    group: Option<ObjectId>,
    /// Number of ids that were made.
    numbers: usize,
    noted_spectra: Cell<bool>,
    /// Hash of the spectrum files.
    spectrum_files: RefCell<Hash>,
}

impl<'r> Translator<'r> {
    fn new(path: &Path, report: &'r Report) -> Self {
        let mut doc = Document::new(path);
        doc.is_pbrt = true;
        let start = Span { file: 0, start: 0, end: 0 };
        let scene = doc.add(Class::Scene, "scene", "scene", start);
        Translator {
            report,
            doc,
            scene,
            state: State::default(),
            is_v3: false,
            in_world: false,
            open: Vec::new(),
            includes: 0,
            texts: Texts::new(COST),
            camera: None,
            film: None,
            filter: None,
            integrator: None,
            materials: HashMap::new(),
            textured: HashSet::new(),
            textures: [HashMap::new(), HashMap::new()],
            media: HashMap::new(),
            wanted_media: Vec::new(),
            wanted: Vec::new(),
            groups: HashMap::new(),
            group: None,
            numbers: 0,
            noted_spectra: Cell::new(false),
            spectrum_files: RefCell::default(),
        }
    }

    /// A number that no other id has.
    fn next_number(&mut self) -> usize {
        self.numbers += 1;
        self.numbers
    }

    /// Read one file. `from` is where it is included.
    fn file(&mut self, path: &Path, from: Option<Span>) {
        let text = match self.texts.read(path, from.is_some(), self.report) {
            Ok(text) => text,
            Err(why) => {
                let message = format!("cannot read `{}`: {why}", path.display());
                return match from {
                    None => self.report.error_nowhere(message),
                    Some(span) => self.report.error(span, message, "included here"),
                };
            }
        };
        self.doc.hash.bytes(text.as_bytes());
        let file = self.report.add_file(path, &text);
        if from.is_none() {
            self.is_v3 = has_world_end(&text);
        }
        self.open.push(path.canonicalize().unwrap_or_else(|_| path.to_owned()));
        let depth = self.state.depth();
        self.directives(&mut Reader::new(&text, file, self.report));
        if from.is_none() {
            self.state.close(depth, self.report);
        }
        self.open.pop();
    }

    /// `Include` and `Import`: read another file here.
    fn include(&mut self, name: &Text) {
        self.includes += 1;
        if self.open.len() > MAX_INCLUDE_DEPTH || self.includes > MAX_INCLUDES {
            return self.report.error(name.span, "too many files include each other", "");
        }
        let Some(path) = self.doc.locate(&name.text, name.span, self.report) else {
            let message = format!("cannot find `{}`", name.text);
            return self.report.error(name.span, message, "included here");
        };
        let canonical = path.canonicalize().unwrap_or_else(|_| path.clone());
        if self.open.contains(&canonical) {
            let message = format!("`{}` includes itself", name.text);
            return self.report.error(name.span, message, "this completes the cycle");
        }
        self.file(&path, Some(name.span));
    }

    /// Add what is known only at the end, and check all references.
    fn finish(mut self) -> Option<Document> {
        if self.open.is_empty() && self.texts.is_empty() {
            return None;
        }
        self.add_sensor();
        self.add_integrator();
        self.check_media();
        let wanted = std::mem::take(&mut self.wanted);
        for (_, name, kind) in wanted.iter().filter(|(key, ..)| !self.doc.knows(key)) {
            self.report_missing(name, kind);
        }
        self.doc.drop_unknown_references();
        self.doc.hash.word(self.spectrum_files.borrow().value());
        Some(self.doc)
    }

    /// Report a reference to something that does not exist.
    fn report_missing(&self, name: &Text, kind: &str) {
        let textures = || self.textures.iter().flat_map(|t| t.keys().map(String::as_str));
        let help = if kind == "material" {
            self.report.suggestion(&name.text, self.materials.keys().map(String::as_str))
        } else if self.textures.iter().any(|t| t.contains_key(&name.text)) {
            // A constant texture is replaced by its value where it is used.
            Some("define this texture before its use".to_owned())
        } else {
            self.report.suggestion(&name.text, textures())
        };
        let message = format!("no {kind} is named `{}`", name.text);
        self.report.error_help(name.span, message, "referred to here", help);
    }
}

/// Whether a text contains the directive that only pbrt-v3 has.
fn has_world_end(text: &str) -> bool {
    let mut lexer = Lexer::new(text);
    while let Some(token) = lexer.next() {
        if token.is_ok_and(|t| t.kind == Kind::Word && lexer.word(&t) == "WorldEnd") {
            return true;
        }
    }
    false
}
