//! Shape plugins.

mod distances;
pub(crate) mod mesh_file;
pub(crate) mod obj;
mod place;
pub(crate) mod ply;
mod power;
mod serialized;
pub(crate) mod sheet;
pub(crate) mod smooth;
mod solids;

use gi_core::geometry::{Geometry, Shape};
use gi_core::material::Material;
use gi_core::texture::Texture;
use glam::Vec3;

use crate::attributes;
use crate::builder::Builder;
use crate::document::{Class, Node};
use crate::origins::ShapeOrigin;

/// The supported plugins.
const KNOWN: [&str; 11] = [
    "obj",
    "ply",
    "serialized",
    "rectangle",
    "cube",
    "sphere",
    "disk",
    "cylinder",
    "shapegroup",
    "instance",
    "sdfgrid",
];

/// Warn about a shape without area, or about a solid that its transform flattens.
fn note_flatness(node: Node<'_>, name: &str, geometry: &Geometry) {
    let no_area = match geometry {
        Geometry::Mesh(mesh) => {
            (0..mesh.triangles.len()).all(|k| mesh.area_vector(k) == Vec3::ZERO)
        }
        Geometry::Disk { du, dv, .. } => du.cross(*dv) == Vec3::ZERO,
        Geometry::Sphere { .. } | Geometry::Cylinder { .. } => false, // an error, reported earlier
    };
    if no_area {
        node.warn(format!("the shape `{name}` has no area: it is invisible"));
        return;
    }
    // Rectangles and disks are flat anyway.
    let solid = !["rectangle", "disk"].contains(&node.plugin());
    if solid && !node.transform("to_world").inverse().is_finite() {
        let message = format!("the shape `{name}` is flat: its `to_world` cannot be inverted");
        node.report.warn(node.span_of("to_world"), message);
    }
}

impl Builder<'_> {
    /// A shape with its material, emission and media; `None` if an error was reported.
    pub(crate) fn shape(&mut self, node: Node<'_>) -> Option<(Shape, ShapeOrigin)> {
        if !self.built_shapes.insert(node.id) {
            node.warn("this shape is already in the scene: the second reference is ignored");
            return None;
        }
        let is_inline = node.doc.is_pbrt && node.plugin() == "trianglemesh";
        if !KNOWN.contains(&node.plugin()) && !is_inline {
            node.unknown_plugin(&KNOWN);
            return None;
        }
        node.ignore(&[
            "filename",
            "flip_tex_coords",
            "shape_index",
            "face_normals",
            "max_smooth_angle",
        ]);
        node.ignore(&["to_world", "subdiv", "silhouette_sampling_weight"]);
        self.enter_shape(node);
        let material = self.shape_material(node);
        let mut emission = self.emission(node);
        let [interior, exterior] = ["interior", "exterior"]
            .map(|side| node.child_if(side, |n| n.class() == Class::Medium))
            .map(|medium| medium.and_then(|m| self.medium(m)));
        let has_attributes = self.attributes.take().is_some();
        let (mut geometry, mut origin, mirrored) = self.geometry(node)?;
        if has_attributes && let Geometry::Mesh(mesh) = &mut geometry {
            attributes::unfold(mesh);
            origin = ShapeOrigin::Itself;
        }
        let name = node.object().id.clone().unwrap_or_else(|| node.plugin().to_owned());
        note_flatness(node, &name, &geometry);
        if let (Some(radiance), true) = (&mut emission, node.doc.is_pbrt) {
            power::normalize(node, &geometry, radiance);
        }
        let shape = Shape {
            name,
            geometry,
            material,
            emission,
            interior,
            exterior,
            flip_normals: node.bool("flip_normals", false) != mirrored,
        };
        Some((shape, origin))
    }

    /// The shape's geometry, how it was given, and whether its normals point the wrong way.
    fn geometry(&mut self, node: Node<'_>) -> Option<(Geometry, ShapeOrigin, bool)> {
        let to_world = node.to_world();
        let rounded = to_world.as_affine3a();
        Some(match node.plugin() {
            "rectangle" => {
                let mesh = Geometry::Mesh(solids::rectangle(&to_world));
                (mesh, ShapeOrigin::Unit("rectangle", rounded), false)
            }
            "cube" => {
                let mesh = Geometry::Mesh(solids::cube(&to_world));
                (mesh, ShapeOrigin::Unit("cube", rounded), false)
            }
            "sphere" => {
                let (geometry, mirrored) = solids::sphere(node, &to_world)?;
                (geometry, ShapeOrigin::Itself, mirrored)
            }
            "disk" => {
                let (geometry, mirrored) = solids::disk(&to_world);
                (geometry, ShapeOrigin::Itself, mirrored)
            }
            "cylinder" => (solids::cylinder(node, &to_world)?, ShapeOrigin::Itself, false),
            "sdfgrid" => {
                let mesh = self.surface_of_distances(node, &to_world)?;
                (Geometry::Mesh(mesh), ShapeOrigin::Itself, false)
            }
            _ => {
                let (file, portable, mesh) = self.assets.take_mesh(node.id)?;
                // pbrt also reads compressed files, and a mirror does not turn a faceted mesh inside out.
                let mirrored = to_world.matrix3.determinant() < 0.0 && mesh.normals.is_empty();
                let is_compressed = file.path.extension().is_some_and(|e| e == "gz");
                let special = node.doc.is_pbrt && (mirrored || is_compressed);
                let origin = if portable && !special && !node.has("max_smooth_angle") {
                    ShapeOrigin::File(file, rounded)
                } else {
                    ShapeOrigin::Itself
                };
                (Geometry::Mesh(mesh), origin, false)
            }
        })
    }

    fn shape_material(&mut self, node: Node<'_>) -> usize {
        let bsdfs = node.children(Class::Bsdf);
        if let [_, second, ..] = bsdfs.as_slice() {
            second.error("a second bsdf of one shape", "expected one");
        }
        if let Some(bsdf) = bsdfs.first() {
            return self.material(*bsdf);
        }
        let has = |class| node.all_children().any(|n| n.class() == class);
        if has(Class::Emitter) {
            return self.black();
        }
        // Mitsuba 0.6 treats a shape that has a medium but no bsdf as a mere boundary.
        if node.doc.version == 0 && has(Class::Medium) {
            let index = self.null.unwrap_or_else(|| self.push_material(Material::Null, None));
            return *self.null.insert(index);
        }
        let index = self.grey.unwrap_or_else(|| {
            self.push_material(Material::Diffuse { reflectance: Texture::grey(0.5) }, None)
        });
        *self.grey.insert(index)
    }

    fn emission(&mut self, node: Node<'_>) -> Option<Texture> {
        let emitters = node.children(Class::Emitter);
        if let [_, second, ..] = emitters.as_slice() {
            second.error("a second emitter of one shape", "expected one");
        }
        let emitter = emitters.first()?;
        self.used_emitters.insert(emitter.id);
        if emitter.plugin() != "area" {
            emitter.unknown_plugin(&["area"]);
            return None;
        }
        emitter.ignore(&["sampling_weight"]);
        Some(self.light_texture(*emitter, "radiance"))
    }
}
