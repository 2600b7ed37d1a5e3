//! Textures that read an attribute of a mesh, such as the colours of its vertices.
//!
//! A texture is a function of texture coordinates, so the attribute becomes a picture: each triangle gets two by two
//! texels of its own, between which the bilinear lookup is exactly the linear interpolation over the triangle. The mesh
//! gets texture coordinates that lead there.

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

use gi_core::geometry::Mesh;
use gi_core::guard::guarded;
use gi_core::math::Rgb;
use gi_core::texture::{Bitmap, Lookup, Texels, Texture, Wrap};
use glam::{Affine2, Vec2};

use crate::builder::Builder;
use crate::document::{Class, Node, ObjectId};
use crate::files;
use crate::shapes::ply;

/// The name of the plugin.
const PLUGIN: &str = "mesh_attribute";
/// Largest depth of the search for the plugin below a shape.
const MAX_DEPTH: usize = 64;

/// The shape under construction, if textures of it read attributes of its mesh.
#[derive(Debug)]
pub(crate) struct AttributeSource {
    /// Its mesh file; `None` if its kind has no attributes.
    file: Option<PathBuf>,
}

impl Builder<'_> {
    /// Prepare for the textures of a shape: whether any of them reads an attribute of its mesh.
    pub(crate) fn enter_shape(&mut self, node: Node<'_>) {
        self.attributes = None;
        let (mut seen, mut textures) = (HashSet::new(), Vec::new());
        textures_below(node, 0, &mut seen, &mut textures);
        let Some(first) = textures.iter().find(|t| t.plugin() == PLUGIN) else { return };
        let file = match node.plugin() {
            "ply" => self.assets.mesh_path(node.id),
            _ => None,
        };
        if node.plugin() != "ply" {
            let message = format!("`{PLUGIN}` on a shape `{}`", node.plugin());
            first.error(message, "expected a shape `ply`: other shapes have no attributes here");
        }
        let needs_uv =
            |t: &&Node<'_>| ["bitmap", "checkerboard", "gridtexture"].contains(&t.plugin());
        if let Some(picture) = textures.iter().find(needs_uv) {
            let message = format!("`{}` beside `{PLUGIN}` on one shape", picture.plugin());
            picture.error(message, "not supported: put both into one picture");
        }
        self.attributes = Some(AttributeSource { file });
    }

    /// The texture of a `mesh_attribute`; `None` if an error was reported.
    pub(crate) fn attribute_texture(&mut self, node: Node<'_>) -> Option<Texture> {
        let scale = Rgb::grey(node.float("scale", 1.0));
        let Some(name) = node.text("name") else {
            node.error(format!("`{PLUGIN}` without a `name`"), "such as `vertex_color`");
            return None;
        };
        // Materials of the scene are built once without a shape, for their errors.
        let Some(source) = &self.attributes else { return Some(Texture::grey(0.5)) };
        let path = source.file.clone()?;
        let read = || {
            let mut claim = node.report.budget.claim(path.display());
            let bytes = files::read_bytes(&path, &mut claim)?;
            let mut own = node.report.budget.claim(path.display());
            let corners = guarded(|| ply::attribute(&bytes, name, &mut own))?;
            // Its texels, and three vertices of its own per triangle.
            own.keep((corners.len() * (4 * size_of::<Rgb>() + 3 * 36)) as u64)?;
            finite(&corners)?;
            Ok::<_, String>(corners)
        };
        match read() {
            Ok(corners) => {
                let picture = Arc::new(atlas(&corners));
                self.origins.note_range(&picture, range(&corners));
                Some(Texture::Bitmap { bitmap: picture, to_uv: Affine2::IDENTITY, scale })
            }
            Err(why) => {
                node.error(format!("attribute `{name}` of `{}`: {why}", path.display()), "");
                None
            }
        }
    }
}

/// All textures of an object and of what it contains or refers to.
fn textures_below<'a>(
    node: Node<'a>,
    depth: usize,
    seen: &mut HashSet<ObjectId>,
    out: &mut Vec<Node<'a>>,
) {
    for child in node.all_children() {
        if child.class() == Class::Shape || depth > MAX_DEPTH || !seen.insert(child.id) {
            continue;
        }
        if child.class() == Class::Texture {
            out.push(child);
        }
        textures_below(child, depth + 1, seen, out);
    }
}

