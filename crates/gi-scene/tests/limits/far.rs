//! Scenes far from the origin of their coordinates.

use gi_core::geometry::Geometry;
use gi_core::light::LightSource;

use super::*;

/// Points of a scene whose places are all moved by `far`: of a mesh in a file, a sphere, a light and the camera. Their
/// last digits are small fractions of the scene.
fn points(far: f64) -> Vec<Vec3> {
    let at = |[x, y, z]: [f64; 3]| format!("{} {} {}", far + x, far * 0.5 + y, z - far);
    let corners = [[0.1, 0.2, 0.3], [1.3, 0.2, 0.3], [0.1, 1.7, 0.3]];
    let folder = Folder::new();
    let vertices: String = corners.iter().map(|c| format!("v {}\n", at(*c))).collect();
    folder.write("m.obj", vertices + "f 1 2 3\n");
    let center = at([0.4, 0.5, 0.6]);
    let body = format!(
        "<shape type='obj'><string name='filename' value='m.obj'/></shape>\
         <shape type='sphere'><point name='center' value='{center}'/></shape>\
         <shape type='rectangle'><transform name='to_world'><translate value='{center}'/></transform></shape>\
         <emitter type='point'><point name='position' value='{center}'/></emitter>\
         <sensor type='perspective'><transform name='to_world'>\
         <lookat origin='{}' target='{center}' up='0 1 0'/></transform></sensor>",
        at([0.7, 0.8, 5.1])
    );
    let loaded = folder.scene("3.0.0", &body).unwrap_or_else(|e| panic!("{e}"));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let mut points = Vec::new();
    for shape in &loaded.parts.shapes {
        match &shape.geometry {
            Geometry::Mesh(mesh) => points.extend(&mesh.positions),
            Geometry::Sphere { center, .. } => points.push(*center),
            other => panic!("{other:?}"),
        }
    }
    let LightSource::Point { position, .. } = loaded.parts.lights[0] else { panic!() };
    points.extend([position, loaded.camera.to_world.translation.into()]);
    points
}

#[test]
fn a_scene_far_from_the_origin_loses_no_digits() {
    let relative = |far: f64| {
        let points = points(far);
        let first = points[0];
        points.into_iter().map(|p| p - first).collect::<Vec<_>>()
    };
    let near = relative(0.0);
    // Single precision alone would round these by 1e-4 and by 1.
    for far in [1e3, 1e7] {
        for (p, q) in near.iter().zip(relative(far)) {
            assert!(p.distance(q) < 3e-6, "{far}: {p} is not {q}");
        }
    }
}

#[test]
fn a_far_mesh_in_single_precision_gives_a_warning() {
    let folder = Folder::new();
    let mut ply = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        .to_vec();
    for [x, y] in [[1e6f32, 0.0], [1e6 + 1.0, 0.0], [1e6, 1.0]] {
        ply.extend([x, y, 0.0].map(f32::to_le_bytes).concat());
    }
    ply.push(3);
    ply.extend([0u32, 1, 2].map(u32::to_le_bytes).concat());
    folder.write("m.ply", ply);
    let body = format!("{SENSOR}<shape type='ply'><string name='filename' value='m.ply'/></shape>");
    let warnings = folder.scene("3.0.0", &body).unwrap().warnings;
    assert!(warnings.iter().any(|w| w.contains("nearer to the origin")), "{warnings:?}");
}
