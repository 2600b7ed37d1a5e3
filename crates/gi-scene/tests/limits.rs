//! Invalid numbers: each one is refused, or corrected with a warning.

mod common;

use common::{Folder, scene};
use gi_core::texture::Texture;
use gi_scene::{CameraOverride, Options, load};
use glam::{Affine3A, Vec3};

/// The errors of a scene with this body.
fn problems(body: &str) -> String {
    Folder::new().problems(body)
}

/// Check that loading fails with `message` and `expected`.
fn refused(body: &str, message: &str, expected: &str) {
    let shown = problems(body);
    assert!(shown.contains(message) && shown.contains(expected), "{body}\n{shown}");
    assert!(shown.contains("scene.xml:2:"), "{shown}");
}

fn bsdf(kind: &str, inner: &str) -> String {
    format!("<shape type='rectangle'><bsdf type='{kind}'>{inner}</bsdf></shape>")
}

fn float(name: &str, value: &str) -> String {
    format!("<float name='{name}' value='{value}'/>")
}

/// A PFM of one row.
fn pfm(texels: &[[f32; 3]]) -> Vec<u8> {
    let mut out = format!("PF\n{} 1\n-1.0\n", texels.len()).into_bytes();
    out.extend(texels.iter().flatten().flat_map(|v| v.to_le_bytes()));
    out
}

const SENSOR: &str = "<sensor type='perspective'/>";
const NAN: [f32; 3] = [1.0, f32::NAN, 1.0];

#[test]
fn a_size_from_the_command_line_gives_no_false_warnings_about_the_film() {
    let scenes = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut count = 0;
    for entry in std::fs::read_dir(scenes).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "xml") {
            continue;
        }
        let options = Options { size: Some([32, 20]), ..Options::default() };
        let loaded = load(&path, &options).unwrap();
        assert_eq!(loaded.camera.size, [32, 20]);
        let plain = load(&path, &Options::default()).unwrap();
        assert_eq!(loaded.warnings, plain.warnings);
        assert!(loaded.warnings.iter().all(|w| !w.contains("hdrfilm")), "{:?}", loaded.warnings);
        count += 1;
    }
    assert!(count > 0);
}

#[test]
fn a_size_from_the_command_line_does_not_hide_errors_of_the_film() {
    let folder = Folder::new();
    let text = "<scene version='3.0.0'><sensor type='perspective'><film type='hdrfilm'>
        <integer name='width' value='0'/></film></sensor><shape type='sphere'/></scene>";
    let options = Options { size: Some([8, 8]), ..Options::default() };
    let shown = load(&folder.write("a.xml", text), &options).unwrap_err().to_string();
    assert!(shown.contains("a film of 0 x 576"), "{shown}");
}

#[test]
fn a_texel_that_is_not_finite_is_named_with_its_file() {
    let picture = "<string name='filename' value='bad.pfm'/>";
    let bodies = [
        bsdf("diffuse", &format!("<texture name='reflectance' type='bitmap'>{picture}</texture>")),
        format!("<emitter type='envmap'>{picture}</emitter>"),
        format!(
            "<shape type='sphere'><emitter type='area'>\
             <texture name='radiance' type='bitmap'>{picture}</texture></emitter></shape>"
        ),
    ];
    for body in bodies {
        let folder = Folder::new();
        folder.write("bad.pfm", pfm(&[[0.5; 3], NAN]));
        let shown = folder.problems(&body);
        assert!(
            shown.contains("cannot read `bad.pfm`: texel (1, 0) is not finite: 1 NaN 1"),
            "{shown}"
        );
    }
}

#[test]
fn negative_texels_of_light_become_zero_with_a_warning() {
    let folder = Folder::new();
    folder.write("neg.pfm", pfm(&[[0.5; 3], [1.0, -1.0, 2.0]]));
    let picture = "<string name='filename' value='neg.pfm'/>";
    let body = format!(
        "<shape type='sphere'><emitter type='area'>\
         <texture name='radiance' type='bitmap'>{picture}</texture></emitter></shape>\
         <emitter type='envmap'>{picture}</emitter>"
    );
    let loaded = folder.scene("3.0.0", &body).unwrap();
    let noted = loaded.warnings.iter().filter(|w| w.contains("texel (1, 0)")).count();
    assert!(noted > 0, "{:?}", loaded.warnings);
    let Some(Texture::Bitmap { bitmap, .. }) = &loaded.parts.shapes[0].emission else { panic!() };
    assert_eq!(bitmap.texel(1, 0).to_array(), [1.0, 0.0, 2.0]);
    let gi_core::light::LightSource::Environment { image, .. } = &loaded.parts.lights[0] else {
        panic!()
    };
    assert_eq!(image.texel(1, 0).to_array(), [1.0, 0.0, 2.0]);
}

