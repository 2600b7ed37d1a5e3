//! Shapes and their transforms.

use super::*;
use crate::common::Folder;

#[test]
fn transforms_apply_in_written_order() {
    let loaded = scene(
        "<shape type='sphere'><float name='radius' value='2'/><transform name='to_world'>
         <scale value='3'/><translate x='1'/><rotate z='1' angle='90'/></transform></shape>",
    );
    let Geometry::Sphere { center, radius, .. } = loaded.parts.shapes[0].geometry else { panic!() };
    assert!((center - Vec3::Y).length() < 1e-6, "scaled, moved to +x, turned to +y: {center}");
    assert!((radius - 6.0).abs() < 1e-5);
}

#[test]
fn a_rectangle_faces_where_its_normal_goes_even_if_mirrored() {
    for scale in ["1 1 1", "-1 1 1", "2 3 1"] {
        let loaded = scene(&format!(
            "<shape type='rectangle'><transform name='to_world'><scale value='{scale}'/></transform></shape>"
        ));
        let Geometry::Mesh(mesh) = &loaded.parts.shapes[0].geometry else { panic!() };
        assert!(mesh.area_vector(0).z > 0.0 && mesh.area_vector(1).z > 0.0, "{scale}");
        let corner = mesh.uvs.iter().position(|uv| *uv == Vec2::ZERO).unwrap();
        assert_eq!(mesh.positions[corner].y, if scale == "2 3 1" { -3.0 } else { -1.0 });
    }
}

#[test]
fn a_cube_is_closed_and_faces_outward() {
    let loaded = scene("<shape type='cube'/>");
    let Geometry::Mesh(mesh) = &loaded.parts.shapes[0].geometry else { panic!() };
    let volume: f32 = (0..12)
        .map(|k| {
            let [a, b, c] = mesh.corners(k);
            a.dot(b.cross(c)) / 6.0
        })
        .sum();
    assert!((volume - 8.0).abs() < 1e-5);
    for k in 0..12 {
        let [a, b, c] = mesh.corners(k);
        assert!(mesh.area_vector(k).dot(a + b + c) > 0.0);
    }
}

#[test]
fn mirrored_spheres_and_disks_have_the_normals_of_mitsuba() {
    // In Mitsuba 3.9.1, a mirrored sphere is turned inside out, a mirrored disk is not.
    let flipped = |kind: &str| {
        let body = format!(
            "<shape type='{kind}'><transform name='to_world'><scale x='-1'/></transform></shape>"
        );
        let loaded = scene(&body);
        match loaded.parts.shapes[0].geometry {
            Geometry::Disk { du, dv, .. } => {
                (du.cross(dv).z < 0.0) == loaded.parts.shapes[0].flip_normals
            }
            _ => loaded.parts.shapes[0].flip_normals,
        }
    };
    assert!(flipped("sphere"));
    assert!(flipped("disk"), "the disk still faces +z");
}

#[test]
fn a_deformed_sphere_becomes_a_closed_mesh() {
    let body = "<shape type='sphere'><transform name='to_world'><scale x='2'/></transform></shape>";
    let loaded = scene(body);
    let Geometry::Mesh(mesh) = &loaded.parts.shapes[0].geometry else { panic!() };
    let volume: f32 = (0..mesh.triangles.len())
        .map(|k| {
            let [a, b, c] = mesh.corners(k);
            a.dot(b.cross(c)) / 6.0
        })
        .sum();
    let exact = 2.0 * 4.0 / 3.0 * std::f32::consts::PI;
    assert!((volume / exact - 1.0).abs() < 1e-3, "{volume} {exact}");
    assert!(!loaded.warnings.is_empty());
}

#[test]
fn groups_appear_through_instances() {
    let loaded = scene(
        "<shape type='shapegroup' id='g'><shape type='cube'/></shape>
         <shape type='instance'><ref id='g'/><transform name='to_world'><translate x='5'/></transform></shape>
         <shape type='instance'><ref id='g'/></shape>",
    );
    assert_eq!((loaded.parts.shapes.len(), loaded.parts.groups.len()), (0, 1));
    assert_eq!(loaded.parts.instances.iter().map(|i| i.group).collect::<Vec<_>>(), [0, 0]);
    assert_eq!(loaded.parts.instances[0].to_world.translation.x, 5.0);
}

