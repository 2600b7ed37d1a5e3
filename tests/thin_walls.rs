//! Light must not leak through walls without thickness.

use gi_core::camera::CameraSpec;
use gi_core::film::Show;
use gi_core::geometry::Shape;
use gi_core::math::Rgb;
use gi_core::scene::SceneParts;
use gi_core::technique::Technique;
use gi_core::texture::Texture;
use gi_stats::Running;
use gi_tests::{World, both_sides, cube_inside, grey, mean_and_variance, polygon};
use glam::Vec3;
use pathtrace::PathTracer;
use photonmap::{Gather, PhotonMapping};
use ppm::{Method, Ppm};

/// The cube from -1 to 1, divided at x = 0 by a wall without thickness up to the height `top`. The lamp is in the left
/// half, the eye in the right half.
fn parted(top: f32) -> World {
    let wall = [[0.0, -1.0, -1.0], [0.0, -1.0, 1.0], [0.0, top, 1.0], [0.0, top, -1.0]];
    let lamp = [[-0.7, 0.95, -0.2], [-0.3, 0.95, -0.2], [-0.3, 0.95, 0.2], [-0.7, 0.95, 0.2]];
    let emission = Some(Texture::Constant(Rgb::grey(20.0)));
    let shapes = vec![
        Shape::new("room", cube_inside(), 1),
        Shape::new("wall", polygon(&wall.map(Vec3::from_array)), 1),
        Shape { emission, ..Shape::new("lamp", polygon(&lamp.map(Vec3::from_array)), 2) },
    ];
    let materials = vec![grey(0.7), both_sides(), grey(0.0)];
    let eye = Vec3::new(0.9, 0.3, 0.0);
    let camera = CameraSpec::look_at(eye, Vec3::new(0.0, -0.6, 0.0), Vec3::Y, 1.4, [16, 16]);
    World::new(SceneParts { shapes, materials, ..SceneParts::default() }, &camera)
}

fn mean<'a, T: Technique<'a>>(world: &'a World, params: &T::Params, seed: u32) -> f64 {
    mean_and_variance(&world.render::<T>(params, 8, seed, Show::All)).0
}

fn photon_maps() -> Vec<photonmap::Params> {
    let of = |gather| photonmap::Params { photons: 200_000, gather, ..Default::default() };
    [Gather::None, Gather::Direct, Gather::Final].map(of).to_vec()
}

fn progressive() -> Vec<ppm::Params> {
    let of = |method| ppm::Params { method, photons: 8192, ..Default::default() };
    [Method::Ppm, Method::Sppm, Method::Ppa].map(of).to_vec()
}

#[test]
fn behind_a_wall_without_thickness_it_is_dark() {
    let world = parted(1.0);
    for params in photon_maps() {
        let mean = mean::<PhotonMapping>(&world, &params, 1);
        assert!(mean < 1e-4, "{:?}: {mean}", params.gather);
    }
    for params in progressive() {
        let mean = mean::<Ppm>(&world, &params, 1);
        assert!(mean < 1e-4, "{:?}: {mean}", params.method);
    }
}

#[test]
fn light_through_a_slit_above_a_thin_wall_is_not_lost_and_no_light_leaks() {
    let world = parted(0.8);
    let truth = world.render::<PathTracer>(&Default::default(), 2048, 5, Show::All);
    let (truth, variance) = mean_and_variance(&truth);
    let check = |name: &str, means: Running| {
        let error = (means.variance_of_mean() + variance).sqrt() / truth;
        let ratio = means.mean() / truth;
        assert!(error < 0.025, "{name}: +- {error}");
        assert!((ratio - 1.0).abs() < 0.03 + 3.0 * error, "{name}: {ratio} +- {error}");
    };
    for params in photon_maps() {
        let of = |seed| mean::<PhotonMapping>(&world, &params, seed);
        check(&format!("{:?}", params.gather), (0..8).map(of).collect());
    }
    for params in progressive() {
        let of = |seed| mean::<Ppm>(&world, &params, seed);
        check(&format!("{:?}", params.method), (0..12).map(of).collect());
    }
}
