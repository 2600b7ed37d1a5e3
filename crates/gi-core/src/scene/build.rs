use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use gi_bvh::{BuildError, Bvh, Solid, Triangle};
use glam::{Mat3, Vec3};

use super::primitives::Primitives;
use super::{PreparedInstance, Scene, SceneParts};
use crate::bsdf::{MAX_COMPONENTS, PreparedMaterial, check_children, component_counts};
use crate::geometry::{Geometry, Instance, Shape};
use crate::light::Lights;
use crate::material::Material;
use crate::math::Bounds;
use crate::medium::MediumId;

/// Why a scene could not be built.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneError {
    /// A shape or instance uses a material, medium or group that does not exist, or a child comes after its parent.
    Dangling(String),
    /// A shape that the tree cannot contain.
    Shape {
        /// The shape's name.
        name: String,
        /// What is wrong with it.
        cause: String,
    },
    /// A material that blends more than [`MAX_COMPONENTS`] lobes.
    TooManyLobes {
        /// The name of a shape with this material.
        shape: String,
        /// How many it blends.
        lobes: usize,
    },
    /// A scene so large that areas and powers overflow.
    TooLarge {
        /// Its size, world units.
        extent: f32,
    },
    /// An emitting shape in a group: its copies would have to be lights.
    ShiningGroup {
        /// The shape's name.
        shape: String,
    },
}

/// Largest diagonal of a scene: twice the radius of its bounding sphere. The fourth power of this radius is still a finite
/// float. Squares of areas, such as the squared length of a cross product, are of that order.
const LARGEST: f32 = 8e9;

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SceneError::Dangling(what) => write!(f, "{what}"),
            SceneError::Shape { name, cause } => write!(f, "shape \"{name}\": {cause}"),
            SceneError::TooManyLobes { shape, lobes } => {
                write!(
                    f,
                    "the material of shape \"{shape}\" blends {lobes} lobes; the maximum is {MAX_COMPONENTS}: \
                     blend fewer materials"
                )
            }
            SceneError::TooLarge { extent } => write!(
                f,
                "the scene is {extent:.1e} units across; more than {LARGEST:.0e} overflows single precision for areas \
                 and powers: scale it down"
            ),
            SceneError::ShiningGroup { shape } => {
                write!(f, "shape \"{shape}\" emits light, which shapes of a group must not")
            }
        }
    }
}

impl std::error::Error for SceneError {}

impl Scene {
    /// Build the scene: its trees and tables.
    ///
    /// # Errors
    /// See [`SceneError`]. An empty scene is valid.
    pub fn new(parts: SceneParts) -> Result<Self, SceneError> {
        check(&parts)?;
        let SceneParts {
            shapes,
            groups,
            instances,
            materials,
            media,
            lights,
            hides_emitters,
            origin,
        } = parts;
        let own_shapes = shapes.len();
        let group_shapes = ranges(own_shapes, groups.iter().map(Vec::len));
        let shapes: Vec<Shape> = shapes.into_iter().chain(groups.into_iter().flatten()).collect();
        let primitives = Primitives::new(&shapes)?;

        let tree = whole_tree(&shapes, &primitives, (own_shapes, &group_shapes), &instances)?;
        let materials = prepare(materials);
        let has_null = shapes.iter().any(|s| materials[s.material].has_null);
        let bounds = tree.bounds();
        if !bounds.is_empty() && bounds.extent().length() > LARGEST {
            return Err(SceneError::TooLarge { extent: bounds.extent().length() });
        }
        let sphere = bounding_sphere(bounds);
        let lights = Lights::new(&shapes[..own_shapes], lights, sphere);
        let instances = instances.iter().map(prepare_instance).collect();
        let is_there = |m: MediumId| !media[m.index()].sigma_t.is_black();
        let has_media =
            shapes.iter().any(|s| s.interior.into_iter().chain(s.exterior).any(is_there));
        let has_varying_media = media.iter().any(|m| m.varying.is_some());
        let mut scene = Scene {
            shapes,
            primitives,
            instances,
            group_shapes,
            materials,
            media,
            lights,
            tree,
            bounds,
            hides_emitters,
            origin,
            has_null,
            has_media,
            has_varying_media,
            light_media: Vec::new(),
        };
        scene.find_media_round_lights();
        Ok(scene)
    }
}

/// Build one tree per group, then the tree of the whole scene with its instances. The first `own_shapes` shapes belong to no group.
fn whole_tree(
    shapes: &[Shape],
    primitives: &Primitives,
    (own_shapes, group_shapes): (usize, &[Range<usize>]),
    instances: &[Instance],
) -> Result<Bvh, SceneError> {
    let group_trees: Vec<Arc<Bvh>> = group_shapes
        .iter()
        .map(|group| tree(shapes, primitives, group.clone(), &[]).map(Arc::new))
        .collect::<Result<_, _>>()?;
    let copies: Vec<(Solid, u32)> = instances
        .iter()
        .enumerate()
        .map(|(k, i)| {
            let tree = Arc::clone(&group_trees[i.group]);
            (Solid::Instance { tree, to_world: i.to_world, index: k as u32 }, k as u32)
        })
        .collect();
    tree(shapes, primitives, 0..own_shapes, &copies)
}

/// A sphere around the scene. It is slightly too large, so that light from infinity starts outside the scene.
fn bounding_sphere(bounds: Bounds) -> (Vec3, f32) {
    if bounds.is_empty() {
        return (Vec3::ZERO, 1.0);
    }
    (bounds.center(), 0.5 * bounds.extent().length() * 1.001)
}

