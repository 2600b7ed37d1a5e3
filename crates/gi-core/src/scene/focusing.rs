//! What focuses light without being a perfect mirror.

use super::Scene;
use crate::bsdf::PreparedMaterial;
use crate::light::Targets;
use crate::light::sphere_round;
use crate::material::{Material, Roughness};
use crate::texture::Texture;

impl Scene {
    /// As [`Scene::focusing`], with what has a lobe of metal or glass whose alpha may be below `alpha`.
    pub fn focusing_below(&self, alpha: f32) -> Targets {
        let mut spheres = Vec::new();
        let own = self.shapes.len() - self.group_shapes.iter().map(|g| g.len()).sum::<usize>();
        let focuses = |material| may_focus(&self.materials, material, alpha);
        let shapes = self.shapes[..own].iter().filter(|shape| focuses(shape.material));
        spheres.extend(shapes.map(sphere_round));
        for instance in &self.instances {
            let group = self.group_shapes[instance.group].clone();
            for shape in self.shapes[group].iter().filter(|shape| focuses(shape.material)) {
                let bounds = shape.geometry.bounds().transformed(&instance.to_world);
                spheres.push((bounds.center(), 0.5 * bounds.extent().length()));
            }
        }
        Targets::new(spheres)
    }
}

fn may_focus(materials: &[PreparedMaterial], id: usize, alpha: f32) -> bool {
    let prepared = &materials[id];
    let is_sharp = match &prepared.material {
        Material::Conductor { roughness: Some(r), .. }
        | Material::Dielectric { roughness: Some(r), .. } => may_be_below(r, alpha),
        _ => false,
    };
    let children = prepared.material.children();
    prepared.has_delta || is_sharp || children.into_iter().any(|c| may_focus(materials, c, alpha))
}

/// Whether either alpha is below `alpha` anywhere, as far as is known without reading pictures.
fn may_be_below(roughness: &Roughness, alpha: f32) -> bool {
    [&roughness.alpha_u, &roughness.alpha_v].into_iter().any(|texture| match texture {
        Texture::Constant(c) => c.mean() < alpha,
        _ => true,
    })
}
