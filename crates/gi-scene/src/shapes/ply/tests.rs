use super::*;
use crate::budget::Budget;
use glam::Vec3;

fn parse(bytes: &[u8], flip: bool) -> Result<Mesh, String> {
    super::parse(bytes, (flip, DVec3::ZERO), &mut Budget::new(u64::MAX).claim("a test"))
}

fn mesh() -> Mesh {
    Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.5)],
        normals: vec![Vec3::Z; 4],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE].into(),
        triangles: vec![[0, 1, 2], [2, 1, 3]].into(),
    }
}

fn same(a: &Mesh, b: &Mesh) -> bool {
    (&a.positions, &a.normals, &a.uvs, &a.triangles)
        == (&b.positions, &b.normals, &b.uvs, &b.triangles)
}

#[test]
fn what_is_written_is_read_back() {
    let full = mesh();
    let bare = Mesh { normals: vec![], uvs: vec![].into(), ..mesh() };
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
