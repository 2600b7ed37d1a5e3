use super::*;
use crate::budget::Budget;

fn parse(bytes: &[u8], flip: bool) -> Result<Contents, String> {
    super::parse(bytes, (flip, DVec3::ZERO), &mut Budget::new(u64::MAX).claim("a test"))
}

const TEXT: &str = "# a square, then a triangle that counts from the end\nmtllib a b.mtl\no x\n\
        v 0 0 0\r\nv 1 0 0 1 1 1\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0 0\nvn 0 0 2\n\
        g one\nusemtl red\nf 1/1/1 2/2/1 3/2/1 4/1/1\ng two\nusemtl blue\nf -4//-1 -3//1 -1//1\nl 1 2\n";

#[test]
fn polygons_groups_and_negative_indices_are_understood() {
    let mut contents = parse(TEXT.as_bytes(), true).unwrap();
    let (_, mesh) = contents.meshes.pop().unwrap();
    assert!(!contents.portable, "Mitsuba 3 refuses indices from the end");
    assert_eq!(mesh.triangles.len(), 3);
    assert_eq!(mesh.positions.len(), 7, "corners with other indices are other vertices");
    assert_eq!(mesh.triangles[1], [0, 2, 3]);
    assert_eq!(mesh.uvs[1], Vec2::new(1.0, 1.0), "v is flipped");
    assert!(mesh.normals.iter().all(|n| *n == Vec3::Z));
    let parts = parse_by_material(
        TEXT.as_bytes(),
        (false, DVec3::ZERO),
        true,
        &mut Budget::new(u64::MAX).claim("a test"),
    )
    .unwrap();
    let names: Vec<_> = parts.meshes.iter().map(|(n, m)| (n.as_str(), m.triangles.len())).collect();
    assert_eq!(names, [("red", 2), ("blue", 1)]);
    assert_eq!(parts.libraries, ["a b.mtl"]);
}

#[test]
fn mistakes_are_named_with_their_line() {
    let fails = |text: &str| parse(text.as_bytes(), true).unwrap_err();
    assert_eq!(fails("v 0 0 0\nf 1 2 3\n"), "line 2: vertex 2 of 1");
    assert_eq!(fails("v 0 0\n"), "line 1: `0 0` instead of 3 numbers");
    assert_eq!(fails("v 0 0 inf\n"), "line 1: vertex 0 is not finite: 0 0 inf");
    assert_eq!(fails("v 0 0 0\nf 0 0 0\n"), "line 2: vertex 0 of 1");
    assert_eq!(fails("v 0 0 0\nf -9223372036854775808 1 1\n").split(':').count(), 2);
    assert_eq!(fails(""), "it contains no faces");
}

#[test]
fn faces_of_one_and_two_corners_are_skipped() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1\nf\nf 1 2 3 # whole\n";
    let contents = parse(text.as_bytes(), true).unwrap();
    assert_eq!((contents.meshes[0].1.triangles.len(), contents.degenerate), (1, (3, 4)));
    assert!(contents.note("a.obj").unwrap().contains("the first in line 4"));
    assert_eq!(parse(b"v 0 0 0\nf 1\n", true).unwrap_err(), "it contains no faces");
}

#[test]
fn byte_order_marks_are_no_part_of_the_first_word() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let wide = |order: fn(u16) -> [u8; 2]| -> Vec<u8> {
        std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(order).collect()
    };
    let narrow = [b"\xef\xbb\xbf", text.as_bytes()].concat();
    for bytes in [narrow, wide(u16::to_le_bytes), wide(u16::to_be_bytes)] {
        assert_eq!(parse(&bytes, true).unwrap().meshes[0].1.triangles, [[0, 1, 2]]);
    }
}

#[test]
fn a_file_cut_at_any_byte_never_panics() {
    for end in 0..TEXT.len() {
        let _ = parse(&TEXT.as_bytes()[..end], true);
    }
}