fn finite(corners: &[[Rgb; 3]]) -> Result<(), String> {
    let bad = |c: &Rgb| !c.to_array().iter().all(|v| v.abs() <= crate::value::MAX_NUMBER);
    match corners.iter().position(|t| t.iter().any(bad)) {
        Some(k) => Err(format!("triangle {k} has a value that is not finite or above 1e15")),
        None => Ok(()),
    }
}

/// The smallest and the largest value. (The fourth texel of a triangle may be beyond, but no point of it is.)
fn range(corners: &[[Rgb; 3]]) -> [f32; 2] {
    let all = corners.iter().flatten().flat_map(|c| c.to_array());
    all.fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)])
}

/// Number of triangles in a row of the picture.
fn columns(triangles: usize) -> usize {
    (triangles as f64).sqrt().ceil().max(1.0) as usize
}

/// The picture of an attribute: two by two texels per triangle.
fn atlas(corners: &[[Rgb; 3]]) -> Bitmap {
    let columns = columns(corners.len());
    let rows = corners.len().div_ceil(columns).max(1);
    let [w, h] = [2 * columns, 2 * rows];
    let mut texels = vec![Rgb::BLACK; w * h];
    for (k, &[a, b, c]) in corners.iter().enumerate() {
        let at = 2 * (k / columns) * w + 2 * (k % columns);
        [texels[at], texels[at + 1], texels[at + w]] = [a, b, c];
        texels[at + w + 1] = b + c - a;
    }
    Bitmap::new(w, h, Texels::Float(texels), Wrap::Clamp, Lookup::Bilinear)
}

/// Give each triangle vertices of its own, with texture coordinates at the centres of its texels.
pub(crate) fn unfold(mesh: &mut Mesh) {
    let columns = columns(mesh.triangles.len());
    let rows = mesh.triangles.len().div_ceil(columns).max(1);
    let texel = Vec2::new(1.0 / (2 * columns) as f32, 1.0 / (2 * rows) as f32);
    let at = |k: usize, x: f32, y: f32| {
        let first = Vec2::new((2 * (k % columns)) as f32, (2 * (k / columns)) as f32);
        (first + Vec2::new(x + 0.5, y + 0.5)) * texel
    };
    let corners = || mesh.triangles.iter().flatten().map(|i| *i as usize);
    let positions = corners().map(|i| mesh.positions[i]).collect();
    let normals = if mesh.normals.is_empty() {
        Vec::new()
    } else {
        corners().map(|i| mesh.normals[i]).collect()
    };
    let count = mesh.triangles.len();
    let uvs =
        (0..count).flat_map(|k| [at(k, 0.0, 0.0), at(k, 1.0, 0.0), at(k, 0.0, 1.0)]).collect();
    let triangles = (0..count as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    *mesh = Mesh { positions, normals, uvs, triangles };
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_picture_interpolates_each_triangle_linearly() {
        let colors = |k: usize| {
            let k = k as f32;
            [Rgb::new(k, 0.0, 1.0), Rgb::new(0.5, k, 2.0), Rgb::new(0.1 * k, 3.0, 0.0)]
        };
        let corners: Vec<_> = (0..7).map(colors).collect();
        let picture = atlas(&corners);
        let mut mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]; 7].into(),
            ..Mesh::default()
        };
        unfold(&mut mesh);
        assert_eq!(mesh.positions.len(), 21);
        for (k, want) in corners.iter().enumerate() {
            for [b, c] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.3, 0.6], [0.2, 0.1]] {
                let uv = mesh.triangles[k].map(|i| mesh.uvs[i as usize]);
                let got = picture.eval(uv[0] * (1.0 - b - c) + uv[1] * b + uv[2] * c);
                let exact = want[0] * (1.0 - b - c) + want[1] * b + want[2] * c;
                let error = (got - exact).to_array().map(f32::abs).into_iter().fold(0.0, f32::max);
                assert!(error < 1e-4, "triangle {k}: {got:?} is not {exact:?}");
            }
        }
    }
}
