//! Stanford PLY: text and both binary byte orders.

use gi_core::geometry::Mesh;
use glam::{Vec2, Vec3};

use crate::bytes::{Bytes, TRUNCATED};

/// Largest header, bytes.
const MAX_HEADER: usize = 1 << 16;
/// Most corners of a face; a larger number means a damaged file.
const MAX_CORNERS: u64 = 1 << 16;

/// Read a mesh.
pub(crate) fn parse(bytes: &[u8], flip: bool) -> Result<Mesh, String> {
    let (header, body) = Header::parse(bytes)?;
    let mut source = Source::new(&header, body)?;
    let mut mesh = Mesh::default();
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => vertices(element, &mut source, &mut mesh, flip)?,
            "face" => faces(element, &mut source, &mut mesh)?,
            _ => skip(element, &mut source)?,
        }
    }
    Ok(mesh)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn parse(name: &str) -> Result<Kind, String> {
        Ok(match name {
            "char" | "int8" => Kind::I8,
            "uchar" | "uint8" => Kind::U8,
            "short" | "int16" => Kind::I16,
            "ushort" | "uint16" => Kind::U16,
            "int" | "int32" => Kind::I32,
            "uint" | "uint32" => Kind::U32,
            "float" | "float32" => Kind::F32,
            "double" | "float64" => Kind::F64,
            other => return Err(format!("unknown type `{other}`")),
        })
    }
}

#[derive(Debug)]
struct Property {
    name: String,
    kind: Kind,
    /// The type of the list's length, if this is a list.
    list: Option<Kind>,
}

#[derive(Debug)]
struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Ascii,
    Little,
    Big,
}

#[derive(Debug)]
struct Header {
    format: Format,
    elements: Vec<Element>,
}

impl Header {
    fn parse(bytes: &[u8]) -> Result<(Header, &[u8]), String> {
        let mut rest = bytes;
        let mut line = || -> Result<Vec<String>, String> {
            let window = &rest[..rest.len().min(MAX_HEADER)];
            let end =
                window.iter().position(|&b| b == b'\n').ok_or("the header is not terminated")?;
            let text = String::from_utf8_lossy(&rest[..end]).into_owned();
            rest = &rest[end + 1..];
            Ok(text.split_whitespace().map(str::to_owned).collect())
        };
        if line()? != ["ply"] {
            return Err("it does not start with `ply`".into());
        }
        let mut format = None;
        let mut elements: Vec<Element> = Vec::new();
        loop {
            let words = line()?;
            match words.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
                ["format", "ascii", _] => format = Some(Format::Ascii),
                ["format", "binary_little_endian", _] => format = Some(Format::Little),
                ["format", "binary_big_endian", _] => format = Some(Format::Big),
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| format!("`{count}` is not a count"))?;
                    elements.push(Element {
                        name: (*name).to_owned(),
                        count,
                        properties: Vec::new(),
                    });
                }
                ["property", "list", count, kind, name] => {
                    let list = Some(Kind::parse(count)?);
                    let element = elements.last_mut().ok_or("a property before any element")?;
                    let (name, kind) = ((*name).to_owned(), Kind::parse(kind)?);
                    element.properties.push(Property { name, kind, list });
                }
                ["property", kind, name] => {
                    let element = elements.last_mut().ok_or("a property before any element")?;
                    let (name, kind) = ((*name).to_owned(), Kind::parse(kind)?);
                    element.properties.push(Property { name, kind, list: None });
                }
                ["end_header"] => break,
                ["comment" | "obj_info", ..] | [] => {}
                other => return Err(format!("the header says `{}`", other.join(" "))),
            }
        }
        Ok((Header { format: format.ok_or("the header names no format")?, elements }, rest))
    }
}

