//! Compares `pathtrace --mode volpath` in participating media with closed forms.

mod photons;

use gi_core::camera::CameraSpec;
use gi_core::eye::PathLimits;
use gi_core::film::{Film, Show};
use gi_core::geometry::Shape;
use gi_core::light::LightSource;
use gi_core::material::Material;
use gi_core::math::Rgb;
use gi_core::medium::MediumId;
use gi_core::medium::{Medium, Phase, Tracking};
use gi_core::ray::Ray;
use gi_core::scene::{Scene, SceneParts};
use gi_core::technique::Technique;
use gi_core::texture::Texture;
use gi_tests::{World, assert_mean, furnace, grey, mean_and_variance, polygon, sphere};
use glam::Vec3;
use pathtrace::{Mode, Params, PathTracer};
use photonmap::PhotonMapping;

fn medium(sigma_t: f32, albedo: f32, g: f32) -> Medium {
    let phase = if g == 0.0 { Phase::Isotropic } else { Phase::HenyeyGreenstein { g } };
    Medium::homogeneous(Rgb::grey(sigma_t), Rgb::grey(albedo), phase)
}

/// A ball with a surface of material `material`, filled with medium `inside`.
fn ball(center: Vec3, radius: f32, material: usize, inside: usize) -> Shape {
    Shape {
        interior: Some(MediumId::new(inside)),
        ..Shape::new("ball", sphere(center, radius), material)
    }
}

fn trace(world: &World, max_depth: Option<u32>, passes: u32) -> Film {
    let limits = PathLimits { max_depth, ..PathLimits::default() };
    world.render::<PathTracer>(
        &Params { mode: Mode::VolPath, limits, ..Params::default() },
        passes,
        1,
        Show::All,
    )
}

/// A very narrow camera from `from` to `to`: all rays of the picture are nearly the same.
fn narrow(from: Vec3, to: Vec3) -> CameraSpec {
    CameraSpec::look_at(from, to, Vec3::new(0.1, 0.2, 0.9).normalize(), 1e-3, [8, 8])
}

#[test]
fn a_medium_of_albedo_one_is_invisible_in_a_white_furnace() {
    // Boundaries with and without refraction; isotropic and peaked phase functions; thin and thick media.
    let glass = Material::Dielectric {
        eta: 1.5,
        reflectance: Texture::grey(1.0),
        transmittance: Texture::grey(1.0),
        roughness: None,
    };
    for (name, material) in [("null", Material::Null), ("glass", glass)] {
        for (sigma_t, g) in [(0.5, 0.0), (4.0, 0.7), (4.0, -0.4), (40.0, 0.0)] {
            let parts = SceneParts {
                shapes: vec![ball(Vec3::ZERO, 0.6, 0, 0)],
                materials: vec![material.clone()],
                media: vec![medium(sigma_t, 1.0, g)],
                lights: vec![LightSource::Constant { radiance: Rgb::WHITE }],
                ..SceneParts::default()
            };
            let camera =
                CameraSpec::look_at(Vec3::new(0.0, 0.0, -2.0), Vec3::ZERO, Vec3::Y, 0.6, [16, 16]);
            let film = trace(&World::new(parts, &camera), None, 64);
            let name = format!("{name}, sigma_t {sigma_t}, g {g}");
            assert_mean(&name, &film, 1.0);
            // Roulette must not end paths of up to a thousand scatterings: that would increase the noise.
            let error = mean_and_variance(&film).1.sqrt();
            assert!(error < 0.008, "{name}: noise {error:.1e}");
        }
    }
}

#[test]
fn a_furnace_filled_with_a_medium_of_albedo_one_reads_one_over_one_minus_a() {
    // The camera is inside the medium, but nothing in the scene says so. The walls are the boundary.
    let (mut parts, camera) = furnace(0.5);
    parts.media = vec![medium(0.8, 1.0, 0.3)];
    parts.shapes[0].exterior = Some(MediumId::new(0));
    assert_mean("full furnace", &trace(&World::new(parts, &camera), None, 64), 2.0);
}

#[test]
fn light_through_an_absorbing_ball_obeys_beers_law_in_each_channel() {
    let sigma_t = Rgb::new(0.3, 1.0, 2.5);
    let parts = SceneParts {
        shapes: vec![ball(Vec3::ZERO, 0.5, 0, 0)],
        materials: vec![Material::Null],
        media: vec![Medium::homogeneous(sigma_t, Rgb::BLACK, Phase::Isotropic)],
        lights: vec![LightSource::Constant { radiance: Rgb::WHITE }],
        ..SceneParts::default()
    };
    let world = World::new(parts, &narrow(Vec3::new(0.0, -3.0, 0.0), Vec3::ZERO));
    // Also at the last segment: absorption does not add segments.
    for depth in [Some(1), None] {
        let pixel = trace(&world, depth, 2).radiance()[27].to_array();
        for (found, sigma) in pixel.into_iter().zip(sigma_t.to_array()) {
            // Rays deviate from the axis by at most 1e-3; 1 - cos of that is 5e-7.
            assert!((found / (-sigma).exp() - 1.0).abs() < 1e-5, "{found} for sigma_t {sigma}");
        }
    }
}

