//! The table of all lights.

use std::f32::consts::PI;
use std::sync::OnceLock;

use glam::Vec3;

use super::{Discrete, Emitter, Light, LightSource, LightTree, Vantage};
use crate::geometry::{Geometry, Shape};
use crate::math::sqr;

/// All lights of a scene.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    lights: Vec<Light>,
    by_power: Discrete,
    /// For each shape, its first light, if it emits light.
    first_of_shape: Vec<Option<u32>>,
    /// Indices of the lights at infinity.
    distant: Vec<u32>,
    /// Centre and radius of the scene, for light from outside.
    pub(super) sphere: (Vec3, f32),
    /// Built when it is needed.
    tree: OnceLock<LightTree>,
    /// Whether there are so many lights that the tree chooses better than power.
    are_many: bool,
}

/// With more lights than this at finite distance, the light tree chooses. With 8 lamps, power has half the error in direct
/// light and twice the error in all light; with 128 lamps, the tree is better in both.
const MANY: usize = 32;

impl Lights {
    pub(crate) fn new(shapes: &[Shape], sources: Vec<LightSource>, sphere: (Vec3, f32)) -> Self {
        let mut lights = Vec::new();
        let mut first_of_shape = Vec::with_capacity(shapes.len());
        for (k, shape) in shapes.iter().enumerate() {
            let shines = shape.emission.as_ref().is_some_and(|e| !e.is_black());
            first_of_shape.push(shines.then_some(lights.len() as u32));
            if shines {
                push_area(&mut lights, k as u32, shape);
            }
        }
        let mut distant = Vec::new();
        for source in sources {
            let light = Light::from_source(source);
            if light.is_distant() {
                distant.push(lights.len() as u32);
            }
            lights.push(light);
        }
        let by_power = Discrete::new(lights.iter().map(|l| l.power(shapes, sphere.1)));
        let tree = OnceLock::new();
        let are_many = lights.iter().filter(|l| !l.is_infinite()).count() > MANY;
        let lights = Lights { lights, by_power, first_of_shape, distant, sphere, tree, are_many };
        if are_many {
            lights.tree(shapes);
        }
        lights
    }

    /// The tree of all lights, which is built at the first call.
    pub(crate) fn tree(&self, shapes: &[Shape]) -> &LightTree {
        self.tree.get_or_init(|| {
            let radius = self.sphere.1;
            let power = |light: &Light| light.power(shapes, radius);
            LightTree::new(&self.lights, shapes, power, PI * sqr(radius))
        })
    }

    /// A copy of the tree that learns during rendering.
    pub(crate) fn learning_tree(&self, shapes: &[Shape]) -> LightTree {
        self.tree(shapes).learning(self.sphere)
    }

    /// The tree of all lights if there are many.
    pub(crate) fn tree_of_many(&self) -> Option<&LightTree> {
        if self.are_many { self.tree.get() } else { None }
    }

    /// Centre and radius of the scene.
    pub(crate) fn sphere(&self) -> (Vec3, f32) {
        self.sphere
    }

    /// All lights in order.
    pub fn all(&self) -> &[Light] {
        &self.lights
    }

    /// Probability of a light if lights are chosen by power.
    pub fn probability(&self, light: usize) -> f32 {
        self.by_power.probability(light)
    }

    /// Whether nothing emits light.
    pub fn is_empty(&self) -> bool {
        self.by_power.is_empty()
    }

    /// Sample a light in proportion to its power. Returns its index, its probability, and `u` rescaled for further use.
    #[inline]
    pub(crate) fn choose(&self, u: f32) -> Option<(usize, f32, f32)> {
        self.by_power.sample(u)
    }

    /// Choose a light for a point. Returns its index, its probability, and the first random number rescaled for further
    /// use.
    #[inline]
    pub(crate) fn choose_for(&self, at: &Vantage, u: [f32; 2]) -> Option<(usize, f32, f32)> {
        match at.tree {
            Some(tree) => tree.choose(at, u),
            None => self.choose(u[0]),
        }
    }

    /// Probability with which [`Lights::choose_for`] chooses a light.
    #[inline]
    pub(crate) fn probability_for(&self, at: &Vantage, light: usize) -> f32 {
        match at.tree {
            Some(tree) => tree.probability(at, light),
            None => self.probability(light),
        }
    }

    /// The lights at infinity.
    pub(crate) fn distant(&self) -> impl Iterator<Item = (usize, &Light)> {
        self.distant.iter().map(|&k| (k as usize, &self.lights[k as usize]))
    }

    /// The index of the light of primitive `primitive` of shape `shape`, if it emits light.
    #[inline]
    pub fn of_primitive(&self, shape: u32, primitive: u32) -> Option<usize> {
        self.first_of_shape[shape as usize].map(|first| (first + primitive) as usize)
    }
}

/// Add one light for each primitive of an emitting shape.
fn push_area(lights: &mut Vec<Light>, k: u32, shape: &Shape) {
    let outward = !shape.flip_normals;
    let oriented = |n: Vec3| if outward { n } else { -n };
    let mut push = |emitter, primitive| lights.push(Light::Area { emitter, shape: k, primitive });
    match &shape.geometry {
        Geometry::Mesh(mesh) => {
            for t in 0..mesh.triangles.len() {
                let face = mesh.oriented_normal(t);
                push(Emitter::triangle(mesh.corners(t), oriented(face)), t as u32);
            }
        }
        Geometry::Sphere { center, radius, .. } => {
            push(Emitter::Sphere { center: *center, radius: *radius, outward }, 0);
        }
        Geometry::Disk { center, du, dv } => {
            let normal = oriented(du.cross(*dv).normalize_or_zero());
            push(Emitter::Disk { center: *center, axes: [*du, *dv], normal }, 0);
        }
        Geometry::Cylinder { p0, p1, radius } => {
            push(Emitter::Cylinder { ends: [*p0, *p1], radius: *radius, outward }, 0);
        }
    }
}
