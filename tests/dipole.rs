//! Compares the dipole of translucent solids with closed forms of diffusion theory.

use std::f64::consts::PI;

use gi_core::camera::CameraSpec;
use gi_core::film::Show;
use gi_core::geometry::{Geometry, Shape};
use gi_core::light::LightSource;
use gi_core::material::Material;
use gi_core::math::Rgb;
use gi_core::medium::MediumId;
use gi_core::medium::{Medium, Phase};
use gi_core::scene::SceneParts;
use gi_core::technique::Technique;
use gi_core::texture::Texture;
use gi_stats::{Running, z_test};
use gi_tests::{ALPHA, World, cube_inside, mean_and_variance, sphere};
use glam::Vec3;
use photonmap::{Params, PhotonMapping, Subsurface};

/// Index of refraction of all solids here.
const ETA: f64 = 1.5;

fn polish() -> Material {
    Material::Dielectric {
        eta: ETA as f32,
        reflectance: Texture::grey(1.0),
        transmittance: Texture::grey(1.0),
        roughness: None,
    }
}

fn medium(sigma_t: f32, albedo: f32) -> Medium {
    Medium::homogeneous(Rgb::grey(sigma_t), Rgb::grey(albedo), Phase::Isotropic)
}

fn solid(geometry: Geometry) -> Shape {
    Shape { interior: Some(MediumId::new(0)), ..Shape::new("solid", geometry, 0) }
}

fn params(volume_photons: usize) -> Params {
    // No surface here can store a photon of another map.
    let (photons, caustic_photons, subsurface) = (1, 0, Subsurface::Dipole);
    Params { photons, caustic_photons, volume_photons, subsurface, ..Params::default() }
}

/// Fresnel reflectance for the index [`ETA`] from outside.
fn fresnel(cos: f64) -> f64 {
    let t = (1.0 - (1.0 - cos * cos) / (ETA * ETA)).sqrt();
    let s = (cos - ETA * t) / (cos + ETA * t);
    let p = (ETA * cos - t) / (ETA * cos + t);
    0.5 * (s * s + p * p)
}

/// Fraction of diffuse light that enters from outside.
fn enters() -> f64 {
    let n = 20_000;
    let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
    (0..n).map(|k| 2.0 * (1.0 - fresnel(at(k))) * at(k)).sum::<f64>() / f64::from(n)
}

/// (1 + F) / (1 - F), where F is the fraction of diffuse light that is reflected inward: 1 - F = (1 - F outside) /
/// eta^2.
fn boundary() -> f64 {
    let leaves = enters() / (ETA * ETA);
    (2.0 - leaves) / leaves
}

/// The mean over seeds of a picture's mean, and its variance.
fn mean_of_seeds(world: &World, photons: usize, seeds: u32) -> (f64, f64) {
    let mut means = Running::default();
    for seed in 0..seeds {
        let film = world.render::<PhotonMapping>(&params(photons), 8, seed, Show::All);
        means.push(mean_and_variance(&film).0);
    }
    (means.mean(), means.variance_of_mean())
}

#[test]
fn a_plane_under_a_distant_light_has_the_dipoles_total_reflectance() {
    // The top of a flat box with sides of 20 mean free paths: the part beyond the box is exp(-7.7) of the reflected
    // light. Seen at 45 degrees.
    let (half, albedo) = (10.0, 0.8f32);
    let Geometry::Mesh(mut cube) = cube_inside() else { unreachable!("a mesh") };
    for p in &mut cube.positions {
        *p *= Vec3::new(half, half, 0.5);
    }
    cube.triangles.iter_mut().for_each(|t| t.reverse());
    let direction = -Vec3::Z;
    let parts = SceneParts {
        shapes: vec![solid(Geometry::Mesh(cube))],
        materials: vec![polish()],
        media: vec![medium(1.0, albedo)],
        lights: vec![LightSource::Directional { direction, irradiance: Rgb::WHITE }],
        ..SceneParts::default()
    };
    let (top, eye) = (Vec3::new(0.0, 0.0, 0.5), Vec3::new(3.0, 0.0, 3.5));
    let camera = CameraSpec::look_at(eye, top, Vec3::Y, 0.02, [8, 8]);
    let world = World::new(parts, &camera);
    let albedo = f64::from(albedo);
    let s = (3.0 * (1.0 - albedo)).sqrt();
    let total = 0.5 * albedo * (1.0 + (-4.0 / 3.0 * boundary() * s).exp()) * (-s).exp();
    let cos = 0.5f64.sqrt();
    let expected = (1.0 - fresnel(1.0)) * total / PI * (1.0 - fresnel(cos)) / enters();
    let (mean, variance) = mean_of_seeds(&world, 50_000, 12);
    assert!(variance.sqrt() < 0.01 * expected, "noise {:.1e}", variance.sqrt() / expected);
    // The light that would be reflected beyond the box is at most 5e-4 of the whole.
    let p = z_test(mean, variance + (5e-4 * expected).powi(2), expected, 0.0);
    assert!(p > ALPHA, "{mean} is not {expected} +- {:.1e} (p = {p:.1e})", variance.sqrt());
}

