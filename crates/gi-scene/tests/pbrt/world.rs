//! The Cornell box, shapes, transforms, groups, included files, the grammar and cameras.

use gi_core::camera::Projection;
use gi_core::filter::Filter;
use gi_core::geometry::Geometry;
use gi_core::texture::Texture;
use glam::Vec3;

use super::*;

#[test]
fn the_cornell_box_is_the_same_as_pbrt_and_as_xml() {
    let ours = scene("cornell-box.pbrt");
    let xml = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell-box.xml");
    let xml = load(&xml, &Options::default()).unwrap();
    assert_eq!(ours.warnings, [""; 0]);
    assert_eq!(ours.parts.shapes.len(), xml.parts.shapes.len());
    for (a, b) in ours.parts.shapes.iter().zip(&xml.parts.shapes) {
        let (ma, mb) = (mesh(a), mesh(b));
        assert_eq!(ma.positions, mb.positions);
        assert_eq!(ma.triangles, mb.triangles);
        assert_eq!(format!("{:?}", a.emission), format!("{:?}", b.emission));
    }
    for n in 0..8 {
        assert_eq!(format!("{:?}", inner(&ours, n)), format!("{:?}", inner(&xml, n)));
    }
    let (a, b) = (&ours.camera, &xml.camera);
    assert!(a.to_world.abs_diff_eq(b.to_world, 1e-6), "{a:?} {b:?}");
    assert_eq!((a.size, ours.filter), (b.size, xml.filter));
    let fov = |camera: &gi_core::camera::CameraSpec| match camera.projection {
        Projection::Perspective { fov_x, .. } => fov_x,
        Projection::Orthographic => panic!(),
    };
    assert!((fov(a) - fov(b)).abs() < 1e-6);
}

#[test]
fn all_shapes_are_read() {
    let loaded = scene("shapes.pbrt");
    let shapes = &loaded.parts.shapes;
    assert_eq!(shapes.len(), 10);
    let extents: Vec<Vec3> = shapes.iter().map(|s| s.geometry.bounds().extent()).collect();
    let near = |n: usize, extent: [f32; 3]| {
        assert!((extents[n] - Vec3::from(extent)).length() < 1e-3, "{n}: {}", extents[n]);
    };
    near(0, [1.4, 1.4, 1.4]);
    near(1, [1.4, 0.9, 1.4]);
    near(2, [1.0, 1.3, 1.0]);
    near(3, [1.2, 1.2, 0.0]);
    near(4, [1.4, 1.4, 0.0]);
    for n in 5..9 {
        near(n, [1.0, 1.0, 0.0]);
    }
    assert!(matches!(shapes[0].geometry, Geometry::Sphere { .. }));
    assert!(matches!(shapes[2].geometry, Geometry::Cylinder { .. }));
    let Geometry::Disk { center, .. } = shapes[3].geometry else { panic!() };
    assert!((center - Vec3::new(1.5, 0.0, 0.25)).length() < 1e-6, "{center}");
    // The bowl's surface: the area of a zone of a sphere is 2 pi r h, of which 300 degrees are there.
    let area: f32 = {
        let bowl = mesh(&shapes[1]);
        (0..bowl.triangles.len()).map(|k| 0.5 * bowl.area_vector(k).length()).sum()
    };
    let expected = std::f32::consts::TAU * 0.7 * 0.9 * 300.0 / 360.0;
    assert!((area / expected - 1.0).abs() < 2e-3, "{area} {expected}");
    assert_eq!(mesh(&shapes[5]).normals, [Vec3::Z; 4]);
    assert_eq!(mesh(&shapes[5]).uvs[2], glam::Vec2::ONE);
    assert!(mesh(&shapes[6]).normals.is_empty(), "a mesh without normals stays faceted");
    for shape in &shapes[5..9] {
        assert!(mesh(shape).area_vector(0).z > 0.0, "{shape:?} faces the eye");
    }
    assert_eq!(mesh(&shapes[9]).normals.len(), 4, "smooth");
    let notes = warnings(&loaded).join("\n");
    assert!(
        notes.contains("`curve` is not supported") && notes.contains("`loopsubdiv`"),
        "{notes}"
    );
}

