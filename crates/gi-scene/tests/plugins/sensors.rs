//! Sensors, films, and the choice among several sensors.

use gi_core::camera::Camera;
use gi_scene::{Options, load};

use super::*;

#[test]
fn sensors_see_the_same_as_in_mitsuba() {
    let fov = |inner: &str| {
        let film = "<film type='hdrfilm'><integer name='width' value='300'/><integer name='height' value='200'/></film>";
        let loaded = scene(&format!("<sensor type='perspective'>{inner}{film}</sensor>"));
        let Projection::Perspective { fov_x, .. } = loaded.camera.projection else { panic!() };
        fov_x.to_degrees()
    };
    // Values from Mitsuba 3.9.1.
    let along = |axis: &str| {
        fov(&format!("<float name='fov' value='40'/><string name='fov_axis' value='{axis}'/>"))
    };
    let got = ["x", "y", "diagonal", "smaller", "larger"].map(along);
    for (g, want) in got.into_iter().zip([40.0, 57.265_14, 33.696_98, 57.265_14, 40.0]) {
        assert!((g - want).abs() < 1e-3, "{got:?}");
    }
    let plain = scene("<sensor type='perspective'/>");
    assert_eq!((plain.camera.size, plain.filter), ([768, 576], Filter::Gaussian { stddev: 0.5 }));
    let Projection::Perspective { fov_x, .. } = plain.camera.projection else { panic!() };
    assert!((fov_x.to_degrees() - 38.1848).abs() < 1e-3);
    let lens =
        scene("<sensor type='perspective'><string name='focal_length' value='35mm'/></sensor>");
    let Projection::Perspective { fov_x, .. } = lens.camera.projection else { panic!() };
    assert!((fov_x.to_degrees() - 52.622_54).abs() < 1e-3);
}

#[test]
fn a_crop_shows_its_part_of_the_film() {
    let camera = |sensor: &str, crop: &str| {
        let film = format!(
            "<film type='hdrfilm'><integer name='width' value='30'/><integer name='height' value='20'/>{crop}</film>"
        );
        let loaded = scene(&format!(
            "<sensor type='{sensor}'><float name='principal_point_offset_x' value='0.1'/>
             <transform name='to_world'><scale value='2'/><rotate y='1' angle='30'/></transform>{film}</sensor><shape type='cube'/>"
        ));
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        Camera::new(&loaded.camera)
    };
    let integer = |name: &str, v: u32| format!("<integer name='{name}' value='{v}'/>");
    let crop = integer("crop_offset_x", 12)
        + &integer("crop_offset_y", 3)
        + &integer("crop_width", 8)
        + &integer("crop_height", 15);
    for sensor in ["perspective", "orthographic"] {
        let (whole, part) = (camera(sensor, ""), camera(sensor, &crop));
        assert_eq!(part.size(), [8, 15]);
        for [x, y] in [[0.0, 0.0], [8.0, 15.0], [2.5, 9.0]] {
            let (a, b) = (whole.ray([x + 12.0, y + 3.0], [0.5; 2]), part.ray([x, y], [0.5; 2]));
            assert!(
                (a.o - b.o).length() < 1e-5 && (a.d - b.d).length() < 1e-5,
                "{sensor}: {a:?} {b:?}"
            );
        }
    }
}

#[test]
fn a_crop_outside_the_film_is_an_error() {
    let shown = common::Folder::new().problems(
        "<sensor type='perspective'><film type='hdrfilm'><integer name='width' value='30'/>
         <integer name='crop_offset_x' value='20'/><integer name='crop_width' value='11'/></film></sensor>",
    );
    assert!(
        shown.contains("a crop of 11 x 576 pixels from (20, 0) of a film of 30 x 576"),
        "{shown}"
    );
}

#[test]
fn one_of_several_sensors_can_be_chosen() {
    let film = "<film type='hdrfilm'/>";
    let text = format!(
        "<scene version='3.0.0'><sensor type='orthographic'>{film}</sensor>
         <sensor type='perspective'><film type='hdrfilm'><integer name='width' value='7'/></film></sensor>
         <shape type='cube'/></scene>"
    );
    let folder = common::Folder::new();
    let path = folder.write("a.xml", text);
    let choose = |sensor| load(&path, &Options { sensor, ..Options::default() });
    let first = choose(None).unwrap();
    assert_eq!(first.camera.projection, Projection::Orthographic);
    assert!(first.warnings[0].contains("--sensor 1"), "{:?}", first.warnings);
    let second = choose(Some(1)).unwrap();
    assert_eq!((second.camera.size[0], second.warnings.len()), (7, 0));
    let shown = choose(Some(2)).unwrap_err().to_string();
    assert!(shown.contains("--sensor 2: the scene has 2 sensors, numbered 0 to 1"), "{shown}");
}