fn prepare_instance(instance: &Instance) -> PreparedInstance {
    PreparedInstance {
        group: instance.group,
        to_world: instance.to_world,
        to_local: instance.to_world.inverse(),
        normal_to_world: Mat3::from(instance.to_world.matrix3).inverse().transpose(),
    }
}

/// Prepare materials; children come before their parents.
fn prepare(materials: Vec<Material>) -> Vec<PreparedMaterial> {
    let mut prepared = Vec::with_capacity(materials.len());
    for material in materials {
        prepared.push(PreparedMaterial::new(material, &prepared));
    }
    prepared
}

/// Consecutive ranges of these lengths.
fn ranges(mut start: usize, lengths: impl Iterator<Item = usize>) -> Vec<Range<usize>> {
    let range = |length| {
        let range = start..start + length;
        start = range.end;
        range
    };
    lengths.map(range).collect()
}

/// Check that every index is valid.
fn check(parts: &SceneParts) -> Result<(), SceneError> {
    if !check_children(&parts.materials) {
        return Err(SceneError::Dangling("a material comes before one that it is made of".into()));
    }
    let counts = component_counts(&parts.materials);
    for shape in parts.shapes.iter().chain(parts.groups.iter().flatten()) {
        let name = &shape.name;
        if shape.material >= parts.materials.len() {
            return Err(SceneError::Dangling(format!(
                "shape \"{name}\" has a material that does not exist"
            )));
        }
        if [shape.interior, shape.exterior]
            .into_iter()
            .flatten()
            .any(|m| m.index() >= parts.media.len())
        {
            return Err(SceneError::Dangling(format!(
                "shape \"{name}\" has a medium that does not exist"
            )));
        }
        let lobes = counts[shape.material];
        if lobes > MAX_COMPONENTS {
            return Err(SceneError::TooManyLobes { shape: name.clone(), lobes });
        }
        if let Geometry::Mesh(mesh) = &shape.geometry {
            let n = mesh.positions.len();
            let fits = |len: usize| len == 0 || len == n;
            let inside = mesh.triangles.iter().flatten().all(|&i| (i as usize) < n);
            if !inside || !fits(mesh.normals.len()) || !fits(mesh.uvs.len()) {
                let cause = "its arrays differ in length, or an index is out of range".to_string();
                return Err(SceneError::Shape { name: name.clone(), cause });
            }
        }
    }
    if let Some(shape) = parts.groups.iter().flatten().find(|s| s.emission.is_some()) {
        return Err(SceneError::ShiningGroup { shape: shape.name.clone() });
    }
    if parts.instances.iter().any(|i| i.group >= parts.groups.len()) {
        return Err(SceneError::Dangling("an instance copies a group that does not exist".into()));
    }
    Ok(())
}

/// Build the tree of a range of shapes and some instances.
fn tree(
    shapes: &[Shape],
    Primitives { first, all, .. }: &Primitives,
    range: std::ops::Range<usize>,
    instances: &[(Solid, u32)],
) -> Result<Bvh, SceneError> {
    let mut triangles = Vec::new();
    let mut solids = instances.to_vec();
    for k in range {
        match &shapes[k].geometry {
            Geometry::Mesh(mesh) => {
                let corners =
                    (0..mesh.triangles.len()).map(|t| (mesh.corners(t), first[k] + t as u32));
                triangles.extend(corners.map(|(v, id)| Triangle { v, id }));
            }
            Geometry::Sphere { center, radius, .. } => {
                solids.push((Solid::Sphere { center: *center, radius: *radius }, first[k]));
            }
            Geometry::Disk { center, du, dv } => {
                solids.push((Solid::Disk { center: *center, du: *du, dv: *dv }, first[k]));
            }
            Geometry::Cylinder { p0, p1, radius } => {
                solids.push((Solid::Cylinder { p0: *p0, p1: *p1, radius: *radius }, first[k]));
            }
        }
    }
    Bvh::build(&triangles, &solids).map_err(|error| {
        let id = match error {
            BuildError::NonFinite { id } | BuildError::TooLarge { id } => all.get(id as usize),
            _ => None,
        };
        let name = id.map_or("scene".to_string(), |p| shapes[p.shape as usize].name.clone());
        SceneError::Shape { name, cause: error.to_string() }
    })
}

#[cfg(test)]
mod tests {
    use super::LARGEST;
    use crate::bsdf::component_counts;
    use crate::material::Material;
    use crate::texture::Texture;

    #[test]
    fn the_squared_area_of_the_largest_scene_is_finite_and_that_of_a_larger_one_is_not() {
        let fourth_power = |diagonal: f32| (0.5 * diagonal).powi(4);
        assert!(fourth_power(LARGEST).is_finite());
        assert!(fourth_power(1.1 * LARGEST).is_infinite());
    }

    #[test]
    fn lobes_of_blends_that_double_a_hundred_times_are_counted_at_once() {
        let white = || Texture::grey(0.5);
        let blend = |k| Material::Blend { weight: white(), first: k, second: k };
        let first = std::iter::once(Material::Diffuse { reflectance: white() });
        let materials: Vec<Material> = first.chain((0..100).map(blend)).collect();
        let counts = component_counts(&materials);
        assert_eq!((counts[3], counts[100]), (8, usize::MAX));
    }
}
