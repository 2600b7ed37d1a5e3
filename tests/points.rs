//! Irradiance at points: sensors in place of a camera.

use std::f64::consts::PI;

use gi_core::camera::{Camera, CameraSpec, Sensor};
use gi_core::eye::PathLimits;
use gi_core::film::Show;
use gi_core::geometry::Shape;
use gi_core::light::LightSource;
use gi_core::math::Rgb;
use gi_core::scene::SceneParts;
use gi_core::texture::Texture;
use gi_stats::z_test;
use gi_tests::{ALPHA, World, furnace, grey, mean_and_variance};
use glam::Vec3;
use pathtrace::{Params, PathTracer};

/// The same world, with sensors in place of its camera.
fn measured(world: World, sensors: Vec<Sensor>) -> World {
    World { camera: Camera::of_sensors(sensors, 1), ..world }
}

/// The irradiance of one sensor and the variance of that estimate.
fn irradiance(world: &World, max_depth: Option<u32>, show: Show, passes: u32) -> (f64, f64) {
    let limits = PathLimits { max_depth, ..PathLimits::default() };
    let film = world.render::<PathTracer>(&Params { limits, ..Params::default() }, passes, 1, show);
    mean_and_variance(&film)
}

#[track_caller]
fn assert_irradiance(name: &str, (mean, variance): (f64, f64), expected: f64) {
    let p = z_test(mean, variance + (1e-5 * expected).powi(2), expected, 0.0); // floats have seven digits
    assert!(p > ALPHA, "{name}: {mean} is not {expected} (standard error {:.2e})", variance.sqrt());
}

/// A world with these lights and shapes, and a black ball that no sensor sees.
fn lit_by(lights: Vec<LightSource>, mut shapes: Vec<Shape>) -> World {
    shapes.push(Shape::new("ball", gi_tests::sphere(Vec3::new(-9.0, 0.0, 0.0), 1.0), 0));
    let parts = SceneParts { shapes, materials: vec![grey(0.0)], lights, ..SceneParts::default() };
    World::new(parts, &furnace(0.5).1)
}

/// E = I cos / d^2.
#[test]
fn a_point_light_gives_the_inverse_square_law() {
    let position = Vec3::new(0.0, 3.0, 4.0);
    for (n, expected) in [(Vec3::Z, 4.0 / 125.0), (Vec3::Y, 3.0 / 125.0), (-Vec3::Y, 0.0)] {
        let light = LightSource::Point { position, intensity: Rgb::WHITE };
        let world = measured(lit_by(vec![light], Vec::new()), vec![Sensor { p: Vec3::ZERO, n }]);
        for show in [Show::All, Show::Direct] {
            assert_irradiance("point light", irradiance(&world, None, show, 4), expected);
        }
    }
}

/// Seen from distance h on its axis, a sphere of radius r and radiance 1 gives E = pi r^2 / h^2.
#[test]
fn a_sphere_of_radiance_one_gives_pi_times_its_squared_sine() {
    let lamp = Shape {
        emission: Some(Texture::Constant(Rgb::WHITE)),
        ..Shape::new("lamp", gi_tests::sphere(Vec3::new(0.0, 2.0, 0.0), 0.5), 0)
    };
    let world =
        measured(lit_by(Vec::new(), vec![lamp]), vec![Sensor { p: Vec3::ZERO, n: Vec3::Y }]);
    assert_irradiance("sphere", irradiance(&world, None, Show::All, 4096), PI / 16.0);
    // Light that was scattered does not exist, and a path of one segment sees nothing but the sensor.
    assert_irradiance("sphere", irradiance(&world, None, Show::Indirect, 64), 0.0);
    assert_irradiance("sphere", irradiance(&world, Some(1), Show::All, 64), 0.0);
}

/// In a closed room that emits 1 and reflects a: E = pi / (1 - a), of which pi is direct, wherever the sensor is.
#[test]
fn the_irradiance_in_a_furnace_is_pi_over_one_minus_a() {
    let a = 0.6f32;
    let (parts, camera) = furnace(a);
    for (p, n) in [
        (Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8)),
        // On a wall, and in a corner.
        (Vec3::new(-1.0, 0.2, 0.3), Vec3::X),
        (Vec3::new(1.0, -1.0, 1.0), Vec3::new(-1.0, 1.0, -1.0).normalize()),
    ] {
        let world = measured(World::new(parts.clone(), &camera), vec![Sensor { p, n }]);
        let all = irradiance(&world, None, Show::All, 1024);
        assert_irradiance(&format!("furnace {p}"), all, PI / (1.0 - f64::from(a)));
        let direct = irradiance(&world, None, Show::Direct, 1024);
        assert_irradiance(&format!("furnace {p}, direct"), direct, PI);
        // One more segment: light that was scattered once.
        let cut = irradiance(&world, Some(3), Show::All, 1024);
        assert_irradiance(&format!("furnace {p}, cut"), cut, PI * (1.0 + f64::from(a)));
    }
}

/// A Lambertian surface of albedo rho under the irradiance E has the radiance rho E / pi.
#[test]
fn a_picture_of_a_floor_shows_its_irradiance() {
    let (p, n) = (Vec3::new(450.0, 0.0, 100.0), Vec3::Y);
    let world = World::load_with("cornell-box.xml", [1, 1], &[], |_, camera| {
        let eye = p + Vec3::new(0.0, 40.0, 0.0);
        *camera = CameraSpec::look_at(eye, p, Vec3::Z, 1e-3, [1, 1]);
    });
    let film = world.render::<PathTracer>(&Params::default(), 4096, 1, Show::All);
    let layers = film.layers();
    let value = |name: String| f64::from(layers.channel(&name).expect("a layer")[0]);
    let per_albedo = |c: &str| value(c.to_string()) * PI / value(format!("Albedo.{c}"));
    let expected = ["R", "G", "B"].map(per_albedo).iter().sum::<f64>() / 3.0;
    let (radiance, variance_of_radiance) = mean_and_variance(&film);
    let variance_of_expected = variance_of_radiance * (expected / radiance).powi(2);

    let world = measured(world, vec![Sensor { p, n }]);
    let (mean, variance) = irradiance(&world, None, Show::All, 4096);
    let p = z_test(mean, variance, expected, variance_of_expected);
    assert!(p > ALPHA, "{mean} at the sensor, {expected} from the picture");
}
