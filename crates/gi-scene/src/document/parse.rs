use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use gi_core::guard::guarded;

use super::{Child, Class, Document, Object, ObjectId, Target};
use crate::diagnostics::{Report, Span};
use crate::files;
use crate::hash::Hash;
use crate::texts::Texts;
use crate::value;
use defines::{Define, Defines};
use substitute::Element;

mod comments;
mod defines;
mod includes;
mod properties;
mod references;
mod scan;
mod substitute;

/// Largest depth of nested elements. The reader is recursive, and no real scene comes near this depth.
const MAX_NESTING: usize = 64;
/// Largest number of XML nodes in one file. It bounds the memory, and is far above any real scene.
const MAX_NODES: u32 = 1 << 24;

/// Texture plugins that may be written as a `<spectrum>`.
const TEXTURES: [&str; 5] = ["bitmap", "checkerboard", "scale", "mesh_attribute", "rawconstant"];

/// Read a scene file and all files that it includes.
pub(crate) fn parse(
    path: &Path,
    defines: &[(String, String)],
    report: &Report,
) -> Option<Document> {
    let mut parser = Parser::new(path, defines, report);
    let before = Span { file: 0, start: 0, end: 0 };
    parser.file(path, None, before);
    if parser.doc.objects.is_empty() {
        return None;
    }
    parser.check_references();
    parser.check_defines();
    Some(parser.doc)
}

struct Parser<'r> {
    report: &'r Report,
    defines: Defines,
    /// Files that are open, outermost first.
    stack: Vec<PathBuf>,
    includes: usize,
    texts: Texts,
    aliases: Vec<(String, String, Span)>,
    doc: Document,
}

type XmlNode<'a, 'i> = roxmltree::Node<'a, 'i>;

impl<'r> Parser<'r> {
    fn new(path: &Path, defines: &[(String, String)], report: &'r Report) -> Self {
        let mut hash = Hash::default();
        let mut presets = BTreeMap::new();
        for (name, value) in defines {
            hash.bytes(name.as_bytes());
            hash.bytes(value.as_bytes());
            if name.starts_with("gi.") {
                presets.insert(name.clone(), value.clone());
            }
        }
        let define = |(name, value): &(String, String)| Define {
            name: name.clone(),
            value: value.clone(),
            forced: true,
            used: Cell::new(name.starts_with("gi.")),
        };
        let doc = Document { presets, hash, ..Document::new(path) };
        let mut all = Defines::default();
        defines.iter().rev().map(define).for_each(|d| all.add(d)); // the last -D for a name wins
        Parser {
            report,
            defines: all,
            stack: Vec::new(),
            includes: 0,
            texts: Texts::new(includes::COST),
            aliases: Vec::new(),
            doc,
        }
    }

    /// Read one file. Its elements become children of `parent`; without a parent, the file is the whole scene.
    fn file(&mut self, path: &Path, parent: Option<ObjectId>, from: Span) {
        let text = match self.texts.read(path, parent.is_some(), self.report) {
            Ok(text) => text,
            Err(why) => {
                let message = format!("cannot read `{}`: {why}", path.display());
                match parent {
                    None => self.report.error_nowhere(message),
                    Some(_) => self.report.error(from, message, "included here"),
                }
                return;
            }
        };
        self.doc.hash.bytes(text.as_bytes());
        let file = self.report.add_file(path, &text);
        let readable = comments::without_dashes(&text);
        if let Err((Range { start, end }, message)) = scan::check(&text) {
            return self.report.error(Span { file, start, end }, message, "");
        }
        let mut parsed = elements_of(&readable);
        if let (Ok(Err(_)), Some(end)) = (&parsed, end_of_scene(&readable))
            && let Ok(Ok(whole)) = elements_of(&readable[..end])
        {
            // Mitsuba ignores what follows the outermost element.
            self.report.warn(Span { file, start: end, end }, "what follows `</scene>` is ignored");
            parsed = Ok(Ok(whole));
        }
        let xml = match parsed {
            Ok(Ok(xml)) => xml,
            Ok(Err(why)) => return self.xml_error(&why, &text, file),
            Err(why) => {
                let message = format!("cannot read `{}`: {why}", path.display());
                return self.report.error_nowhere(message);
            }
        };
        let root = xml.root_element();
        let element = self.element(root, file);
        if element.tag != "scene" {
            let message = format!("the outermost element is `{}`", element.tag);
            return self.report.error(element.span, message, "expected `scene`");
        }
        let parent = parent.unwrap_or_else(|| {
            let version = element.text("version").and_then(|v| v.split('.').next());
            self.doc.version = version.and_then(|v| v.parse().ok()).unwrap_or(3);
            self.open(&element, Class::Scene, &files::folder_of(path))
        });
        self.stack.push(path.canonicalize().unwrap_or_else(|_| path.to_owned()));
        self.children(root, file, parent, 0);
        self.stack.pop();
    }