#[test]
fn transforms_follow_each_other() {
    let loaded = scene("transforms.pbrt");
    let corners: Vec<[Vec3; 3]> = loaded.parts.shapes.iter().map(|s| mesh(s).corners(0)).collect();
    let near = |n: usize, expected: [[f32; 3]; 3]| {
        for (a, b) in corners[n].iter().zip(expected) {
            assert!((*a - Vec3::from(b)).length() < 1e-5, "{n}: {:?}", corners[n]);
        }
    };
    // The last directive acts first.
    let first = [[1., 4., 3.], [-1., 2., 3.], [1., 2., 5.]];
    near(0, first);
    near(1, [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]]);
    near(2, [[5., 7., 7.], [4., 6., 7.], [5., 6., 8.]]);
    near(3, [[1., 0., -1.], [0., 1., -1.], [0., 0., 0.]]);
    near(4, first);
    // The camera's axes; the eye is at (3, 4, 5) and looks at the origin.
    let eye = Vec3::new(3.0, 4.0, 5.0);
    let z = -eye.normalize();
    let x = Vec3::Y.cross(z).normalize();
    near(5, [(eye + x).into(), (eye + z.cross(x)).into(), (eye + z).into()]);
    // A mirrored triangle has the mirrored normal of the original; its corners change places for that.
    near(6, [[-1., 0., 0.], [0., 0., 1.], [0., 1., 0.]]);
    assert!(
        (mesh(&loaded.parts.shapes[6]).area_vector(0) - Vec3::new(-1., 1., 1.)).length() < 1e-6
    );
    let flipped: Vec<bool> = loaded.parts.shapes.iter().map(|s| s.flip_normals).collect();
    assert_eq!(flipped, [false, false, false, false, false, false, false, true, false]);
    near(8, [[1., 1., 0.], [0., 2., 0.], [0., 1., 1.]]);
    assert!(warnings(&loaded).join("\n").contains("motion is ignored"));
}

#[test]
fn the_picture_is_not_mirrored() {
    // In pbrt, +x is to the right of an eye that looks along +z with +y up.
    let loaded = world("Shape \"sphere\"");
    let right = loaded.camera.to_world.matrix3.x_axis;
    assert!(right.x < -0.99, "ours is to the left: {right}");
    assert!(loaded.camera.to_world.matrix3.z_axis.z > 0.99);
}

#[test]
fn groups_are_placed_by_instances() {
    let loaded = scene("instances.pbrt");
    assert_eq!(loaded.parts.groups.iter().map(Vec::len).collect::<Vec<_>>(), [2]);
    assert_eq!(loaded.parts.instances.len(), 3);
    // The group is defined one unit above the ground: that is part of its shapes' place.
    let bounds = loaded.parts.groups[0][0].geometry.bounds();
    assert!((bounds.center() - Vec3::Y).length() < 1e-6);
    let place = |n: usize| loaded.parts.instances[n].to_world.transform_point3(Vec3::X);
    assert!((place(1) - Vec3::new(-2.0, 0.0, -1.0)).length() < 1e-6, "{}", place(1));
    assert!((place(2) - Vec3::new(0.0, 0.0, 0.0)).length() < 1e-6, "{}", place(2));
    let [outside] = loaded.parts.shapes.as_slice() else { panic!() };
    assert!((outside.geometry.bounds().extent().x - 0.2).abs() < 1e-6);
    let Material::Diffuse { reflectance: Texture::Constant(c) } = inner(&loaded, 0) else {
        panic!()
    };
    assert_eq!(c.to_array(), [0.7, 0.2, 0.2], "the material before the group");
}

#[test]
fn included_files_share_the_state() {
    let loaded = scene("include.pbrt");
    assert_eq!(loaded.camera.size, [32, 24]);
    assert_eq!((loaded.parts.shapes.len(), loaded.parts.lights.len()), (4, 1));
    let x = |n: usize| loaded.parts.shapes[n].geometry.bounds().center().x;
    assert_eq!([x(0), x(1), x(2), x(3)], [0.0, 0.0, 2.0, 2.0]);
    let red = |n: usize| match inner(&loaded, n) {
        Material::Diffuse { reflectance: Texture::Constant(c) } => c.r,
        _ => panic!(),
    };
    assert_eq!([red(0), red(1)], [0.8, 0.1]);
    assert_eq!(loaded.files.len(), 5, "{:?}", loaded.files);
}

