//! Collects several hits of a ray in one traversal. A ray through many transparent surfaces would otherwise start again
//! at the root for each of them. In nested boxes each of these traversals visits all of them.

use std::ops::ControlFlow;

use super::layout::{LANES, Tree};
use super::portable::{Leaf, traverse, triangle};
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
            return collect_leaves(&self.tree, ray, nearest);
        }
        let Some(tamed) = Tamed::new(ray, self.bounds) else { return };
        let mut inner = Nearest { hits: Vec::new(), complete: true, ..*nearest };
        collect_leaves(&self.tree, &tamed.ray, &mut inner);
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

/// Add the hits of all leaves, as far as they may be among the nearest.
fn collect_leaves(tree: &Tree, ray: &Ray, nearest: &mut Nearest) {
    let walk = Walk::new(ray);
    traverse(tree, ray, &walk, |leaf, ray| {
        match leaf {
            Leaf::Solids(solids) => solids.iter().for_each(|solid| solid.collect(ray, nearest)),
            Leaf::Triangles(blocks) => {
                for block in blocks {
                    let hits = (0..LANES).filter_map(|lane| triangle(block, lane, ray, &walk));
                    nearest.hits.extend(hits);
                }
            }
        }
        ray.tmax = nearest.limit(ray.tmax);
        ControlFlow::Continue(())
    });
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