/// A sequence of numbers.
enum Source<'a> {
    Text(std::str::SplitAsciiWhitespace<'a>, usize),
    Binary(Bytes<'a>),
}

impl<'a> Source<'a> {
    fn new(header: &Header, body: &'a [u8]) -> Result<Self, String> {
        Ok(match header.format {
            Format::Ascii => {
                let text = std::str::from_utf8(body).map_err(|_| "it is not text")?;
                Source::Text(text.split_ascii_whitespace(), body.len())
            }
            format => Source::Binary(Bytes::new(body, format == Format::Big)),
        })
    }

    fn next(&mut self, kind: Kind) -> Result<f64, String> {
        match self {
            Source::Text(words, _) => {
                let word = words.next().ok_or(TRUNCATED)?;
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
    mesh: &mut Mesh,
    flip: bool,
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
    mesh.positions.reserve(count);
    let mut row = vec![0.0; e.properties.len()];
    for _ in 0..count {
        for (slot, p) in row.iter_mut().zip(&e.properties) {
            *slot = match p.list {
                None => source.next(p.kind)? as f32,
                Some(list) => {
                    for _ in 0..source.list_length(list)? {
                        source.next(p.kind)?;
                    }
                    0.0
                }
            };
        }
        mesh.positions.push(Vec3::new(row[x], row[y], row[z]));
        if let [Some(x), Some(y), Some(z)] = normal {
            mesh.normals.push(Vec3::new(row[x], row[y], row[z]).normalize_or_zero());
        }
        if let [Some(u), Some(v)] = uv {
            mesh.uvs.push(Vec2::new(row[u], if flip { 1.0 - row[v] } else { row[v] }));
        }
    }
    Ok(())
}

fn faces(e: &Element, source: &mut Source<'_>, mesh: &mut Mesh) -> Result<(), String> {
    let is_corners = |p: &Property| {
        ["vertex_indices", "vertex_index"].contains(&p.name.as_str()) && p.list.is_some()
    };
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
                    mesh.triangles.push([fan[0], fan[1], index]);
                }
                fan[usize::from(j > 0)] = index;
            }
        }
    }
    Ok(())
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
    let mut header = String::from("ply\nformat binary_little_endian 1.0\n");
    header += &format!("element vertex {}\n", mesh.positions.len());
    let floats = |names: &[&str]| -> String {
        names.iter().map(|n| format!("property float {n}\n")).collect()
    };
    header += &floats(&["x", "y", "z"]);
    if !mesh.normals.is_empty() {
        header += &floats(&["nx", "ny", "nz"]);
    }
    if !mesh.uvs.is_empty() {
        header += &floats(&["u", "v"]);
    }
    header += &format!("element face {}\n", mesh.triangles.len());
    header += "property list uchar int vertex_indices\nend_header\n";
    let mut out = header.into_bytes();
    let mut put = |x: f32| out.extend(x.to_le_bytes());
    for (i, p) in mesh.positions.iter().enumerate() {
        p.to_array().into_iter().for_each(&mut put);
        if let Some(n) = mesh.normals.get(i) {
            n.to_array().into_iter().for_each(&mut put);
        }
        if let Some(uv) = mesh.uvs.get(i) {
            uv.to_array().into_iter().for_each(&mut put);
        }
    }
    for t in &mesh.triangles {
        out.push(3);
        t.iter().for_each(|i| out.extend(i.to_le_bytes()));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.5)],
            normals: vec![Vec3::Z; 4],
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE],
            triangles: vec![[0, 1, 2], [2, 1, 3]],
        }
    }

    fn same(a: &Mesh, b: &Mesh) -> bool {
        (&a.positions, &a.normals, &a.uvs, &a.triangles)
            == (&b.positions, &b.normals, &b.uvs, &b.triangles)
    }

    #[test]
    fn what_is_written_is_read_back() {
        let full = mesh();
        let bare = Mesh { normals: vec![], uvs: vec![], ..mesh() };
        for m in [full, bare] {
            assert!(same(&parse(&write(&m), false).unwrap(), &m));
        }
    }

    #[test]
    fn text_and_big_endian_files_with_other_properties_are_read_too() {
        let header = |format: &str| {
            format!(
                "ply\nformat {format} 1.0\ncomment x\nelement vertex 4\nproperty double x\n\
                 property double y\nproperty uchar red\nproperty double z\nelement face 1\n\
                 property list uchar short vertex_index\nproperty int flag\nelement edge 1\n\
                 property list uint float w\nend_header\n"
            )
        };
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0f64]];
        let mut text = header("ascii");
        let mut binary = header("binary_big_endian").into_bytes();
        for [x, y, z] in points {
            text += &format!("{x} {y} 7 {z}\n");
            binary.extend(x.to_be_bytes());
            binary.extend(y.to_be_bytes());
            binary.push(7);
            binary.extend(z.to_be_bytes());
        }
        text += "4 0 1 2 3 9\n1 0.5\n";
        binary.push(4);
        (0..4i16).for_each(|i| binary.extend(i.to_be_bytes()));
        binary.extend(9i32.to_be_bytes());
        binary.extend(1u32.to_be_bytes());
        binary.extend(0.5f32.to_be_bytes());
        let (a, b) = (parse(text.as_bytes(), false).unwrap(), parse(&binary, false).unwrap());
        assert!(same(&a, &b));
        assert_eq!(a.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(a.positions[2], Vec3::new(1.0, 1.0, 0.0));
    }

    #[test]
    fn a_file_cut_or_damaged_at_any_byte_never_panics() {
        let whole = write(&mesh());
        for end in 0..whole.len() {
            assert!(parse(&whole[..end], false).is_err());
        }
        for at in 0..whole.len() {
            for value in [0, 0x80, 0xff, b' ', b'9'] {
                let mut bytes = whole.clone();
                bytes[at] = value;
                let _ = parse(&bytes, false);
            }
        }
    }

    #[test]
    fn false_counts_allocate_no_memory() {
        let text = "ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\n\
            property float x\nproperty float y\nproperty float z\nend_header\nabc";
        assert!(parse(text.as_bytes(), false).unwrap_err().contains("elements in 3 bytes"));
        let empty = "ply\nformat ascii 1.0\nelement nothing 18446744073709551615\nend_header\n";
        assert!(parse(empty.as_bytes(), false).unwrap().positions.is_empty());
    }
}
