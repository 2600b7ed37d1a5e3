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
                super::check_size(Vec3::from(p)).map_err(fail)?;
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

/// One, two or three numbers.
fn texture_coordinate(text: &str) -> Result<Vec2, String> {
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
mod tests {
    use super::*;

    const TEXT: &str = "# a square, then a triangle that counts from the end\nmtllib a b.mtl\no x\n\
        v 0 0 0\r\nv 1 0 0 1 1 1\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0 0\nvn 0 0 2\n\
        g one\nusemtl red\nf 1/1/1 2/2/1 3/2/1 4/1/1\ng two\nusemtl blue\nf -4//-1 -3//1 -1//1\nl 1 2\n";

    #[test]
    fn polygons_groups_and_negative_indices_are_understood() {
        let (mesh, portable) = parse(TEXT.as_bytes(), true).unwrap();
        assert!(!portable, "Mitsuba 3 refuses indices from the end");
        assert_eq!(mesh.triangles.len(), 3);
        assert_eq!(mesh.positions.len(), 7, "corners with other indices are other vertices");
        assert_eq!(mesh.triangles[1], [0, 2, 3]);
        assert_eq!(mesh.uvs[1], Vec2::new(1.0, 1.0), "v is turned round");
        assert!(mesh.normals.iter().all(|n| *n == Vec3::Z));
        let parts = parse_by_material(TEXT.as_bytes(), false, true).unwrap();
        let names: Vec<_> =
            parts.meshes.iter().map(|(n, m)| (n.as_str(), m.triangles.len())).collect();
        assert_eq!(names, [("red", 2), ("blue", 1)]);
        assert_eq!(parts.libraries, ["a b.mtl"]);
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        let fails = |text: &str| parse(text.as_bytes(), true).unwrap_err();
        assert_eq!(fails("v 0 0 0\nf 1 2 3\n"), "line 2: vertex 2 of 1");
        assert_eq!(fails("v 0 0 0\nf 1 1\n"), "line 2: a face of 2 corners");
        assert_eq!(fails("v 0 0\n"), "line 1: `0 0` where 3 numbers belong");
        assert_eq!(fails("v 0 0 inf\n"), "line 1: vertex 0 is not finite: 0 0 inf");
        assert_eq!(fails("v 0 0 0\nf 0 0 0\n"), "line 2: vertex 0 of 1");
        assert_eq!(fails("v 0 0 0\nf -9223372036854775808 1 1\n").split(':').count(), 2);
        assert_eq!(fails(""), "it holds no faces");
    }

    #[test]
    fn a_file_cut_at_any_byte_never_panics() {
        for end in 0..TEXT.len() {
            let _ = parse(&TEXT.as_bytes()[..end], true);
        }
    }
}