#[test]
fn a_reflectance_picture_above_one_gives_one_warning() {
    let folder = Folder::new();
    folder.write("two.pfm", pfm(&[[0.5; 3], [1.0, 2.0, 2.0]]));
    let body = bsdf(
        "diffuse",
        "<texture name='reflectance' type='bitmap'><string name='filename' value='two.pfm'/></texture>",
    );
    let loaded = folder.scene("3.0.0", &format!("{SENSOR}{body}")).unwrap();
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    assert!(loaded.warnings[0].contains("outside [0, 1]: 0.5 to 2"), "{:?}", loaded.warnings);
}

#[test]
fn a_filter_of_zero_or_huge_width_is_refused() {
    let film = |filter: &str| {
        format!(
            "<sensor type='perspective'><film type='hdrfilm'>{filter}</film></sensor>\
             <shape type='sphere'/>"
        )
    };
    for stddev in ["0", "1e-40", "-1", "4.5", "1e10"] {
        let filter = format!("<rfilter type='gaussian'>{}</rfilter>", float("stddev", stddev));
        refused(&film(&filter), "stddev", "expected more than 0 and at most 4");
    }
    for name in ["b", "c", "B"] {
        let filter = format!("<rfilter type='mitchell'>{}</rfilter>", float(name, "11"));
        refused(&film(&filter), &format!("{} 11", name.to_lowercase()), "expected -10 to 10");
    }
    for lobes in ["0", "-1", "9"] {
        let filter =
            format!("<rfilter type='lanczos'><integer name='lobes' value='{lobes}'/></rfilter>");
        refused(&film(&filter), &format!("lobes {lobes}"), "expected 1 to 8");
    }
}

#[test]
fn negative_light_is_refused() {
    let lights = [
        "<emitter type='point'><rgb name='intensity' value='1 -1 1'/></emitter>",
        "<emitter type='spot'><float name='intensity' value='-1'/></emitter>",
        "<emitter type='constant'><spectrum name='radiance' value='-1'/></emitter>",
        "<emitter type='constant'><spectrum name='radiance' value='400:-1 600:1'/></emitter>",
        "<emitter type='directional'><rgb name='irradiance' value='-1'/></emitter>",
        "<emitter type='sunsky'><float name='scale' value='-1'/></emitter>",
        "<shape type='sphere'><emitter type='area'><rgb name='radiance' value='-1'/></emitter></shape>",
        "<emitter type='constant'><spectrum type='d65' name='radiance'><float name='scale' value='-2'/></spectrum></emitter>",
    ];
    for light in lights {
        refused(light, "light cannot be negative", "expected 0 or more");
    }
}

#[test]
fn light_of_one_wavelength_is_not_refused_as_negative() {
    for light in ["480:0 490:1 500:0", "690:0 700:1 710:0"] {
        let body = format!(
            "<emitter type='constant'><spectrum name='radiance' value='{light}'/></emitter>"
        );
        scene(&body);
    }
}

#[test]
fn numbers_that_would_overflow_later_are_refused() {
    refused(&bsdf("bumpmap", &float("scale", "2e15")), "too large", "a number");
    let moved = "<transform name='to_world'><scale value='1e10'/><scale value='1e10'/></transform>";
    refused(&format!("<shape type='cube'>{moved}</shape>"), "product is too large", "1e15");
    refused(
        "<emitter type='point'><rgb name='intensity' value='1e16'/></emitter>",
        "too large",
        "number",
    );
}

#[test]
fn parameters_of_materials_outside_their_range_are_refused() {
    for (kind, name, value) in [
        ("dielectric", "int_ior", "1e10"),
        ("plastic", "int_ior", "0.01"),
        ("thindielectric", "ext_ior", "100"),
    ] {
        refused(&bsdf(kind, &float(name, value)), "inside / outside", "expected 0.1 to 10");
    }
    for kind in ["roughconductor", "roughdielectric", "roughplastic"] {
        refused(&bsdf(kind, &float("alpha", "-0.1")), "`alpha` is -0.1", "expected 0 to 10");
        refused(&bsdf(kind, &float("alpha", "11")), "`alpha` is 11", "expected 0 to 10");
        scene(&bsdf(kind, &float("alpha", "2")));
    }
    refused(&bsdf("phong", &float("exponent", "-1")), "`exponent` is -1", "0 or more");
}

#[test]
fn fractions_outside_zero_to_one_and_huge_exponents_are_clamped_with_a_warning() {
    let two = "<bsdf type='diffuse'/><bsdf type='null'/>";
    let bodies = [
        bsdf("mask", &format!("{}<bsdf type='diffuse'/>", float("opacity", "1.5"))),
        bsdf("blendbsdf", &format!("{}{two}", float("weight", "-1"))),
        bsdf("phong", &float("exponent", "1e9")),
    ];
    for body in bodies {
        let loaded = scene(&format!("{SENSOR}{body}"));
        assert_eq!(loaded.warnings.len(), 1, "{body} {:?}", loaded.warnings);
    }
}

