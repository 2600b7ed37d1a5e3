//! From a document to the parts of a scene.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::sync::Arc;

use gi_core::geometry::{Instance, Shape};
use gi_core::light::LightSource;
use gi_core::scene::SceneParts;
use gi_core::texture::Bitmap;
use glam::Affine3A;

use crate::assets::Assets;
use crate::diagnostics::Report;
use crate::document::{Class, Document, Node, ObjectId};
use crate::shapes::MeshFile;
use crate::sky::SunSky;
use crate::textures::BitmapFile;

/// Where the parts of a scene came from: what an export writes instead of the parts themselves.
#[derive(Clone, Debug, Default)]
pub(crate) struct Origins {
    /// Names of the materials.
    pub(crate) materials: Vec<Option<String>>,
    /// Names of the media.
    pub(crate) media: Vec<Option<String>>,
    /// Of each shape, how its geometry was given.
    pub(crate) shapes: Vec<ShapeOrigin>,
    /// The same for each group.
    pub(crate) groups: Vec<Vec<ShapeOrigin>>,
    /// Of each light.
    pub(crate) lights: Vec<LightOrigin>,
    /// By the address of the picture, which is kept alive beside it.
    bitmaps: HashMap<usize, (Arc<Bitmap>, BitmapFile)>,
}

/// How a shape's geometry was given.
#[derive(Clone, Debug)]
pub(crate) enum ShapeOrigin {
    /// By a file that Mitsuba 3 reads as we do.
    File(MeshFile, Affine3A),
    /// As `rectangle` or `cube`.
    Unit(&'static str, Affine3A),
    /// In some other way: the geometry itself says all.
    Itself,
}

/// How a light was given.
#[derive(Clone, Debug)]
pub(crate) enum LightOrigin {
    /// As an `envmap`.
    Picture(PathBuf),
    /// As `sun`, `sky` or `sunsky`; the next light may be part of the same.
    SunSky(SunSky),
    /// Part of the light before.
    SameAsBefore,
    /// The light itself says all.
    Itself,
}

impl Origins {
    /// Remember where a picture came from.
    pub(crate) fn note_bitmap(&mut self, bitmap: &Arc<Bitmap>, file: &BitmapFile) {
        let known = self.bitmaps.entry(Arc::as_ptr(bitmap).addr());
        known.or_insert_with(|| (bitmap.clone(), file.clone()));
    }

    /// Where a picture came from.
    pub(crate) fn bitmap_file(&self, bitmap: &Arc<Bitmap>) -> Option<&BitmapFile> {
        self.bitmaps.get(&Arc::as_ptr(bitmap).addr()).map(|(_, file)| file)
    }
}

/// What the scene is made from while it is made.
pub(crate) struct Builder<'a> {
    pub(crate) report: &'a Report,
    pub(crate) assets: Assets,
    pub(crate) parts: SceneParts,
    pub(crate) origins: Origins,
    /// Of each material, whether light can pass through it.
    pub(crate) transmits: Vec<bool>,
    pub(crate) material_of: HashMap<ObjectId, usize>,
    /// Bsdfs being made, outermost first.
    pub(crate) open_materials: Vec<ObjectId>,
    pub(crate) black: Option<usize>,
    pub(crate) grey: Option<usize>,
    pub(crate) null: Option<usize>,
    pub(crate) medium_of: HashMap<ObjectId, usize>,
    pub(crate) group_of: HashMap<ObjectId, usize>,
    pub(crate) built_shapes: HashSet<ObjectId>,
    /// Emitters that belong to shapes.
    pub(crate) used_emitters: HashSet<ObjectId>,
}

impl<'a> Builder<'a> {
    /// A builder that has made nothing.
    pub(crate) fn new(report: &'a Report, assets: Assets) -> Self {
        Builder {
            report,
            assets,
            parts: SceneParts::default(),
            origins: Origins::default(),
            transmits: Vec::new(),
            material_of: HashMap::new(),
            open_materials: Vec::new(),
            black: None,
            grey: None,
            null: None,
            medium_of: HashMap::new(),
            group_of: HashMap::new(),
            built_shapes: HashSet::new(),
            used_emitters: HashSet::new(),
        }
    }

    /// Make everything that stands in the scene but its sensor.
    pub(crate) fn scene(&mut self, doc: &'a Document) {
        let Some(scene) = doc.nodes(self.report).next() else { return };
        // Named materials are made even if no shape uses them: their mistakes are reported too.
        for node in scene.children(Class::Bsdf) {
            self.material(node);
        }
        for node in scene.children(Class::Medium) {
            self.medium(node);
        }
        for node in scene.children(Class::Shape) {
            self.top_level_shape(node);
        }
        for node in scene.children(Class::Emitter) {
            self.light(node);
        }
        scene.children(Class::Texture);
        scene.children(Class::Volume);
        scene.children(Class::Phase);
        scene.children(Class::Ignored);
        scene.children(Class::Film);
        scene.children(Class::Spectrum);
    }

    fn top_level_shape(&mut self, node: Node<'_>) {
        match node.plugin() {
            "shapegroup" => {
                self.group(node);
            }
            "instance" => self.instance(node),
            _ => {
                if let Some((shape, origin)) = self.shape(node) {
                    self.parts.shapes.push(shape);
                    self.origins.shapes.push(origin);
                }
            }
        }
    }

    fn group(&mut self, node: Node<'_>) -> usize {
        if let Some(&known) = self.group_of.get(&node.id) {
            return known;
        }
        let mut shapes: Vec<Shape> = Vec::new();
        let mut origins = Vec::new();
        for child in node.children(Class::Shape) {
            if ["instance", "shapegroup"].contains(&child.plugin()) {
                child.error(
                    format!("`{}` inside of a `shapegroup`", child.plugin()),
                    "expected a shape",
                );
                continue;
            }
            let Some((shape, origin)) = self.shape(child) else { continue };
            if shape.emission.is_some() {
                child.error("an area light inside of a `shapegroup`", "this shape shines");
            }
            shapes.push(shape);
            origins.push(origin);
        }
        self.parts.groups.push(shapes);
        self.origins.groups.push(origins);
        self.group_of.insert(node.id, self.parts.groups.len() - 1);
        self.parts.groups.len() - 1
    }

    fn instance(&mut self, node: Node<'_>) {
        let to_world = node.transform("to_world");
        if !to_world.inverse().is_finite() {
            let message = "the instance is flattened: its `to_world` cannot be inverted";
            node.report.warn(node.span_of("to_world"), message);
        }
        match node.children(Class::Shape).as_slice() {
            [group] if group.plugin() == "shapegroup" => {
                let group = self.group(*group);
                self.parts.instances.push(Instance { group, to_world });
            }
            _ => {
                node.error("`instance` without a `shapegroup`", "expected one reference to a group")
            }
        }
    }

    /// Add a light that is no surface.
    pub(crate) fn push_light(&mut self, light: LightSource, origin: LightOrigin) {
        self.parts.lights.push(light);
        self.origins.lights.push(origin);
    }
}