#[test]
fn a_ball_of_albedo_one_in_a_white_furnace_has_the_integral_of_the_dipole_over_a_sphere() {
    // On a sphere, the part of the surface within a chord r has the area pi r^2. Over the whole sphere, the dipole
    // integrates to 1 - z_r / 2 |(z_r, 2)| - z_v / 2 |(z_v, 2)|. It integrates to 1 only for half-spaces.
    let sigma_t = 40.0;
    let parts = SceneParts {
        shapes: vec![solid(sphere(Vec3::ZERO, 1.0))],
        materials: vec![polish()],
        media: vec![medium(sigma_t, 1.0)],
        lights: vec![LightSource::Constant { radiance: Rgb::WHITE }],
        ..SceneParts::default()
    };
    let eye = Vec3::new(0.0, 0.0, 3.0);
    let world = World::new(parts, &CameraSpec::look_at(eye, Vec3::ZERO, Vec3::Y, 0.02, [8, 8]));
    let z_r = 1.0 / f64::from(sigma_t);
    let z_v = z_r * (1.0 + 4.0 / 3.0 * boundary());
    let beyond = |z: f64| 0.5 * z / (z * z + 4.0).sqrt();
    let diffused = 1.0 - beyond(z_r) - beyond(z_v);
    let expected = fresnel(1.0) + (1.0 - fresnel(1.0)) * diffused;
    let (mean, variance) = mean_of_seeds(&world, 50_000, 12);
    assert!(variance.sqrt() < 0.01 * expected, "noise {:.1e}", variance.sqrt() / expected);
    let p = z_test(mean, variance, expected, 0.0);
    assert!(p > ALPHA, "{mean} is not {expected} +- {:.1e} (p = {p:.1e})", variance.sqrt());
}

#[test]
fn a_ball_in_a_glass_shell_is_as_bright_as_a_bare_one() {
    // The light that the shell reflects inward enters the ball again. If the boundary of the ball counted it as well,
    // it would be counted twice. The ball returns less than 1 (see the test above): this loss occurs once at least, and
    // again for the light that the shell reflects back.
    let glass = |eta| Material::Dielectric {
        eta,
        reflectance: Texture::grey(1.0),
        transmittance: Texture::grey(1.0),
        roughness: None,
    };
    let shell = Shape::new("shell", sphere(Vec3::ZERO, 1.1), 1);
    let parts = SceneParts {
        shapes: vec![solid(sphere(Vec3::ZERO, 1.0)), shell],
        materials: vec![glass(1.35 / 1.5), glass(1.5)],
        media: vec![medium(40.0, 1.0)],
        lights: vec![LightSource::Constant { radiance: Rgb::WHITE }],
        ..SceneParts::default()
    };
    let eye = Vec3::new(0.0, 0.0, 3.0);
    let world = World::new(parts, &CameraSpec::look_at(eye, Vec3::ZERO, Vec3::Y, 0.02, [8, 8]));
    let (mean, variance) = mean_of_seeds(&world, 50_000, 12);
    // z_r and z_v for a surface with little internal reflection.
    let missing = 0.5 * (2.0 + 4.0 / 3.0) / 40.0 / 2.0;
    let error = variance.sqrt();
    assert!(error < 0.02, "noise {error:.1e}");
    let range = 1.0 - 4.0 * missing - 4.0 * error..1.0 + 4.0 * error;
    assert!(range.contains(&mean), "{mean} +- {error:.1e} is not in {range:?}");
}

#[test]
fn the_dipole_is_refused_without_solids_and_with_the_camera_or_a_light_inside_one() {
    let lit = |material: Material, eye: f32, lamps: Vec<LightSource>| {
        let parts = SceneParts {
            shapes: vec![solid(sphere(Vec3::ZERO, 1.0))],
            materials: vec![material],
            media: vec![medium(3.0, 0.9)],
            lights: lamps,
            ..SceneParts::default()
        };
        let eye = Vec3::new(0.0, 0.0, eye);
        World::new(parts, &CameraSpec::look_at(eye, Vec3::ZERO, Vec3::Y, 0.5, [4, 4]))
    };
    let world =
        |material, eye| lit(material, eye, vec![LightSource::Constant { radiance: Rgb::WHITE }]);
    let refusal = |world: &World, photons| {
        PhotonMapping::prepare(world.setting(1, Show::All), &params(photons))
            .err()
            .unwrap_or_default()
    };
    assert_eq!(refusal(&world(polish(), 3.0), 100), "");
    assert!(refusal(&world(polish(), 3.0), 0).contains("no medium fills a solid"));
    assert!(refusal(&world(Material::Null, 3.0), 100).contains("no medium fills a solid"));
    assert!(refusal(&world(polish(), 0.5), 100).contains("camera stands inside"));
    let lamp = LightSource::Point { position: Vec3::X * 0.3, intensity: Rgb::WHITE };
    assert!(refusal(&lit(polish(), 3.0, vec![lamp]), 100).contains("no light stands in it"));
}
