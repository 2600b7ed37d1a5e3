//! The light tree: chooses a light for a point by an estimate of the light that it brings there \[Conty18\].
//!
//! Each node bounds the positions, the normals and the intensities of its lights. From the root, one random number
//! descends to a light: at each node, the children are chosen in proportion to their importance. Lights at infinity
//! have no place in the tree. They stand beside it: the root's importance is an estimate of the irradiance from all
//! lamps, and is weighed against their mean irradiance. A copy of the tree can learn during rendering which nodes reach
//! which part of the scene, see `learned.rs`.

mod bounds;
mod build;
mod guided;
mod learned;
mod node;
#[cfg(test)]
mod tests;
mod vantage;

use std::sync::Arc;

use super::{Discrete, Light};
use crate::bytes::{Reader, Writer};
use crate::geometry::Shape;
use crate::rng::hash_words;
use bounds::LightBounds;
use build::{Leaf, build};
use glam::Vec3;
use learned::Guide;
use node::{Link, Node};
use rayon::prelude::*;
pub use vantage::{Facing, Vantage};

/// A tree of all lights with a position, and a list of the others.
#[derive(Clone, Debug)]
pub struct LightTree {
    /// The root, an unused node, then pairs of siblings; empty without lights.
    nodes: Vec<Node>,
    /// For each light the way to it: bit k is set if the second child is taken at depth k. [`NOT_IN_TREE`] for others.
    trails: Vec<u64>,
    /// Indices of the lights at infinity, in order, and their distribution by power.
    distant: Vec<u32>,
    by_power: Discrete,
    /// Mean irradiance from the lights at infinity on planes of all orientations, as luminance.
    irradiance: f32,
    /// What was learned, in a copy that learns.
    guide: Option<Arc<Guide>>,
}

/// The trail of a light that is not in the tree. No light is so deep.
const NOT_IN_TREE: u64 = u64::MAX;
/// Smallest probability of the lamps, and of the lights at infinity, where both may contribute. The estimates ignore
/// occlusion, and that of the lamps is too low among them.
const LEAST_SHARE: f32 = 0.25;
/// Smallest probability of one of two siblings if it may contribute.
const LEAST_PART: f64 = 1e-9;
/// Largest random number.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

impl LightTree {
    /// Build the tree. `powers` are the powers of the lights; `disc` is the area by which power from infinity is
    /// divided for its irradiance.
    pub(super) fn new(
        lights: &[Light],
        shapes: &[Shape],
        power: impl Fn(&Light) -> f32,
        disc: f32,
    ) -> Self {
        let leaf = |(k, light): (usize, &Light)| {
            let of = LightBounds::of(light, shapes)?;
            Some(Leaf { of, light: k as u32, trail: 0 })
        };
        let mut leaves: Vec<Leaf> = lights.par_iter().enumerate().filter_map(leaf).collect();
        let nodes = build(&mut leaves);
        let mut trails = vec![NOT_IN_TREE; lights.len()];
        leaves.iter().for_each(|l| trails[l.light as usize] = l.trail);
        let is_distant = |k: &u32| lights[*k as usize].is_infinite();
        let distant: Vec<u32> = (0..lights.len() as u32).filter(is_distant).collect();
        let by_power = Discrete::new(distant.iter().map(|&k| power(&lights[k as usize])));
        // The mean cosine with a random normal is a quarter, because half of all normals face away.
        let irradiance = 0.25 * (by_power.total() / f64::from(disc)) as f32;
        LightTree { nodes, trails, distant, by_power, irradiance, guide: None }
    }

    /// Memory in bytes.
    pub fn memory_bytes(&self) -> usize {
        let guide = self.guide.as_ref().map_or(0, |g| g.memory_bytes());
        size_of_val(&self.nodes[..]) + size_of_val(&self.trails[..]) + guide
    }

    /// A copy that learns during rendering which lights reach which part of the scene, within this centre and radius.
    pub(super) fn learning(&self, sphere: (Vec3, f32)) -> Self {
        let guide = Guide::new(&self.nodes, self.distant.len(), sphere);
        LightTree { guide: Some(Arc::new(guide)), ..self.clone() }
    }

    /// What the tree learns. Copies of a tree that learns are made before it is in use, or not at all.
    fn guide_mut(&mut self) -> Option<&mut Guide> {
        self.guide.as_mut().map(|guide| Arc::get_mut(guide).expect("no other copy"))
    }

    /// Whether the next pass adds its light samples, in a tree that learns.
    pub fn learn_from_samples(&mut self, learns: bool) {
        if let Some(guide) = self.guide_mut() {
            guide.learns = learns;
        }
    }

    /// After a pass: use what its light samples have shown.
    pub fn update(&mut self) {
        if let Some(guide) = self.guide_mut() {
            guide.update();
        }
    }

