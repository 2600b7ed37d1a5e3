//! Counts of what a scene contains.

use std::collections::BTreeMap;

use gi_core::geometry::{Geometry, Shape};
use gi_core::light::{LightSource, Window};
use gi_core::material::Material;
use gi_core::scene::SceneParts;

/// Counts by kind.
type Kinds = BTreeMap<&'static str, usize>;

/// What a scene contains.
pub(super) struct Counts {
    shapes: Kinds,
    triangles: usize,
    groups: usize,
    instances: usize,
    /// Materials that shapes use, without those that only wrap others.
    materials: Kinds,
    lights: Kinds,
}

impl Counts {
    pub(super) fn of(parts: &SceneParts) -> Counts {
        let mut counts = Counts {
            shapes: Kinds::new(),
            triangles: 0,
            groups: parts.groups.len(),
            instances: parts.instances.len(),
            materials: Kinds::new(),
            lights: Kinds::new(),
        };
        let mut used = vec![false; parts.materials.len()];
        for shape in parts.shapes.iter().chain(parts.groups.iter().flatten()) {
            counts.shape(shape);
            used[shape.material] = true;
        }
        mark_children(&parts.materials, &mut used);
        for (material, _) in parts.materials.iter().zip(&used).filter(|(_, used)| **used) {
            if let Some(kind) = material_kind(material) {
                *counts.materials.entry(kind).or_default() += 1;
            }
        }
        for light in &parts.lights {
            *counts.lights.entry(light_kind(light)).or_default() += 1;
        }
        counts
    }

    fn shape(&mut self, shape: &Shape) {
        let kind = match &shape.geometry {
            Geometry::Mesh(mesh) => {
                self.triangles += mesh.triangles.len();
                "mesh"
            }
            Geometry::Sphere { .. } => "sphere",
            Geometry::Disk { .. } => "disk",
            Geometry::Cylinder { .. } => "cylinder",
        };
        *self.shapes.entry(kind).or_default() += 1;
        if shape.emission.is_some() {
            *self.lights.entry("emitting shape").or_default() += 1;
        }
    }

    pub(super) fn shapes(&self) -> String {
        let groups = match self.groups {
            0 => String::new(),
            n => format!("; {n} groups, placed {} times", self.instances),
        };
        format!("{}; {} triangles{groups}", list(&self.shapes), self.triangles)
    }

    pub(super) fn materials(&self) -> String {
        list(&self.materials)
    }

    /// `primitives`: the number of lights that techniques choose from, one per emitting triangle.
    pub(super) fn lights(&self, primitives: usize) -> String {
        format!("{}; {primitives} to choose from, one per emitting triangle", list(&self.lights))
    }
}

/// Mark the materials that marked ones use. Children come before their parents.
fn mark_children(materials: &[Material], used: &mut [bool]) {
    for id in (0..materials.len()).rev() {
        if used[id] {
            materials[id].children().into_iter().for_each(|child| used[child] = true);
        }
    }
}

/// "3: 2 mesh, 1 sphere".
fn list(kinds: &Kinds) -> String {
    let total: usize = kinds.values().sum();
    let parts: Vec<String> = kinds.iter().map(|(kind, n)| format!("{n} {kind}")).collect();
    match total {
        0 => "0".into(),
        _ => format!("{total}: {}", parts.join(", ")),
    }
}

/// The name of a material; `None` if it only wraps others.
fn material_kind(material: &Material) -> Option<&'static str> {
    Some(match material {
        Material::Diffuse { .. } => "diffuse",
        Material::RoughDiffuse { .. } => "roughdiffuse",
        Material::Conductor { roughness: None, .. } => "conductor",
        Material::Conductor { .. } => "roughconductor",
        Material::Dielectric { roughness: None, .. } => "dielectric",
        Material::Dielectric { .. } => "roughdielectric",
        Material::ThinDielectric { .. } => "thindielectric",
        Material::Plastic { roughness: None, .. } => "plastic",
        Material::Plastic { .. } => "roughplastic",
        Material::Phong { .. } => "phong",
        Material::Principled(_) => "principled",
        Material::PrincipledThin(_) => "principledthin",
        Material::Null => "null",
        Material::Mask { .. }
        | Material::TwoSided { .. }
        | Material::Blend { .. }
        | Material::Bump { .. }
        | Material::NormalMap { .. } => return None,
    })
}

fn light_kind(light: &LightSource) -> &'static str {
    match light {
        LightSource::Point { .. } => "point",
        LightSource::Spot { .. } => "spot",
        LightSource::Projector { window: Window::Cone, .. } => "spot with a picture",
        LightSource::Projector { window: Window::Unfolded | Window::Latitudes, .. } => {
            "goniometric"
        }
        LightSource::Projector { .. } => "projector",
        LightSource::Directional { .. } => "directional",
        LightSource::Constant { .. } => "constant",
        LightSource::Environment { .. } => "environment",
        LightSource::DistantDisc { .. } => "sun",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gi_core::math::Rgb;
    use gi_core::texture::Texture;
    use glam::Vec3;

    #[test]
    fn only_materials_that_shapes_use_are_counted() {
        let diffuse = || Material::Diffuse { reflectance: Texture::grey(0.5) };
        let disk = Geometry::Disk { center: Vec3::ZERO, du: Vec3::X, dv: Vec3::Y };
        let mut lamp = Shape::new("lamp", disk, 2);
        lamp.emission = Some(Texture::Constant(Rgb::WHITE));
        let parts = SceneParts {
            materials: vec![diffuse(), Material::Null, Material::TwoSided { front: 0, back: 0 }],
            shapes: vec![lamp],
            lights: vec![LightSource::Constant { radiance: Rgb::WHITE }],
            ..SceneParts::default()
        };
        let counts = Counts::of(&parts);
        assert_eq!(counts.materials(), "1: 1 diffuse");
        assert_eq!(counts.shapes(), "1: 1 disk; 0 triangles");
        assert_eq!(
            counts.lights(2),
            "2: 1 constant, 1 emitting shape; 2 to choose from, one per emitting triangle"
        );
    }
}
