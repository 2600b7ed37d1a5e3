//! Attributes of vertices and faces, such as colours, with the names that Mitsuba 3 gives them.

use gi_core::math::Rgb;
use gi_core::texture::srgb_to_linear;

use super::header::{Element, Header, Kind, Property};
use super::{Source, is_corners};
use crate::budget::Claim;

/// The value of an attribute at the three corners of each triangle, in the order of the mesh. The name begins with
/// `vertex_` or `face_`.
pub(crate) fn attribute(
    bytes: &[u8],
    name: &str,
    claim: &mut Claim<'_>,
) -> Result<Vec<[Rgb; 3]>, String> {
    let (header, body) = Header::parse(bytes)?;
    let (owner, base) = split(name).ok_or("expected `vertex_...` or `face_...`")?;
    let columns = header.elements.iter().find(|e| e.name == owner).and_then(|e| columns(e, base));
    let columns = columns.ok_or_else(|| format!("its {owner} elements have no such attribute"))?;
    let mut source = Source::new(&header, body)?;
    let mut corners = Corners { columns, owner, of_vertex: Vec::new(), triangles: Vec::new() };
    for element in &header.elements {
        for _ in 0..source.at_most(element.count)? {
            claim.at_least(
                24 * corners.of_vertex.len() as u64 + 72 * corners.triangles.len() as u64,
            )?;
            corners.read(element, &mut source)?;
        }
    }
    Ok(corners.triangles)
}

/// `vertex` or `face`, and the rest of the name.
fn split(name: &str) -> Option<(&'static str, &str)> {
    let of = |owner: &'static str| Some((owner, name.strip_prefix(owner)?.strip_prefix('_')?));
    of("vertex").or_else(|| of("face"))
}

/// The columns of the attribute `base`: three, or one that counts for all channels.
fn columns(element: &Element, base: &str) -> Option<[usize; 3]> {
    let at =
        |name: &str| element.properties.iter().position(|p| p.name == name && p.list.is_none());
    let all = |names: [String; 3]| {
        let [a, b, c] = names.map(|name| at(&name));
        Some([a?, b?, c?])
    };
    let colors = if base == "color" {
        all(["r", "g", "b"].map(String::from))
            .or_else(|| all(["red", "green", "blue"].map(String::from)))
    } else {
        None
    };
    let with = |base: &str, ends: [&str; 3]| {
        let triple = all(ends.map(|end| format!("{base}_{end}")));
        triple.or_else(|| at(&format!("{base}_{}", ends[0])).map(|column| [column; 3]))
    };
    let colors = colors.or_else(|| with(base.strip_suffix("_color")?, ["r", "g", "b"]));
    let numbers = [["x", "y", "z"], ["0", "1", "2"], ["1", "2", "3"]];
    colors.or_else(|| numbers.into_iter().find_map(|ends| with(base, ends)))
}

/// What was read so far.
struct Corners {
    columns: [usize; 3],
    owner: &'static str,
    of_vertex: Vec<Rgb>,
    triangles: Vec<[Rgb; 3]>,
}

impl Corners {
    /// Read one element.
    fn read(&mut self, element: &Element, source: &mut Source<'_>) -> Result<(), String> {
        let mut row = Vec::with_capacity(element.properties.len());
        let mut polygon = Vec::new();
        for p in &element.properties {
            let Some(list) = p.list else {
                row.push(value(source.next(p.kind)?, p));
                continue;
            };
            row.push(0.0);
            for _ in 0..source.list_length(list)? {
                let index = source.next(p.kind)?;
                if element.name == "face" && is_corners(p) {
                    polygon.push(index as usize); // a false index is refused below
                }
            }
        }
        let own = |corners: &Self| Rgb::from(corners.columns.map(|c| row[c]));
        let owns = element.name == self.owner;
        match element.name.as_str() {
            "vertex" if owns => self.of_vertex.push(own(self)),
            "face" => {
                let whole = if owns { Some(own(self)) } else { None };
                let corner = |index: usize| {
                    let known = whole.or_else(|| self.of_vertex.get(index).copied());
                    known.ok_or_else(|| format!("a face names vertex {index}"))
                };
                let colors = polygon.into_iter().map(corner).collect::<Result<Vec<_>, _>>()?;
                let fan = (2..colors.len()).map(|k| [colors[0], colors[k - 1], colors[k]]);
                self.triangles.extend(fan);
            }
            _ => {}
        }
        Ok(())
    }
}

/// As in Mitsuba, whole numbers are colours with the sRGB curve, and their largest value is one.
fn value(number: f64, property: &Property) -> f32 {
    let most = match property.kind {
        Kind::F32 | Kind::F64 => return number as f32,
        Kind::I8 => f64::from(i8::MAX),
        Kind::U8 => f64::from(u8::MAX),
        Kind::I16 => f64::from(i16::MAX),
        Kind::U16 => f64::from(u16::MAX),
        Kind::I32 => f64::from(i32::MAX),
        Kind::U32 => f64::from(u32::MAX),
    };
    srgb_to_linear((number / most) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::Budget;

    fn read(text: &str, name: &str) -> Result<Vec<[Rgb; 3]>, String> {
        attribute(text.as_bytes(), name, &mut Budget::new(u64::MAX).claim("a test"))
    }

    const QUAD: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nproperty float red\nproperty float green\nproperty float blue\n\
        property float heat_0\nelement face 1\nproperty list uchar int vertex_indices\n\
        property uchar dye_r\nproperty uchar dye_g\nproperty uchar dye_b\nend_header\n\
        0 0 0 .1 .2 .3 5\n1 0 0 .4 .5 .6 6\n1 1 0 .7 .8 .9 7\n0 1 0 1 1 1 8\n4 0 1 2 3 255 0 128\n";

    #[test]
    fn attributes_of_vertices_and_faces_follow_the_triangles() {
        let colors = read(QUAD, "vertex_color").unwrap();
        assert_eq!(colors.len(), 2);
        assert_eq!(colors[1], [Rgb::new(0.1, 0.2, 0.3), Rgb::new(0.7, 0.8, 0.9), Rgb::WHITE]);
        assert_eq!(read(QUAD, "vertex_heat").unwrap()[0], [5.0, 6.0, 7.0].map(Rgb::grey));
        let dye = read(QUAD, "face_dye_color").unwrap();
        assert_eq!(dye[0], dye[1]);
        assert_eq!(dye[0][2].r, 1.0);
        assert!((dye[0][2].b - 0.215_86).abs() < 1e-4, "128 is half of the sRGB curve");
    }

    #[test]
    fn missing_attributes_and_false_indices_are_errors() {
        assert!(read(QUAD, "vertex_dye").unwrap_err().contains("no such attribute"));
        assert!(read(QUAD, "color").unwrap_err().contains("expected `vertex_"));
        let wrong = QUAD.replace("4 0 1 2 3", "4 0 1 2 9");
        assert!(read(&wrong, "vertex_color").unwrap_err().contains("vertex 9"));
        for end in 0..QUAD.len() - 4 {
            assert!(read(&QUAD[..end], "vertex_color").is_err(), "{end}");
        }
    }
}
