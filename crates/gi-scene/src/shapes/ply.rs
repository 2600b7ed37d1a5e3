//! Stanford PLY: text and both binary byte orders.

use gi_core::bytes::{Reader, TOO_SHORT};
use gi_core::geometry::Mesh;
use gi_core::points::Ply;
use glam::{DVec3, Vec2};

use super::mesh_file;
use crate::budget::Claim;

use header::{Element, Format, Header, Kind, Property};

mod attributes;
mod header;

pub(crate) use attributes::attribute;

/// Most corners of a face; a larger number means a damaged file.
const MAX_CORNERS: u64 = 1 << 16;

/// Read a mesh, whose positions are relative to `origin`.
pub(crate) fn parse(
    bytes: &[u8],
    (flip, origin): (bool, DVec3),
    claim: &mut Claim<'_>,
) -> Result<Mesh, String> {
    let (header, body) = Header::parse(bytes)?;
    let mut source = Source::new(&header, body)?;
    let mut mesh = Mesh::default();
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => vertices(element, &mut source, (&mut mesh, claim), (flip, origin))?,
            "face" => faces(element, &mut source, (&mut mesh, claim))?,
            _ => skip(element, &mut source)?,
        }
    }
    Ok(mesh)
}

/// Whether a file stores positions in single precision.
pub(crate) fn is_single(bytes: &[u8]) -> bool {
    let Ok((header, _)) = Header::parse(bytes) else { return false };
    let mut vertices = header.elements.iter().filter(|e| e.name == "vertex");
    let has_float =
        |e: &Element| e.properties.iter().any(|p| p.name == "x" && matches!(p.kind, Kind::F32));
    !matches!(header.format, Format::Ascii) && vertices.any(has_float)
}

/// The number of faces that a file announces.
pub(crate) fn face_count(bytes: &[u8]) -> Option<u64> {
    let (header, _) = Header::parse(bytes).ok()?;
    header.elements.iter().find(|e| e.name == "face").map(|e| e.count)
}

