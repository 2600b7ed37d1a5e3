//! Cameras, from the scene and from the command line.

use super::*;

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
