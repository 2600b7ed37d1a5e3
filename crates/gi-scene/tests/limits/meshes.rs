//! Meshes and other shapes.

use super::*;

#[test]
fn the_normals_of_a_mirrored_cylinder_point_outward() {
    let flipped = |x: &str| {
        let body = format!(
            "<shape type='cylinder'><transform name='to_world'><scale value='{x} 1 1'/>\
             </transform></shape>"
        );
        scene(&body).parts.shapes[0].flip_normals
    };
    assert_eq!([flipped("1"), flipped("-1")], [false, false]);
}

fn mesh(name: &str, text: &str) -> Result<gi_scene::Loaded, String> {
    let folder = Folder::new();
    folder.write(name, text);
    let (kind, _) = name.rsplit_once('.').map(|(_, k)| (k, ())).unwrap();
    let body =
        format!("{SENSOR}<shape type='{kind}'><string name='filename' value='{name}'/></shape>");
    folder.scene("3.0.0", &body).map_err(|e| folder.strip(&e.to_string()))
}

#[test]
fn invalid_normals_are_replaced_by_face_normals_with_a_warning() {
    let obj = |n: &str| format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn {n}\nf 1//1 2//1 3//2\n");
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nproperty float nx\nproperty float ny\nproperty float nz\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n\
        0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 nan 0 0\n3 0 1 2\n";
    let meshes = [("m.obj", obj("0 0 0")), ("m.obj", obj("nan 0 1")), ("m.ply", ply.to_owned())];
    for (name, text) in meshes {
        let loaded = mesh(name, &text).unwrap();
        assert!(loaded.warnings[0].contains("1 normals are zero"), "{:?}", loaded.warnings);
        let gi_core::geometry::Geometry::Mesh(mesh) = &loaded.parts.shapes[0].geometry else {
            panic!()
        };
        assert_eq!(mesh.normals, [Vec3::Z; 3]);
    }
}

#[test]
fn texture_coordinates_that_are_not_finite_are_refused() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt nan 0\nf 1/1 2/1 3/1\n";
    let shown = mesh("m.obj", obj).unwrap_err();
    assert!(shown.contains("line 4: a texture coordinate is not finite"), "{shown}");
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nproperty float u\nproperty float v\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n\
        0 0 0 0 0\n1 0 0 inf 0\n0 1 0 0 0\n3 0 1 2\n";
    let shown = mesh("m.ply", ply).unwrap_err();
    assert!(shown.contains("texture coordinate 1 is not finite"), "{shown}");
}

#[test]
fn vertices_so_far_away_that_areas_overflow_are_refused() {
    let shown = mesh("m.obj", "v 0 0 0\nv 1e30 0 0\nv 0 1 0\nf 1 2 3\n").unwrap_err();
    assert!(shown.contains("line 2: a vertex is too far away"), "{shown}");
}

#[test]
fn shapes_without_area_give_a_warning() {
    let warnings = |kind: &str, scale: &str| {
        let body = format!(
            "{SENSOR}<shape type='{kind}' id='it'><transform name='to_world'>\
             <scale value='{scale}'/></transform></shape>"
        );
        scene(&body).warnings
    };
    for kind in ["rectangle", "cube", "disk"] {
        let shown = warnings(kind, "0");
        assert!(shown[0].contains("`it` has no area"), "{kind} {shown:?}");
    }
    assert!(warnings("cube", "1 1 0")[0].contains("`it` is flat"));
    assert!(warnings("rectangle", "1 1 0").is_empty());
}