/// A triangle whose corners are red, green and blue.
const COLORED: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    property float r\nproperty float g\nproperty float b\nelement face 1\nproperty list uchar int vertex_indices\n\
    end_header\n0 0 0 1 0 0\n1 0 0 0 1 0\n0 1 0 0 0 1\n3 0 1 2\n";

#[test]
fn a_mesh_attribute_colours_each_shape_with_its_own_mesh() {
    let folder = common::Folder::new();
    folder.write("a.ply", COLORED);
    folder.write("b.ply", COLORED.replace("0 0 0 1 0 0", "0 0 0 1 1 1"));
    let shape = |file: &str, inner: &str| {
        format!("<shape type='ply'><string name='filename' value='{file}'/>{inner}</shape>")
    };
    let bsdf = "<bsdf type='twosided' id='dyed'><bsdf type='diffuse'><texture type='mesh_attribute' name='reflectance'>
        <string name='name' value='vertex_color'/><float name='scale' value='0.5'/></texture></bsdf></bsdf>";
    let shared = "<ref id='dyed'/>";
    let body = format!("{bsdf}{}{}", shape("a.ply", shared), shape("b.ply", shared));
    let loaded = folder.scene("3.0.0", &body).unwrap();
    let at_corners = |k: usize| {
        let shape = &loaded.parts.shapes[k];
        let Geometry::Mesh(mesh) = &shape.geometry else { panic!() };
        let Material::TwoSided { front, .. } = loaded.parts.materials[shape.material] else {
            panic!()
        };
        let Material::Diffuse { reflectance } = &loaded.parts.materials[front] else { panic!() };
        mesh.triangles[0].map(|i| reflectance.eval(mesh.uvs[i as usize]))
    };
    let half = |r: f32, g: f32, b: f32| Rgb::new(r, g, b) * 0.5;
    assert_eq!(at_corners(0), [half(1., 0., 0.), half(0., 1., 0.), half(0., 0., 1.)]);
    assert_eq!(at_corners(1)[0], Rgb::grey(0.5));
    assert!(loaded.warnings.iter().all(|w| !w.contains("outside")), "{:?}", loaded.warnings);
    let unknown = body.replace("vertex_color", "vertex_colour");
    let shown = folder.problems(&unknown);
    assert!(shown.contains("attribute `vertex_colour` of `a.ply`"), "{shown}");
    let cube = format!("<shape type='cube'>{bsdf}</shape>");
    assert!(folder.problems(&cube).contains("`mesh_attribute` on a shape `cube`"));
}

/// A grid of 2 x 2 x 2 signed distances from the plane x = 0.25, in one or more channels.
fn distances(channels: usize) -> Vec<u8> {
    let mut out = b"VOL\x03".to_vec();
    out.extend([1, 2, 2, 2, channels as i32].map(i32::to_le_bytes).concat());
    out.extend([0.0, 0.0, 0.0, 1.0, 1.0, 1.0f32].map(f32::to_le_bytes).concat());
    let values =
        (0..8 * channels).map(|k| if (k / channels).is_multiple_of(2) { -0.25f32 } else { 0.75 });
    out.extend(values.flat_map(f32::to_le_bytes));
    out
}

#[test]
fn a_grid_of_distances_becomes_a_mesh_in_the_transformed_unit_cube() {
    let folder = Folder::new();
    folder.write("plane.vol", distances(1));
    let body = "<shape type='sdfgrid'><string name='filename' value='plane.vol'/>
        <transform name='to_world'><scale x='4'/><translate y='1'/></transform></shape>";
    let loaded = folder.scene("3.0.0", body).unwrap();
    let Geometry::Mesh(mesh) = &loaded.parts.shapes[0].geometry else { panic!() };
    let bounds = mesh.bounds();
    let near = |a: Vec3, b: Vec3| (a - b).length() < 1e-5;
    assert!(
        near(bounds.min, Vec3::new(1.0, 1.0, 0.0)) && near(bounds.max, Vec3::new(1.0, 2.0, 1.0)),
        "{bounds:?}"
    );
    assert!(mesh.normals.iter().all(|n| near(*n, Vec3::X)), "away from the negative side");
    assert!(loaded.warnings.iter().any(|w| w.contains("`sdfgrid` is approximated by a mesh")));
    folder.write("colour.vol", distances(3));
    let shown = folder.scene("3.0.0", &body.replace("plane", "colour")).unwrap_err().to_string();
    assert!(shown.contains("the distances have three channels"), "{shown}");
}
