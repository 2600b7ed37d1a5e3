//! Lights, media and colours.

use gi_core::geometry::Geometry;
use gi_core::light::{LightSource, Window};
use gi_core::material::Material;
use gi_core::math::Rgb;
use gi_core::medium::Phase;
use gi_core::texture::Texture;
use glam::{Vec2, Vec3};

use super::*;

#[track_caller]
fn near(a: Rgb, b: [f32; 3]) {
    let close = a.to_array().iter().zip(b).all(|(x, y)| (x - y).abs() <= 1e-3 * (1.0 + y.abs()));
    assert!(close, "{a:?} is not {b:?}");
}

#[test]
fn all_lights_are_read() {
    let loaded = scene("lights.pbrt");
    let lights = &loaded.parts.lights;
    assert_eq!(lights.len(), 8);
    let LightSource::Point { position, intensity } = &lights[0] else { panic!() };
    assert_eq!(*position, Vec3::new(1.0, 1.0, 0.0));
    near(*intensity, [2.0, 4.0, 6.0]);
    let LightSource::Point { intensity, .. } = &lights[1] else { panic!() };
    near(*intensity, [1.0; 3]);
    let LightSource::Spot { position, direction, cutoff, beam, .. } = &lights[2] else { panic!() };
    assert!((*position - Vec3::new(0.0, 3.0, -1.0)).length() < 1e-6, "{position}");
    assert!((*direction + Vec3::Z).length() < 1e-6, "{direction}");
    assert!((cutoff.to_degrees() - 40.0).abs() < 1e-4 && (beam.to_degrees() - 30.0).abs() < 1e-4);
    let LightSource::Directional { direction, irradiance } = &lights[3] else { panic!() };
    assert!((*direction - Vec3::new(0.0, -0.6, -0.8)).length() < 1e-6);
    near(*irradiance, [2.0; 3]);
    let LightSource::Constant { radiance } = &lights[4] else { panic!() };
    near(*radiance, [0.5, 1.0, 1.5]);
    let LightSource::Point { intensity, .. } = &lights[5] else { panic!() };
    near(*intensity, [3.0; 3]);
    let notes = warnings(&loaded).join("\n");
    assert!(notes.contains("`goniometric` without a `filename`"), "{notes}");
    let windows = lights[6..].iter().map(|light| match light {
        LightSource::Projector { window, .. } => *window,
        other => panic!("{other:?}"),
    });
    assert_eq!(windows.collect::<Vec<_>>(), [Window::Intensity(Vec2::ONE), Window::Unfolded]);
}

#[test]
fn surfaces_emit_what_pbrt_says() {
    let loaded = scene("area-lights.pbrt");
    let emission = |n: usize| loaded.parts.shapes[n].emission.as_ref();
    let constant = |n: usize| match emission(n) {
        Some(Texture::Constant(c)) => *c,
        other => panic!("{other:?}"),
    };
    assert!(emission(0).is_none());
    near(constant(1), [2.0, 4.0, 6.0]);
    near(constant(2), [0.25; 3]);
    let warm = constant(3);
    assert!((warm.luminance() - 5.0).abs() < 1e-2 && warm.r > 2.0 * warm.b, "{warm:?}");
    // Two sheets back to back emit from both sides of a disk.
    let sheets = &loaded.parts.shapes[4..6];
    assert_eq!(sheets.iter().map(|s| s.flip_normals).collect::<Vec<_>>(), [false, true]);
    let z = |s: &Shape| match s.geometry {
        Geometry::Disk { center, .. } => center.z,
        _ => panic!(),
    };
    assert!(z(&sheets[1]) < z(&sheets[0]) && z(&sheets[0]) - z(&sheets[1]) < 1e-3);
    let Some(Texture::Bitmap { scale, bitmap, .. }) = emission(6) else { panic!() };
    near(*scale, [2.0; 3]);
    assert_eq!(bitmap.width(), 4);
    assert!(loaded.parts.groups[0][0].emission.is_none());
    assert!(warnings(&loaded).join("\n").contains("inside `ObjectBegin` is ignored"));
}

