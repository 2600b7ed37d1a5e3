//! Lights whose intensity is a picture. The picture of the tests has 4 x 4 texels: red grows from left to right, green
//! downward, both from 0 to 0.75, and blue is 0.5.

use std::f32::consts::PI;
use std::sync::Arc;

use gi_core::light::LightSource;
use gi_core::math::Rgb;
use gi_core::scene::Scene;
use gi_core::texture::{Bitmap, Texture};
use glam::{Mat3, Vec3};

use super::*;

/// The scene of a light at the origin, with the picture of the tests.
fn lit_by(light: &str, version: &str) -> Scene {
    lit_by_picture(light, version, std::fs::read(path("picture.pfm")).unwrap())
}

fn lit_by_picture(light: &str, version: &str, picture: Vec<u8>) -> Scene {
    let folder = common::Folder::new();
    folder.write("picture.pfm", picture);
    let end = if version == "v3" { "WorldEnd" } else { "" };
    // Directives before the light end with a bar.
    let (before, light) = light.split_once('|').unwrap_or(("", light));
    let text = format!(
        "Camera \"perspective\"\nWorldBegin\n{before}LightSource {light}\n\
         Identity Translate 0 0 9\nShape \"disk\" \"float radius\" 3\n{end}\n"
    );
    let loaded = load(&folder.write("scene.pbrt", text), &Options::default());
    let loaded = loaded.unwrap_or_else(|problems| panic!("{problems}"));
    assert_eq!(warnings(&loaded).iter().filter(|w| w.contains("light")).count(), 0);
    Scene::new(loaded.parts).expect("a scene")
}

/// The intensity along a direction.
fn intensity(scene: &Scene, d: [f32; 3]) -> Rgb {
    const DISTANCE: f32 = 2.0;
    let p = DISTANCE * Vec3::from(d).normalize();
    scene.sample_light(p, [0.5; 2]).map_or(Rgb::BLACK, |s| s.radiance * DISTANCE.powi(2))
}

#[track_caller]
fn near(a: Rgb, b: [f32; 3]) {
    assert!(a.to_array().iter().zip(b).all(|(x, y)| (x - y).abs() <= 1e-4), "{a:?} is not {b:?}");
}

#[test]
fn a_projection_is_upright_and_not_mirrored() {
    let light = "\"projection\" \"string filename\" \"picture.pfm\" \"float scale\" 2";
    // pbrt's x runs to the right, and its field of view is 90 degrees.
    let scene = lit_by(light, "v4");
    near(intensity(&scene, [-0.75, 0.75, 1.0]), [0.0, 0.0, 1.0]);
    near(intensity(&scene, [0.75, 0.75, 1.0]), [1.5, 0.0, 1.0]);
    near(intensity(&scene, [-0.75, -0.75, 1.0]), [0.0, 1.5, 1.0]);
    near(intensity(&scene, [1.01, 0.0, 1.0]), [0.0; 3]);
    near(intensity(&scene, [0.1, 0.0, -1.0]), [0.0; 3]);
}

#[test]
fn a_projection_of_pbrt_v3_is_upside_down() {
    let light = "\"projection\" \"string mapname\" \"picture.pfm\" \"rgb I\" [1 2 4]";
    let scene = lit_by(light, "v3");
    let edge = 22.5f32.to_radians().tan();
    near(intensity(&scene, [-0.75 * edge, -0.75 * edge, 1.0]), [0.0, 0.0, 2.0]);
    near(intensity(&scene, [0.75 * edge, 0.75 * edge, 1.0]), [0.75, 1.5, 2.0]);
    near(intensity(&scene, [1.01 * edge, 0.0, 1.0]), [0.0; 3]);
}

#[test]
fn a_goniometric_light_is_bright_where_its_picture_is() {
    let light = "\"goniometric\" \"string filename\" \"picture.pfm\" \"rgb I\" [1 2 4]";
    // The picture's centre is at +y, its corners are at -y. The mean of a texel's colours counts.
    let scene = lit_by(light, "v4");
    let expected = |mean: f32| [mean, 2.0 * mean, 4.0 * mean];
    near(intensity(&scene, [0.2, 1.0, -0.1]), expected((0.5 + 0.25 + 0.5) / 3.0));
    near(intensity(&scene, [-0.2, -1.0, -0.1]), expected(0.5 / 3.0));
    near(intensity(&scene, [0.2, -1.0, 0.1]), expected((0.75 + 0.75 + 0.5) / 3.0));
}

