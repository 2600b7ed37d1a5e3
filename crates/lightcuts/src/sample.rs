//! Two newer, unbiased methods on the same trees: one light sampled by a walk down the tree \[Conty18\], and stochastic
//! lightcuts, which sample one light from each cluster of a cut \[Yuksel19\].
//!
//! A walk chooses a child in proportion to its importance: the bound of [`crate::bound`], but with the distance to the
//! centre of the box, which reduces variance near lights. A child that may bring light has a probability above 0.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f32::consts::PI;

use gi_core::rng::Pcg;
use gi_core::sampler::Sampler;

use crate::bound::{Site, Terms};
use crate::cut::Lit;
use crate::light::{At, Lights};
use crate::tree::{Family, NodeId, Tree};

/// Limit of the emission in an importance: a glossy light with an unknown peak must not attract all walks.
const MOST_EMITTED: f32 = 10.0;

/// Rough estimate of the light from a node; 0 only if no light can come from it.
fn importance(tree: &Tree, k: u32, site: &Site) -> f32 {
    let Some(terms) = Terms::new(tree, k, site) else { return 0.0 };
    let [distance_sq, radius_sq] = terms.toward.middle_and_radius_sq();
    let falloff = match tree.family {
        Family::Directional => 1.0,
        _ => 1.0 / distance_sq.max(radius_sq).max(f32::MIN_POSITIVE),
    };
    let emitted = terms.emitted.min(MOST_EMITTED);
    // A lobe's peak is narrow: over a cone the mean of f cos is at most one over its solid angle. (Lambert is below
    // that.)
    let mean = 1.0 / terms.toward.solid_angle().clamp(f32::MIN_POSITIVE, PI);
    let scattered = terms.scatter.f_cos.map(|f| f.min(mean));
    let brings = (tree.node(k).power * scattered).luminance() * emitted * falloff;
    brings.clamp(f32::MIN_POSITIVE, 1e30)
}

impl<'a> Lights<'_, 'a> {
    /// Illuminate a point by `count` lights sampled from all trees.
    pub fn light_by_some(&self, at: &At<'_, '_, 'a>, count: u32, sampler: &mut Sampler) -> Lit {
        let mut rng = numbers(sampler);
        let mut roots = Vec::new();
        for (t, tree) in self.forest.trees.iter().enumerate().filter(|(_, t)| at.counts(t)) {
            roots.push((t as u32, importance(tree, 0, &at.site)));
        }
        let all: f32 = roots.iter().map(|r| r.1).sum();
        let mut lit = Lit::default();
        if all <= 0.0 {
            return lit;
        }
        for _ in 0..count {
            // Choose a tree, then walk down.
            let mut u = rng.next_f32() * all;
            let chosen = roots.iter().find(|(_, w)| {
                let here = u < *w;
                u -= *w;
                here
            });
            let (tree, weight) = *chosen.unwrap_or(&roots[roots.len() - 1]);
            if weight > 0.0 {
                let root = NodeId { tree, node: 0 };
                self.draw(at, root, count as f32 * weight / all, &mut rng, &mut lit);
            }
        }
        lit
    }

    /// Illuminate a point by one light sampled from each of `size` clusters. The cut is chosen by bounds; a choice by
    /// the sampled lights would be biased.
    pub fn light_stochastically(
        &self,
        at: &At<'_, '_, 'a>,
        size: u32,
        sampler: &mut Sampler,
    ) -> Lit {
        let (mut rng, mut lit) = (numbers(sampler), Lit::default());
        for start in self.clusters_by_bound(at, size) {
            self.draw(at, start, 1.0, &mut rng, &mut lit);
        }
        lit
    }

    /// A cut of at most `size` nodes: the node with the largest bound is split repeatedly.
    fn clusters_by_bound(&self, at: &At<'_, '_, 'a>, size: u32) -> Vec<NodeId> {
        let (mut open, mut lights) = (BinaryHeap::new(), Vec::new());
        let mut next: Vec<NodeId> = Vec::new();
        let trees = self.forest.trees.iter().enumerate();
        next.extend(
            trees.filter(|(_, t)| at.counts(t)).map(|(t, _)| NodeId { tree: t as u32, node: 0 }),
        );
        loop {
            for id in next.drain(..) {
                if self.forest.trees[id.tree as usize].node(id.node).children().is_none() {
                    lights.push(id);
                } else if let Some(bound) = self.bound(at, id.tree, id.node) {
                    // The bits of non-negative floats sort like the values.
                    let bound = bound.luminance().min(f32::MAX);
                    open.push((bound.to_bits(), Reverse(id)));
                }
            }
            if open.len() + lights.len() >= size as usize {
                break;
            }
            let Some((_, Reverse(id))) = open.pop() else { break };
            let children = self.forest.trees[id.tree as usize].node(id.node).children();
            next.extend(children.into_iter().flatten().map(|node| NodeId { node, ..id }));
        }
        let mut clusters: Vec<NodeId> =
            open.into_iter().map(|(_, Reverse(node))| node).chain(lights).collect();
        clusters.sort_unstable();
        clusters
    }

    /// Sample a light below a node, and add its light divided by its probability and by `pdf`.
    fn draw(
        &self,
        at: &At<'_, '_, 'a>,
        NodeId { tree, mut node }: NodeId,
        mut pdf: f32,
        rng: &mut Pcg,
        lit: &mut Lit,
    ) {
        let shape = &self.forest.trees[tree as usize];
        while let Some([a, b]) = shape.node(node).children() {
            let [first, second] = [a, b].map(|k| importance(shape, k, &at.site));
            let share = first / (first + second);
            // Neither child can bring light.
            if share.is_nan() {
                return;
            }
            let to_first = rng.next_f32() < share;
            node = if to_first { a } else { b };
            pdf *= if to_first { share } else { 1.0 - share };
        }
        let node = shape.node(node);
        lit.size += 1;
        let Some(c) = self.prepared.connect_unit(node.representative as usize, &at.receiver) else {
            return;
        };
        lit.rays += 1;
        let kept = at.kept(c.geometry, shape.is_direct());
        let light = c.radiance * node.power * c.transmittance(self.scene) * (1.0 / pdf);
        let part = if shape.is_direct() { &mut lit.direct } else { &mut lit.indirect };
        *part += light * kept;
        lit.cut_off += (light * (1.0 - kept)).luminance();
    }
}

/// A generator of random numbers for walks, seeded with two numbers of the path.
fn numbers(sampler: &mut Sampler) -> Pcg {
    let [a, b] = sampler.next_2d().map(|u| u64::from(u.to_bits()));
    Pcg::new(a << 32 | b, 0)
}

#[cfg(test)]
mod tests;