#[test]
fn parameters_of_cameras_and_skies_outside_their_range_are_refused() {
    let lens =
        |inner: &str| format!("<sensor type='thinlens'>{inner}</sensor><shape type='sphere'/>");
    refused(&lens(&float("aperture_radius", "-1")), "aperture_radius -1", "0 or more");
    refused(&lens(&float("near_clip", "-1")), "near_clip -1", "0 or more");
    let focus = float("aperture_radius", "1") + &float("focus_distance", "0");
    refused(&lens(&focus), "focus_distance 0", "more than 0");
    let sky = |inner: &str| format!("<emitter type='sunsky'>{inner}</emitter>");
    refused(&sky(&float("albedo", "1.5")), "albedo is 1.5", "0 to 1");
    refused(&sky(&float("sun_radius_scale", "-1")), "sun_radius_scale -1", "0 or more");
}

fn with_camera(camera: CameraOverride) -> Result<gi_scene::Loaded, String> {
    let folder = Folder::new();
    let path = folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let options = Options { camera, ..Options::default() };
    load(&path, &options).map_err(|e| e.to_string())
}

#[test]
fn an_invalid_camera_on_the_command_line_is_refused() {
    let none = CameraOverride::default();
    for fov in [0.0, -5.0, 180.0, f32::NAN] {
        let shown = with_camera(CameraOverride { fov: Some(fov), ..none }).unwrap_err();
        assert!(shown.contains("--fov"), "{shown}");
    }
    for bad in [Vec3::splat(f32::NAN), Vec3::splat(f32::INFINITY), Vec3::splat(1e13)] {
        for camera in [
            CameraOverride { origin: Some(bad), ..none },
            CameraOverride { target: Some(bad), ..none },
            CameraOverride { up: Some(bad), ..none },
        ] {
            assert!(with_camera(camera).unwrap_err().contains("expected finite numbers"));
        }
    }
    let narrow = CameraOverride { fov: Some(1e-38), ..none };
    assert!(with_camera(narrow).unwrap_err().contains("a wider --fov"));
    let same = CameraOverride { origin: Some(Vec3::ONE), target: Some(Vec3::ONE), ..none };
    assert!(with_camera(same).unwrap_err().contains("looks at itself"));
    assert!(with_camera(CameraOverride { up: Some(Vec3::ZERO), ..none }).is_err());
    let along = CameraOverride { up: Some(Vec3::Z), ..none };
    assert!(with_camera(along).unwrap_err().contains("is parallel to the view"));
    let above = CameraOverride { origin: Some(Vec3::Y), target: Some(Vec3::ZERO), ..none };
    let seen = with_camera(above).unwrap();
    assert!(seen.warnings[0].contains("looks along y"), "{:?}", seen.warnings);
    assert!(seen.camera.to_world.is_finite());
}

#[test]
fn the_command_line_moves_turns_and_zooms_the_camera_of_a_scene() {
    let folder = Folder::new();
    // A mirrored and scaled sensor, as exporters write them.
    let text = "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='30'/>
        <transform name='to_world'><scale x='-2' y='2' z='2'/>
        <lookat origin='1 2 5' target='0 0 0' up='0 1 0'/></transform></sensor>
        <shape type='sphere'/></scene>";
    let path = folder.write("a.xml", text);
    let seen =
        |camera| load(&path, &Options { camera, ..Options::default() }).map_err(|e| e.to_string());
    let none = CameraOverride::default();
    let own = seen(none).unwrap().camera;
    let near = |a: Affine3A, b: Affine3A| assert!(a.abs_diff_eq(b, 1e-5), "{a} is not {b}");
    // Repeating the scene's own values changes nothing.
    let [origin, target] = [Vec3::new(1.0, 2.0, 5.0), Vec3::ZERO].map(Some);
    let same = CameraOverride { origin, target, up: Some(Vec3::Y), fov: Some(30.0) };
    let same = seen(same).unwrap().camera;
    near(same.to_world, own.to_world);
    assert_eq!(same.projection, own.projection);
    // An origin alone keeps the directions; a target alone keeps the position.
    let moved = seen(CameraOverride { origin: Some(Vec3::ONE), ..none }).unwrap().camera.to_world;
    near(moved, Affine3A { translation: Vec3::ONE.into(), ..own.to_world });
    let turned = seen(CameraOverride { target: Some(Vec3::X), ..none }).unwrap().camera.to_world;
    assert_eq!(turned.translation, own.to_world.translation);
    let view = Vec3::from(turned.matrix3.z_axis).normalize();
    assert!(view.abs_diff_eq(Vec3::new(0.0, -2.0, -5.0).normalize(), 1e-6), "{view}");
    assert!((turned.matrix3.determinant() - own.to_world.matrix3.determinant()).abs() < 1e-4);
    let here = CameraOverride { target: Some(Vec3::new(1.0, 2.0, 5.0)), ..none };
    assert!(seen(here).unwrap_err().contains("is the position of the camera"));
    assert!(seen(CameraOverride { fov: Some(200.0), ..none }).unwrap_err().contains("--fov"));
}

