//! Facts about paths from the eye.

use glam::Vec3;

use super::{EyeWalk, GatherRay};
use crate::geometry::{Geometry, Shape};
use crate::material::Material;
use crate::math::Frame;
use crate::options::PathLimits;
use crate::ray::Ray;
use crate::sampler::Sampler;
use crate::scene::{Scene, SceneParts};
use crate::texture::Texture;

/// Probability that light passes straight through the wall of the cavity.
const HOLES: f32 = 0.04;

/// A white sphere whose wall lets the fraction [`HOLES`] of the light pass.
fn white_cavity() -> Scene {
    let axes = Frame::from_normal(Vec3::Z);
    let sphere = Geometry::Sphere { center: Vec3::ZERO, radius: 1.0, axes };
    let white = Material::Diffuse { reflectance: Texture::grey(1.0) };
    let wall = Material::Mask { opacity: Texture::grey(1.0 - HOLES), inner: 0 };
    let parts = SceneParts {
        shapes: vec![Shape { flip_normals: true, ..Shape::new("sphere", sphere, 1) }],
        materials: vec![white, wall],
        ..SceneParts::default()
    };
    Scene::new(parts).expect("a scene")
}

/// The throughputs with which paths leave the cavity are 1 on average, because no light is lost. If paths survive each
/// scattering with probability s or more, their second moment is at most q / (1 - (1 - q) / s) / s, where q = [`HOLES`]: 1.33 for s
/// = 0.99, and infinite for s = 0.95.
#[test]
fn paths_in_a_white_cavity_have_no_huge_throughput() {
    let (scene, paths) = (white_cavity(), 20_000);
    let (mut sum, mut squares, mut largest) = (0.0, 0.0, 0.0f64);
    for path in 0..paths {
        let ray = Ray::new(Vec3::ZERO, Vec3::Z);
        let start = GatherRay { ray, segments: 1, length: 0.0 };
        let sampler = Sampler::new(1, 0, path);
        let mut walk = EyeWalk::along(&scene, PathLimits::default(), start, sampler);
        let left = loop {
            let Some(v) = &walk.next_vertex() else { break f64::from(walk.throughput().g) };
            if !walk.scatter(v) {
                break 0.0;
            }
        };
        sum += left;
        squares += left * left;
        largest = largest.max(left);
    }
    let (mean, square) = (sum / f64::from(paths), squares / f64::from(paths));
    let standard_error = ((square - mean * mean) / f64::from(paths)).sqrt();
    assert!((mean - 1.0).abs() < 4.0 * standard_error, "{mean} +- {standard_error}");
    assert!(square < 1.5, "second moment {square}, largest {largest}");
}