    fn xml_error(&self, why: &roxmltree::Error, text: &str, file: usize) {
        let pos = why.pos();
        let line = text.split_inclusive('\n').take(pos.row.saturating_sub(1) as usize);
        let base: usize = line.map(str::len).sum();
        let column = text[base..].chars().take(pos.col.saturating_sub(1) as usize);
        let start = (base + column.map(char::len_utf8).sum::<usize>()).min(text.len());
        let end = start + text[start..].chars().next().map_or(0, char::len_utf8);
        let full = why.to_string();
        let message = full.split(" at ").next().unwrap_or(&full);
        self.report.error(
            Span { file, start, end },
            format!("this is not valid XML: {message}"),
            "",
        );
    }

    /// Read all elements inside an element, in order.
    fn children(&mut self, node: XmlNode<'_, '_>, file: usize, parent: ObjectId, depth: usize) {
        for child in node.children().filter(|n| n.is_element()) {
            let element = self.element(child, file);
            if depth >= MAX_NESTING {
                self.report.error(element.span, "elements are nested too deeply", "");
                return;
            }
            self.one(child, element, file, parent, depth);
        }
    }

    fn one(
        &mut self,
        node: XmlNode<'_, '_>,
        element: Element,
        file: usize,
        parent: ObjectId,
        depth: usize,
    ) {
        match element.tag.as_str() {
            "default" => self.default(&element),
            "include" => self.include(&element, parent),
            "path" => self.search_path(&element, parent),
            "alias" => self.alias(&element),
            "ref" => self.reference(&element, parent),
            "transform" => self.transform(node, &element, file, parent),
            "spectrum" if element.get("type").is_some() => {
                // Mitsuba 2 wrote textures this way.
                let is_texture = TEXTURES.contains(&element.text("type").unwrap_or_default());
                let class = if is_texture { Class::Texture } else { Class::Spectrum };
                self.object(node, &element, class, (file, parent, depth));
            }
            "mode" => {}
            tag => match Class::of(tag) {
                Some(class) => self.object(node, &element, class, (file, parent, depth)),
                None => self.property(&element, parent),
            },
        }
    }

    fn open(&mut self, element: &Element, class: Class, folder: &Path) -> ObjectId {
        let plugin = element.text("type").unwrap_or_default();
        let plugin = if class == Class::Scene { "scene" } else { plugin };
        self.doc.objects.push(Object {
            class,
            tag: element.tag.clone(),
            plugin: plugin.to_lowercase(),
            plugin_span: element.span_of("type"),
            id: element.text("id").map(str::to_owned),
            folder: self.doc.shared_folder(folder),
            properties: Vec::new(),
            children: Vec::new(),
            asked: RefCell::default(),
            touched: Cell::new(false),
        });
        self.doc.objects.len() - 1
    }

    fn object(
        &mut self,
        node: XmlNode<'_, '_>,
        element: &Element,
        class: Class,
        (file, parent, depth): (usize, ObjectId, usize),
    ) {
        if element.get("type").is_none() && class != Class::Ignored {
            let message = format!("`{}` without a type", element.tag);
            return self.report.error(element.span, message, "expected `type=\"...\"`");
        }
        let folder = self.stack.last().map(|p| files::folder_of(p)).unwrap_or_default();
        let id = self.open(element, class, &folder);
        if let Some(a) = element.get("id")
            && self.doc.ids.insert(a.value.clone(), id).is_some()
        {
            self.report.error(a.span, format!("the id `{}` is already used", a.value), "");
        }
        let name = value::snake_case(element.text("name").unwrap_or_default());
        let child =
            Child { name, span: element.span, target: Target::Here(id), used: Cell::new(false) };
        self.doc.objects[parent].children.push(child);
        self.children(node, file, id, depth + 1);
    }
}

/// The elements of a text, or why it is no XML.
fn elements_of(text: &str) -> Result<Result<roxmltree::Document<'_>, roxmltree::Error>, String> {
    let options = roxmltree::ParsingOptions { nodes_limit: MAX_NODES, ..Default::default() };
    guarded(|| Ok(roxmltree::Document::parse_with_options(text, options)))
}

/// Where the last `</scene>` ends, if more text follows.
fn end_of_scene(text: &str) -> Option<usize> {
    const TAG: &str = "</scene>";
    let end = text.rfind(TAG)? + TAG.len();
    (!text[end..].trim().is_empty()).then_some(end)
}
