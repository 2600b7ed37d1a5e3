//! Builds a document piece by piece, for formats other than XML.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Child, Class, Document, Object, ObjectId, Property, Target, Value};
use crate::diagnostics::{Report, Span};
use crate::files::{self, Folders};
use crate::hash::Hash;

impl Document {
    /// A document that contains nothing. `path` is the scene's file; files are looked for in its folder.
    pub(crate) fn new(path: &Path) -> Document {
        Document {
            objects: Vec::new(),
            ids: HashMap::new(),
            search: vec![files::folder_of(path)],
            folders: Folders::default(),
            presets: BTreeMap::new(),
            version: 3,
            is_pbrt: false,
            inline_meshes: RefCell::default(),
            inline_grids: RefCell::default(),
            unknown_tags: Vec::new(),
            unknown_things: false,
            hash: Hash::default(),
            local: RefCell::default(),
        }
    }

    /// Add an object, which belongs to no other yet. `tag` is the word of the file that introduced it.
    pub(crate) fn add(&mut self, class: Class, tag: &str, plugin: &str, span: Span) -> ObjectId {
        let folder =
            self.shared_folder(self.search.first().map_or(Path::new("."), PathBuf::as_path));
        self.objects.push(Object {
            class,
            tag: tag.to_owned(),
            plugin: plugin.to_owned(),
            plugin_span: span,
            id: None,
            folder,
            properties: Vec::new(),
            children: Vec::new(),
            asked: RefCell::default(),
            touched: Cell::new(false),
        });
        self.objects.len() - 1
    }

    /// A folder for a new object: the last object's, if it is the same.
    pub(super) fn shared_folder(&self, folder: &Path) -> Arc<Path> {
        match self.objects.last() {
            Some(last) if *last.folder == *folder => last.folder.clone(),
            _ => folder.into(),
        }
    }

    /// Give an object a property. No warning follows if it is not used: the format's reader has its own.
    pub(crate) fn set(&mut self, object: ObjectId, name: &str, span: Span, value: Value) {
        let used = Cell::new(true);
        self.objects[object].properties.push(Property { name: name.to_owned(), span, value, used });
    }

    /// Make an object a child of another.
    pub(crate) fn nest(&mut self, parent: ObjectId, name: &str, child: ObjectId) {
        let span = self.objects[child].plugin_span;
        self.child(parent, name, span, Target::Here(child));
    }

    /// Refer to an object by the id that [`Document::register`] gives it, now or later.
    pub(crate) fn refer(&mut self, parent: ObjectId, name: &str, span: Span, id: &str) {
        self.child(parent, name, span, Target::Ref(id.to_owned()));
    }

    fn child(&mut self, parent: ObjectId, name: &str, span: Span, target: Target) {
        let used = Cell::new(true);
        self.objects[parent].children.push(Child { name: name.to_owned(), span, target, used });
    }

    /// Give an object an id for references. `shown` is its name in messages and exports.
    pub(crate) fn register(&mut self, object: ObjectId, id: &str, shown: Option<&str>) {
        self.ids.insert(id.to_owned(), object);
        self.objects[object].id = shown.map(str::to_owned);
    }

    /// Whether an object has this id.
    pub(crate) fn knows(&self, id: &str) -> bool {
        self.ids.contains_key(id)
    }

    /// Whether an object has any children.
    pub(crate) fn has_children(&self, object: ObjectId) -> bool {
        !self.objects[object].children.is_empty()
    }

    /// Replace references to ids that do not exist, which have been reported.
    pub(crate) fn drop_unknown_references(&mut self) {
        let ids = &self.ids;
        for child in self.objects.iter_mut().flat_map(|o| &mut o.children) {
            if matches!(&child.target, Target::Ref(id) if !ids.contains_key(id)) {
                child.target = Target::Missing;
            }
        }
    }

    /// The path of a file that the scene names; warns if its name differs in case.
    pub(crate) fn locate(&self, name: &str, span: Span, report: &Report) -> Option<PathBuf> {
        let folder = self.search.first()?;
        match self.folders.find(name, folder, &self.search[1..]) {
            files::Found::Exact(path) => Some(path),
            files::Found::OtherCase(path) => {
                report.warn(span, format!("`{name}` is read as `{}`", path.display()));
                Some(path)
            }
            files::Found::No => None,
        }
    }
}
