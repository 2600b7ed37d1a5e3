//! The steps by which a cut is refined: a shadow ray to a representative, a bound of the error, the split of a cluster.
//! And the light of a finished cut [slide 61].

use gi_core::math::Rgb;
use gi_core::scene::Scene;
use vpl::{Prepared, Receiver};

use crate::bound::{Site, Terms, error};
use crate::cut::{Cluster, Cut, Limits, Lit};
use crate::record::Record;
use crate::tree::{Forest, NodeId, Tree};

/// Lights and trees, prepared to illuminate points.
pub struct Lights<'l, 'a> {
    /// The world.
    pub scene: &'a Scene,
    /// The lights.
    pub prepared: &'l Prepared<'l, 'a>,
    /// Their trees.
    pub forest: &'l Forest,
}

/// A point that receives light.
pub struct At<'r, 's, 'a> {
    /// The point for connections.
    pub receiver: Receiver<'r, 'a>,
    /// The point for bounds.
    pub site: Site<'s, 'a>,
    /// Largest number of scatterings of lights that count here.
    pub deepest: u32,
    /// Whether lights on light sources count.
    pub direct: bool,
}

impl At<'_, '_, '_> {
    /// The fraction of a light that the clamp of the geometry term keeps. Lights on light sources are not clamped.
    #[inline]
    pub fn kept(&self, geometry: f32, direct: bool) -> f32 {
        let most = self.site.most;
        if !direct && geometry > most { most / geometry } else { 1.0 }
    }

    /// Whether the lights of a tree count here.
    pub fn counts(&self, tree: &Tree) -> bool {
        if tree.is_direct() { self.direct } else { tree.depth[1] <= self.deepest }
    }
}