    /// Number of regions in which something was learned.
    pub fn regions(&self) -> usize {
        self.guide.as_ref().map_or(0, |g| g.regions())
    }

    /// What was learned, for a checkpoint.
    pub fn save(&self, w: &mut Writer) {
        if let Some(guide) = &self.guide {
            guide.save(w);
        }
    }

    /// Add what [`LightTree::save`] stored.
    ///
    /// # Errors
    /// A message of one line: the bytes are damaged.
    pub fn restore(&mut self, r: &mut Reader) -> Result<(), String> {
        self.guide_mut().map_or(Ok(()), |guide| guide.restore(r))
    }

    /// Choose a light for a point. Returns its index, its probability, and the first random number rescaled for further
    /// use. `None` if no light contributes.
    #[inline]
    pub(super) fn choose(&self, at: &Vantage, u: [f32; 2]) -> Option<(usize, f32, f32)> {
        let mut u = finer(u);
        if let Some(weights) = self.weights(at) {
            return self.choose_learned(at, u, &weights);
        }
        let distant = self.distant_share(at);
        if u < f64::from(distant) {
            let (k, p, rest) = self.by_power.sample(to_float(u / f64::from(distant)))?;
            return Some((self.distant[k] as usize, distant * p, rest));
        }
        let mut probability = f64::from(1.0 - distant);
        u = part(u, f64::from(distant), 1.0);
        let mut node = self.nodes.first()?;
        loop {
            match node.link() {
                Link::Light(light) => {
                    return Some((light as usize, probability as f32, to_float(u)));
                }
                Link::Children(first) => {
                    let first = first as usize;
                    let share = self.first_share(first, at);
                    let is_second = u >= share;
                    if is_second {
                        u = part(u, share, 1.0);
                        probability *= 1.0 - share;
                    } else {
                        u = part(u, 0.0, share);
                        probability *= share;
                    }
                    node = &self.nodes[first + usize::from(is_second)];
                }
            }
        }
    }

    /// Probability with which [`LightTree::choose`] chooses a light.
    #[inline]
    pub(super) fn probability(&self, at: &Vantage, light: usize) -> f32 {
        if let Some(weights) = self.weights(at) {
            return self.probability_learned(at, light, &weights);
        }
        let distant = self.distant_share(at);
        let mut trail = self.trails[light];
        if trail == NOT_IN_TREE {
            let place = self.distant.binary_search(&(light as u32));
            return place.map_or(0.0, |k| distant * self.by_power.probability(k));
        }
        let mut probability = f64::from(1.0 - distant);
        let mut node = &self.nodes[0];
        while let Link::Children(first) = node.link() {
            let first = first as usize;
            let share = self.first_share(first, at);
            let is_second = trail & 1 != 0;
            probability *= if is_second { 1.0 - share } else { share };
            trail >>= 1;
            node = &self.nodes[first + usize::from(is_second)];
        }
        probability as f32
    }

    /// Probability of the first of two siblings. In double precision, so that one minus it is not rounded to zero.
    #[inline]
    fn first_share(&self, first: usize, at: &Vantage) -> f64 {
        let (a, b) = (&self.nodes[first], &self.nodes[first + 1]);
        let (wa, wb) = (f64::from(a.importance(at)), f64::from(b.importance(at)));
        let share = wa / (wa + wb);
        if wa > 0.0 && wb > 0.0 && share.is_finite() {
            return share.clamp(LEAST_PART, 1.0 - LEAST_PART);
        }
        // If neither contributes, one of them must still be chosen.
        let by_intensity = || f64::from(a.intensity) / f64::from(a.intensity + b.intensity);
        if share.is_finite() { share } else { by_intensity() }
    }

    /// Probability of the lights at infinity.
    #[inline]
    fn distant_share(&self, at: &Vantage) -> f32 {
        let Some(root) = self.nodes.first() else { return 1.0 };
        if self.by_power.is_empty() {
            return 0.0;
        }
        let lamps = root.importance(at);
        if lamps == 0.0 {
            return 1.0;
        }
        (self.irradiance / (self.irradiance + lamps)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
    }
}

/// The position of `u` between `low` and `high`.
#[inline]
fn part(u: f64, low: f64, high: f64) -> f64 {
    ((u - low) / (high - low)).min(BELOW_ONE)
}

/// A random number below one.
#[inline]
fn to_float(u: f64) -> f32 {
    (u as f32).min(1.0 - f32::EPSILON / 2.0)
}

/// The first of two random numbers with more digits: a million lights use up those of a float. The new digits come from
/// a hash.
#[inline]
fn finer(u: [f32; 2]) -> f64 {
    let digits = hash_words(&u.map(f32::to_bits));
    let last = 0.5f64.powi(24);
    (f64::from(u[0]) + last * (f64::from(digits) * 0.5f64.powi(32))).min(BELOW_ONE)
}