#[test]
fn the_grammar_is_understood() {
    let loaded = scene("grammar.pbrt");
    assert_eq!(loaded.warnings, [""; 0]);
    assert_eq!(loaded.camera.size, [32, 24]);
    assert_eq!(loaded.filter, Filter::Mitchell { b: 0.5, c: 0.25 });
    assert_eq!(loaded.integrator_max_depth, Some(8), "pbrt counts bounces");
    let radius = |n: usize| match loaded.parts.shapes[n].geometry {
        Geometry::Sphere { radius, .. } => radius,
        _ => panic!(),
    };
    assert_eq!([radius(0), radius(1), radius(2)], [0.25, 0.5, 1.0]);
    let Material::Diffuse { reflectance: Texture::Constant(c) } = inner(&loaded, 0) else {
        panic!()
    };
    assert_eq!(c.to_array(), [0.2, 0.4, 0.6], "of the `Attribute` directive");
    assert_eq!(loaded.camera.projection, Projection::Orthographic);
    let width = loaded.camera.to_world.matrix3.x_axis.length();
    assert!((width - 2.0).abs() < 1e-6, "half of the screen window: {width}");
}

#[test]
fn lenses_and_shifted_pictures_are_read() {
    let loaded = scene("lens.pbrt");
    let Projection::Perspective { fov_x, aperture_radius, focus_distance } =
        loaded.camera.projection
    else {
        panic!()
    };
    assert_eq!([aperture_radius, focus_distance], [0.1, 3.0]);
    // Two units to each side of the window's centre, at 60 degrees for one unit.
    let tangent = (0.5 * fov_x).tan();
    assert!((tangent - 2.0 * 30f32.to_radians().tan()).abs() < 1e-5, "{tangent}");
    assert_eq!(loaded.filter, Filter::Tent);
    // The sphere lies straight ahead of the eye, a quarter of the picture left of its centre and a quarter below.
    let camera = gi_core::camera::Camera::new(&loaded.camera);
    let seen = camera.connect(Vec3::new(1.0, 2.0, 0.0), [0.5; 2], 0.0).expect("visible");
    assert!(
        (seen.film[0] - 10.0).abs() < 0.1 && (seen.film[1] - 15.0).abs() < 0.1,
        "{:?}",
        seen.film
    );
    assert!(warnings(&loaded).join("\n").contains("multiplies by 2"), "{:?}", loaded.warnings);
}

#[test]
fn compressed_files_are_read() {
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;
    let folder = common::Folder::new();
    let compressed = |text: &[u8]| {
        let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
        gzip.write_all(text).unwrap();
        gzip.finish().unwrap()
    };
    let ply = std::fs::read(path("meshes/square.ply")).unwrap();
    folder.write("square.ply.gz", compressed(&ply));
    let text = "WorldBegin Shape \"plymesh\" \"string filename\" \"square.ply.gz\"";
    let scene = folder.write("scene.pbrt.gz", compressed(text.as_bytes()));
    let loaded = load(&scene, &Options::default()).unwrap();
    assert_eq!(mesh(&loaded.parts.shapes[0]).triangles.len(), 2);
    // A small file that contains much is refused before it takes the memory.
    folder.write("square.ply.gz", compressed(&vec![b' '; 100_000_000]));
    let options = Options { max_memory: 10_000_000, ..Options::default() };
    let shown = load(&scene, &options).unwrap_err().to_string();
    assert!(shown.contains("square.ply.gz") && shown.contains("--max-memory"), "{shown}");
}

#[test]
fn every_number_of_an_inline_mesh_and_of_a_grid_changes_the_hash_of_the_world() {
    let mesh = |normals: &str, uvs: &str| {
        world(&format!(
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] \"normal N\" [{normals}] \"point2 uv\" [{uvs}]"
        ))
        .world
    };
    let first = mesh("0 0 1 0 0 1 0 0 1", "0 0 1 0 0 1");
    assert_eq!(mesh("0 0 1 0 0 1 0 0 1", "0 0 1 0 0 1"), first);
    assert_ne!(mesh("0 0 1 0 0 1 0 0.1 1", "0 0 1 0 0 1"), first, "a normal");
    assert_ne!(mesh("0 0 1 0 0 1 0 0 1", "0 0 1 0.5 0 1"), first, "a second texture coordinate");
    let grid = |size: &str| {
        world(&format!(
            "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" {size} \"float density\" [1 2 3 4]\n\
             AttributeBegin\nMediumInterface \"m\" \"\"\nMaterial \"interface\"\nShape \"sphere\"\nAttributeEnd"
        ))
        .world
    };
    let along = grid("\"integer nx\" 4 \"integer ny\" 1 \"integer nz\" 1");
    assert_ne!(
        grid("\"integer nx\" 1 \"integer ny\" 4 \"integer nz\" 1"),
        along,
        "the grid's size"
    );
}
