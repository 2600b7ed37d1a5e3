use super::*;
use crate::bsdf::Transport;
use crate::geometry::{Geometry, Shape};
use crate::light::LightSource;
use crate::material::Material;
use crate::math::Frame;
use crate::ray::Ray;
use crate::scene::SceneParts;
use crate::texture::Texture;

const ALBEDO: f32 = 0.5;
const RADIUS: f32 = 2.0;

/// A point light at the centre of a sphere, inside a glass ball if `bulb`.
fn lit_sphere(bulb: bool) -> Scene {
    let sphere = |radius, material| {
        let axes = Frame::from_normal(Vec3::Z);
        Shape::new("sphere", Geometry::Sphere { center: Vec3::ZERO, radius, axes }, material)
    };
    let room = Shape { flip_normals: true, ..sphere(RADIUS, 0) };
    let white = || Texture::grey(1.0);
    let parts = SceneParts {
        shapes: std::iter::once(room).chain(bulb.then(|| sphere(0.3, 1))).collect(),
        materials: vec![
            Material::Diffuse { reflectance: Texture::grey(ALBEDO) },
            Material::Dielectric {
                eta: 1.5,
                reflectance: white(),
                transmittance: white(),
                roughness: None,
            },
        ],
        lights: vec![LightSource::Point { position: Vec3::ZERO, intensity: Rgb::WHITE }],
        ..SceneParts::default()
    };
    Scene::new(parts).expect("a scene")
}

/// The focused light at a point of the sphere.
fn read(scene: &Scene, light: &FocusedLight, d: Vec3, deepest: u32) -> Option<f32> {
    let (surface, _) = scene.intersect(&Ray::new(d, d)).expect("the sphere");
    let bsdf = scene.bsdf(&surface, -d, Transport::Radiance);
    light.radiance(scene, (&surface, -d, &bsdf), deepest).map(|c| c.g)
}

#[test]
fn a_point_light_in_a_glass_bulb_lights_the_room() {
    let scene = lit_sphere(true);
    let mut light = FocusedLight::new(&scene, 1, 1 << 16);
    let (mut sum, mut count) = (0.0f64, 0u32);
    for pass in 0..4 {
        light.shoot(&scene, 1, pass);
        for k in 0..50 {
            let (z, angle) = ((k as f32 + 0.5) / 25.0 - 1.0, 2.4 * k as f32);
            let d = Vec3::new(angle.cos(), angle.sin(), 0.0) * (1.0 - z * z).sqrt();
            sum += f64::from(read(&scene, &light, d.with_z(z), u32::MAX).expect("photons"));
            count += 1;
        }
        // The light passes the glass once: fewer scatterings are not enough.
        assert_eq!(read(&scene, &light, Vec3::X, 0), Some(0.0));
    }
    // No light is lost, because it hits the glass at normal incidence. A disc contains some eight photons, in each of
    // 200 readings.
    let expected = f64::from(ALBEDO / PI / (RADIUS * RADIUS));
    let ratio = sum / f64::from(count) / expected;
    assert!((ratio - 1.0).abs() < 4.0 / (8.0 * f64::from(count)).sqrt(), "{ratio}");
}

#[test]
fn without_mirrors_and_glass_there_is_no_focused_light() {
    let scene = lit_sphere(false);
    let mut light = FocusedLight::new(&scene, 1, 1 << 16);
    light.shoot(&scene, 1, 0);
    assert!(!light.is_some() && read(&scene, &light, Vec3::X, u32::MAX).is_none());
}
