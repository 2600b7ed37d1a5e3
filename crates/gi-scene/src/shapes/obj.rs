//! Wavefront OBJ geometry. Groups and smoothing groups are ignored, as in Mitsuba; polygons become triangle fans.

use std::collections::HashMap;
use std::str::FromStr;

use gi_core::geometry::Mesh;
use glam::{DVec3, Vec2, Vec3};

use crate::budget::Claim;
use crate::files;
use crate::statements::{statements, without_comment};

/// An index that a corner does not have.
const ABSENT: u32 = u32::MAX;

/// The contents of a file, with one mesh per material.
#[derive(Debug, Default)]
pub(crate) struct Contents {
    /// The arguments of each `mtllib` statement, in order: one name or several.
    pub(crate) libraries: Vec<String>,
    /// One mesh per material name, in order of first use; the name is `""` before the first `usemtl`. A mesh has no
    /// normals unless all its corners have one.
    pub(crate) meshes: Vec<(String, Mesh)>,
    /// Whether Mitsuba 3 reads the file like we do: it refuses negative indices.
    pub(crate) portable: bool,
    /// Faces of fewer than three corners, which are skipped: their number, and the line of the first.
    pub(crate) degenerate: (usize, usize),
    /// Whether the file contains unsupported statements: free-form curves or surfaces, or calls of other files.
    ignored: bool,
}

/// Unsupported statements that draw something.
const IGNORED: [&str; 4] = ["curv", "curv2", "surf", "call"];

impl Contents {
    /// Count a face with too few corners.
    fn count_corners(&mut self, corners: usize, line: usize) {
        let (count, first) = self.degenerate;
        if corners < 3 {
            self.degenerate = (count + 1, if count == 0 { line } else { first });
        }
    }

    /// A warning about what was skipped, if anything was.
    pub(crate) fn note(&self, path: &str) -> Option<String> {
        if self.ignored {
            return Some(format!(
                "`{path}`: free-form surfaces, curves and calls of other files are ignored"
            ));
        }
        let (count, first) = self.degenerate;
        let faces = if count == 1 { "a face" } else { "faces" };
        (count > 0).then(|| {
            format!(
                "`{path}`: {count} {faces} of one or two corners skipped, the first in line {first}"
            )
        })
    }
}

/// Read all faces as one mesh, whose positions are relative to `origin`.
pub(crate) fn parse(
    bytes: &[u8],
    (flip, origin): (bool, DVec3),
    claim: &mut Claim<'_>,
) -> Result<Contents, String> {
    let contents = parse_by_material(bytes, (flip, origin), false, claim)?;
    if contents.meshes.is_empty() {
        return Err("it contains no faces".into());
    }
    Ok(contents)
}

/// Read the faces of each material as a separate mesh, or all faces as one mesh. Positions are relative to `origin`.
pub(crate) fn parse_by_material(
    bytes: &[u8],
    (flip, origin): (bool, DVec3),
    by_material: bool,
    claim: &mut Claim<'_>,
) -> Result<Contents, String> {
    let mut reader = Reader { flip, ..Reader::default() };
    let mut contents = Contents::default();
    let text = files::without_mark(bytes);
    for statement in statements(&text) {
        let fail = |why: String| format!("line {}: {why}", statement.line);
        let (keyword, rest) = statement.split();
        claim.at_least(reader.bytes + 64 * rest.len() as u64)?;
        match keyword {
            "v" => {
                let p = position(rest, reader.positions.len(), origin).map_err(fail)?;
                reader.positions.push(p);
                reader.bytes += NUMBERS;
            }
            "vn" => {
                reader.normals.push(Vec3::from(floats::<f32, 3>(rest).map_err(fail)?));
                reader.bytes += NUMBERS;
            }
            "vt" => {
                reader.uvs.push(texture_coordinate(rest).map_err(fail)?);
                reader.bytes += NUMBERS;
            }
            // Old files write `fo`.
            "f" | "fo" => {
                let corners = reader.face(without_comment(rest)).map_err(fail)?;
                contents.count_corners(corners, statement.line);
                reader.bytes += CORNER * corners as u64;
            }
            "usemtl" if by_material => reader.material(rest),
            "mtllib" => contents.libraries.push(rest.to_owned()),
            _ if IGNORED.contains(&keyword) => contents.ignored = true,
            _ => {}
        }
    }
    contents.portable = !reader.from_end;
    let all = std::mem::take(&mut reader.parts);
    contents.meshes = all
        .into_iter()
        .filter(|p| !p.triangles.is_empty())
        .map(|p| (p.name.clone(), reader.mesh(p)))
        .collect();
    Ok(contents)
}

/// Indices of a corner: position, texture coordinate, normal.
type Corner = [u32; 3];

#[derive(Debug, Default)]
struct Part {
    name: String,
    corners: Vec<Corner>,
    known: HashMap<Corner, u32>,
    triangles: Vec<[u32; 3]>,
}

#[derive(Debug, Default)]
struct Reader {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    parts: Vec<Part>,
    /// The part of each material.
    part_of: HashMap<String, usize>,
    current: usize,
    flip: bool,
    /// Whether any index is negative: it counts from the end.
    from_end: bool,
    /// Estimate of the memory taken by everything read.
    bytes: u64,
}

