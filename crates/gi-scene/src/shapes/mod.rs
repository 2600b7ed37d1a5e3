//! Shape plugins.

pub(crate) mod obj;
pub(crate) mod ply;
mod serialized;
pub(crate) mod smooth;
mod solids;

use std::path::PathBuf;

use gi_core::geometry::{Geometry, Mesh, Shape};
use gi_core::material::Material;
use gi_core::texture::Texture;
use glam::{Affine3A, Vec3};

use crate::build::{Builder, ShapeOrigin};
use crate::document::{Class, Node};
use crate::value::MAX_NUMBER;

/// The plugins that are understood.
const KNOWN: [&str; 10] = [
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
];

/// A mesh file and how it is read: files with equal keys are read once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct MeshFile {
    pub(crate) path: PathBuf,
    pub(crate) kind: MeshKind,
}

/// The format of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MeshKind {
    /// Wavefront; `flip`: v = 0 is the bottom of the picture, as is usual there.
    Obj { flip: bool },
    /// Stanford.
    Ply { flip: bool },
    /// Mitsuba's own; a file holds several.
    Serialized { index: usize },
}

/// What a mesh file holds.
#[derive(Clone, Debug)]
pub(crate) struct ReadMesh {
    pub(crate) mesh: Mesh,
    /// Whether Mitsuba 3 reads the same from this file.
    pub(crate) portable: bool,
    /// What of the file was left out.
    pub(crate) note: Option<String>,
}

impl MeshFile {
    /// The plugins that read files.
    pub(crate) const KINDS: [&'static str; 3] = ["obj", "ply", "serialized"];

    /// What a shape says about its file.
    pub(crate) fn of(node: Node<'_>, path: PathBuf) -> MeshFile {
        let kind = match node.plugin() {
            "obj" => MeshKind::Obj { flip: node.bool("flip_tex_coords", true) },
            "ply" => MeshKind::Ply { flip: node.bool("flip_tex_coords", false) },
            _ => {
                let index = node.int_opt("shape_index").unwrap_or(0);
                MeshKind::Serialized { index: usize::try_from(index).unwrap_or(usize::MAX) }
            }
        };
        MeshFile { path, kind }
    }

    /// Read the mesh. Its vertices are finite and its indices in range.
    pub(crate) fn parse(&self, bytes: &[u8]) -> Result<ReadMesh, String> {
        let plain = |mesh, portable| ReadMesh { mesh, portable, note: None };
        let read = match self.kind {
            MeshKind::Obj { flip } => {
                let mut contents = obj::parse(bytes, flip)?;
                let note = contents.note(&self.path.display().to_string());
                let (_, mesh) = contents.meshes.pop().ok_or("it holds no faces")?;
                ReadMesh { mesh, portable: contents.portable, note }
            }
            MeshKind::Ply { flip } => plain(ply::parse(bytes, flip)?, true),
            MeshKind::Serialized { index } => plain(serialized::parse(bytes, index)?, false),
        };
        check(&read.mesh)?;
        Ok(read)
    }
}

/// What every mesh must hold, whatever format it came in.
fn check(mesh: &Mesh) -> Result<(), String> {
    if let Some(i) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(format!("vertex {i} is not finite: {}", mesh.positions[i]));
    }
    mesh.positions.iter().try_for_each(|p| check_size(*p))?;
    if let Some(i) = mesh.uvs.iter().position(|uv| !uv.is_finite()) {
        return Err(format!("texture coordinate {i} is not finite: {}", mesh.uvs[i]));
    }
    let count = mesh.positions.len();
    if let Some(k) = mesh.triangles.iter().position(|t| t.iter().any(|&i| i as usize >= count)) {
        let t = mesh.triangles[k];
        return Err(format!("triangle {k} names vertices {t:?} of {count}"));
    }
    if mesh.triangles.is_empty() {
        return Err("it holds no faces".into());
    }
    Ok(())
}

/// Refuse a vertex so far away that areas and distances overflow.
fn check_size(p: Vec3) -> Result<(), String> {
    if p.abs().max_element() <= MAX_NUMBER {
        return Ok(());
    }
    Err(format!("a vertex is too far away: {p}, at most 1e15"))
}

