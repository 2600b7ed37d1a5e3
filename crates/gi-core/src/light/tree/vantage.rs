//! The point that light is sampled for.

use glam::Vec3;

use super::LightTree;
use crate::bsdf::Bsdf;
use crate::light::LightSample;

/// The directions from which a point scatters light toward the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Facing {
    /// All, equally: a point of a medium.
    Any,
    /// Those on the side of this unit normal.
    Side(Vec3),
    /// Those on both sides of the surface with this unit normal.
    Both(Vec3),
}

/// The point that light is sampled for, and how the light is chosen. Light sampling and its densities depend on all of
/// it.
#[derive(Clone, Copy, Debug)]
pub struct Vantage<'a> {
    pub(crate) p: Vec3,
    pub(crate) facing: Facing,
    /// Chooses the light; without a tree, lights are chosen by power.
    pub(crate) tree: Option<&'a LightTree>,
}

impl<'a> Vantage<'a> {
    /// A point in a medium, or one whose surface does not matter.
    #[inline]
    pub fn new(tree: Option<&'a LightTree>, p: Vec3) -> Self {
        Vantage { p, facing: Facing::Any, tree }
    }

    /// Teach the tree how much light a light sample brought, divided by its density. Only trees that learn use it.
    #[inline]
    pub(crate) fn learn(&self, sample: &LightSample, brought: impl FnOnce() -> f32) {
        if let Some(tree) = self.tree.filter(|tree| tree.learns()) {
            tree.learn(self, sample.light, brought());
        }
    }

    /// A point of a surface.
    #[inline]
    pub fn on_surface(tree: Option<&'a LightTree>, p: Vec3, bsdf: &Bsdf) -> Self {
        let facing = if tree.is_some() { bsdf.facing() } else { Facing::Any };
        Vantage { p, facing, tree }
    }
}