/// In pbrt-v3 the picture has colours. Its columns are longitudes and its rows latitudes, with +y at the top.
#[test]
fn a_goniometric_light_of_pbrt_v3_has_a_picture_of_latitudes() {
    let scene = lit_by("\"goniometric\" \"string mapname\" \"picture.pfm\"", "v3");
    // The centres of texels: the value between them is interpolated.
    for (column, row) in (0..4).flat_map(|column| (0..4).map(move |row| (column, row))) {
        let [u, v] = [column, row].map(|k| (k as f32 + 0.5) / 4.0);
        let ((z, x), (side, y)) = ((2.0 * PI * u).sin_cos(), (PI * v).sin_cos());
        let d = [side * x, y, side * z];
        near(intensity(&scene, d), [0.25 * column as f32, 0.25 * row as f32, 0.5]);
    }
    // Rows that are narrower than those of a square of the same width count too.
    let rows = |k: usize| if k == 30 || k == 31 { 1.0f32 } else { 0.0 };
    let texels = (0..64).rev().flat_map(|k| [rows(k); 12]).flat_map(f32::to_le_bytes);
    let picture = b"PF\n4 64\n-1.0\n".iter().copied().chain(texels).collect();
    let scene = lit_by_picture("\"goniometric\" \"string mapname\" \"picture.pfm\"", "v3", picture);
    assert!(intensity(&scene, [1.0, 0.05, 0.3]).r > 0.9);
}

