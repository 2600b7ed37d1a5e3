//! Masks, and the sum of the components.

use super::*;

#[test]
fn components_add_up_to_the_whole_and_a_mask_of_one_half_lets_half_through() {
    let world = World::load("cornell-spheres.xml", [16, 16], &[]);
    let film = trace(&world, Mode::Path, None, 16);
    let layers = film.layers();
    let layer = |name: &str| layers.channel(name).expect("a layer").to_vec();
    let parts = [layer("Direct.R"), layer("Indirect.R"), layer("Caustic.R")];
    for (i, whole) in layer("R").into_iter().enumerate() {
        let sum: f32 = parts.iter().map(|p| p[i]).sum();
        assert!((sum - whole).abs() < 1e-5 * (1.0 + whole), "pixel {i}: {sum} is not {whole}");
    }
    // A black mask with opacity 1/2 in front of a white sky.
    let mask = Material::Mask { opacity: Texture::grey(0.5), inner: 0 };
    let screen = [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]]
        .map(Vec3::from_array);
    let floor = [[-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [-1.0, 1.0, -1.0]]
        .map(Vec3::from_array);
    let light = LightSource::Directional {
        direction: -Vec3::Z,
        irradiance: Rgb::grey(std::f32::consts::PI),
    };
    let parts = SceneParts {
        shapes: vec![
            Shape::new("screen", polygon(&screen), 1),
            Shape::new("floor", polygon(&floor), 2),
        ],
        materials: vec![grey(0.0), mask, grey(0.5)],
        lights: vec![light],
        ..SceneParts::default()
    };
    let camera = CameraSpec::look_at(
        Vec3::new(0.0, 0.3, -0.2),
        Vec3::new(0.0, 0.0, -1.0),
        Vec3::Y,
        0.5,
        [8, 8],
    );
    for mode in modes() {
        // The floor is lit through the mask: half of 0.5 pi / pi.
        let world = World::new(
            SceneParts {
                shapes: parts.shapes.clone(),
                materials: parts.materials.clone(),
                lights: parts.lights.clone(),
                ..SceneParts::default()
            },
            &camera,
        );
        assert_mean(&format!("behind a mask, {mode:?}"), &trace(&world, mode, None, 256), 0.25);
    }
}

#[test]
fn a_mask_does_not_count_as_a_segment() {
    // A black mask in front of a white sky, seen with paths of one segment.
    let mask = Material::Mask { opacity: Texture::grey(0.5), inner: 0 };
    let screen = [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]]
        .map(Vec3::from_array);
    let parts = SceneParts {
        shapes: vec![Shape::new("screen", polygon(&screen), 1)],
        materials: vec![grey(0.0), mask],
        lights: vec![LightSource::Constant { radiance: Rgb::WHITE }],
        ..SceneParts::default()
    };
    let camera = CameraSpec::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 0.5, [8, 8]);
    let world = World::new(parts, &camera);
    for mode in modes() {
        assert_mean(&format!("{mode:?}"), &trace(&world, mode, Some(1), 256), 0.5);
    }
}

#[test]
fn shadow_rays_pass_masks_and_end_at_opaque_surfaces_in_any_order() {
    // Twelve masks of opacity 1/2, one behind the other; in every third case, one of them is opaque.
    let mask = Material::Mask { opacity: Texture::grey(0.5), inner: 0 };
    let screen = |z: f32| {
        [[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]].map(Vec3::from_array)
    };
    for opaque in 0..36 {
        let shape =
            |k: u32| Shape::new("screen", polygon(&screen(k as f32)), usize::from(k != opaque));
        let parts = SceneParts {
            shapes: (0..12).map(shape).collect(),
            materials: vec![grey(0.0), mask.clone()],
            ..SceneParts::default()
        };
        let scene = gi_core::scene::Scene::new(parts).expect("a scene");
        for (from, to) in [(-1.0, 20.0), (20.0, -1.0), (3.5, 7.5), (7.5, 3.5)] {
            let (near, far) = (f32::min(from, to), f32::max(from, to));
            let met = |k: &u32| (near..far).contains(&(*k as f32));
            let ray = Ray::new(Vec3::new(0.1, 0.2, from), Vec3::new(0.0, 0.0, to - from));
            let through = scene.transmittance(Ray { tmax: 1.0, ..ray });
            let met: Vec<u32> = (0..12).filter(met).collect();
            let expected = if met.contains(&opaque) { 0.0 } else { 0.5f32.powi(met.len() as i32) };
            assert_eq!(through, Rgb::grey(expected), "{opaque} opaque, from {from} to {to}");
        }
    }
}