#[test]
fn a_point_light_in_an_absorbing_medium_lights_a_floor_through_it() {
    // Under the light, E = I exp(-sigma h) / h^2. Then L = a / pi E, and exp(-sigma s) on the way to the eye at
    // distance s.
    let floor = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]];
    let (h, s, sigma, a) = (0.8f32, 0.7f32, 1.3f32, 0.5f32);
    let parts = SceneParts {
        shapes: vec![
            Shape::new("floor", polygon(&floor.map(Vec3::from_array)), 0),
            ball(Vec3::ZERO, 4.0, 1, 0),
        ],
        materials: vec![grey(a), Material::Null],
        media: vec![medium(sigma, 0.0, 0.0)],
        lights: vec![LightSource::Point {
            position: Vec3::new(0.0, h, 0.0),
            intensity: Rgb::WHITE,
        }],
        ..SceneParts::default()
    };
    let direction = Vec3::new(0.6, 0.8, 0.0);
    let film = trace(&World::new(parts, &narrow(direction * s, Vec3::ZERO)), None, 4);
    let dimmed = f64::from(-sigma * (h + s)).exp();
    let expected = f64::from(a) / std::f64::consts::PI / f64::from(h * h) * dimmed;
    let (mean, _) = mean_and_variance(&film);
    assert!((mean / expected - 1.0).abs() < 1e-4, "{mean} is not {expected}");
}

/// Single scattering of a point light of intensity 1 along a ray from `o` to `o + d length`, all in a medium:
/// the airlight integral sigma_s p exp(-sigma_t (t + r)) / r^2 dt, by Simpson's rule.
fn airlight(m: &Medium, light: Vec3, o: Vec3, d: Vec3, length: f64) -> f64 {
    let n = 20_000;
    let (sigma_t, sigma_s) = (f64::from(m.sigma_t.r), f64::from(m.sigma_s().r));
    let at = |t: f64| {
        let to = light - (o + d * t as f32);
        let r = f64::from(to.length());
        let phase = f64::from(m.phase.eval(-d, to.normalize()));
        sigma_s * phase * (-sigma_t * (t + r)).exp() / (r * r)
    };
    let h = length / f64::from(n);
    let inner = (1..n).map(|k| at(f64::from(k) * h) * if k % 2 == 1 { 4.0 } else { 2.0 });
    (at(0.0) + inner.sum::<f64>() + at(length)) * h / 3.0
}

#[test]
fn single_scattering_of_a_point_light_equals_the_airlight_integral() {
    for (sigma_t, albedo, g) in [(0.7, 0.8, 0.0), (0.7, 0.8, 0.6), (2.0, 1.0, -0.5)] {
        let m = medium(sigma_t, albedo, g);
        let (light, o, d) = (Vec3::new(0.3, 0.5, -0.2), Vec3::new(-1.0, 0.0, 0.0), Vec3::X);
        let parts = SceneParts {
            shapes: vec![ball(Vec3::ZERO, 2.0, 0, 0)],
            materials: vec![Material::Null],
            media: vec![m.clone()],
            lights: vec![LightSource::Point { position: light, intensity: Rgb::WHITE }],
            ..SceneParts::default()
        };
        let world = World::new(parts, &narrow(o, o + d));
        // Two segments: scattered once. The ray ends at the sphere, at distance 3.
        let film = trace(&world, Some(2), 4096);
        assert_mean(&format!("{m:?}"), &film, airlight(&m, light, o, d, 3.0));
    }
}

#[test]
fn shadow_rays_are_attenuated_by_each_medium_over_its_own_length() {
    // A ball of another medium inside a ball, and a mask that transmits one half.
    let screen = [[-3.0, -3.0, 0.6], [3.0, -3.0, 0.6], [3.0, 3.0, 0.6], [-3.0, 3.0, 0.6]];
    let parts = SceneParts {
        shapes: vec![
            ball(Vec3::ZERO, 2.0, 0, 0),
            Shape { exterior: Some(MediumId::new(0)), ..ball(Vec3::ZERO, 0.5, 0, 1) },
            Shape::new("screen", polygon(&screen.map(Vec3::from_array)), 2),
        ],
        materials: vec![
            Material::Null,
            grey(0.0),
            Material::Mask { opacity: Texture::grey(0.5), inner: 1 },
        ],
        media: vec![medium(0.4, 0.5, 0.0), medium(2.0, 0.9, 0.0)],
        ..SceneParts::default()
    };
    let scene = Scene::new(parts).expect("a scene");
    assert!(scene.media_warnings().is_empty(), "{:?}", scene.media_warnings());
    // The direction is not of unit length, so t is in units of its length.
    let ray = Ray { tmax: 1.0, ..Ray::new(Vec3::new(0.0, 0.0, -3.0), Vec3::new(0.0, 0.0, 6.0)) };
    let expected = 0.5 * (-0.4f32 * 3.0 - 2.0 * 1.0).exp();
    let found = scene.transmittance_through_media(ray, None, &mut Tracking::none()).r;
    assert!((found / expected - 1.0).abs() < 1e-4, "{found} is not {expected}");
    // A ray that starts and ends inside the media.
    let ray = Ray { tmax: 0.9, ..Ray::new(Vec3::new(0.0, 0.0, -0.2), -Vec3::Z) };
    let expected = (-2.0f32 * 0.3 - 0.4 * 0.6).exp();
    let inside = scene.medium_at(ray.o, Vec3::X);
    assert_eq!(inside, Some(MediumId::new(1)));
    let found = scene.transmittance_through_media(ray, inside, &mut Tracking::none()).r;
    assert!((found / expected - 1.0).abs() < 1e-4, "{found} is not {expected}");
}