#[test]
fn a_scaled_or_sheared_transform_stretches_the_window_of_a_projection() {
    let light = "\"projection\" \"string filename\" \"picture.pfm\" \"float fov\" 60";
    let plain = lit_by(light, "v4");
    let shear = "Transform [1 0 0 0  0.5 1 0 0  0 0 1 0  0 0 0 1] |";
    for (change, image) in [
        ("Scale 2 1 1 |", [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        ("Scale 1 1 2 |", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]]),
        ("Scale 3 3 3 |", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        (shear, [[1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    ] {
        let changed = lit_by(&format!("{change}{light}"), "v4");
        let image = Mat3::from_cols_array_2d(&image);
        for k in 0..64 {
            let at = |n: i32| 0.6 * ((n as f32 + 0.5) / 4.0 - 1.0);
            let d = Vec3::new(at(k % 8), at(k / 8), 1.0);
            let expected = intensity(&plain, d.to_array()).to_array();
            near(intensity(&changed, (image * d).to_array()), expected);
        }
    }
}

#[test]
fn a_transform_that_flattens_the_picture_of_a_light_is_refused() {
    let light = "Scale 0 1 1\nLightSource \"projection\" \"string filename\" \"picture.pfm\"\n";
    let folder = common::Folder::new();
    folder.write("picture.pfm", std::fs::read(path("picture.pfm")).unwrap());
    let text = format!("Camera \"perspective\"\nWorldBegin\n{light}Identity\nShape \"disk\"\n");
    let problems = load(&folder.write("scene.pbrt", text), &Options::default()).unwrap_err();
    assert!(problems.to_string().contains("invert"), "{problems}");
}

#[test]
fn goniometric_lights_share_their_picture() {
    let light = "LightSource \"goniometric\" \"string filename\" \"picture.pfm\"\n";
    let loaded = {
        let folder = common::Folder::new();
        folder.write("picture.pfm", std::fs::read(path("picture.pfm")).unwrap());
        let text = format!("Camera \"perspective\"\nWorldBegin\n{light}{light}Shape \"disk\"\n");
        load(&folder.write("scene.pbrt", text), &Options::default()).unwrap()
    };
    let pictures: Vec<&Arc<Bitmap>> = (loaded.parts.lights.iter())
        .map(|light| match light {
            LightSource::Projector { picture: Texture::Bitmap { bitmap, .. }, .. } => bitmap,
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(Arc::ptr_eq(pictures[0], pictures[1]));
}

#[test]
fn a_picture_at_infinity_of_pbrt_v3_has_the_colour_of_l() {
    let folder = common::Folder::new();
    folder.write("picture.pfm", std::fs::read(path("picture.pfm")).unwrap());
    let text = "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\" \"rgb L\" [4 2 1]\n\
        \"string mapname\" \"picture.pfm\"\nShape \"disk\"\nWorldEnd\n";
    let loaded = load(&folder.write("scene.pbrt", text), &Options::default()).unwrap();
    let LightSource::Environment { image, scale, .. } = &loaded.parts.lights[0] else { panic!() };
    near(image.texel(3, 3) * *scale, [3.0, 1.5, 0.5]);
}

#[test]
fn a_picture_at_infinity_that_is_twice_as_wide_as_high_is_no_square() {
    let folder = common::Folder::new();
    let texels = [1.0f32; 8 * 4 * 3].map(f32::to_le_bytes).concat();
    folder.write("wide.pfm", [b"PF\n8 4\n-1.0\n".as_slice(), &texels].concat());
    let text = "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\" \"string filename\" \"wide.pfm\"\n\
        Shape \"disk\"\n";
    let loaded = load(&folder.write("scene.pbrt", text), &Options::default()).unwrap();
    let LightSource::Environment { image, .. } = &loaded.parts.lights[0] else { panic!() };
    assert_eq!([image.width(), image.height()], [8, 4]);
    assert!(warnings(&loaded)[0].contains("latitude"), "{:?}", loaded.warnings);
}

/// The luminance over all directions, from 200,000 directions that are evenly spread. The loader takes a texel's direction at its
/// centre, as pbrt-v4 does, so the picture is finer than that of the other tests.
#[test]
fn the_power_of_a_pictured_light_is_that_which_the_file_gives() {
    let mut picture = b"PF\n64 64\n-1.0\n".to_vec();
    for k in 0..64 * 64 {
        let texel = [(k % 64) as f32 / 64.0, (k / 64) as f32 / 64.0, 0.5];
        picture.extend(texel.iter().flat_map(|v| v.to_le_bytes()));
    }
    for kind in ["projection", "goniometric"] {
        let light = format!("\"{kind}\" \"string filename\" \"picture.pfm\" \"float power\" 3");
        let scene = lit_by_picture(&light, "v4", picture.clone());
        let n = 200_000;
        let luminance = |k: usize| {
            let u = [(k as f32 + 0.5) / n as f32, (k as f32 * 0.618_034).fract()];
            f64::from(intensity(&scene, gi_core::warp::sphere(u).to_array()).luminance())
        };
        let power = (0..n).map(luminance).sum::<f64>() / n as f64 * 4.0 * std::f64::consts::PI;
        // The border of a window cuts through about 0.2 % of the directions that fall into it.
        assert!((power / 3.0 - 1.0).abs() < 2e-3, "{kind}: {power}");
    }
}

/// Mitsuba's projector has the irradiance as its picture. The two agree at the centres of the texels.
#[test]
fn an_exported_projection_is_a_projector_with_the_same_filter() {
    let folder = common::Folder::new();
    folder.write("picture.pfm", std::fs::read(path("picture.pfm")).unwrap());
    let light = "LightSource \"projection\" \"string filename\" \"picture.pfm\" \"float fov\" 70";
    let text =
        format!("Camera \"perspective\"\nWorldBegin\n{light}\nTranslate 0 0 9\nShape \"disk\"\n");
    let [scene, exported] = [folder.write("scene.pbrt", text), folder.path("out.xml")];
    gi_scene::export_mitsuba(&scene, &Options::default(), &exported).unwrap();
    let [before, after] = [scene, exported].map(|file| {
        let loaded = load(&file, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
        Scene::new(loaded.parts).expect("a scene")
    });
    // The exported picture has 512 texels along a side.
    let half = 35f32.to_radians().tan();
    for k in 0..900 {
        let at = |n: i32| half * ((n as f32 + 0.5) / 15.0 - 1.0);
        let d = [at(k % 30), at(k / 30), 1.0];
        let [a, b] = [&before, &after].map(|scene| intensity(scene, d));
        let same = |x: f32, y: f32| (x - y).abs() < 4e-3 * x.max(1e-2);
        assert!(same(a.r, b.r) && same(a.g, b.g) && same(a.b, b.b), "{d:?}: {a:?} {b:?}");
    }
}

#[test]
fn a_picture_that_is_no_square_is_no_goniometric_light() {
    let folder = common::Folder::new();
    folder.write("wide.pfm", [b"PF\n2 1\n-1.0\n".as_slice(), &[0; 24]].concat());
    let light = "Camera \"perspective\"\nWorldBegin\nShape \"disk\"\n\
        LightSource \"goniometric\" \"string filename\" \"wide.pfm\"\n";
    let problems = load(&folder.write("scene.pbrt", light), &Options::default()).unwrap_err();
    let shown = problems.to_string();
    assert!(shown.contains("2 x 1 pixels") && shown.contains("expected a square"), "{shown}");
}
