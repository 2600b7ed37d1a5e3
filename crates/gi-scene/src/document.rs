//! A scene file as a tree of typed properties, with includes inlined, `$name`s substituted and references resolved.
//! Only this module and its submodules read XML; `pbrt` makes the same tree of its own format.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gi_core::math::Rgb;
use glam::{DAffine3, DVec3};

use crate::diagnostics::{Report, Span};
use crate::files::Folders;
use crate::hash::Hash;
use crate::local::Local;
use crate::media::InlineGrid;
use crate::shapes::mesh_file::ReadMesh;
use crate::spectrum::Spectrum;

mod colors;
mod grow;
mod node;
mod parse;
mod ranges;
mod refused;

pub(crate) use colors::Meaning;
pub(crate) use node::Node;
pub(crate) use parse::parse;

/// Index into [`Document::objects`].
pub(crate) type ObjectId = usize;

/// The class of a plugin, which its tag names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    Scene,
    Shape,
    Bsdf,
    Texture,
    Spectrum,
    Emitter,
    Sensor,
    Film,
    Filter,
    Medium,
    Phase,
    Volume,
    Ignored,
}

impl Class {
    /// The class that a tag names, in the old or the new Mitsuba format.
    fn of(tag: &str) -> Option<Class> {
        Some(match tag {
            "shape" => Class::Shape,
            "bsdf" => Class::Bsdf,
            "texture" => Class::Texture,
            "emitter" | "luminaire" => Class::Emitter,
            "sensor" | "camera" => Class::Sensor,
            "film" => Class::Film,
            "rfilter" => Class::Filter,
            "medium" => Class::Medium,
            "phase" => Class::Phase,
            "volume" => Class::Volume,
            "integrator" | "sampler" | "subsurface" | "mode" => Class::Ignored,
            _ => return None,
        })
    }

    /// The tag that Mitsuba 3 uses.
    pub(crate) fn tag(self) -> &'static str {
        match self {
            Class::Scene => "scene",
            Class::Shape => "shape",
            Class::Bsdf => "bsdf",
            Class::Texture => "texture",
            Class::Spectrum => "spectrum",
            Class::Emitter => "emitter",
            Class::Sensor => "sensor",
            Class::Film => "film",
            Class::Filter => "rfilter",
            Class::Medium => "medium",
            Class::Phase => "phase",
            Class::Volume => "volume",
            Class::Ignored => "integrator",
        }
    }
}

/// The value of a property.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Bool(bool),
    Integer(i64),
    Float(f32),
    Text(String),
    Color(Rgb),
    Spectrum(Spectrum),
    Vector(DVec3),
    Transform(Box<DAffine3>),
}

impl Value {
    /// A transform. It is boxed, because it is several times as large as all other values.
    pub(crate) fn transform(m: DAffine3) -> Self {
        Value::Transform(Box::new(m))
    }

    /// The kind of value, for messages.
    fn kind(&self) -> &'static str {
        match self {
            Value::Bool(_) => "a boolean",
            Value::Integer(_) => "an integer",
            Value::Float(_) => "a float",
            Value::Text(_) => "a string",
            Value::Color(_) => "a colour",
            Value::Spectrum(_) => "a spectrum",
            Value::Vector(_) => "a vector",
            Value::Transform(_) => "a transform",
        }
    }
}

/// A named value.
#[derive(Debug)]
pub(crate) struct Property {
    name: String,
    span: Span,
    value: Value,
    used: Cell<bool>,
}

/// A child of an object, either nested in it or referred to.
#[derive(Debug)]
pub(crate) struct Child {
    name: String,
    span: Span,
    target: Target,
    used: Cell<bool>,
}

#[derive(Debug)]
enum Target {
    Here(ObjectId),
    Ref(String),
    /// A reference to an id that does not exist; already reported.
    Missing,
}

/// A plugin with its properties and children.
#[derive(Debug)]
pub(crate) struct Object {
    pub(crate) class: Class,
    /// The tag as it appears in the file.
    pub(crate) tag: String,
    pub(crate) plugin: String,
    /// Where the plugin's name is in the text.
    pub(crate) plugin_span: Span,
    pub(crate) id: Option<String>,
    /// Folder of the file that contains the object; file names are relative to it.
    pub(crate) folder: Arc<Path>,
    properties: Vec<Property>,
    children: Vec<Child>,
    /// Property names that the code asked for; candidates for "did you mean".
    asked: RefCell<Vec<&'static str>>,
    /// Whether the code asked for any property. Unused properties are reported only for such objects.
    touched: Cell<bool>,
}

