//! The guard against light leaks: whether a record and the point that uses it see each other.

use gi_core::ray::Ray;
use gi_core::scene::Scene;
use glam::Vec3;

use crate::site::{Query, Site};

/// Tests whether a wall stands between a record and a query, so that light does not leak under thin walls or around
/// corners.
#[derive(Clone, Copy)]
pub struct LeakGuard<'a> {
    /// The world.
    pub scene: &'a Scene,
    /// Whether to look for walls; without the guard every record passes.
    pub is_on: bool,
}

/// Ray offset from both surfaces, as a fraction of the distance between the two points. It exceeds the bulge of a
/// curved surface, if the normals are similar enough for a record to be used.
const RAY_OFFSET: f32 = 0.1;
/// A query closer to the record than this fraction of `Site::clear` needs no ray: nothing can stand in between.
const SURELY_VISIBLE: f32 = 0.5;

impl LeakGuard<'_> {
    /// Whether a query may use the record at `site`.
    pub fn passes(&self, site: &Site, q: &Query) -> bool {
        !self.is_on || is_visible(self.scene, site, q)
    }
}

fn is_visible(scene: &Scene, site: &Site, q: &Query) -> bool {
    let distance = (site.p - q.p).length();
    if distance <= SURELY_VISIBLE * site.clear {
        return true;
    }
    let lifted = |p: Vec3, n: Vec3| p + n * (RAY_OFFSET * distance);
    let (a, b) = (lifted(q.p, q.n), lifted(site.p, site.n));
    !scene.tree().occluded(&Ray { o: a, tmin: 0.0, d: b - a, tmax: 1.0 })
}