#[test]
fn a_square_picture_at_infinity_is_unfolded() {
    let loaded = scene("environment.pbrt");
    let LightSource::Environment { image, scale, to_world } = &loaded.parts.lights[0] else {
        panic!()
    };
    assert_eq!(*scale, 2.0);
    // The square's centre is the upper half of the sphere: +z in pbrt's world, whatever the rotation about it.
    near(image.texel(3, 0), [0.5, 0.5, 1.0]);
    near(image.texel(3, image.height() - 1), [0.25; 3]);
    let up = to_world.transform_vector3(Vec3::Y);
    assert!((up - Vec3::Z).length() < 1e-6, "{up}");
}

#[test]
fn media_fill_shapes() {
    let loaded = scene("media.pbrt");
    let [fog, milk] = loaded.parts.media.as_slice() else { panic!("{:?}", loaded.parts.media) };
    near(fog.sigma_t, [1.0, 1.0, 2.0]);
    near(fog.albedo, [0.5, 1.0, 0.75]);
    assert_eq!(fog.phase, Phase::HenyeyGreenstein { g: 0.3 });
    near(milk.sigma_t, [2.5511, 3.2124, 3.784]);
    let interiors: Vec<bool> = loaded.parts.shapes.iter().map(|s| s.interior.is_some()).collect();
    assert_eq!(interiors, [true, true, false]);
    assert!(matches!(inner(&loaded, 0), Material::Null));
}

#[test]
fn a_grid_of_densities_fills_its_box() {
    let grid = "Translate 1 0 0\nMakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \"integer ny\" 1\n\
        \"integer nz\" 1 \"float density\" [1 3] \"point3 p1\" [2 1 1] \"rgb sigma_a\" [1 1 0] \"rgb sigma_s\" [1 2 3]\n\
        \"float scale\" 2 \"float g\" 0.5\nMediumInterface \"m\" \"\"\nShape \"sphere\"";
    let medium = &world(grid).parts.media[0];
    near(medium.albedo, [0.5, 2.0 / 3.0, 1.0]);
    assert_eq!(medium.phase, Phase::HenyeyGreenstein { g: 0.5 });
    let varying = medium.varying.as_ref().expect("a density that varies");
    let at = |x: f32| varying.sigma_t().at(Vec3::new(x, 0.5, 0.5)).r;
    let bounds = varying.domain().bounds();
    assert_eq!((bounds.min, bounds.max), (Vec3::X, Vec3::new(3.0, 1.0, 1.0)));
    assert_eq!([1.5, 2.0, 2.5].map(at), [4.0, 8.0, 12.0]);
    // Half a cell beyond the outer centres the density has halved: there is nothing outside.
    assert_eq!([1.0, 3.0].map(at), [2.0, 6.0]);
}

#[test]
fn spectra_become_linear_colours() {
    let loaded = scene("spectra.pbrt");
    let radiance = |n: usize| match &loaded.parts.lights[n] {
        LightSource::Constant { radiance } => *radiance,
        other => panic!("{other:?}"),
    };
    near(radiance(0), [0.5; 3]);
    assert!((radiance(1).luminance() - 1.0).abs() < 1e-3, "a black body has a luminance of one");
    let equal = radiance(2);
    assert!((equal.luminance() - 1.0).abs() < 1e-3 && equal.r > equal.b, "{equal:?}");
    near(radiance(3), [1.0; 3]);
    let reflectance = |n: usize| match inner(&loaded, n) {
        Material::Diffuse { reflectance: Texture::Constant(c) } => *c,
        other => panic!("{other:?}"),
    };
    near(reflectance(0), [0.25; 3]);
    near(reflectance(1), [0.75; 3]);
    near(reflectance(2), [0.5; 3]);
    let notes = warnings(&loaded);
    let count = notes.iter().filter(|n| n.contains("spectra are reduced")).count();
    assert_eq!(count, 1, "{notes:?}");
    assert!(loaded.files.iter().any(|f| f.ends_with("grey.spd")));
}
