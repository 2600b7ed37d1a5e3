//! Scenes with known answers.

mod hidden;
mod masks;

use gi_core::camera::CameraSpec;
use gi_core::eye::PathLimits;
use gi_core::film::{Film, Show};
use gi_core::geometry::Shape;
use gi_core::light::LightSource;
use gi_core::material::Material;
use gi_core::math::Rgb;
use gi_core::ray::Ray;
use gi_core::scene::SceneParts;
use gi_core::texture::Texture;
use gi_tests::{
    World, assert_mean, cube_inside, furnace, grey, mean_and_variance, polygon, sphere,
};
use glam::Vec3;
use pathtrace::{Mode, Params, PathTracer};

/// Both modes of the path tracer. `light` can render only scenes without mirrors and glass in view.
fn modes() -> [Mode; 2] {
    [Mode::Path, Mode::Light]
}

fn trace(world: &World, mode: Mode, max_depth: Option<u32>, passes: u32) -> Film {
    world.render::<PathTracer>(
        &Params {
            mode,
            limits: PathLimits { max_depth, ..PathLimits::default() },
            ..Params::default()
        },
        passes,
        1,
        Show::All,
    )
}

#[test]
fn a_furnace_of_albedo_a_reads_one_over_one_minus_a() {
    for a in [0.2, 0.5, 0.8] {
        let (parts, camera) = furnace(a);
        let world = World::new(parts, &camera);
        for mode in modes() {
            let film = trace(&world, mode, None, 64);
            assert_mean(&format!("furnace {a}, {mode:?}"), &film, 1.0 / (1.0 - f64::from(a)));
        }
    }
}

#[test]
fn a_furnace_cut_at_k_bounces_reads_the_geometric_sum() {
    let a = 0.7f32;
    let (parts, camera) = furnace(a);
    let world = World::new(parts, &camera);
    for k in 0..5 {
        let expected = (1.0 - f64::from(a).powi(k as i32 + 1)) / (1.0 - f64::from(a));
        for mode in modes() {
            // A path of k bounces has k + 1 segments.
            let film = trace(&world, mode, Some(k + 1), 64);
            assert_mean(&format!("{k} bounces, {mode:?}"), &film, expected);
        }
    }
}

#[test]
fn a_point_light_of_intensity_pi_in_a_unit_sphere_of_albedo_one_half_gives_one() {
    // The normal of a sphere points outward: flip it.
    let shape = Shape { flip_normals: true, ..Shape::new("sphere", sphere(Vec3::ZERO, 1.0), 0) };
    let light =
        LightSource::Point { position: Vec3::ZERO, intensity: Rgb::grey(std::f32::consts::PI) };
    let parts = SceneParts {
        shapes: vec![shape],
        materials: vec![grey(0.5)],
        lights: vec![light],
        ..SceneParts::default()
    };
    let camera = CameraSpec::look_at(Vec3::new(0.3, 0.2, -0.5), Vec3::X, Vec3::Y, 1.2, [16, 16]);
    let world = World::new(parts, &camera);
    for mode in modes() {
        assert_mean(&format!("unit sphere, {mode:?}"), &trace(&world, mode, None, 64), 1.0);
    }
}

#[test]
fn a_polygon_light_over_a_floor_obeys_lamberts_formula() {
    let lamp = [[-0.4, 0.7, -0.3], [0.5, 0.8, -0.4], [0.6, 1.0, 0.5], [-0.3, 0.9, 0.6]]
        .map(Vec3::from_array);
    // A small patch of floor around the origin fills the picture.
    let floor = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]]
        .map(Vec3::from_array);
    // The four corners are not in a plane. The lamp is the two triangles, and so is the formula below.
    let emission = Some(Texture::Constant(Rgb::grey(3.0)));
    let shapes = vec![
        Shape::new("floor", polygon(&floor), 0),
        Shape { emission, ..Shape::new("lamp", polygon(&lamp), 1) },
    ];
    let parts =
        SceneParts { shapes, materials: vec![grey(0.6), grey(0.0)], ..SceneParts::default() };
    let mut camera =
        CameraSpec::look_at(Vec3::new(0.0, 0.3, -0.5), Vec3::ZERO, Vec3::Y, 1e-3, [4, 4]);
    camera.principal_point_offset = glam::Vec2::ZERO;
    let world = World::new(parts, &camera);
    // E = L / 2 times the sum over edges of the edge's angle, times the cosine between the edge's plane normal and the
    // floor normal [Lambert1760].
    let irradiance = |corners: [Vec3; 3]| -> f64 {
        let edge = |p: Vec3, q: Vec3| {
            let angle = p.normalize().dot(q.normalize()).clamp(-1.0, 1.0).acos();
            f64::from(angle * p.cross(q).normalize().y)
        };
        let [a, b, c] = corners;
        (3.0 * 0.5 * (edge(a, b) + edge(b, c) + edge(c, a))).abs()
    };
    let e = irradiance([lamp[0], lamp[1], lamp[2]]) + irradiance([lamp[0], lamp[2], lamp[3]]);
    let expected = e * 0.6 / std::f64::consts::PI;
    assert_mean("polygon light", &trace(&world, Mode::Path, None, 1024), expected);
    // A camera that sees only a millimetre receives few light paths: let it see more, around the same point.
    let film = trace(&world, Mode::Path, Some(2), 1024);
    assert_mean("polygon light, direct", &film, expected);
}

