//! Measures how much light is focused by mirrors and glass. Paths from the eye find such light rarely or never.

use super::{LightWalk, Roulette};
use crate::light::Light;
use crate::sampler::Sampler;
use crate::scene::Scene;

/// Number of light paths that are traced.
const PATHS: u32 = 4096;
/// Separates their random numbers from all others.
const SALT: u32 = 0x666f_6375;
/// Maximum number of delta scatterings per path.
const MOST_MET: u32 = 32;
/// A lamp is small if it covers less than this fraction of the sphere of directions.
const SMALL: f32 = 2e-3;

/// Fractions of the light that reaches a first surface with lobes that are not delta lobes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Focused {
    /// Light that came over delta lobes from a point, spot or directional light: paths from the eye cannot find it.
    pub unreachable: f32,
    /// Light that came over delta lobes from a small lamp: paths from the eye find it rarely, as a few bright pixels.
    pub rare: f32,
}

/// Smaller fractions do not matter.
const LITTLE: f32 = 0.01;

impl Focused {
    /// Whether the fraction of such light is large enough to matter.
    pub fn matters(&self) -> bool {
        self.unreachable >= LITTLE || self.rare >= LITTLE
    }
}

/// Trace a few light paths and measure the fractions.
pub fn focused(scene: &Scene, seed: u32) -> Focused {
    let (mut all, mut found) = (0.0, Focused::default());
    for path in 0..PATHS {
        let Some(mut walk) = LightWalk::begin(scene, Sampler::new(seed ^ SALT, 0, path)) else {
            continue;
        };
        let light = &scene.lights().all()[walk.emission().light as usize];
        while let Some(vertex) = &walk.next_vertex() {
            if !vertex.bsdf.is_delta() {
                let power = vertex.power.luminance();
                all += power;
                if vertex.after_delta && is_delta(light) {
                    found.unreachable += power;
                } else if vertex.after_delta && is_small(scene, light) {
                    found.rare += power;
                }
                break;
            }
            if vertex.depth >= MOST_MET || !walk.scatter(vertex, Roulette::ByAlbedo { from: 4 }) {
                break;
            }
        }
    }
    if all > 0.0 {
        (found.unreachable, found.rare) = (found.unreachable / all, found.rare / all);
    }
    found
}

/// Whether a path from the eye cannot hit the light.
fn is_delta(light: &Light) -> bool {
    matches!(light, Light::Point { .. } | Light::Spot { .. } | Light::Directional { .. })
}

/// Whether a light covers little of the sphere of directions, as seen from the distance of the scene's radius.
fn is_small(scene: &Scene, light: &Light) -> bool {
    match light {
        Light::DistantDisc { one_minus_cos, .. } => 0.5 * one_minus_cos < SMALL,
        Light::Area { shape, .. } => {
            let extent = scene.shapes()[*shape as usize].geometry.bounds().extent();
            // A sphere with this diameter, as seen from that distance.
            (0.25 * extent.length() / scene.radius()).powi(2) < SMALL
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Geometry, Shape};
    use crate::light::LightSource;
    use crate::material::Material;
    use crate::math::{Frame, Rgb};
    use crate::scene::SceneParts;
    use crate::texture::Texture;
    use glam::Vec3;

    #[test]
    fn all_light_of_a_point_in_a_glass_bulb_is_focused_and_none_of_a_bare_one() {
        let sphere = |radius, material| {
            let axes = Frame::from_normal(Vec3::Z);
            Shape::new("sphere", Geometry::Sphere { center: Vec3::ZERO, radius, axes }, material)
        };
        let white = || Texture::grey(1.0);
        let room = Shape { flip_normals: true, ..sphere(2.0, 0) };
        for (bulb, expected) in [(None, 0.0), (Some(sphere(0.1, 1)), 1.0)] {
            let parts = SceneParts {
                shapes: std::iter::once(room.clone()).chain(bulb).collect(),
                materials: vec![
                    Material::Diffuse { reflectance: Texture::grey(0.5) },
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
            let scene = Scene::new(parts).expect("a scene");
            let found = focused(&scene, 1);
            assert_eq!(found, Focused { unreachable: expected, rare: 0.0 });
        }
    }
}
