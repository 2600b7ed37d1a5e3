//! Collects several hits of a ray in one traversal. A ray through many transparent surfaces would otherwise start again
//! at the root for each of them. In nested boxes each of these traversals visits all of them.

use super::layout::{LANES, SENTINEL, STACK, Tree, WIDTH, is_leaf, is_solid, leaf_range};
use super::portable::{slabs, triangle};
use super::tame::{Tamed, is_tame};
use super::walk::Walk;
use super::{Bvh, solid::PlacedSolid};
use crate::ray::{Hit, Ray};

impl Bvh {
    /// The nearest hits in (tmin, tmax], in order, at most `most` of them, and whether these are all. A primitive may be
    /// hit several times.
    pub fn nearest(&self, ray: &Ray, most: usize) -> (Vec<Hit>, bool) {
        let mut nearest = Nearest { hits: Vec::new(), most: most.max(1), complete: true };
        self.collect(ray, &mut nearest);
        nearest.sorted()
    }

    /// Add all hits that may be among the nearest.
    fn collect(&self, ray: &Ray, nearest: &mut Nearest) {
        if is_tame(ray, self.reach) {
            return traverse(&self.tree, ray, nearest);
        }
        let Some(tamed) = Tamed::new(ray, self.bounds) else { return };
        let mut inner = Nearest { hits: Vec::new(), complete: true, ..*nearest };
        traverse(&self.tree, &tamed.ray, &mut inner);
        nearest.complete &= inner.complete;
        inner.hits.iter().for_each(|hit| nearest.add(Hit { t: tamed.untame(hit.t), ..*hit }));
    }
}

/// The nearest hits so far.
struct Nearest {
    /// In any order, up to twice as many as needed.
    hits: Vec<Hit>,
    most: usize,
    /// Whether no hit has been discarded.
    complete: bool,
}

impl Nearest {
    fn add(&mut self, hit: Hit) {
        self.hits.push(hit);
    }

    /// Discard all but the nearest if there are many more. Returns the parameter beyond which hits need not be added.
    fn limit(&mut self, tmax: f32) -> f32 {
        if self.hits.len() < 2 * self.most {
            return tmax;
        }
        let (_, last, _) = self.hits.select_nth_unstable_by(self.most - 1, order);
        let limit = last.t;
        self.hits.truncate(self.most);
        self.complete = false;
        limit.min(tmax)
    }

    fn sorted(mut self) -> (Vec<Hit>, bool) {
        self.hits.sort_unstable_by(order);
        // Large triangles are in several leaves.
        self.hits.dedup();
        let complete = self.complete && self.hits.len() <= self.most;
        self.hits.truncate(self.most);
        (self.hits, complete)
    }
}

fn order(a: &Hit, b: &Hit) -> std::cmp::Ordering {
    let key = |h: &Hit| (h.instance, h.prim);
    a.t.total_cmp(&b.t).then_with(|| key(a).cmp(&key(b)))
}

/// The traversal of `portable::trace`, which does not stop at the nearest hit.
fn traverse(tree: &Tree, ray: &Ray, nearest: &mut Nearest) {
    let walk = Walk::new(ray);
    let mut ray = *ray;
    let mut stack = [(SENTINEL, f32::NEG_INFINITY); STACK];
    let mut top = 0;
    let mut word = 0;
    loop {
        if !is_leaf(word) {
            let node = &tree.nodes[word as usize];
            let (near, mask) = slabs(node, &ray, &walk);
            // Push the children that are hit, the nearest last.
            for k in 0..WIDTH {
                let slot = (node.order[k] >> walk.order_shift & 7) as usize;
                stack[top + 1] = (node.child[slot], near[slot]);
                top += usize::from(mask[slot]);
            }
        } else {
            let (first, count) = leaf_range(word);
            if is_solid(word) {
                let solids = &tree.solids[first..first + count];
                solids.iter().for_each(|solid| solid.collect(&ray, nearest));
            } else {
                for block in &tree.blocks[first..first + count] {
                    let hits = (0..LANES).filter_map(|lane| triangle(block, lane, &ray, &walk));
                    nearest.hits.extend(hits);
                }
            }
            ray.tmax = nearest.limit(ray.tmax);
        }
        // Pop the next child that is not beyond the farthest hit that counts.
        while stack[top].1 > ray.tmax {
            top -= 1;
        }
        if top == 0 {
            return;
        }
        word = stack[top].0;
        top -= 1;
    }
}

impl PlacedSolid {
    /// Add all hits in the ray's interval.
    fn collect(&self, ray: &Ray, nearest: &mut Nearest) {
        if let Some((tree, ray, index)) = self.inner(ray) {
            let (hits, complete) = tree.nearest(&ray, nearest.most);
            nearest.complete &= complete;
            hits.iter().for_each(|hit| nearest.add(Hit { instance: index, ..*hit }));
            return;
        }
        let mut rest = *ray;
        while let Some(hit) = self.closest(&rest) {
            nearest.add(hit);
            rest.tmin = hit.t; // hits at tmin are ignored
        }
    }
}
