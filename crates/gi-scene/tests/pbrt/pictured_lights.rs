//! Lights whose intensity is a picture. The picture of the tests has 4 x 4 texels: red grows from left to right, green
//! downward, both from 0 to 0.75, and blue is 0.5.

use gi_core::math::Rgb;
use gi_core::scene::Scene;
use glam::Vec3;

use super::*;

/// The scene of a light at the origin, with the picture of the tests.
fn lit_by(light: &str, version: &str) -> Scene {
    lit_by_picture(light, version, std::fs::read(path("picture.pfm")).unwrap())
}

fn lit_by_picture(light: &str, version: &str, picture: Vec<u8>) -> Scene {
    let folder = common::Folder::new();
    folder.write("picture.pfm", picture);
    let end = if version == "v3" { "WorldEnd" } else { "" };
    let text = format!(
        "Camera \"perspective\"\nWorldBegin\nLightSource {light}\n\
         Translate 0 0 9\nShape \"disk\" \"float radius\" 3\n{end}\n"
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
    // In pbrt-v3 it is a picture of latitude and longitude in colour, with +y at its top.
    let light = "\"goniometric\" \"string mapname\" \"picture.pfm\"";
    let scene = lit_by(light, "v3");
    near(intensity(&scene, [0.2, 1.0, 0.1]), [0.0, 0.0, 0.5]);
    near(intensity(&scene, [0.2, 1.0, -0.1]), [0.75, 0.0, 0.5]);
    near(intensity(&scene, [-0.2, -1.0, 0.1]), [0.25, 0.75, 0.5]);
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
    let half = 35f32.to_radians().tan();
    for k in 0..16 {
        let at = |n: i32| half * ((n as f32 + 0.5) / 2.0 - 1.0);
        // Off the centre, the colour is the same. Interpolation would give another.
        let shift = 0.2 * half / 4.0;
        let centre = intensity(&before, [at(k % 4), at(k / 4), 1.0]);
        near(intensity(&after, [at(k % 4), at(k / 4), 1.0]), centre.to_array());
        let aside = [at(k % 4) + shift, at(k / 4) + shift, 1.0];
        let [a, b] = [&before, &after].map(|scene| intensity(scene, aside));
        let same = |x: f32, y: f32| (x / a.b - y / b.b).abs() < 1e-4;
        assert!(same(a.r, b.r) && same(a.g, b.g), "{a:?} {b:?}");
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
