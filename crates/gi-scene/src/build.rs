//! Builds the parts of a scene from a document.

use gi_core::geometry::{Instance, Shape};
use gi_core::light::LightSource;

use crate::builder::Builder;
use crate::document::{Class, Document, Node};
use crate::origins::{LightOrigin, ShapeOrigin};
use crate::shapes::sheet;

impl<'a> Builder<'a> {
    /// Build everything in the scene except its sensor.
    pub(crate) fn scene(&mut self, doc: &'a Document) {
        let Some(scene) = doc.nodes(self.report).next() else { return };
        // Build named materials even if no shape uses them, so that their errors are reported too.
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
                    let second = sheet::second(node, &shape);
                    self.parts.shapes.push(shape);
                    self.origins.shapes.push(origin);
                    self.origins.shapes.extend(second.iter().map(|_| ShapeOrigin::Itself));
                    self.parts.shapes.extend(second);
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
                    format!("`{}` inside a `shapegroup`", child.plugin()),
                    "expected a shape",
                );
                continue;
            }
            let Some((shape, origin)) = self.shape(child) else { continue };
            if shape.emission.is_some() {
                child.error("an area light inside a `shapegroup`", "this shape emits light");
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
        let to_world = node.to_world().as_affine3a();
        if !to_world.inverse().is_finite() {
            let message = "the instance is flat: its `to_world` cannot be inverted";
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

    /// Add a light that is not a surface.
    pub(crate) fn push_light(&mut self, light: LightSource, origin: LightOrigin) {
        self.parts.lights.push(light);
        self.origins.lights.push(origin);
    }
}
