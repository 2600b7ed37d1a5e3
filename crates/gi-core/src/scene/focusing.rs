//! Shapes that focus light: perfect and nearly perfect mirrors and glass.

use super::Scene;
use crate::bsdf::PreparedMaterial;
use crate::geometry::Shape;
use crate::light::{Targets, sphere_round};
use crate::material::{Material, Roughness};
use crate::texture::Texture;

impl Scene {
    /// All shapes with a delta lobe: light is focused only if its path hits one of them first.
    pub fn focusing(&self) -> Targets {
        self.targets(|material| self.materials[material].has_delta)
    }

    /// The same, and also shapes of metal or glass whose roughness may be below `alpha`.
    pub fn focusing_below(&self, alpha: f32) -> Targets {
        self.targets(|material| may_focus(&self.materials, material, alpha))
    }

    /// All shapes whose material is accepted.
    fn targets(&self, is_wanted: impl Fn(usize) -> bool) -> Targets {
        let own = self.shapes.len() - self.group_shapes.iter().map(|g| g.len()).sum::<usize>();
        let is_wanted = |shape: &&Shape| is_wanted(shape.material);
        let mut spheres: Vec<_> =
            self.shapes[..own].iter().filter(is_wanted).map(sphere_round).collect();
        for instance in &self.instances {
            let group = self.group_shapes[instance.group].clone();
            for shape in self.shapes[group].iter().filter(is_wanted) {
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

/// Whether the roughness may be below `alpha` at some point. Textures with pictures count as if it were.
fn may_be_below(roughness: &Roughness, alpha: f32) -> bool {
    [&roughness.alpha_u, &roughness.alpha_v].into_iter().any(|texture| match texture {
        Texture::Constant(c) => c.mean() < alpha,
        _ => true,
    })
}