impl Object {
    /// Note that the code asks for a property.
    fn ask(&self, name: &'static str) {
        let mut asked = self.asked.borrow_mut();
        if !asked.contains(&name) {
            asked.push(name);
        }
    }
}

/// A whole scene file.
#[derive(Debug)]
pub(crate) struct Document {
    objects: Vec<Object>,
    ids: HashMap<String, ObjectId>,
    /// Folders searched for files after the file's own folder: the main scene's folder, then those of `<path>`.
    pub(crate) search: Vec<PathBuf>,
    /// The names in the folders where files were looked for.
    pub(crate) folders: Folders,
    /// Values of the scene's `gi.*` names.
    pub(crate) presets: BTreeMap<String, String>,
    /// Major version of the format that the file declares; 0 means 0.5 or 0.6.
    pub(crate) version: u32,
    /// Whether the file is pbrt's: its meshes without normals stay faceted, and keep their sides if they are mirrored.
    pub(crate) is_pbrt: bool,
    /// Meshes that the scene file itself contains. Each is taken when it is moved to its place.
    pub(crate) inline_meshes: RefCell<HashMap<ObjectId, ReadMesh>>,
    /// Grids of media that the scene file itself contains. Each is taken when its medium is built.
    pub(crate) inline_grids: RefCell<HashMap<ObjectId, InlineGrid>>,
    /// Unknown tags directly inside the scene, each once.
    pub(crate) unknown_tags: Vec<String>,
    /// Whether any unknown tag has a `type`, as scene objects do.
    pub(crate) unknown_things: bool,
    /// Hash of the text of all files and of the defines.
    pub(crate) hash: Hash,
    /// Where shapes, lights and cameras are placed.
    pub(crate) local: RefCell<Local>,
}

impl Document {
    /// All objects in document order; the first is the scene itself.
    pub(crate) fn nodes<'a>(&'a self, report: &'a Report) -> impl Iterator<Item = Node<'a>> {
        (0..self.objects.len()).map(move |id| Node::new(self, report, id))
    }

    /// Hash of all objects except those that do not change the world: cameras, films and integrators.
    /// The contents of mesh and picture files are not included.
    pub(crate) fn world_hash(&self) -> Hash {
        let of_the_world = |o: &&Object| {
            !matches!(o.class, Class::Sensor | Class::Film | Class::Filter | Class::Ignored)
        };
        let mut hash = Hash::default();
        for object in self.objects.iter().filter(of_the_world) {
            let Object { class, plugin, properties, children, .. } = object;
            hash.bytes(format!("{class:?} {plugin} {:?}", object.id).as_bytes());
            for p in properties {
                hash.bytes(format!("{} = {:?}", p.name, p.value).as_bytes());
            }
            for c in children {
                // A nested object is hashed by its own turn of the loop; a reference is hashed by its name.
                let target = match &c.target {
                    Target::Here(id) => self.objects[*id].class.tag(),
                    Target::Ref(name) => name.as_str(),
                    Target::Missing => "",
                };
                let of_the_world =
                    !matches!(&c.target, Target::Here(id) if !of_the_world(&&self.objects[*id]));
                if of_the_world {
                    hash.bytes(format!("{} : {target}", c.name).as_bytes());
                }
            }
        }
        hash
    }

    /// Warn about every property and child that was given but not used.
    pub(crate) fn report_unused(&self, report: &Report) {
        for object in self.objects.iter().filter(|o| o.touched.get()) {
            let mut asked = object.asked.borrow().clone();
            asked.sort_unstable();
            let what = format!("{} `{}`", object.class.tag(), object.plugin);
            for p in object.properties.iter().filter(|p| !p.used.get()) {
                let hint = report.suggestion(&p.name, asked.iter().copied());
                let hint = hint.map(|hint| format!(", {hint}")).unwrap_or_default();
                report.warn(p.span, format!("{what} has no parameter `{}`: ignored{hint}", p.name));
            }
            for c in object.children.iter().filter(|c| !c.used.get()) {
                let tag = match &c.target {
                    Target::Here(id) => self.objects[*id].tag.as_str(),
                    Target::Ref(_) | Target::Missing => "ref",
                };
                let name = match c.name.as_str() {
                    "" => String::new(),
                    name => format!(" `{name}`"),
                };
                report.warn(c.span, format!("{what} does not use its {tag}{name}: ignored"));
            }
        }
    }
}
