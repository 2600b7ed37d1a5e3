//! Mesh files, and how shapes use them.

use std::path::PathBuf;

use gi_core::geometry::Mesh;
use gi_core::guard::guarded;
use glam::{Affine3A, Vec3};

use super::{obj, ply, serialized, smooth};
use crate::budget::Claim;
use crate::document::Node;
use crate::value::check_size;

/// A mesh file and its reading options: files with equal keys are read once.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct MeshFile {
    pub(crate) path: PathBuf,
    pub(crate) kind: MeshKind,
}

/// The format of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum MeshKind {
    /// Wavefront. With `flip`, v = 0 is the bottom of the picture, as is usual for OBJ.
    Obj { flip: bool },
    /// Stanford.
    Ply { flip: bool },
    /// Mitsuba's own format; one file contains several meshes.
    Serialized { index: usize },
}

/// The contents of a mesh file.
#[derive(Clone, Debug)]
pub(crate) struct ReadMesh {
    pub(crate) mesh: Mesh,
    /// Whether Mitsuba 3 reads the same mesh from this file.
    pub(crate) portable: bool,
    /// A note about what was ignored.
    pub(crate) note: Option<String>,
}

impl MeshFile {
    /// The plugins that read mesh files.
    pub(crate) const KINDS: [&'static str; 3] = ["obj", "ply", "serialized"];

    /// The file and its options, from a shape's properties.
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

    /// Read the mesh. Its vertices are finite and its indices in range. The claim keeps the memory of the mesh.
    pub(crate) fn parse(&self, bytes: &[u8], mut claim: Claim<'_>) -> Result<ReadMesh, String> {
        let read = guarded(|| self.decode(bytes, &mut claim))?;
        check(&read.mesh)?;
        claim.keep(self::bytes(&read.mesh))?;
        Ok(read)
    }

    fn decode(&self, bytes: &[u8], claim: &mut Claim<'_>) -> Result<ReadMesh, String> {
        let plain = |mesh, portable| ReadMesh { mesh, portable, note: None };
        Ok(match self.kind {
            MeshKind::Obj { flip } => {
                let mut contents = obj::parse(bytes, flip, claim)?;
                let note = contents.note(&self.path.display().to_string());
                let (_, mesh) = contents.meshes.pop().ok_or("it contains no faces")?;
                ReadMesh { mesh, portable: contents.portable, note }
            }
            MeshKind::Ply { flip } => plain(ply::parse(bytes, flip, claim)?, true),
            MeshKind::Serialized { index } => plain(serialized::parse(bytes, index, claim)?, false),
        })
    }
}

/// The memory that a mesh takes, with the normals that it may get.
pub(crate) fn bytes(mesh: &Mesh) -> u64 {
    own_bytes(mesh) + size_of_val(&mesh.uvs[..]) as u64 + triangle_bytes(mesh)
}

/// The part of this memory that another shape with the same mesh does not share: its positions and normals.
pub(crate) fn own_bytes(mesh: &Mesh) -> u64 {
    (mesh.positions.len() * 2 * size_of::<Vec3>()) as u64
}

fn triangle_bytes(mesh: &Mesh) -> u64 {
    size_of_val(&mesh.triangles[..]) as u64
}

/// Check what must be true of every mesh, in any format.
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
        return Err("it contains no faces".into());
    }
    Ok(())
}

/// How a shape transforms its mesh and makes the normals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    pub(crate) to_world: Affine3A,
    face_normals: bool,
    max_smooth_angle: Option<f32>,
}

impl Placement {
    /// The placement, from a shape's properties.
    pub(crate) fn of(node: Node<'_>) -> Placement {
        Placement {
            to_world: node.transform("to_world"),
            face_normals: node.bool("face_normals", false),
            max_smooth_angle: node.float_opt("max_smooth_angle"),
        }
    }

    /// Transform the mesh. As in Mitsuba, a mesh without normals gets smooth ones unless face normals are requested.
    /// Returns the number of invalid normals that were replaced. The claim keeps the memory of what this shape no longer
    /// shares with others.
    pub(crate) fn apply(&self, mesh: &mut Mesh, mut claim: Claim<'_>) -> Result<usize, String> {
        if self.face_normals || !self.to_world.inverse().is_finite() {
            mesh.normals.clear();
        }
        let replaced = smooth::replace_bad_normals(mesh);
        mesh.transform(&self.to_world);
        if self.face_normals {
            return Ok(replaced);
        }
        match self.max_smooth_angle {
            Some(degrees) => {
                claim.set(mesh.triangles.len() as u64 * smooth::BYTES)?;
                smooth::smooth_up_to(mesh, degrees.to_radians());
                claim.keep(bytes(mesh))?;
            }
            None if mesh.normals.is_empty() => mesh.smooth_normals(),
            None if smooth::face_their_normals(mesh) => {}
            None => {
                if mesh.triangles.is_shared() {
                    claim.keep(triangle_bytes(mesh))?;
                }
                smooth::face_the_normals(mesh);
            }
        }
        Ok(replaced)
    }
}