/// A sequence of numbers.
enum Source<'a> {
    Text(std::str::SplitAsciiWhitespace<'a>, usize),
    Binary(Reader<'a>),
}

impl<'a> Source<'a> {
    fn new(header: &Header, body: &'a [u8]) -> Result<Self, String> {
        Ok(match header.format {
            Format::Ascii => {
                let text = std::str::from_utf8(body).map_err(|_| "it is not text")?;
                Source::Text(text.split_ascii_whitespace(), body.len())
            }
            Format::Little => Source::Binary(Reader::new(body)),
            Format::Big => Source::Binary(Reader::big_endian(body)),
        })
    }

    fn next(&mut self, kind: Kind) -> Result<f64, String> {
        match self {
            Source::Text(words, _) => {
                let word = words.next().ok_or(TOO_SHORT)?;
                word.parse().map_err(|_| format!("`{word}` is not a number"))
            }
            Source::Binary(bytes) => Ok(match kind {
                Kind::I8 => f64::from(bytes.i8()?),
                Kind::U8 => f64::from(bytes.u8()?),
                Kind::I16 => f64::from(bytes.i16()?),
                Kind::U16 => f64::from(bytes.u16()?),
                Kind::I32 => f64::from(bytes.i32()?),
                Kind::U32 => f64::from(bytes.u32()?),
                Kind::F32 => f64::from(bytes.f32()?),
                Kind::F64 => bytes.f64()?,
            }),
        }
    }

    /// The number of elements to allocate. Every element takes at least one byte, so a false count cannot exhaust the
    /// memory.
    fn at_most(&self, count: u64) -> Result<usize, String> {
        let left = match self {
            Source::Text(_, len) => *len,
            Source::Binary(bytes) => bytes.len(),
        };
        if count > left as u64 {
            return Err(format!("{count} elements in {left} bytes"));
        }
        Ok(count as usize)
    }

    fn list_length(&mut self, kind: Kind) -> Result<u64, String> {
        let n = self.next(kind)?;
        if !(0.0..=MAX_CORNERS as f64).contains(&n) {
            return Err(format!("a list of {n} entries"));
        }
        Ok(n as u64)
    }
}

fn vertices(
    e: &Element,
    source: &mut Source<'_>,
    (mesh, claim): (&mut Mesh, &mut Claim<'_>),
    (flip, origin): (bool, DVec3),
) -> Result<(), String> {
    let at = |names: &[&str]| {
        e.properties.iter().position(|p| names.contains(&p.name.as_str()) && p.list.is_none())
    };
    let position = [at(&["x"]), at(&["y"]), at(&["z"])];
    let normal = [at(&["nx"]), at(&["ny"]), at(&["nz"])];
    let uv = [at(&["u", "s", "texture_u", "texture_s"]), at(&["v", "t", "texture_v", "texture_t"])];
    let [Some(x), Some(y), Some(z)] = position else {
        return Err("its vertices lack x, y or z".into());
    };
    if e.properties.is_empty() {
        return Err("its vertices have no properties".into());
    }
    let count = source.at_most(e.count)?;
    claim.at_least(mesh_file::bytes(mesh) + 2 * 32 * count as u64)?; // growing vectors double
    mesh.positions.reserve(count);
    let uvs: &mut Vec<Vec2> = &mut mesh.uvs;
    let mut row = vec![0.0; e.properties.len()];
    for _ in 0..count {
        for (slot, p) in row.iter_mut().zip(&e.properties) {
            *slot = match p.list {
                None => source.next(p.kind)?,
                Some(list) => {
                    for _ in 0..source.list_length(list)? {
                        source.next(p.kind)?;
                    }
                    0.0
                }
            };
        }
        let p = DVec3::new(row[x], row[y], row[z]);
        mesh.positions.push((p - origin).as_vec3());
        if let [Some(x), Some(y), Some(z)] = normal {
            let n = DVec3::new(row[x], row[y], row[z]).as_vec3();
            mesh.normals.push(n.normalize_or_zero());
        }
        if let [Some(u), Some(v)] = uv {
            let (u, v) = (row[u] as f32, row[v] as f32);
            uvs.push(Vec2::new(u, if flip { 1.0 - v } else { v }));
        }
    }
    Ok(())
}

fn faces(
    e: &Element,
    source: &mut Source<'_>,
    (mesh, claim): (&mut Mesh, &mut Claim<'_>),
) -> Result<(), String> {
    let vertices = mesh_file::bytes(mesh);
    let triangles: &mut Vec<[u32; 3]> = &mut mesh.triangles;
    if !e.properties.iter().any(is_corners) {
        return Err("its faces lack `vertex_indices`".into());
    }
    for _ in 0..source.at_most(e.count)? {
        for p in &e.properties {
            let Some(list) = p.list else {
                source.next(p.kind)?;
                continue;
            };
            let n = source.list_length(list)?;
            claim.at_least(vertices + 24 * (triangles.len() as u64 + n))?; // it may double
            if !is_corners(p) {
                for _ in 0..n {
                    source.next(p.kind)?;
                }
                continue;
            }
            let mut fan = [0u32; 2];
            for j in 0..n {
                let index = source.next(p.kind)?;
                if !(0.0..=f64::from(u32::MAX)).contains(&index) {
                    return Err(format!("a face names vertex {index}"));
                }
                let index = index as u32;
                if j >= 2 {
                    triangles.push([fan[0], fan[1], index]);
                }
                fan[usize::from(j > 0)] = index;
            }
        }
    }
    Ok(())
}

/// Whether a property of a face lists its corners.
fn is_corners(p: &Property) -> bool {
    ["vertex_indices", "vertex_index"].contains(&p.name.as_str()) && p.list.is_some()
}

fn skip(e: &Element, source: &mut Source<'_>) -> Result<(), String> {
    if e.properties.is_empty() {
        return Ok(()); // elements without properties take no bytes
    }
    for _ in 0..source.at_most(e.count)? {
        for p in &e.properties {
            let n = p.list.map_or(Ok(1), |list| source.list_length(list))?;
            for _ in 0..n {
                source.next(p.kind)?;
            }
        }
    }
    Ok(())
}

/// Write a mesh as little-endian PLY.
pub(crate) fn write(mesh: &Mesh) -> Vec<u8> {
    let mut properties = vec!["float x", "float y", "float z"];
    if !mesh.normals.is_empty() {
        properties.extend(["float nx", "float ny", "float nz"]);
    }
    if !mesh.uvs.is_empty() {
        properties.extend(["float u", "float v"]);
    }
    let mut ply = Ply::default();
    ply.element("vertex", mesh.positions.len(), &properties);
    ply.element("face", mesh.triangles.len(), &["list uchar int vertex_indices"]);
    for (i, p) in mesh.positions.iter().enumerate() {
        ply.body.vec3(*p);
        if let Some(n) = mesh.normals.get(i) {
            ply.body.vec3(*n);
        }
        if let Some(uv) = mesh.uvs.get(i) {
            ply.body.f32s(&uv.to_array());
        }
    }
    for t in mesh.triangles.iter() {
        ply.body.u8(3);
        t.iter().for_each(|i| ply.body.u32(*i));
    }
    ply.into_bytes()
}

#[cfg(test)]
mod tests;
