//! Scenes that are difficult for photons: wide ground, glossy lobes, edges.

use super::*;

#[test]
fn under_a_roof_on_ground_to_the_horizon_it_agrees_with_the_path_tracer() {
    // A roof of 4 m over 400 m of ground, seen from below. All of its light comes from the ground, and most of the
    // ground does not matter. Photons that are not aimed hit the roof a few times in a million, and discs relative to
    // the scene are wider than it.
    let world = World::roof_over_wide_ground();
    let truth = world.render::<PathTracer>(&Default::default(), 256, 5, Show::Indirect);
    let (truth, variance) = mean_and_variance(&truth);
    // Methods with a radius per pixel, and with one for all.
    for method in [Method::Sppm, Method::Ppa] {
        let of = |seed| {
            mean_and_variance(&render(&world, &with(method, 20_000), 8, seed, Show::Indirect)).0
        };
        let means: Running = (0..16).map(of).collect();
        let error = means.variance_of_mean().sqrt();
        assert!(error < 0.02 * truth, "{method:?}: +- {error} of {truth}");
        let p = z_test(means.mean(), error * error, truth, variance);
        assert!(p > ALPHA / 2.0, "{method:?}: {} +- {error} of {truth}, p = {p:.1e}", means.mean());
    }
}

#[test]
fn rays_follow_a_lobe_of_roughness_one_tenth_instead_of_gathering_few_photons() {
    // A metal floor in a room under a wide lamp.
    let tenth = Texture::grey(0.1);
    let (distribution, alpha_u, alpha_v) = (Distribution::Ggx, tenth.clone(), tenth);
    let metal = Material::Conductor {
        eta: Rgb::BLACK,
        k: Rgb::WHITE,
        reflectance: Texture::grey(0.9),
        roughness: Some(Roughness { distribution, alpha_u, alpha_v }),
    };
    let emission = Some(Texture::grey(5.0));
    let shapes = vec![
        Shape::new("room", cube_inside(), 1),
        Shape::new("floor", square(1.0, -0.99), 2),
        Shape { emission, ..Shape::new("lamp", square(0.5, 0.99), 1) },
    ];
    let materials = vec![grey(0.6), both_sides(), metal];
    let eye = Vec3::new(0.0, 0.2, 0.9);
    let camera = CameraSpec::look_at(eye, Vec3::new(0.0, -0.9, 0.0), Vec3::Y, 1.2, [24, 24]);
    let world = World::new(SceneParts { shapes, materials, ..SceneParts::default() }, &camera);
    let reference = world.render::<PathTracer>(&Default::default(), 512, 5, Show::Indirect);
    let error = |params: &Params| {
        relative_mse(&render(&world, params, 16, 1, Show::Indirect), &reference, "Indirect.")
    };
    let gathered = Params { min_roughness: 0.1, ..Params::default() };
    let [followed, gathered] = [Params::default(), gathered].map(|params| error(&params));
    assert!(followed < 0.5 * gathered, "{followed} against {gathered}");
}

#[test]
fn indirect_light_is_right_along_the_edges_of_boxes_in_the_sun() {
    // Boxes on which no point is far from an edge, on ground that is lit too.
    let mut shapes = vec![Shape::new("ground", square(4.0, 0.0), 1)];
    for (x, z) in [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)] {
        let Geometry::Mesh(mut mesh) = cube_inside() else { unreachable!("a mesh") };
        let (size, place) = (Vec3::new(0.2, 0.4, 0.2), Vec3::new(x, 0.4, z));
        mesh.transform(&Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, place));
        shapes.push(Shape::new("box", Geometry::Mesh(mesh), 1));
    }
    let direction = Vec3::new(0.5, -1.0, 0.3).normalize();
    let sun = LightSource::Directional { direction, irradiance: Rgb::grey(3.0) };
    let parts = SceneParts {
        shapes,
        materials: vec![grey(0.6), both_sides()],
        lights: vec![sun],
        ..SceneParts::default()
    };
    let eye = Vec3::new(1.2, 1.1, 1.6);
    let camera = CameraSpec::look_at(eye, Vec3::new(0.0, 0.3, 0.0), Vec3::Y, 0.7, [32, 32]);
    let world = World::new(parts, &camera);
    let truth = world.render::<PathTracer>(&Default::default(), 512, 5, Show::Indirect);
    let (truth, variance) = mean_and_variance(&truth);
    let of = |seed| {
        mean_and_variance(&render(&world, &with(Method::Sppm, 8192), 24, seed, Show::Indirect)).0
    };
    // The standard error of eight runs is itself uncertain by a quarter; these runs leave it well below the bound.
    let means: Running = (0..16).map(of).collect();
    let error = (means.variance_of_mean() + variance).sqrt() / truth;
    let ratio = means.mean() / truth;
    assert!(error < 0.01, "+- {error}");
    assert!((ratio - 1.0).abs() < 0.01 + 2.0 * error, "{ratio} +- {error}");
}
