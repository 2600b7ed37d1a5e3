//! Light sources that the camera does not see.

use super::*;

/// A camera on +z that looks at a wall, past the back of nothing but a lamp that shines toward it. A point light between
/// the two lights the wall.
fn scene(hides_emitters: bool) -> World {
    let square = |z: f32| {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        polygon(&corners.map(|[x, y]| Vec3::new(x, y, z)))
    };
    let mut lamp = Shape::new("lamp", square(3.0), 0);
    lamp.emission = Some(Texture::grey(7.0));
    let parts = SceneParts {
        shapes: vec![Shape::new("wall", square(0.0), 0), lamp],
        materials: vec![grey(0.5)],
        lights: vec![LightSource::Point { position: Vec3::Z, intensity: Rgb::grey(2.0) }],
        hides_emitters,
        ..SceneParts::default()
    };
    World::new(parts, &CameraSpec::look_at(Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, 1e-3, [4, 4]))
}

#[test]
fn a_hidden_lamp_shows_what_is_behind_it() {
    let seen = trace(&scene(false), Mode::Path, Some(2), 4);
    assert!((mean_and_variance(&seen).0 - 7.0).abs() < 1e-5);
    let behind = 0.5 * std::f64::consts::FRAC_1_PI * 2.0;
    let hidden = trace(&scene(true), Mode::Path, Some(2), 1024);
    assert_mean("a wall behind a hidden lamp", &hidden, behind);
}

#[test]
fn light_from_infinity_lights_surfaces_but_is_hidden_itself() {
    let world = |shapes: Vec<Shape>| {
        let parts = SceneParts {
            shapes,
            materials: vec![grey(0.5)],
            lights: vec![LightSource::Constant { radiance: Rgb::WHITE }],
            hides_emitters: true,
            ..SceneParts::default()
        };
        World::new(parts, &CameraSpec::look_at(Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, 0.1, [4, 4]))
    };
    let empty = trace(&world(Vec::new()), Mode::Path, None, 4);
    assert_eq!(mean_and_variance(&empty).0, 0.0);
    let ball =
        trace(&world(vec![Shape::new("ball", sphere(Vec3::ZERO, 1.0), 0)]), Mode::Path, None, 64);
    assert_mean("a ball under a white sky", &ball, 0.5);
}

#[test]
fn modes_with_paths_from_the_lights_refuse_hidden_lamps() {
    use gi_core::technique::Technique;
    let world = scene(true);
    for mode in [Mode::Light, Mode::Bdpt, Mode::Vcm] {
        let params = Params { mode, ..Params::default() };
        let refused = PathTracer::prepare(world.setting(0, Show::All), &params).err();
        assert!(refused.is_some_and(|why| why.contains("hide_emitters")), "{mode:?}");
    }
}