#[test]
fn under_a_constant_sky_irradiance_is_pi_times_radiance() {
    let floor = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]]
        .map(Vec3::from_array);
    let parts = SceneParts {
        shapes: vec![Shape::new("floor", polygon(&floor), 0)],
        materials: vec![grey(0.5)],
        lights: vec![LightSource::Constant { radiance: Rgb::grey(2.0) }],
        ..SceneParts::default()
    };
    let camera = CameraSpec::look_at(Vec3::new(0.0, 1.0, -0.5), Vec3::ZERO, Vec3::Y, 0.6, [16, 16]);
    let world = World::new(parts, &camera);
    for mode in modes() {
        assert_mean(&format!("constant sky, {mode:?}"), &trace(&world, mode, None, 256), 1.0);
    }
}

#[test]
fn in_a_box_of_mirrors_the_depth_is_counted_exactly() {
    // Every path of k segments hits the emitting walls k times, and each reflection keeps one half.
    let half = Material::Conductor {
        eta: Rgb::BLACK,
        k: Rgb::WHITE,
        reflectance: Texture::grey(0.5),
        roughness: None,
    };
    let walls = Shape {
        emission: Some(Texture::Constant(Rgb::WHITE)),
        ..Shape::new("walls", cube_inside(), 0)
    };
    let parts = SceneParts { shapes: vec![walls], materials: vec![half], ..SceneParts::default() };
    let camera = CameraSpec::look_at(
        Vec3::new(0.1, -0.2, -0.7),
        Vec3::new(0.2, 0.1, 1.0),
        Vec3::Y,
        1.4,
        [8, 8],
    );
    let world = World::new(parts, &camera);
    for k in 1..5 {
        let film = world.render::<PathTracer>(
            &Params {
                limits: PathLimits { max_depth: Some(k), rr_depth: 100 },
                ..Params::default()
            },
            2,
            1,
            Show::All,
        );
        let expected = 2.0 * (1.0 - 0.5f32.powi(k as i32));
        assert!(
            film.radiance().iter().all(|c| (c.r - expected).abs() < 1e-5),
            "{k} segments: {:?}",
            film.radiance()[0]
        );
    }
}

#[test]
fn a_glass_ball_in_a_white_furnace_is_invisible() {
    let dielectric = |roughness| Material::Dielectric {
        eta: 1.5,
        reflectance: Texture::grey(1.0),
        transmittance: Texture::grey(1.0),
        roughness,
    };
    let pane = Material::ThinDielectric {
        eta: 1.5,
        reflectance: Texture::grey(1.0),
        transmittance: Texture::grey(1.0),
    };
    let mask = Material::Mask { opacity: Texture::grey(0.4), inner: 0 };
    for (name, table) in [
        ("glass", vec![dielectric(None)]),
        ("pane", vec![pane]),
        ("masked glass", vec![dielectric(None), mask]),
    ] {
        let material = table.len() - 1;
        let parts = SceneParts {
            shapes: vec![Shape::new("ball", sphere(Vec3::ZERO, 0.5), material)],
            materials: table,
            lights: vec![LightSource::Constant { radiance: Rgb::WHITE }],
            ..SceneParts::default()
        };
        let camera =
            CameraSpec::look_at(Vec3::new(0.0, 0.0, -2.0), Vec3::ZERO, Vec3::Y, 0.6, [16, 16]);
        let film = trace(&World::new(parts, &camera), Mode::Path, None, 64);
        let worst = film.radiance().iter().map(|c| (c.g - 1.0).abs()).fold(0.0, f32::max);
        let (mean, variance) = mean_and_variance(&film);
        assert!((mean - 1.0).abs() < 4.0 * variance.sqrt() + 1e-5, "{name}: mean {mean}");
        assert!(worst < 1.0, "{name}: a pixel differs by {worst}");
    }
}

#[test]
fn a_scene_ten_times_as_large_gives_the_same_picture() {
    let read = |scale: f32| World::load_scaled("cornell-glossy.xml", [24, 24], scale);
    for mode in modes() {
        let render = |scale| trace(&read(scale), mode, None, 32);
        let (one, other) = (mean_and_variance(&render(1.0)), mean_and_variance(&render(10.0)));
        // The random numbers are the same, so only rounding differs. A path that rounding diverts becomes a different
        // path, so allow a few pixels.
        assert!(
            (one.0 - other.0).abs() < 0.2 * one.1.sqrt(),
            "{mode:?}: {} against {}",
            one.0,
            other.0
        );
    }
}
