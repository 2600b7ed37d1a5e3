//! Choices by a light tree that learns: at the top of the tree, importance is weighted by what was learned. Some choices
//! ignore that, so that no light is missed.

use super::learned::{Guide, PLAIN, Weights};
use super::node::Link;
use super::vantage::Vantage;
use super::{LightTree, NOT_IN_TREE, part, to_float};

/// The two probabilities of a choice, without and with what was learned, and their mixture.
#[derive(Clone, Copy)]
struct Both {
    plain: f64,
    learned: f64,
}

impl Both {
    #[inline]
    fn mixed(&self) -> f64 {
        PLAIN * self.plain + (1.0 - PLAIN) * self.learned
    }

    #[inline]
    fn times(self, o: Both) -> Both {
        Both { plain: self.plain * o.plain, learned: self.learned * o.learned }
    }

    /// The probabilities of the opposite choice.
    #[inline]
    fn opposite(self) -> Both {
        Both { plain: 1.0 - self.plain, learned: 1.0 - self.learned }
    }
}

/// Choices with what was learned.
impl LightTree {
    /// The weights at a point, if something was learned there.
    #[inline]
    pub(super) fn weights(&self, at: &Vantage) -> Option<Weights<'_>> {
        self.guide.as_ref()?.weights(at)
    }

    /// [`LightTree::choose`] with what was learned.
    pub(super) fn choose_learned(
        &self,
        at: &Vantage,
        u: f64,
        weights: &Weights,
    ) -> Option<(usize, f32, f32)> {
        let is_plain = u < PLAIN;
        let mut u = if is_plain { part(u, 0.0, PLAIN) } else { part(u, PLAIN, 1.0) };
        let of = |both: Both| if is_plain { both.plain } else { both.learned };
        let distant = self.distant_shares(at, weights);
        if u < of(distant) {
            u = part(u, 0.0, of(distant));
            let (mut k, mut below) = (0, 0.0);
            // One by one: with many lights at infinity, this is not the costly part.
            let chosen = loop {
                let share = self.distant_part(k, weights);
                if u < below + of(share) || k + 1 == self.distant.len() {
                    u = part(u.max(below), below, below + of(share));
                    break share;
                }
                below += of(share);
                k += 1;
            };
            let p = distant.times(chosen).mixed();
            return Some((self.distant[k] as usize, p as f32, to_float(u)));
        }
        u = part(u, of(distant), 1.0);
        let mut p = distant.opposite();
        let mut node = self.nodes.first()?;
        loop {
            match node.link() {
                Link::Light(light) => return Some((light as usize, p.mixed() as f32, to_float(u))),
                Link::Children(first) => {
                    let first = first as usize;
                    let share = self.first_shares(first, at, weights);
                    let is_second = u >= of(share);
                    u = if is_second { part(u, of(share), 1.0) } else { part(u, 0.0, of(share)) };
                    p = p.times(if is_second { share.opposite() } else { share });
                    node = &self.nodes[first + usize::from(is_second)];
                }
            }
        }
    }

    /// [`LightTree::probability`] with what was learned.
    pub(super) fn probability_learned(&self, at: &Vantage, light: usize, weights: &Weights) -> f32 {
        let distant = self.distant_shares(at, weights);
        let mut trail = self.trails[light];
        if trail == NOT_IN_TREE {
            let place = self.distant.binary_search(&(light as u32));
            let p = |k| distant.times(self.distant_part(k, weights)).mixed() as f32;
            return place.map_or(0.0, p);
        }
        let (mut p, mut node) = (distant.opposite(), &self.nodes[0]);
        while let Link::Children(first) = node.link() {
            let share = self.first_shares(first as usize, at, weights);
            let is_second = trail & 1 != 0;
            p = p.times(if is_second { share.opposite() } else { share });
            trail >>= 1;
            node = &self.nodes[first as usize + usize::from(is_second)];
        }
        p.mixed() as f32
    }

    /// Probabilities of the first of two siblings.
    #[inline]
    fn first_shares(&self, first: usize, at: &Vantage, weights: &Weights) -> Both {
        let plain = self.first_share(first, at);
        let learned = weights.pair(first).map_or(plain, |[a, b]| {
            let (a, b) = (plain * f64::from(a), (1.0 - plain) * f64::from(b));
            let share = a / (a + b);
            if share.is_finite() { share } else { plain }
        });
        Both { plain, learned }
    }

    /// Probabilities of the lights at infinity.
    #[inline]
    fn distant_shares(&self, at: &Vantage, weights: &Weights) -> Both {
        let plain = f64::from(self.distant_share(at));
        let distant: f32 = weights.distant.iter().sum();
        let lamps = self.nodes.first().map_or(0.0, |root| root.importance(at) * weights.root());
        let share = f64::from(distant) / f64::from(distant + lamps);
        let known = plain > 0.0 && plain < 1.0 && !weights.distant.is_empty();
        let learned = if known && share.is_finite() { share } else { plain };
        Both { plain, learned }
    }

    /// Probabilities of one of the lights at infinity.
    #[inline]
    fn distant_part(&self, k: usize, weights: &Weights) -> Both {
        let plain = f64::from(self.by_power.probability(k));
        let share = weights.distant.get(k).map(|w| w / weights.distant.iter().sum::<f32>());
        Both { plain, learned: share.map_or(plain, f64::from) }
    }

    /// Add the light that light `light` brought: a sample divided by its probability and density, without a weight of
    /// multiple importance sampling. Does nothing in a tree that does not learn.
    pub(crate) fn learn(&self, at: &Vantage, light: u32, brought: f32) {
        if let Some(guide) = &self.guide {
            self.add(guide, at, light as usize, brought);
        }
    }

    /// Whether light samples are wanted.
    #[inline]
    pub(crate) fn learns(&self) -> bool {
        self.guide.as_ref().is_some_and(|g| g.learns)
    }

    fn add(&self, guide: &Guide, at: &Vantage, light: usize, brought: f32) {
        let weights = guide.weights(at);
        let plain = |p: f64| Both { plain: p, learned: p };
        let distant = match &weights {
            Some(weights) => self.distant_shares(at, weights),
            None => plain(self.distant_share(at).into()),
        };
        let mut trail = self.trails[light];
        if trail == NOT_IN_TREE {
            let Ok(k) = self.distant.binary_search(&(light as u32)) else { return };
            let part = match &weights {
                Some(weights) => self.distant_part(k, weights),
                None => plain(self.by_power.probability(k).into()),
            };
            return guide.add_distant(at, k, brought * distant.times(part).mixed() as f32);
        }
        let Some(add) = guide.adding(at) else { return };
        let (mut p, mut k) = (distant.opposite(), 0);
        // The light that a node brings, over the node's importance.
        let factor = |p: Both, k: usize| {
            let importance = self.nodes[k].importance(at);
            if brought > 0.0 { brought * p.mixed() as f32 / importance } else { 0.0 }
        };
        while add(k, factor(p, k)) {
            let Link::Children(first) = self.nodes[k].link() else { break };
            let first = first as usize;
            let share = match &weights {
                Some(weights) => self.first_shares(first, at, weights),
                None => plain(self.first_share(first, at)),
            };
            let is_second = trail & 1 != 0;
            p = p.times(if is_second { share.opposite() } else { share });
            trail >>= 1;
            k = first + usize::from(is_second);
        }
    }
}
