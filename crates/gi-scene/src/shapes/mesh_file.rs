//! Mesh files, and how shapes use them.

use std::path::PathBuf;

use gi_core::geometry::Mesh;
use gi_core::guard::guarded;
use glam::{DAffine3, DVec3, Vec3};

use super::place::place;
use super::{obj, ply, serialized, smooth};
use crate::budget::Claim;
use crate::document::Node;
use crate::local::Extent;
use crate::precision;
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
    /// Not a file: the scene file itself contains the mesh.
    Inline,
}

/// The contents of a mesh file.
#[derive(Clone, Debug)]
pub(crate) struct ReadMesh {
    pub(crate) mesh: Mesh,
    /// Whether Mitsuba 3 reads the same mesh from this file.
    pub(crate) portable: bool,
    /// A note about what was ignored.
    pub(crate) note: Option<String>,
    /// The positions are relative to this point. It is not zero only if the mesh is far from the origin.
    pub(crate) origin: DVec3,
    /// How much the file rounds its positions, if it stores them in single precision; otherwise 0.
    pub(crate) rounding: f32,
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
        let mut read = guarded(|| self.decode(bytes, DVec3::ZERO, &mut claim))?;
        check(&read.mesh)?;
        let farthest = read.mesh.positions.iter().map(|p| p.abs().max_element());
        let rounding = farthest.fold(0.0, f32::max) * precision::ROUNDING;
        let origin = extent(&read).map_or(DVec3::ZERO, |extent| extent.origin());
        if origin != DVec3::ZERO {
            // Again, with all digits that the file has.
            drop(read);
            read = guarded(|| self.decode(bytes, origin, &mut claim))?;
            check(&read.mesh)?;
        }
        read.rounding = if self.is_single(bytes) { rounding } else { 0.0 };
        claim.keep(self::bytes(&read.mesh))?;
        Ok(read)
    }

    /// Whether the file stores positions in single precision. Text has as many digits as its author gave.
    fn is_single(&self, bytes: &[u8]) -> bool {
        match self.kind {
            MeshKind::Obj { .. } | MeshKind::Inline => false,
            MeshKind::Ply { .. } => ply::is_single(bytes),
            MeshKind::Serialized { index } => serialized::is_single(bytes, index),
        }
    }

    fn decode(
        &self,
        bytes: &[u8],
        origin: DVec3,
        claim: &mut Claim<'_>,
    ) -> Result<ReadMesh, String> {
        let all = |mesh, portable, note| ReadMesh { mesh, portable, note, origin, rounding: 0.0 };
        Ok(match self.kind {
            MeshKind::Obj { flip } => {
                let mut contents = obj::parse(bytes, (flip, origin), claim)?;
                let note = contents.note(&self.path.display().to_string());
                let (_, mesh) = contents.meshes.pop().ok_or("it contains no faces")?;
                all(mesh, contents.portable, note)
            }
            MeshKind::Ply { flip } => {
                let mesh = ply::parse(bytes, (flip, origin), claim)?;
                // Mitsuba 3 reads triangles only.
                let portable = ply::face_count(bytes) == Some(mesh.triangles.len() as u64);
                all(mesh, portable, None)
            }
            MeshKind::Serialized { index } => {
                all(serialized::parse(bytes, (index, origin), claim)?, false, None)
            }
            MeshKind::Inline => return Err("it is not a file".into()),
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

/// The box around a mesh, in the coordinates of its file.
pub(crate) fn extent(read: &ReadMesh) -> Option<Extent> {
    let bounds = read.mesh.bounds();
    let ends = [bounds.min, bounds.max].map(|p| p.as_dvec3() + read.origin);
    Extent::of(ends).filter(|_| !bounds.is_empty())
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
    pub(crate) to_world: DAffine3,
    face_normals: bool,
    max_smooth_angle: Option<f32>,
    /// Whether a mesh without normals stays faceted and keeps its sides even if it is mirrored, as in pbrt. Otherwise it
    /// gets smooth normals, and a mirrored mesh turns its sides, as in Mitsuba.
    faceted: bool,
}

impl Placement {
    /// The placement, from a shape's properties.
    pub(crate) fn of(node: Node<'_>) -> Placement {
        Placement {
            to_world: node.to_world(),
            face_normals: node.bool("face_normals", false),
            max_smooth_angle: node.float_opt("max_smooth_angle"),
            faceted: node.doc.is_pbrt,
        }
    }

    /// Largest factor by which lengths grow.
    pub(crate) fn scale(&self) -> f32 {
        let m = self.to_world.matrix3;
        [m.x_axis, m.y_axis, m.z_axis]
            .map(|axis| axis.length() as f32)
            .into_iter()
            .fold(0.0, f32::max)
    }

    /// Transform the mesh. As in Mitsuba, a mesh without normals gets smooth ones unless face normals are requested.
    /// Returns the number of invalid normals that were replaced. The claim keeps the memory of what this shape no longer
    /// shares with others.
    pub(crate) fn apply(&self, read: &mut ReadMesh, mut claim: Claim<'_>) -> Result<usize, String> {
        let mesh = &mut read.mesh;
        if self.face_normals || !self.to_world.as_affine3a().inverse().is_finite() {
            mesh.normals.clear();
        }
        let replaced = smooth::replace_bad_normals(mesh);
        place(mesh, &self.to_world, read.origin);
        if self.face_normals {
            return Ok(replaced);
        }
        match self.max_smooth_angle {
            Some(degrees) => {
                claim.set(mesh.triangles.len() as u64 * smooth::BYTES)?;
                smooth::smooth_up_to(mesh, degrees.to_radians());
                claim.keep(bytes(mesh))?;
            }
            None if mesh.normals.is_empty() && self.faceted => {
                if self.to_world.matrix3.determinant() < 0.0 {
                    if mesh.triangles.is_shared() {
                        claim.keep(triangle_bytes(mesh))?;
                    }
                    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
                }
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