#[test]
fn a_camera_moved_to_look_straight_down_needs_no_other_up() {
    let folder = Folder::new();
    let text = "<scene version='3.0.0'><sensor type='perspective'>
        <transform name='to_world'><lookat origin='0 1 5' target='0 1 0' up='0 1 0'/></transform></sensor>
        <shape type='sphere'/></scene>";
    let path = folder.write("a.xml", text);
    let camera = CameraOverride {
        origin: Some(Vec3::new(0.0, 9.0, 0.0)),
        target: Some(Vec3::ZERO),
        ..CameraOverride::default()
    };
    let loaded = load(&path, &Options { camera, ..Options::default() }).unwrap();
    let axes = loaded.camera.to_world.matrix3;
    assert!(Vec3::from(axes.z_axis).abs_diff_eq(Vec3::NEG_Y, 1e-6), "{axes}");
    // The old viewing direction is up in the picture.
    assert!(Vec3::from(axes.y_axis).abs_diff_eq(Vec3::NEG_Z, 1e-6), "{axes}");
    assert!(loaded.warnings.iter().any(|w| w.contains("--up changes that")));
    // The same up direction is an error if the command line gives it.
    let camera = CameraOverride { up: Some(Vec3::Y), ..camera };
    let refused = load(&path, &Options { camera, ..Options::default() }).unwrap_err().to_string();
    assert!(refused.contains("--up 0,1,0 is parallel to the view"), "{refused}");
}

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

#[test]
fn unsupported_wrap_modes_give_a_warning() {
    let warnings = |modes: &str| {
        let folder = Folder::new();
        folder.write("a.pfm", pfm(&[[0.5; 3]]));
        let body = format!(
            "{SENSOR}<shape type='sphere'><bsdf type='diffuse'><texture type='bitmap' \
             name='reflectance'><string name='filename' value='a.pfm'/>{modes}</texture></bsdf></shape>"
        );
        folder.scene("3.0.0", &body).unwrap().warnings
    };
    let mode = |name: &str, mode: &str| format!("<string name='{name}' value='{mode}'/>");
    for border in ["zero", "one", "black", "white"] {
        let shown = warnings(&mode("wrap_mode", border));
        assert!(shown[0].contains(&format!("`{border}` is read as `clamp`")), "{shown:?}");
    }
    let two = |u: &str, v: &str| mode("wrap_mode_u", u) + &mode("wrap_mode_v", v);
    assert!(warnings(&two("clamp", "mirror"))[0].contains("along v is ignored"));
    assert!(warnings(&two("clamp", "clamp")).is_empty());
    assert!(warnings(&mode("wrap_mode", "mirror")).is_empty());
}

#[test]
fn a_flat_instance_gives_a_warning() {
    let body = format!(
        "{SENSOR}<shape type='shapegroup' id='g'><shape type='cube'/></shape>\
         <shape type='instance'><ref id='g'/><transform name='to_world'><scale value='1 1 0'/>\
         </transform></shape>"
    );
    let shown = scene(&body).warnings;
    assert!(shown[0].contains("the instance is flat"), "{shown:?}");
}

#[test]
fn an_environment_with_a_huge_scale_is_refused() {
    let folder = Folder::new();
    folder.write("a.pfm", pfm(&[[1e10; 3]]));
    let body = format!(
        "<emitter type='envmap'><string name='filename' value='a.pfm'/>{}</emitter>",
        float("scale", "1e10")
    );
    let shown = folder.problems(&body);
    assert!(shown.contains("`scale` is too large"), "{shown}");
}

#[test]
fn a_library_with_negative_light_or_an_invalid_index_is_refused() {
    let folder = Folder::new();
    let obj = "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let path = folder.write("a.obj", obj);
    for (line, shown) in [
        ("Ke 1 -1 1", "material `m`: light `Ke 1 -1 1`: expected 0 to 1e15"),
        ("illum 4\nNi 100", "material `m`: `Ni 100`: expected 0.1 to 10"),
    ] {
        folder.write("a.mtl", format!("newmtl m\n{line}\n"));
        let problems = load(&path, &Options::default()).unwrap_err().to_string();
        assert!(problems.contains(shown), "{problems}");
    }
}
