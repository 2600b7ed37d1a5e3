//! Wavefront OBJ geometry. Groups and smoothing groups are ignored, as Mitsuba does; polygons become fans.

use std::collections::HashMap;

use gi_core::geometry::Mesh;
use glam::{Vec2, Vec3};

/// What is absent from a corner.
const ABSENT: u32 = u32::MAX;

/// The contents of a file with its materials.
#[derive(Debug, Default)]
pub(crate) struct Contents {
    /// Names after `mtllib`, in order.
    pub(crate) libraries: Vec<String>,
    /// One mesh a material (the first `usemtl` that names it opens it; `""` before any), without normals
    /// where not every corner has one.
    pub(crate) meshes: Vec<(String, Mesh)>,
    /// Whether Mitsuba 3 reads the file as we do: it refuses indices that count from the end.
    pub(crate) portable: bool,
}

/// Read all faces as one mesh, and say whether Mitsuba 3 reads the same.
pub(crate) fn parse(bytes: &[u8], flip: bool) -> Result<(Mesh, bool), String> {
    let mut contents = parse_by_material(bytes, flip, false)?;
    let (_, mesh) = contents.meshes.pop().ok_or("it holds no faces")?;
    Ok((mesh, contents.portable))
}

/// Read the faces of each material as a mesh of its own, or all as one.
pub(crate) fn parse_by_material(
    bytes: &[u8],
    flip: bool,
    by_material: bool,
) -> Result<Contents, String> {
    let mut reader = Reader { flip, ..Reader::default() };
    let mut contents = Contents::default();
    for (number, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let fail = |why: String| format!("line {}: {why}", number + 1);
        // Names may be in any encoding; numbers are ASCII.
        let line = String::from_utf8_lossy(line);
        let line = line.split('#').next().unwrap_or_default().trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        match keyword {
            "v" => {
                let p = floats::<3>(rest).map_err(fail)?;
                if !p.iter().all(|x| x.is_finite()) {
                    let n = reader.positions.len();
                    return Err(fail(format!("vertex {n} is not finite: {rest}")));
                }
                reader.positions.push(Vec3::from(p));
            }
            "vn" => reader.normals.push(Vec3::from(floats::<3>(rest).map_err(fail)?)),
            "vt" => reader.uvs.push(texture_coordinate(rest).map_err(fail)?),
            "f" => reader.face(rest).map_err(fail)?,
            "usemtl" if by_material => reader.material(rest.trim()),
            "mtllib" => contents.libraries.push(rest.trim().to_owned()),
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
    current: usize,
    flip: bool,
    /// Whether any index counts from the end.
    from_end: bool,
}

impl Reader {
    fn material(&mut self, name: &str) {
        self.current = self.parts.iter().position(|p| p.name == name).unwrap_or_else(|| {
            self.parts.push(Part { name: name.to_owned(), ..Part::default() });
            self.parts.len() - 1
        });
    }

    fn face(&mut self, text: &str) -> Result<(), String> {
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
        if count < 3 {
            return Err(format!("a face of {count} corners"));
        }
        Ok(())
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
                text.parse().map_err(|_| format!("`{word}` is no corner of a face"))?;
            self.from_end |= index < 0;
            let count = counts[k] as i64;
            // One is the first, -1 the last so far.
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
        Mesh { positions, normals, uvs, triangles: part.triangles }
    }
}

fn floats<const N: usize>(text: &str) -> Result<[f32; N], String> {
    let mut out = [0.0; N];
    let mut words = text.split_whitespace();
    for x in &mut out {
        let word = words.next().ok_or_else(|| format!("`{text}` where {N} numbers belong"))?;
        *x = word.parse().map_err(|_| format!("`{word}` is not a number"))?;
    }
    Ok(out)
}

/// One, two or three numbers; a value that is not finite counts as zero.
fn texture_coordinate(text: &str) -> Result<Vec2, String> {
    let mut words = text.split_whitespace();
    let mut next = |default: f32| match words.next() {
        Some(w) => w.parse::<f32>().map_err(|_| format!("`{w}` is not a number")),
        None => Ok(default),
    };
    let (u, v) = (next(0.0)?, next(0.0)?);
    Ok(Vec2::new(if u.is_finite() { u } else { 0.0 }, if v.is_finite() { v } else { 0.0 }))
}
