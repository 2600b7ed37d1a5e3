//! Records must not be used where their light does not reach.

use super::*;

/// A closed box, divided by a wall without thickness, with a lamp in one half. The camera looks in through the ceiling.
fn divided_box() -> World {
    let wall =
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(y, z)| Vec3::new(0.0, y, z));
    let lamp =
        [(-0.8, -0.3), (-0.2, -0.3), (-0.2, 0.3), (-0.8, 0.3)].map(|(x, z)| Vec3::new(x, 0.9, z));
    let emission = Some(Texture::Constant(Rgb::WHITE));
    let shapes = vec![
        Shape::new("box", cube_inside(), 0),
        Shape::new("wall", polygon(&wall), 1),
        Shape { emission, ..Shape::new("lamp", polygon(&lamp), 0) },
    ];
    let materials = vec![grey(0.7), Material::TwoSided { front: 0, back: 0 }];
    let parts = SceneParts { shapes, materials, ..SceneParts::default() };
    let mut camera =
        CameraSpec::look_at(Vec3::new(0.0, 4.0, 0.0), Vec3::ZERO, Vec3::Z, 0.42, [64, 64]);
    camera.near = 3.2; // inside the box, whose ceiling is 3 away
    World::new(parts, &camera)
}

#[test]
fn light_leaks_under_a_thin_wall_only_without_the_guard() {
    let world = divided_box();
    for error in CONTROLS {
        let leak = |leak_guard: bool| {
            let reach = ReachOptions { leak_guard, ..defaults() };
            let params = Params { error, reach, rays: 300, accuracy: 0.8, ..Params::default() };
            let film = render(&world, &params, 4, 1, Show::Indirect);
            let radiance = film.radiance();
            let of = |dark: bool| {
                let pixels = (0..64 * 64).filter(|i| ((i % 64) < 32) == dark);
                pixels.map(|i| f64::from(radiance[i].g)).sum::<f64>()
            };
            // Which half is dark depends on the orientation of the camera.
            let (a, b) = (of(true), of(false));
            a.min(b) / a.max(b)
        };
        let (guarded, open) = (leak(true), leak(false));
        assert_eq!(guarded, 0.0, "{error:?}: fraction of light that leaks with the guard");
        assert!(open > 0.0, "{error:?}: nothing leaks even without the guard");
    }
}

#[test]
fn records_of_open_ground_are_not_used_in_the_court() {
    // The ground extends 400 m around a court of 8 m. Records far outside hit almost no surfaces, so their harmonic
    // mean distance is huge, and they could be used everywhere. The test checks that they do not replace the court's
    // own records.
    let world = World::load("patio.xml", [24, 18], &[("sun", "0")]);
    let truth = world.render::<PathTracer>(&pathtrace::Params::default(), 1024, 9, Show::Indirect);
    let (truth, noise) = mean_and_variance(&truth);
    let reach = ReachOptions { min_spacing: 0.5, ..defaults() };
    let params = Params { reach, ..Params::default() };
    let of = |seed| mean_and_variance(&render(&world, &params, 64, seed, Show::Indirect)).0;
    let (mean, error) = mean_and_error(&[1, 2, 3, 4].map(of));
    // The bound includes half a per cent for interpolation in corners, where light changes faster than records can
    // follow.
    let off = (mean / truth - 1.0).abs();
    let noise = (noise.sqrt() / truth).hypot(error / truth);
    assert!(
        off < 0.005 + 4.0 * noise,
        "{mean} against {truth}: relative difference {off:.4} +- {noise:.4}"
    );
}
