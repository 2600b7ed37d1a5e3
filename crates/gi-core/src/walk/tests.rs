use super::*;
use crate::geometry::{Geometry, Shape};
use crate::light::LightSource;
use crate::material::Material;
use crate::math::Frame;
use crate::scene::SceneParts;
use crate::texture::Texture;

/// A point light in a sphere with this albedo.
fn lit_sphere(albedo: f32) -> Scene {
    let axes = Frame::from_normal(Vec3::Z);
    let sphere = Geometry::Sphere { center: Vec3::ZERO, radius: 1.0, axes };
    let shapes = vec![Shape { flip_normals: true, ..Shape::new("sphere", sphere, 0) }];
    let materials = vec![Material::Diffuse { reflectance: Texture::grey(albedo) }];
    let lights = vec![LightSource::Point { position: Vec3::ZERO, intensity: Rgb::WHITE }];
    let parts = SceneParts { shapes, materials, lights, ..SceneParts::default() };
    Scene::new(parts).expect("a scene")
}

#[test]
fn paths_without_absorption_end() {
    let scene = lit_sphere(1.0);
    let mut scatterings = 0.0;
    for path in 0..100 {
        let mut walk = LightWalk::begin(&scene, Sampler::new(1, 0, path)).expect("it shines");
        while let Some(vertex) = walk.next_vertex() {
            // One path in 10^17 is longer.
            assert!(vertex.depth < 40_000, "path {path} does not end");
            scatterings += 0.01;
            if !walk.scatter(&vertex, Roulette::ByAlbedo { from: 1 }) {
                break;
            }
        }
    }
    // 1000 scatterings, and on average as many again. The mean of a hundred paths has a standard error of 100.
    assert!((scatterings - 2000.0f64).abs() < 400.0, "{scatterings}");
}

#[test]
fn a_techniques_random_numbers_do_not_depend_on_the_survival_of_the_path() {
    let scene = lit_sphere(0.5);
    let (mut sum, mut count) = (0.0f64, 0u32);
    for path in 0..20_000 {
        let mut walk = LightWalk::begin(&scene, Sampler::new(1, 0, path)).expect("it shines");
        while let Some(vertex) = walk.next_vertex() {
            if vertex.depth > 0 {
                sum += f64::from(walk.sampler().next_1d());
                count += 1;
            }
            if !walk.scatter(&vertex, Roulette::ByAlbedo { from: 1 }) {
                break;
            }
        }
    }
    // Uniform numbers have a mean of 1/2 with standard error 1 / sqrt(12 n).
    let error = (12.0 * f64::from(count)).sqrt().recip();
    let mean = sum / f64::from(count);
    assert!((mean - 0.5).abs() < 5.0 * error, "{mean} +- {error} over {count} vertices");
}
