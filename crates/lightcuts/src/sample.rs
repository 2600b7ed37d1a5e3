//! Today's relatives on the same trees, without bias: one light drawn by a walk down the tree \[Conty18\], and stochastic
//! lightcuts, which draw a light from each cluster of a cut \[Yuksel19\].
//!
//! A walk goes to a child in proportion to what it may bring: the bounds of [`crate::bound`], but with the distance to the
//! middle of the box, which keeps the estimate steady near lights. A child that may bring something is never left out.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f32::consts::PI;

use gi_core::rng::Pcg;
use gi_core::sampler::Sampler;

use crate::bound::{Site, Terms};
use crate::cut::Lit;
use crate::light::{At, Lights};
use crate::tree::{Family, Tree};

/// Glossy lights of whose peak nothing is known must not keep walks from all others.
const MOST_EMITTED: f32 = 10.0;

/// What a node may bring, roughly: 0 only where it can bring nothing.
fn importance(tree: &Tree, k: u32, site: &Site) -> f32 {
    let Some(terms) = Terms::new(tree, k, site) else { return 0.0 };
    let [distance_sq, radius_sq] = terms.toward.middle_and_radius_sq();
    let falloff = match tree.family {
        Family::Directional => 1.0,
        _ => 1.0 / distance_sq.max(radius_sq).max(f32::MIN_POSITIVE),
    };
    let emitted = terms.emitted.min(MOST_EMITTED);
    // A lobe's peak is narrow: over a cone the mean of f cos is at most one over its solid angle. (Lambert is below that.)
    let mean = 1.0 / terms.toward.solid_angle().clamp(f32::MIN_POSITIVE, PI);
    let scattered = terms.scatter.f_cos.map(|f| f.min(mean));
    let brings = (tree.node(k).power * scattered).luminance() * emitted * falloff;
    brings.clamp(f32::MIN_POSITIVE, 1e30)
}

impl<'a> Lights<'_, 'a> {
    /// Light a point by `count` lights drawn from all trees.
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
                self.draw(at, (tree, 0), count as f32 * weight / all, &mut rng, &mut lit);
            }
        }
        lit
    }

    /// Light a point by one light drawn from each of `size` clusters. The cut is chosen by what clusters may bring, not by
    /// what was drawn: that would be biased.
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

    /// A cut of at most so many nodes: that with the largest bound is split again and again.
    fn clusters_by_bound(&self, at: &At<'_, '_, 'a>, size: u32) -> Vec<(u32, u32)> {
        let (mut open, mut lights) = (BinaryHeap::new(), Vec::new());
        let mut next: Vec<(u32, u32)> = Vec::new();
        let trees = self.forest.trees.iter().enumerate();
        next.extend(trees.filter(|(_, t)| at.counts(t)).map(|(t, _)| (t as u32, 0)));
        loop {
            for (t, k) in next.drain(..) {
                if self.forest.trees[t as usize].node(k).children().is_none() {
                    lights.push((t, k));
                } else if let Some(bound) = self.bound(at, t, k) {
                    // Bounds are not negative: their bits are in their order.
                    let bound = bound.luminance().min(f32::MAX);
                    open.push((bound.to_bits(), Reverse((t, k))));
                }
            }
            if open.len() + lights.len() >= size as usize {
                break;
            }
            let Some((_, Reverse((t, k)))) = open.pop() else { break };
            let children = self.forest.trees[t as usize].node(k).children();
            next.extend(children.into_iter().flatten().map(|k| (t, k)));
        }
        let mut clusters: Vec<(u32, u32)> =
            open.into_iter().map(|(_, Reverse(node))| node).chain(lights).collect();
        clusters.sort_unstable();
        clusters
    }

    /// Draw a light below a node and add what it brings, over the probability of having drawn it and over `pdf`.
    fn draw(
        &self,
        at: &At<'_, '_, 'a>,
        (tree, mut node): (u32, u32),
        mut pdf: f32,
        rng: &mut Pcg,
        lit: &mut Lit,
    ) {
        let shape = &self.forest.trees[tree as usize];
        while let Some([a, b]) = shape.node(node).children() {
            let [first, second] = [a, b].map(|k| importance(shape, k, &at.site));
            let share = first / (first + second);
            // Neither can bring anything.
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

/// As many numbers as a walk wants, from two of the path's.
fn numbers(sampler: &mut Sampler) -> Pcg {
    let [a, b] = sampler.next_2d().map(|u| u64::from(u.to_bits()));
    Pcg::new(a << 32 | b, 0)
}

#[cfg(test)]
mod tests;
