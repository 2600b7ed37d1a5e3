use super::*;
use crate::Receiver;
use gi_core::bsdf::Transport;
use gi_core::geometry::{Geometry, Shape};
use gi_core::light::LightSource;
use gi_core::material::Material;
use gi_core::math::Frame;
use gi_core::ray::Ray;
use gi_core::scene::SceneParts;
use gi_core::texture::Texture;
use std::f32::consts::PI;

/// The inside of a unit sphere with this albedo, with a point light of intensity 1 at some point inside.
fn sphere(albedo: f32) -> Scene {
    let axes = Frame::from_normal(Vec3::Z);
    let geometry = Geometry::Sphere { center: Vec3::ZERO, radius: 1.0, axes };
    let shapes = vec![Shape { flip_normals: true, ..Shape::new("sphere", geometry, 0) }];
    let materials = vec![Material::Diffuse { reflectance: Texture::grey(albedo) }];
    let position = Vec3::new(0.2, 0.1, -0.3);
    let lights = vec![LightSource::Point { position, intensity: Rgb::WHITE }];
    let parts = SceneParts { shapes, materials, lights, ..SceneParts::default() };
    Scene::new(parts).expect("a scene")
}

fn shooting(scene: &Scene, termination: Termination) -> Shooting {
    let pilot = Pilot::of(scene, 3, false);
    let (paths, max_scatterings) = (4096, None);
    Shooting {
        seed: 1,
        first_path: 0,
        paths,
        termination,
        max_scatterings,
        lights: false,
        pilot,
        through_media: false,
    }
}

#[test]
fn powers_add_up_to_the_geometric_series() {
    let albedo = 0.6f32;
    let scene = sphere(albedo);
    for termination in [Termination::Fractional, Termination::Roulette] {
        let how = shooting(&scene, termination);
        // The pilot's reflectance is estimated from some 5000 scatterings.
        assert!((how.pilot.reflectance - albedo).abs() < 0.03, "{:?}", how.pilot);
        let set = shoot(&scene, &how);
        let emitted = 4.0 * PI;
        assert!((set.emitted.g / emitted - 1.0).abs() < 1e-4);
        // The lights have the powers rho Phi, rho^2 Phi, ... : in total rho / (1 - rho) Phi. With Russian roulette,
        // each survivor has the power of its path, and their number per path has a standard deviation of sqrt(rho) / (1
        // - rho).
        let left: f32 = set.lights.iter().map(|v| v.power.g * PI).sum();
        let expected = albedo / (1.0 - albedo) * emitted;
        let sigma = albedo.sqrt() / (1.0 - albedo) / 64.0 * albedo;
        assert!(
            (left / emitted - expected / emitted).abs() < 4.0 * sigma,
            "{termination:?}: {left} is not {expected}"
        );
        assert!((set.arrived.g * albedo / left - 1.0).abs() < 1e-4);
        if termination == Termination::Fractional {
            let first = set.up_to(1);
            let power: f32 = first.iter().map(|v| v.power.g * PI).sum();
            assert!(
                (power / (albedo * emitted) - 1.0).abs() < 1e-4,
                "every path leaves at least one light"
            );
            assert_eq!(first.len(), 4096);
        }
        assert!(set.lights.is_sorted_by_key(|v| v.depth));
    }
}

#[test]
fn one_light_by_hand() {
    let scene = sphere(0.5);
    let p = Vec3::new(0.0, 0.0, 1.0);
    let power = Rgb::new(1.0, 2.0, 3.0);
    let vpl = Vpl { p, n: -Vec3::Z, ns: -Vec3::Z, power, kind: Kind::Oriented, depth: 1, on: None };
    let set = Vpls::default();
    // The sphere's lowest point, seen from its centre: cosines 1, distance 2, f = 0.5 / pi.
    let ray = Ray::new(Vec3::ZERO, -Vec3::Z);
    let (surface, _) = scene.intersect(&ray).expect("the sphere");
    let wo = Vec3::Z;
    let bsdf = scene.bsdf(&surface, wo, Transport::Radiance);
    let at = Receiver::new(&surface, wo, &bsdf);
    let c = set.connect(&scene, &vpl, &at).expect("they face each other");
    assert!((c.radiance.g - 2.0 * 0.5 / PI / 4.0).abs() < 1e-6 && (c.geometry - 0.25).abs() < 1e-6);
    assert!(!scene.tree().occluded(&c.shadow));
    // A point at the side: on a unit sphere, cos cos' / d^2 is 1/4 for any two points.
    let ray = Ray::new(Vec3::ZERO, Vec3::X);
    let (surface, _) = scene.intersect(&ray).expect("hits the sphere");
    let bsdf = scene.bsdf(&surface, -Vec3::X, Transport::Radiance);
    let at = Receiver::new(&surface, -Vec3::X, &bsdf);
    let c = set.connect(&scene, &vpl, &at).expect("they see each other");
    assert!((c.geometry - 0.25).abs() < 1e-6);
    // A light that faces away illuminates nothing; parallel light does not fall off.
    assert!(set.connect(&scene, &Vpl { n: Vec3::Z, ns: Vec3::Z, ..vpl }, &at).is_none());
    let sun = Vpl { n: Vec3::X, kind: Kind::Directional, ..vpl };
    let c = set.connect(&scene, &sun, &at).expect("it shines on it");
    assert!((c.radiance.b - 3.0 * 0.5 / PI).abs() < 1e-6);
}

#[test]
fn the_lights_are_the_same_for_any_number_of_threads_and_sets_join_into_one() {
    let scene = sphere(0.7);
    let how = shooting(&scene, Termination::Roulette);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| shoot(&scene, &how)).lights
    };
    let one = with(1);
    assert!(one == with(2) && one == with(4));
    let half = |first_path| shoot(&scene, &Shooting { first_path, paths: 2048, ..how }).lights;
    assert_eq!(half(0).len() + half(2048).len(), one.len());
}