impl<'a> Lights<'_, 'a> {
    /// Replace a cluster by its children. One of them has the same representative, so its light is known already.
    pub fn split(
        &self,
        at: &At<'_, '_, 'a>,
        cut: &mut Cut,
        number: u32,
        record: &mut Option<&mut Record>,
    ) {
        let parent = cut.clusters[number as usize];
        let tree = &self.forest.trees[parent.tree as usize];
        let node = tree.node(parent.node);
        let children = node.children().expect("lights have no error");
        cut.total -= f64::from((parent.unit * node.power).luminance());
        cut.squares = cut.squares.map(|s| s - f64::from(parent.error).powi(2));
        let slot = record.as_mut().map_or(0, |r| r.split(parent.slot));
        let inherits = u32::from(tree.node(children[0]).representative != node.representative);
        let (same, other) = (children[inherits as usize], children[1 - inherits as usize]);
        if let Some(record) = record {
            record.inherit(slot + inherits, parent.slot);
        }
        let heir = &mut cut.clusters[number as usize];
        (heir.node, heir.slot, heir.error) = (same, slot + inherits, 0.0);
        if tree.is_pair(same) {
            cut.total += f64::from((parent.unit * tree.node(same).power).luminance());
            self.split(at, cut, number, record);
        } else {
            cut.bounds += 1;
            let bound = self.bound(at, parent.tree, same);
            self.weigh(cut, number, bound);
        }
        let other = NodeId { tree: parent.tree, node: other };
        self.add(at, cut, other, slot + 1 - inherits, record);
    }

    /// Add a node to a cut, with a shadow ray to its representative.
    pub fn add(
        &self,
        at: &At<'_, '_, 'a>,
        cut: &mut Cut,
        id: NodeId,
        slot: u32,
        record: &mut Option<&mut Record>,
    ) {
        let NodeId { tree, node } = id;
        let shape = &self.forest.trees[tree as usize];
        // A shadow ray to the second of two lights costs no more than a bound: add both lights.
        if shape.is_pair(node) {
            let [a, b] = shape.node(node).children().expect("two lights");
            let first = record.as_mut().map_or(0, |r| r.split(slot));
            self.add(at, cut, NodeId { node: a, ..id }, first, record);
            return self.add(at, cut, NodeId { node: b, ..id }, first + 1, record);
        }
        let light = shape.node(node).representative;
        let mut cluster = Cluster { error: 0.0, tree, node, unit: Rgb::BLACK, kept: 1.0, slot };
        // A cluster that cannot bring light needs no shadow ray.
        let is_light = shape.node(node).children().is_none();
        cut.bounds += u32::from(!is_light);
        let bound = self.bound(at, tree, node);
        if !is_light && bound.is_none() {
            return;
        }
        if let Some(c) = self.prepared.connect_unit(light as usize, &at.receiver) {
            cut.rays += 1;
            let open = c.transmittance(self.scene);
            cluster.kept = at.kept(c.geometry, shape.is_direct());
            cluster.unit = c.radiance * open * cluster.kept;
            if let Some(record) = record {
                record.note(slot, c.wi, c.arriving * open * cluster.kept);
            }
        } else if is_light {
            return;
        }
        cut.clusters.push(cluster);
        self.weigh(cut, cut.clusters.len() as u32 - 1, bound);
    }

    /// Upper bound of the light from a cluster; `None` for single lights, and if no light comes from it.
    #[inline]
    pub fn bound(&self, at: &At, tree: u32, node: u32) -> Option<Rgb> {
        let tree = &self.forest.trees[tree as usize];
        tree.node(node).children()?;
        Some(Terms::new(tree, node, &at.site)?.bound(tree, tree.node(node), &at.site))
    }

    /// Set the error of a cluster, add its estimate to the total, and put it on the heap.
    #[inline]
    fn weigh(&self, cut: &mut Cut, number: u32, bound: Option<Rgb>) {
        let cluster = &mut cut.clusters[number as usize];
        let power = self.forest.trees[cluster.tree as usize].node(cluster.node).power;
        let estimate = cluster.unit * power;
        cut.total += f64::from(estimate.luminance());
        // A single light has no error, and neither has a cluster that cannot bring light.
        let error = bound.map_or(0.0, |bound| error(estimate, bound));
        cluster.error = error;
        if error > 0.0 {
            cut.push(error, number);
        }
    }

    /// The light of a cut.
    pub fn add_up(&self, cut: &mut Cut, limits: &Limits) -> Lit {
        let at_most = !cut.is_good(limits);
        let mut lit = Lit { rays: cut.rays, bounds: cut.bounds, at_most, ..Lit::default() };
        for cluster in &cut.clusters {
            let tree = &self.forest.trees[cluster.tree as usize];
            let light = cluster.unit * tree.node(cluster.node).power;
            if tree.is_direct() {
                lit.direct += light;
            } else {
                lit.indirect += light;
                lit.cut_off += light.luminance() * (1.0 / cluster.kept - 1.0);
            }
        }
        lit.size = cut.clusters.len() as u32;
        lit
    }

    /// The light that one virtual light of unit power brings, with shadows and the clamped geometry term.
    pub fn one_unit(&self, at: &At<'_, '_, 'a>, light: u32) -> Rgb {
        let Some(c) = self.prepared.connect_unit(light as usize, &at.receiver) else {
            return Rgb::BLACK;
        };
        let direct = self.prepared.set().lights[light as usize].depth == 0;
        let kept = at.kept(c.geometry, direct);
        c.radiance * c.transmittance(self.scene) * kept
    }

    /// The light that one virtual light brings.
    pub fn one(&self, at: &At<'_, '_, 'a>, light: u32) -> Rgb {
        self.one_unit(at, light) * self.prepared.set().lights[light as usize].power
    }

    /// Illuminate a point by every single light: the reference for cuts.
    pub fn light_by_all(&self, at: &At<'_, '_, 'a>) -> Lit {
        let set = self.prepared.set();
        let points = set.up_to(0).len();
        let all = set.up_to(at.deepest).len();
        let mut lit = Lit::default();
        let mut add = |range: std::ops::Range<usize>, most: f32, direct: bool| {
            let mut sum = Rgb::BLACK;
            lit.rays += self.prepared.for_each_visible(range, &at.receiver, |c, through| {
                let light = c.radiance * through;
                let kept = if c.geometry > most { most / c.geometry } else { 1.0 };
                lit.cut_off += (light * (1.0 - kept)).luminance();
                sum += light * kept;
            }) as u32;
            if direct {
                lit.direct = sum;
            } else {
                lit.indirect = sum;
            }
        };
        if at.direct {
            add(0..points, f32::INFINITY, true);
        }
        add(points..all.max(points), at.site.most, false);
        lit.size = lit.rays;
        lit
    }
}

#[cfg(test)]
pub(crate) mod tests;
