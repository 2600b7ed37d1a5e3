//! Scenes of the tests.

use gi_core::geometry::{Geometry, Mesh, Shape};
use gi_core::light::LightSource;
use gi_core::material::Material;
use gi_core::math::{Frame, Rgb};
use gi_core::scene::{Scene, SceneParts};
use gi_core::texture::Texture;
use glam::Vec3;

fn grey(albedo: f32) -> Material {
    Material::Diffuse { reflectance: Texture::grey(albedo) }
}

fn glass() -> Material {
    Material::Dielectric {
        eta: 1.5,
        reflectance: Texture::grey(1.0),
        transmittance: Texture::grey(1.0),
        roughness: None,
    }
}

fn sphere(center: Vec3, radius: f32) -> Geometry {
    Geometry::Sphere { center, radius, axes: Frame::from_normal(Vec3::Z) }
}

/// A horizontal square round `center`, its normal up.
fn square(center: Vec3, half: f32) -> Geometry {
    let corner = |x: f32, z: f32| center + Vec3::new(x, 0.0, z) * half;
    let positions =
        vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    Geometry::Mesh(Mesh {
        positions,
        triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
        ..Mesh::default()
    })
}

fn scene(parts: SceneParts) -> Scene {
    Scene::new(parts).expect("a valid scene")
}

/// A point light of intensity 1 in the middle of a unit sphere of albedo 1/2.
pub(crate) fn lit_sphere() -> Scene {
    let shape = Shape { flip_normals: true, ..Shape::new("sphere", sphere(Vec3::ZERO, 1.0), 0) };
    scene(SceneParts {
        shapes: vec![shape],
        materials: vec![grey(0.5)],
        lights: vec![LightSource::Point { position: Vec3::ZERO, intensity: Rgb::WHITE }],
        ..SceneParts::default()
    })
}

/// A small glass ball and a mirror ball over a wide floor under a lamp, with a sky besides.
pub(crate) fn glass_over_floor() -> Scene {
    let lamp = Shape {
        emission: Some(Texture::grey(5.0)),
        flip_normals: true,
        ..Shape::new("lamp", square(Vec3::new(0.0, 3.0, 0.0), 0.3), 1)
    };
    let mirror = Material::Conductor {
        eta: Rgb::BLACK,
        k: Rgb::WHITE,
        reflectance: Texture::grey(0.9),
        roughness: None,
    };
    scene(SceneParts {
        shapes: vec![
            Shape::new("floor", square(Vec3::ZERO, 4.0), 0),
            lamp,
            Shape::new("glass", sphere(Vec3::new(0.2, 1.0, 0.1), 0.3), 2),
            Shape::new("mirror", sphere(Vec3::new(-0.9, 0.5, 0.4), 0.2), 3),
        ],
        materials: vec![grey(0.5), grey(0.0), glass(), mirror],
        lights: vec![LightSource::Constant { radiance: Rgb::grey(0.05) }],
        ..SceneParts::default()
    })
}

/// A glass ball between a floor and a ceiling. The ceiling consists of four squares around a small hole, through which the
/// sky shines.
pub(crate) fn glass_below_a_hole() -> Scene {
    let (half, hole) = (30.0, 0.15);
    let (near, far) = (half - hole, half + hole);
    let centers = [(near, far), (far, -near), (-near, -far), (-far, near)];
    let tiles = centers.map(|(x, z)| square(Vec3::new(x, 1.6, z), half));
    let shapes = std::iter::once(square(Vec3::ZERO, half)).chain(tiles);
    let ball = Shape::new("glass", sphere(Vec3::new(0.1, 1.0, 0.2), 0.3), 1);
    scene(SceneParts {
        shapes: shapes.map(|s| Shape::new("square", s, 0)).chain([ball]).collect(),
        materials: vec![grey(0.5), glass()],
        lights: vec![LightSource::Constant { radiance: Rgb::WHITE }],
        ..SceneParts::default()
    })
}

/// Parallel light of irradiance 3 straight down on a black floor; below it, a hair's breadth away, its other side.
pub(crate) fn lit_plane() -> Scene {
    let below = Shape {
        flip_normals: true,
        ..Shape::new("below", square(Vec3::new(0.0, -1e-3, 0.0), 1.0), 0)
    };
    scene(SceneParts {
        shapes: vec![Shape::new("floor", square(Vec3::ZERO, 1.0), 0), below],
        materials: vec![grey(0.0)],
        lights: vec![LightSource::Directional { direction: -Vec3::Y, irradiance: Rgb::grey(3.0) }],
        ..SceneParts::default()
    })
}