#[test]
fn overlapping_open_and_unbounded_media_are_reported() {
    let warnings = |shapes: Vec<Shape>| {
        let media = vec![medium(1.0, 0.5, 0.0), medium(2.0, 0.5, 0.0), medium(2.0, 0.5, 0.0)];
        let materials = vec![Material::Null];
        let parts = SceneParts { shapes, materials, media, ..SceneParts::default() };
        Scene::new(parts).expect("a scene").media_warnings().join("\n")
    };
    let named = |name: &str, shape: Shape| Shape { name: name.into(), ..shape };
    // A ball inside another's medium that does not declare this medium outside, and one that does. Media with equal
    // parameters count as the same.
    let outer = || named("outer", ball(Vec3::ZERO, 2.0, 0, 1));
    let inner = || named("inner", ball(Vec3::ZERO, 0.5, 0, 0));
    let said = warnings(vec![outer(), inner()]);
    assert!(said.contains("\"inner\" and \"outer\" do not name the same medium"), "{said}");
    assert_eq!(warnings(vec![outer(), Shape { exterior: Some(MediumId::new(2)), ..inner() }]), "");
    // Two balls that overlap.
    let other = named("other", ball(Vec3::new(1.5, 0.0, 0.0), 1.0, 0, 0));
    let said = warnings(vec![named("one", ball(Vec3::ZERO, 1.0, 0, 1)), other]);
    assert!(said.contains("\"one\" and \"other\" do not name the same medium"), "{said}");
    // A single square has an unbounded inside, and open edges.
    let square = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]];
    let square = Shape::new("square", polygon(&square.map(Vec3::from_array)), 0);
    let said = warnings(vec![Shape { interior: Some(MediumId::new(0)), ..square }]);
    assert!(said.contains("not closed at \"square\""), "{said}");
    assert!(said.contains("medium at \"square\" is unbounded"), "{said}");
}

#[test]
fn the_medium_of_the_camera_is_found() {
    let parts = SceneParts {
        shapes: vec![
            ball(Vec3::ZERO, 2.0, 0, 0),
            Shape { exterior: Some(MediumId::new(0)), ..ball(Vec3::ZERO, 0.5, 0, 1) },
        ],
        materials: vec![Material::Null],
        media: vec![medium(0.4, 0.5, 0.0), medium(2.0, 0.9, 0.0)],
        ..SceneParts::default()
    };
    let scene = Scene::new(parts).expect("a scene");
    for (x, expected) in [(0.2, Some(1)), (0.7, Some(0)), (3.0, None)] {
        for d in [Vec3::X, -Vec3::X, Vec3::Y] {
            assert_eq!(
                scene.medium_at(Vec3::new(x, 0.0, 0.0), d),
                expected.map(MediumId::new),
                "at {x}"
            );
        }
    }
}

#[test]
fn without_media_volpath_equals_path_bit_for_bit() {
    let world = World::load("cornell-spheres.xml", [24, 24], &[]);
    let render = |mode| {
        let params = Params { mode, ..Params::default() };
        world.render::<PathTracer>(&params, 4, 3, Show::All).radiance()
    };
    assert_eq!(render(Mode::Path), render(Mode::VolPath));
}

#[test]
fn cognac_is_tinted_in_all_programs_and_absorbs_on_request() {
    // A medium without effect is removed, so no program says that it ignores it.
    assert!(!World::load("cognac.xml", [8, 8], &[]).scene.has_media());
    let amber = [("tint", "1,1,1"), ("absorption", "0.36,2.08,6.37")];
    let world = World::load("cognac.xml", [8, 8], &amber);
    assert!(world.scene.has_media() && world.scene.media_warnings().is_empty());
    // Volume photons are stored where media scatter. This medium does not scatter, so none are traced, whatever their
    // number.
    let (photons, caustic_photons, volume_photons) = (1000, 1000, 1 << 40);
    let params = photonmap::Params {
        photons,
        caustic_photons,
        volume_photons,
        ..photonmap::Params::default()
    };
    let (technique, _) = world.run::<PhotonMapping>(&params, 1, 1, Show::All);
    let paths = technique.statistics().into_iter().find(|(name, _)| name == "volume_paths");
    assert_eq!(paths.expect("known").1, 0.0);
}