/// Memory taken by a vertex, a normal or a texture coordinate, in a vector that grows.
const NUMBERS: u64 = 2 * 12;
/// Memory taken by a corner: its entry in the table, its triangle and what its mesh stores.
const CORNER: u64 = 64;
/// Memory taken by an empty part.
const PART: u64 = 256;

impl Reader {
    fn material(&mut self, name: &str) {
        self.current = match self.part_of.get(name) {
            Some(known) => *known,
            None => {
                self.part_of.insert(name.to_owned(), self.parts.len());
                self.bytes += PART;
                self.parts.push(Part { name: name.to_owned(), ..Part::default() });
                self.parts.len() - 1
            }
        };
    }

    /// Add a face as a triangle fan; returns its number of corners.
    fn face(&mut self, text: &str) -> Result<usize, String> {
        if self.parts.is_empty() {
            self.material("");
        }
        let mut fan: Option<(u32, u32)> = None;
        let mut first = None;
        let mut count = 0;
        for word in text.split_whitespace() {
            let corner = self.corner(word)?;
            let part = &mut self.parts[self.current];
            let index = *part.known.entry(corner).or_insert_with(|| {
                part.corners.push(corner);
                part.corners.len() as u32 - 1
            });
            count += 1;
            if let Some((a, b)) = fan {
                part.triangles.push([a, b, index]);
            }
            let start = *first.get_or_insert(index);
            if count >= 2 {
                fan = Some((start, index));
            }
        }
        Ok(count)
    }

    fn corner(&mut self, word: &str) -> Result<Corner, String> {
        let mut out = [ABSENT; 3];
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        for (k, text) in word.split('/').enumerate() {
            if k > 2 {
                return Err(format!("`{word}` has more than three indices"));
            }
            if text.is_empty() && k > 0 {
                continue;
            }
            let index: i64 =
                text.parse().map_err(|_| format!("`{word}` is not a corner of a face"))?;
            self.from_end |= index < 0;
            let count = counts[k] as i64;
            // 1 is the first, -1 the last one so far.
            let at = if index < 0 { count + index } else { index - 1 };
            if at < 0 || at >= count.min(i64::from(ABSENT)) {
                let what = ["vertex", "texture coordinate", "normal"][k];
                return Err(format!("{what} {index} of {count}"));
            }
            out[k] = at as u32;
        }
        Ok(out)
    }

    fn mesh(&self, part: Part) -> Mesh {
        let has = |k: usize| part.corners.iter().any(|c| c[k] != ABSENT);
        let all = |k: usize| part.corners.iter().all(|c| c[k] != ABSENT);
        let positions = part.corners.iter().map(|c| self.positions[c[0] as usize]).collect();
        let uv = |c: &Corner| {
            let uv = self.uvs.get(c[1] as usize).copied().unwrap_or(Vec2::ZERO);
            if self.flip { Vec2::new(uv.x, 1.0 - uv.y) } else { uv }
        };
        let uvs = if has(1) { part.corners.iter().map(uv).collect() } else { Vec::new() };
        let normal = |c: &Corner| self.normals[c[2] as usize].normalize_or_zero();
        let normals = if all(2) { part.corners.iter().map(normal).collect() } else { Vec::new() };
        Mesh { positions, normals, uvs: uvs.into(), triangles: part.triangles.into() }
    }
}

/// Vertex number `index`, relative to `origin`.
fn position(text: &str, index: usize, origin: DVec3) -> Result<Vec3, String> {
    let p = floats::<f32, 3>(text)?;
    if !p.iter().all(|x| x.is_finite()) {
        return Err(format!("vertex {index} is not finite: {}", without_comment(text)));
    }
    crate::value::check_size(Vec3::from(p))?;
    if origin == DVec3::ZERO {
        return Ok(Vec3::from(p));
    }
    Ok((DVec3::from(floats::<f64, 3>(text)?) - origin).as_vec3())
}

fn floats<T: FromStr + Default + Copy, const N: usize>(text: &str) -> Result<[T; N], String> {
    let text = without_comment(text);
    let mut out = [T::default(); N];
    let mut words = text.split_whitespace();
    for x in &mut out {
        let word = words.next().ok_or_else(|| format!("`{text}` instead of {N} numbers"))?;
        *x = word.parse().map_err(|_| format!("`{word}` is not a number"))?;
    }
    Ok(out)
}

/// One, two or three numbers.
fn texture_coordinate(text: &str) -> Result<Vec2, String> {
    let text = without_comment(text);
    let mut words = text.split_whitespace();
    let mut next = |default: f32| match words.next() {
        Some(w) => w.parse::<f32>().map_err(|_| format!("`{w}` is not a number")),
        None => Ok(default),
    };
    let (u, v) = (next(0.0)?, next(0.0)?);
    if !(u.is_finite() && v.is_finite()) {
        return Err(format!("a texture coordinate is not finite: {text}"));
    }
    Ok(Vec2::new(u, v))
}

#[cfg(test)]
mod tests;
