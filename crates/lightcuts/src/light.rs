//! Lighting a point: choosing its cut, and adding up what the cut's clusters bring [slide 61].

use std::cell::RefCell;

use gi_core::math::Rgb;
use gi_core::scene::Scene;
use vpl::{Prepared, Receiver};

use crate::bound::{Site, Terms, error};
use crate::cut::{Cluster, Cut, Limits, Lit};
use crate::reconstruct::Record;
use crate::tree::{Forest, Tree};

/// Lights ready to light points.
pub struct Lights<'l, 'a> {
    /// The world.
    pub scene: &'a Scene,
    /// The lights.
    pub prepared: &'l Prepared<'l, 'a>,
    /// Their trees.
    pub forest: &'l Forest,
}

thread_local! {
    /// A cut that is used again and again: choosing one allocates nothing.
    static CUT: RefCell<Cut> = RefCell::default();
}

/// By how many clusters a cut grows at most when one is split: both children may be pairs.
const MOST_MORE: usize = 3;

/// A point and everything that is asked about it.
pub struct At<'r, 's, 'a> {
    /// As connections want it.
    pub receiver: Receiver<'r, 'a>,
    /// As bounds want it.
    pub site: Site<'s, 'a>,
    /// Only trees whose lights have at most so many scatterings.
    pub deepest: u32,
    /// Whether points of lights count.
    pub direct: bool,
}

impl At<'_, '_, '_> {
    /// The share of a light that the bound of the geometric term leaves: of points of lights all.
    #[inline]
    pub fn kept(&self, geometry: f32, direct: bool) -> f32 {
        let most = self.site.most;
        if !direct && geometry > most { most / geometry } else { 1.0 }
    }

    /// Whether a tree's lights count here.
    pub fn counts(&self, tree: &Tree) -> bool {
        if tree.is_direct() { self.direct } else { tree.depth[1] <= self.deepest }
    }
}

impl<'a> Lights<'_, 'a> {
    /// Light a point by a cut.
    pub fn light(&self, at: &At<'_, '_, 'a>, limits: &Limits) -> Lit {
        CUT.with_borrow_mut(|cut| {
            cut.clear();
            self.choose(at, limits, cut, &mut None);
            self.add_up(cut, limits)
        })
    }

    /// Choose the cut of a point, from the roots [slide 61].
    pub fn choose(
        &self,
        at: &At<'_, '_, 'a>,
        limits: &Limits,
        cut: &mut Cut,
        record: &mut Option<&mut Record>,
    ) {
        let trees = &self.forest.trees;
        if let Some(record) = record {
            record.begin(trees.len());
        }
        for (t, _) in trees.iter().enumerate().filter(|(_, tree)| at.counts(tree)) {
            self.add(at, cut, (t as u32, 0), t as u32, record);
        }
        self.refine(at, limits, cut, record);
    }

    /// Refine the worst cluster until none is worse than it may be, or there are too many.
    pub fn refine(
        &self,
        at: &At<'_, '_, 'a>,
        limits: &Limits,
        cut: &mut Cut,
        record: &mut Option<&mut Record>,
    ) {
        let most = limits.max_clusters() as usize;
        while !cut.is_good(limits) && cut.clusters.len() + MOST_MORE <= most {
            let Some(worst) = cut.open.pop() else { return };
            self.split(at, cut, worst as u32, record);
        }
    }

    /// Replace a cluster by its children. One of them has the same representative: what it says is known already.
    fn split(
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
            let bound = self.bound(at, parent.tree, same);
            self.weigh(cut, number, bound);
        }
        self.add(at, cut, (parent.tree, other), slot + 1 - inherits, record);
    }

    /// Ask a node's representative, and add the node to a cut.
    pub fn add(
        &self,
        at: &At<'_, '_, 'a>,
        cut: &mut Cut,
        (tree, node): (u32, u32),
        slot: u32,
        record: &mut Option<&mut Record>,
    ) {
        let shape = &self.forest.trees[tree as usize];
        // A ray to the other of two lights costs no more than a bound.
        if shape.is_pair(node) {
            let [a, b] = shape.node(node).children().expect("two lights");
            let first = record.as_mut().map_or(0, |r| r.split(slot));
            self.add(at, cut, (tree, a), first, record);
            return self.add(at, cut, (tree, b), first + 1, record);
        }
        let light = shape.node(node).representative;
        let mut cluster = Cluster { error: 0.0, tree, node, unit: Rgb::BLACK, kept: 1.0, slot };
        // What cannot bring anything needs no ray.
        let is_light = shape.node(node).children().is_none();
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

    /// Bound what a node's lights bring; `None` for lights, and where nothing comes from them.
    #[inline]
    pub(crate) fn bound(&self, at: &At, tree: u32, node: u32) -> Option<Rgb> {
        let tree = &self.forest.trees[tree as usize];
        tree.node(node).children()?;
        Some(Terms::new(tree, node, &at.site)?.bound(tree, tree.node(node), &at.site))
    }

    /// Say how wrong a cluster may be, and add its estimate to the whole.
    #[inline]
    fn weigh(&self, cut: &mut Cut, number: u32, bound: Option<Rgb>) {
        let cluster = &mut cut.clusters[number as usize];
        let power = self.forest.trees[cluster.tree as usize].node(cluster.node).power;
        let estimate = cluster.unit * power;
        cut.total += f64::from(estimate.luminance());
        // Lights have no error, and what cannot bring anything has none.
        let error = bound.map_or(0.0, |bound| error(estimate, bound));
        cluster.error = error;
        if error > 0.0 {
            cut.squares = cut.squares.map(|s| s + f64::from(error).powi(2));
            cut.open.push(u64::from(error.to_bits()) << 32 | u64::from(number));
        }
    }

    /// The light of a cut.
    pub fn add_up(&self, cut: &mut Cut, limits: &Limits) -> Lit {
        let mut lit = Lit { rays: cut.rays, at_most: !cut.is_good(limits), ..Lit::default() };
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

    /// What one light would bring if its power were one, shadows and the bound of the geometric term included.
    pub fn one_unit(&self, at: &At<'_, '_, 'a>, light: u32) -> Rgb {
        let Some(c) = self.prepared.connect_unit(light as usize, &at.receiver) else {
            return Rgb::BLACK;
        };
        let direct = self.prepared.set().lights[light as usize].depth == 0;
        let kept = at.kept(c.geometry, direct);
        c.radiance * c.transmittance(self.scene) * kept
    }

    /// What one light brings.
    pub fn one(&self, at: &At<'_, '_, 'a>, light: u32) -> Rgb {
        self.one_unit(at, light) * self.prepared.set().lights[light as usize].power
    }

    /// Light a point by all lights, one by one: what cuts are compared with.
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
