//! Media whose density varies, rendered from the eye and from the lights. What is known of single rays is tested beside
//! the code, in `gi-core`.

use std::sync::Arc;

use gi_core::camera::CameraSpec;
use gi_core::film::Show;
use gi_core::geometry::Shape;
use gi_core::light::LightSource;
use gi_core::material::Material;
use gi_core::math::Rgb;
use gi_core::medium::{
    Between, Cells, Domain, Grid, Medium, MediumId, Outside, Phase, Varying, Volume,
};
use gi_core::rng::Pcg;
use gi_core::scene::SceneParts;
use gi_tests::World;
use glam::{Affine3A, Vec3};
use pathtrace::{Mode, PathTracer};

use crate::media_light::{
    assert_agree, assert_paths_agree, assert_reads, ball, block_means, mode, murky_camera,
    murky_parts,
};

/// A medium of random density in most of the cells of a grid over the cube around the origin with half side `half`. The
/// others are empty.
fn clouds(half: f32, most: Rgb, albedo: Rgb, phase: Phase) -> Medium {
    let size = [9, 8, 7];
    let mut rng = Pcg::new(3, 3);
    let density = |_| (3.0 * rng.next_f32() - 1.0).max(0.0) * 0.5;
    let cells = Cells::Grey((0..size.iter().product()).map(density).collect());
    let grid = Grid::new(size, cells, Outside::Clamp, Between::Trilinear).expect("a grid");
    let to_local = Affine3A::from_translation(Vec3::splat(0.5))
        * Affine3A::from_scale(Vec3::splat(0.5 / half));
    let sigma_t = Volume::Grid { grid: Arc::new(grid), to_local, factor: most };
    let varying = Varying::new(sigma_t, Volume::Constant(albedo), Domain::Cube(to_local));
    Medium::heterogeneous(varying, phase)
}

/// A grid of one value over the same cube.
fn even(half: f32, medium: &Medium) -> Medium {
    let grid = Grid::new([4; 3], Cells::Grey([1.0; 64].into()), Outside::Clamp, Between::Trilinear);
    let to_local = Affine3A::from_translation(Vec3::splat(0.5))
        * Affine3A::from_scale(Vec3::splat(0.5 / half));
    let grid = Arc::new(grid.expect("a grid"));
    let sigma_t = Volume::Grid { grid, to_local, factor: medium.sigma_t };
    let albedo = Volume::Constant(medium.albedo);
    Medium::heterogeneous(Varying::new(sigma_t, albedo, Domain::Cube(to_local)), medium.phase)
}

#[test]
fn paths_from_the_eye_and_from_the_lights_agree_in_media_whose_density_varies() {
    let mut parts = murky_parts();
    let phase = Phase::HenyeyGreenstein { g: 0.5 };
    let (most, albedo) = (Rgb::new(4.0, 2.5, 1.5), Rgb::new(0.9, 0.7, 0.5));
    parts.media[0] = clouds(3.0, Rgb::new(0.1, 0.2, 0.4), Rgb::BLACK, phase);
    parts.media[1] = clouds(0.8, most, albedo, phase);
    assert_paths_agree(&World::new(parts, &murky_camera()));
}

#[test]
fn a_grid_of_one_value_looks_like_the_homogeneous_medium() {
    let parts = murky_parts();
    let mut same = parts.clone();
    same.media = parts.media.iter().map(|m| even(3.1, m)).collect();
    let [a, b] = [parts, same].map(|parts| {
        let world = World::new(parts, &murky_camera());
        block_means::<PathTracer>(&world, &mode(Mode::VolPath, None), 16, Show::All, 8)
    });
    assert_agree("grid", &b, &a);
}

#[test]
fn clouds_of_albedo_one_are_invisible_in_a_white_furnace() {
    for (most, g) in [(2.0, 0.0), (10.0, 0.6)] {
        let phase = Phase::HenyeyGreenstein { g };
        let parts = SceneParts {
            shapes: vec![Shape { interior: Some(MediumId::new(0)), ..ball(Vec3::ZERO, 0.6, 0) }],
            materials: vec![Material::Null],
            media: vec![clouds(0.6, Rgb::new(most, 0.5 * most, 0.3 * most), Rgb::WHITE, phase)],
            lights: vec![LightSource::Constant { radiance: Rgb::WHITE }],
            ..SceneParts::default()
        };
        let camera =
            CameraSpec::look_at(Vec3::new(0.0, 0.0, -2.0), Vec3::ZERO, Vec3::Y, 0.6, [16, 16]);
        let world = World::new(parts, &camera);
        for (m, passes) in [(Mode::VolPath, 32), (Mode::Light, 128)] {
            assert_reads(&format!("{m:?}, {most}, {g}"), &world, (m, passes), 1.0);
        }
    }
}