/// Where a mesh goes and how its normals are made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    pub(crate) to_world: Affine3A,
    face_normals: bool,
    max_smooth_angle: Option<f32>,
}

impl Placement {
    /// What a shape says about it.
    pub(crate) fn of(node: Node<'_>) -> Placement {
        Placement {
            to_world: node.transform("to_world"),
            face_normals: node.bool("face_normals", false),
            max_smooth_angle: node.float_opt("max_smooth_angle"),
        }
    }

    /// Move the mesh. As in Mitsuba, one without normals gets smooth ones unless face normals are asked for.
    /// Returns how many normals were none and had to be replaced.
    pub(crate) fn apply(&self, mesh: &mut Mesh) -> usize {
        if self.face_normals || !self.to_world.inverse().is_finite() {
            mesh.normals.clear();
        }
        let replaced = smooth::replace_bad_normals(mesh);
        mesh.transform(&self.to_world);
        if self.face_normals {
            return replaced;
        }
        match self.max_smooth_angle {
            Some(degrees) => smooth::smooth_up_to(mesh, degrees.to_radians()),
            None if mesh.normals.is_empty() => mesh.smooth_normals(),
            None => smooth::face_the_normals(mesh),
        }
        replaced
    }
}

/// Say that nothing of a shape is seen, or less than was drawn.
fn note_flatness(node: Node<'_>, name: &str, geometry: &Geometry) {
    let no_area = match geometry {
        Geometry::Mesh(mesh) => {
            (0..mesh.triangles.len()).all(|k| mesh.area_vector(k) == Vec3::ZERO)
        }
        Geometry::Disk { du, dv, .. } => du.cross(*dv) == Vec3::ZERO,
        Geometry::Sphere { .. } | Geometry::Cylinder { .. } => false, // refused before
    };
    if no_area {
        node.warn(format!("the shape `{name}` has no area: nothing of it is seen"));
        return;
    }
    // A rectangle or disk is flat anyway.
    let solid = !["rectangle", "disk"].contains(&node.plugin());
    if solid && !node.transform("to_world").inverse().is_finite() {
        let message = format!("the shape `{name}` is flattened: its `to_world` cannot be inverted");
        node.report.warn(node.span_of("to_world"), message);
    }
}

impl Builder<'_> {
    /// A shape with its material, emission and media; `None` after a reported problem.
    pub(crate) fn shape(&mut self, node: Node<'_>) -> Option<(Shape, ShapeOrigin)> {
        if !self.built_shapes.insert(node.id) {
            node.warn("this shape is there already: a second reference to it is ignored");
            return None;
        }
        if !KNOWN.contains(&node.plugin()) {
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
        let material = self.shape_material(node);
        let emission = self.emission(node);
        let [interior, exterior] = ["interior", "exterior"]
            .map(|side| node.child_if(side, |n| n.class() == Class::Medium))
            .map(|medium| medium.and_then(|m| self.medium(m)));
        let (geometry, origin, mirrored) = self.geometry(node)?;
        let name = node.object().id.clone().unwrap_or_else(|| node.plugin().to_owned());
        note_flatness(node, &name, &geometry);
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

    /// The shape's points, how they were given, and whether the normals point the wrong way.
    fn geometry(&mut self, node: Node<'_>) -> Option<(Geometry, ShapeOrigin, bool)> {
        let to_world = node.transform("to_world");
        Some(match node.plugin() {
            "rectangle" => {
                let mesh = Geometry::Mesh(solids::rectangle(&to_world));
                (mesh, ShapeOrigin::Unit("rectangle", to_world), false)
            }
            "cube" => {
                let mesh = Geometry::Mesh(solids::cube(&to_world));
                (mesh, ShapeOrigin::Unit("cube", to_world), false)
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
            _ => {
                let (file, portable, mesh) = self.assets.take_mesh(node.id)?;
                let origin = if portable && !node.has("max_smooth_angle") {
                    ShapeOrigin::File(file, to_world)
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
        // Mitsuba 0.6 takes a shape of nothing but a medium for a mere boundary.
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
