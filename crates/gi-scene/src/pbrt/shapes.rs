//! Shapes, and what they get from the graphics state.

use std::rc::Rc;

use glam::{DAffine3, DVec3};

use super::Translator;
use super::meshes::{Corners, ProfilePoint, revolve};
use super::params::Params;
use super::textures::Factor;
use super::types::Text;
use crate::diagnostics::Span;
use crate::document::{Class, ObjectId, Value};

/// The supported shapes.
const KNOWN: [&str; 7] =
    ["sphere", "cylinder", "disk", "trianglemesh", "plymesh", "bilinearmesh", "loopsubdiv"];
/// Shapes that are left out.
const SKIPPED: [&str; 6] = ["curve", "cone", "paraboloid", "hyperboloid", "heightfield", "nurbs"];
/// Rows of triangles from pole to pole of a sphere that becomes a mesh.
const ROWS: usize = 64;

impl Translator<'_> {
    /// `Shape`.
    pub(super) fn shape(&mut self, params: &Params) {
        if SKIPPED.contains(&params.plugin.as_str()) {
            let message = format!("shape `{}` is not supported: it is left out", params.plugin);
            return self.report.warn(params.span, message);
        }
        let Some((shape, local)) = self.geometry(params) else { return };
        let span = params.span;
        let to_world = Value::transform(self.state.now.ctm * local);
        self.doc.set(shape, "to_world", span, to_world);
        if self.state.now.reverse_orientation {
            self.doc.set(shape, "flip_normals", span, Value::Bool(true));
        }
        params.ignore(&["shadowalpha"]);
        let material = self.masked_material(params);
        self.doc.refer(shape, "", span, &material);
        self.attach_area_light(shape, params);
        self.attach_media(shape, params);
        params.report_unused(self.report);
        self.doc.nest(self.group.unwrap_or(self.scene), "", shape);
    }

    /// The shape's geometry and its place in the current coordinates; `None` after an error.
    fn geometry(&mut self, params: &Params) -> Option<(ObjectId, DAffine3)> {
        let shape = match params.plugin.as_str() {
            "sphere" => self.sphere(params),
            "cylinder" => self.cylinder(params),
            "disk" => return self.disk(params),
            "trianglemesh" | "loopsubdiv" => self.triangle_mesh(params),
            "bilinearmesh" => self.bilinear_mesh(params),
            "plymesh" => self.ply_mesh(params),
            _ => {
                params.unknown_plugin(&KNOWN, self.report);
                None
            }
        };
        Some((shape?, DAffine3::IDENTITY))
    }

    fn new_shape(&mut self, params: &Params, plugin: &str) -> ObjectId {
        self.doc.add(Class::Shape, "shape", plugin, params.span)
    }

    /// A surface of revolution as a mesh.
    fn turned(&mut self, params: &Params, profile: &[ProfilePoint], degrees: f64) -> ObjectId {
        let shape = self.new_shape(params, "trianglemesh");
        let (corners, triangles) = revolve(profile, degrees.to_radians());
        self.inline_mesh(shape, params, corners, triangles);
        shape
    }

    /// Whether the current material has textures, which need pbrt's coordinates.
    fn has_textures(&self, params: &Params) -> bool {
        let material = self.state.now.material.as_ref();
        let light = self.state.now.area_light.as_ref();
        material.is_some_and(|key| self.textured.contains(key))
            || params.texture("alpha").is_some()
            || light.is_some_and(|light| light.has_picture())
    }

    /// A positive length; 1 if it is not given. `None` after an error.
    fn radius(&self, params: &Params) -> Option<f64> {
        let radius = params.number("radius", self.report).unwrap_or(1.0);
        if radius > 1e-12 {
            return Some(radius);
        }
        let span = params.span_of("radius");
        self.report.error(span, format!("radius {radius}"), "expected more than 0");
        None
    }

    fn sphere(&mut self, params: &Params) -> Option<ObjectId> {
        let radius = self.radius(params)?;
        let degrees = params.within("phimax", 360.0, [0.0, 360.0], self.report);
        let end = |name, default| params.number(name, self.report).unwrap_or(default);
        let (low, high) = (end("zmin", -radius), end("zmax", radius));
        let [low, high] = [low.min(high), low.max(high)].map(|z| (z / radius).clamp(-1.0, 1.0));
        if degrees == 360.0 && [low, high] == [-1.0, 1.0] && !self.has_textures(params) {
            let shape = self.new_shape(params, "sphere");
            let value = Value::Float(radius as f32);
            self.doc.set(shape, "radius", params.span_of("radius"), value);
            return Some(shape);
        }
        let (from, to) = (low.acos(), high.acos());
        let profile: Vec<ProfilePoint> = (0..=ROWS)
            .map(|row| {
                let theta = from + (to - from) * row as f64 / ROWS as f64;
                let pole = (row == 0 && low == -1.0) || (row == ROWS && high == 1.0);
                let sin = if pole { 0.0 } else { theta.sin() };
                let cos = theta.cos();
                ProfilePoint { radius: radius * sin, z: radius * cos, normal: [sin, cos] }
            })
            .collect();
        Some(self.turned(params, &profile, degrees))
    }

    fn cylinder(&mut self, params: &Params) -> Option<ObjectId> {
        let radius = self.radius(params)?;
        let degrees = params.within("phimax", 360.0, [0.0, 360.0], self.report);
        let end = |name, default| params.number(name, self.report).unwrap_or(default);
        let (low, high) = (end("zmin", -1.0), end("zmax", 1.0));
        if degrees == 360.0 && !self.has_textures(params) {
            let shape = self.new_shape(params, "cylinder");
            for (name, z, at) in [("p0", low, "zmin"), ("p1", high, "zmax")] {
                let value = Value::Vector(DVec3::new(0.0, 0.0, z));
                self.doc.set(shape, name, params.span_of(at), value);
            }
            let value = Value::Float(radius as f32);
            self.doc.set(shape, "radius", params.span_of("radius"), value);
            return Some(shape);
        }
        let profile = [low, high].map(|z| ProfilePoint { radius, z, normal: [1.0, 0.0] });
        Some(self.turned(params, &profile, degrees))
    }

    /// A disk: Mitsuba's unit disk at its place, or a mesh if it has a hole.
    fn disk(&mut self, params: &Params) -> Option<(ObjectId, DAffine3)> {
        let radius = self.radius(params)?;
        let degrees = params.within("phimax", 360.0, [0.0, 360.0], self.report);
        let inner = params.within("innerradius", 0.0, [0.0, radius], self.report);
        let z = params.number("height", self.report).unwrap_or(0.0);
        if degrees == 360.0 && inner == 0.0 && !self.has_textures(params) {
            let place = DAffine3::from_translation(DVec3::Z * z);
            let size = DAffine3::from_scale(DVec3::new(radius, radius, 1.0));
            return Some((self.new_shape(params, "disk"), place * size));
        }
        let profile = [radius, inner].map(|radius| ProfilePoint { radius, z, normal: [0.0, 1.0] });
        Some((self.turned(params, &profile, degrees), DAffine3::IDENTITY))
    }

    fn triangle_mesh(&mut self, params: &Params) -> Option<ObjectId> {
        let corners = self.corners(params)?;
        let indices = self.indices(params, 3, corners.positions.len(), &[0, 1, 2])?;
        let triangles: Vec<_> = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        let shape = self.new_shape(params, "trianglemesh");
        let is_subdivision = params.plugin == "loopsubdiv";
        self.inline_mesh(shape, params, corners, triangles);
        if is_subdivision {
            params.ignore(&["levels", "nlevels", "scheme"]);
            let message =
                "shape `loopsubdiv` is approximated by its control mesh with smooth normals";
            self.report.warn(params.span, message);
            if let Some(read) = self.doc.inline_meshes.borrow_mut().get_mut(&shape) {
                read.mesh.smooth_normals();
            }
        }
        Some(shape)
    }

    /// Bilinear patches, each as two triangles.
    fn bilinear_mesh(&mut self, params: &Params) -> Option<ObjectId> {
        let mut corners = self.corners(params)?;
        let mut indices = self.indices(params, 4, corners.positions.len(), &[0, 1, 2, 3])?;
        params.note_ignored(&["emissionfilename"], "patches emit evenly", self.report);
        // Without coordinates, each patch covers the unit square.
        if corners.uvs.is_empty() {
            corners = spread(&corners, &indices);
            indices = (0..indices.len() as u32).collect();
        }
        let halves = |q: &[u32]| [[q[0], q[1], q[3]], [q[0], q[3], q[2]]];
        let triangles = indices.chunks_exact(4).flat_map(halves).collect();
        if indices.chunks_exact(4).any(|q| !is_flat(q, &corners.positions)) {
            self.report.warn(params.span, "curved bilinear patches are approximated by triangles");
        }
        let shape = self.new_shape(params, "trianglemesh");
        self.inline_mesh(shape, params, corners, triangles);
        Some(shape)
    }

    fn ply_mesh(&mut self, params: &Params) -> Option<ObjectId> {
        let Some(file) = params.text("filename") else {
            self.report.error(params.span, "`plymesh` without a `filename`", "");
            return None;
        };
        let shape = self.new_shape(params, "ply");
        self.doc.set(shape, "filename", file.span, Value::Text(file.text.clone()));
        params.note_ignored(&["displacement"], "the mesh is not displaced", self.report);
        params.ignore(&["edgelength"]);
        Some(shape)
    }

    /// The id of the current material, with a mask around it if the shape has an `alpha`.
    fn masked_material(&mut self, params: &Params) -> Rc<str> {
        let inner = match self.state.now.material.clone() {
            Some(key) => key,
            None => self.default_material(params.span),
        };
        let alpha = self.scalar(params, "alpha");
        let name = match &alpha {
            None => return inner,
            Some(Factor::Constant(c)) if c.r >= 1.0 => return inner,
            Some(Factor::Constant(c)) => format!("number {}", c.r),
            Some(Factor::Texture(text, _)) => format!("texture {}", text.text),
        };
        let key: Rc<str> = format!("mask {name} of {inner}").into();
        if !self.doc.knows(&key) {
            let mask = self.doc.add(Class::Bsdf, "alpha", "mask", params.span);
            let alpha = alpha.unwrap_or(Factor::grey(1.0));
            self.set_factor(mask, "opacity", &alpha, params.span_of("alpha"));
            self.doc.refer(mask, "", params.span, &inner);
            self.doc.register(mask, &key, None);
            self.doc.nest(self.scene, "", mask);
        }
        key
    }

    /// The material of shapes before the first `Material`: grey.
    fn default_material(&mut self, span: Span) -> Rc<str> {
        let key: Rc<str> = "default material".into();
        if !self.doc.knows(&key) {
            let diffuse = self.doc.add(Class::Bsdf, "material", "diffuse", span);
            let outer = self.doc.add(Class::Bsdf, "material", "twosided", span);
            self.doc.nest(outer, "", diffuse);
            self.doc.register(outer, &key, None);
            self.doc.nest(self.scene, "", outer);
        }
        key
    }

    /// `ObjectBegin`: the shapes that follow make a group.
    pub(super) fn object_begin(&mut self, name: &Text, span: Span) {
        self.state.push(super::state::Opened::Object, span, self.report);
        if self.group.is_some() {
            return self.report.error(span, "`ObjectBegin` inside another one", "");
        }
        if self.groups.contains_key(&name.text) && !self.is_v3 {
            let message = format!("an object named `{}` exists already", name.text);
            self.report.error(name.span, message, "");
        }
        let group = self.doc.add(Class::Shape, "ObjectBegin", "shapegroup", name.span);
        self.groups.insert(name.text.clone(), group);
        self.group = Some(group);
    }

    /// `ObjectEnd`.
    pub(super) fn object_end(&mut self, span: Span) {
        if self.state.pop(super::state::Opened::Object, self.is_v3, span, self.report) {
            self.group = None;
        }
    }

    /// `ObjectInstance`: a group at the current place.
    pub(super) fn object_instance(&mut self, name: &Text) {
        if self.group.is_some() {
            let message = "`ObjectInstance` inside `ObjectBegin`";
            return self.report.error(name.span, message, "expected shapes");
        }
        let Some(&group) = self.groups.get(&name.text) else {
            let help = self.report.suggestion(&name.text, self.groups.keys().map(String::as_str));
            let message = format!("no object is named `{}`", name.text);
            return self.report.error_help(name.span, message, "referred to here", help);
        };
        // All that it contained was left out.
        if !self.doc.has_children(group) {
            return;
        }
        let key = format!("group {group}");
        if !self.doc.knows(&key) {
            self.doc.register(group, &key, Some(&name.text));
        }
        let instance = self.doc.add(Class::Shape, "ObjectInstance", "instance", name.span);
        let to_world = Value::transform(self.state.now.ctm);
        self.doc.set(instance, "to_world", name.span, to_world);
        self.doc.refer(instance, "", name.span, &key);
        self.doc.nest(self.scene, "", instance);
    }
}

/// The corners of each patch of its own, with the unit square as texture coordinates.
fn spread(corners: &Corners, indices: &[u32]) -> Corners {
    let square = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
    Corners {
        positions: indices.iter().map(|&i| corners.positions[i as usize]).collect(),
        normals: match corners.normals.is_empty() {
            true => Vec::new(),
            false => indices.iter().map(|&i| corners.normals[i as usize]).collect(),
        },
        uvs: (0..indices.len()).map(|k| square[k % 4].into()).collect(),
    }
}

/// Whether the four corners of a patch lie in a plane.
fn is_flat(patch: &[u32], positions: &[DVec3]) -> bool {
    let [a, b, c, d] = [0, 1, 2, 3].map(|k| positions[patch[k] as usize]);
    let (u, v, w) = (b - a, c - a, d - a);
    u.cross(v).dot(w).abs() <= 1e-4 * u.length() * v.length() * w.length()
}
