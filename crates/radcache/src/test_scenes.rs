//! Scenes for tests.

use gi_core::geometry::{Geometry, Shape};
use gi_core::material::{Distribution, Material, Roughness};
use gi_core::math::{Frame, Rgb};
use gi_core::scene::{Scene, SceneParts};
use gi_core::texture::Texture;
use glam::Vec3;

/// A ball with a perfectly reflecting rough conductor.
pub(crate) fn lobe_scene(alpha: f32) -> Scene {
    let alpha = Texture::grey(alpha);
    let roughness =
        Roughness { distribution: Distribution::Ggx, alpha_u: alpha.clone(), alpha_v: alpha };
    let material = Material::Conductor {
        eta: Rgb::BLACK,
        k: Rgb::WHITE,
        reflectance: Texture::grey(1.0),
        roughness: Some(roughness),
    };
    let axes = Frame::from_normal(Vec3::Z);
    let ball = Geometry::Sphere { center: Vec3::ZERO, radius: 1.0, axes };
    let shapes = vec![Shape::new("ball", ball, 0)];
    Scene::new(SceneParts { shapes, materials: vec![material], ..SceneParts::default() })
        .expect("valid")
}
