//! Learns during rendering which lights reach which part of the scene, so that lights behind walls are rarely sampled
//! \[Vevoda18\].
//!
//! The scene is divided into regions: cells of a grid, by the direction of the surface. For each region and each node
//! at the top of the light tree, a Bayesian regression predicts the light from the node, relative to its importance. The
//! descent then weighs each node by the root of the predicted second moment, which minimises the variance.
//!
//! Light samples are added up as whole numbers, so sums do not depend on the order in which threads add. Weights change
//! only between passes.

mod regression;

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use glam::Vec3;

use super::node::{Link, Node};
use super::vantage::{Facing, Vantage};
use crate::bytes::{Reader, Writer};
use regression::{Data, Sums};

/// Number of nodes of the cut through the tree above which weights are learned.
const CLUSTERS: usize = 64;
/// Number of cells of the grid along each axis, and number of directions of surfaces: six, and one for media.
const CELLS: usize = 48;
const DIRECTIONS: usize = 7;
/// Largest number of regions.
const REGIONS: usize = 1 << 14;
/// Largest number of lights at infinity whose weights are learned.
const MOST_DISTANT: usize = 16;
/// Probability of a choice that ignores what was learned.
pub(super) const PLAIN: f64 = 0.15;
/// The slot of a node that is not at the top.
const NONE: u32 = u32::MAX;
/// A cell that no light was sampled in, one that will be a region after the pass, and one that cannot be a region.
const UNTOUCHED: u32 = u32::MAX;
const TOUCHED: u32 = u32::MAX - 1;
const REFUSED: u32 = u32::MAX - 2;

/// What is known about lights and regions.
#[derive(Debug)]
pub(super) struct Guide {
    /// Lowest corner of the grid, and cells per world unit.
    low: Vec3,
    cells_per_unit: f32,
    /// The slot of each node of the tree: its place in the sums and weights of a region.
    slots: Vec<u32>,
    /// Number of slots of a region: nodes, then lights at infinity.
    width: usize,
    /// Number of them that are lights at infinity.
    distant: usize,
    /// For each cell and direction its region.
    regions: Vec<AtomicU32>,
    /// The cells of the regions, in order.
    keys: Vec<u32>,
    sums: Vec<Sums>,
    /// The weights of all regions, relative to importance; for lights at infinity, to 1.
    weights: Vec<f32>,
    /// Whether samples are being added.
    pub(super) learns: bool,
}

impl Guide {
    /// Nothing is known yet. The grid covers the sphere of the scene.
    pub(super) fn new(nodes: &[Node], distant: usize, (center, radius): (Vec3, f32)) -> Self {
        let (slots, top) = top_of(nodes);
        let distant = if distant > MOST_DISTANT { 0 } else { distant };
        let untouched = || AtomicU32::new(UNTOUCHED);
        Guide {
            low: center - radius,
            cells_per_unit: CELLS as f32 / (2.0 * radius),
            slots,
            width: top + distant,
            distant,
            regions: std::iter::repeat_with(untouched).take(CELLS.pow(3) * DIRECTIONS).collect(),
            keys: Vec::new(),
            sums: Vec::new(),
            weights: Vec::new(),
            learns: true,
        }
    }

    /// Number of regions.
    pub(super) fn regions(&self) -> usize {
        self.keys.len()
    }

    /// Memory in bytes.
    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&self.slots[..])
            + size_of_val(&self.regions[..])
            + size_of_val(&self.sums[..])
            + size_of_val(&self.weights[..])
    }

    /// The cell and direction of a point.
    #[inline]
    fn key(&self, at: &Vantage) -> usize {
        let cell = (at.p - self.low) * self.cells_per_unit;
        let [x, y, z] = cell.to_array().map(|c| (c as usize).min(CELLS - 1));
        let direction = match at.facing {
            Facing::Any => 6,
            Facing::Side(n) | Facing::Both(n) => {
                let size = n.abs();
                let axis = if size.x >= size.y && size.x >= size.z {
                    0
                } else if size.y >= size.z {
                    1
                } else {
                    2
                };
                2 * axis + usize::from(n[axis] < 0.0)
            }
        };
        ((x * CELLS + y) * CELLS + z) * DIRECTIONS + direction
    }

    /// The weights at a point; `None` if nothing is known there.
    #[inline]
    pub(super) fn weights(&self, at: &Vantage) -> Option<Weights<'_>> {
        let region = self.regions[self.key(at)].load(Relaxed) as usize;
        let all = self.weights.get(region * self.width..(region + 1) * self.width)?;
        let (nodes, distant) = all.split_at(self.width - self.distant);
        Some(Weights { slots: &self.slots, nodes, distant })
    }

    /// The place of the sums of a point's region. Until the region exists, marks its cell.
    #[inline]
    fn place(&self, at: &Vantage) -> Option<usize> {
        let region = &self.regions[self.key(at)];
        match region.load(Relaxed) {
            UNTOUCHED | TOUCHED => {
                region.store(TOUCHED, Relaxed);
                None
            }
            REFUSED => None,
            known => Some(known as usize * self.width),
        }
    }

    /// Add a sample of the light from light `k` at infinity.
    #[inline]
    pub(super) fn add_distant(&self, at: &Vantage, k: usize, light: f32) {
        if let Some(place) = self.place(at).filter(|_| k < self.distant) {
            self.sums[place + self.width - self.distant + k].add(light);
        }
    }

    /// What adds the factor of a light sample to the sums of a node. It returns whether the node has sums, as the nodes at the top
    /// of the tree do. `None` if the point is in no region.
    #[inline]
    pub(super) fn adding(&self, at: &Vantage) -> Option<impl Fn(usize, f32) -> bool + '_> {
        let place = self.place(at)?;
        Some(move |node: usize, factor: f32| {
            let slot = self.slots[node];
            if slot != NONE {
                self.sums[place + slot as usize].add(factor);
            }
            slot != NONE
        })
    }

    /// Make regions of the cells that the last pass has touched, and compute all weights.
    pub(super) fn update(&mut self) {
        for key in 0..self.regions.len() {
            let region = self.regions[key].get_mut();
            if *region == TOUCHED {
                let next = self.keys.len();
                *region = if next < REGIONS { next as u32 } else { REFUSED };
                if next < REGIONS {
                    self.keys.push(key as u32);
                }
            }
        }
        self.sums.resize_with(self.keys.len() * self.width, Sums::default);
        self.weigh();
    }

    /// Compute all weights from the sums.
    fn weigh(&mut self) {
        let (width, nodes) = (self.width, self.width - self.distant);
        // The prior mean: that of all nodes in all regions, or of one light at infinity in all regions.
        let mut all = vec![Data::default(); self.distant + 1];
        for (k, sums) in self.sums.iter().enumerate() {
            all[(k % width + 1).saturating_sub(nodes)].include(sums.data());
        }
        let prior = |slot: usize| all[(slot + 1).saturating_sub(nodes)].mean().unwrap_or(1.0);
        let priors: Vec<f64> = (0..width).map(prior).collect();
        let weight = |(k, sums): (usize, &Sums)| sums.data().root_of_moment(priors[k % width]);
        self.weights = self.sums.iter().enumerate().map(weight).collect();
    }

    /// The sums of all regions and the weights in use, for a checkpoint.
    pub(super) fn save(&self, w: &mut Writer) {
        let is_touched = |key: &usize| self.regions[*key].load(Relaxed) == TOUCHED;
        let touched: Vec<usize> = (0..self.regions.len()).filter(is_touched).collect();
        w.u64(touched.len() as u64);
        touched.iter().for_each(|key| w.u32(*key as u32));
        w.u64(self.keys.len() as u64);
        for (key, sums) in self.keys.iter().zip(self.sums.chunks(self.width.max(1))) {
            w.u32(*key);
            sums.iter().for_each(|s| w.counts(s.all()));
        }
        w.f32s(&self.weights);
    }

    /// Add stored sums. The weights are those that were in use, unless sums of several runs are added.
    pub(super) fn restore(&mut self, r: &mut Reader) -> Result<(), String> {
        let is_first = self.keys.is_empty();
        for _ in 0..r.u64()? {
            let region = self.region_mut(r.u32()?)?;
            if *region == UNTOUCHED {
                *region = TOUCHED;
            }
        }
        let stored = r.u64()?;
        for _ in 0..stored {
            let key = r.u32()?;
            let next = self.keys.len() as u32;
            let region = self.region_mut(key)?;
            if *region >= REFUSED {
                *region = next;
                self.keys.push(key);
                self.sums.resize_with(self.keys.len() * self.width, Sums::default);
            }
            let place = *self.region_mut(key)? as usize * self.width;
            for sums in &self.sums[place..place + self.width] {
                r.add_to_counts(sums.all())?;
            }
        }
        let weights = (0..stored).flat_map(|_| 0..self.width).map(|_| r.f32());
        self.weights = weights.collect::<Result<_, _>>()?;
        if !is_first {
            self.weigh();
        }
        Ok(())
    }

    fn region_mut(&mut self, key: u32) -> Result<&mut u32, String> {
        let region = self.regions.get_mut(key as usize);
        region.map(AtomicU32::get_mut).ok_or_else(|| "a region is outside the scene".into())
    }
}

/// The weights of a region.
#[derive(Clone, Copy)]
pub(super) struct Weights<'g> {
    slots: &'g [u32],
    nodes: &'g [f32],
    /// Those of the lights at infinity; empty if these are too many.
    pub(super) distant: &'g [f32],
}

impl Weights<'_> {
    /// The weights of two siblings; `None` if they are not at the top.
    #[inline]
    pub(super) fn pair(&self, first: usize) -> Option<[f32; 2]> {
        let slot = self.slots[first];
        (slot != NONE).then(|| [first, first + 1].map(|k| self.nodes[self.slots[k] as usize]))
    }

    /// The weight of the root.
    #[inline]
    pub(super) fn root(&self) -> f32 {
        self.nodes[0]
    }
}

/// Cut the tree into clusters that are small for their intensity. Returns the slots of all nodes, and the number of
/// nodes that have one: the clusters and all nodes above them.
fn top_of(nodes: &[Node]) -> (Vec<u32>, usize) {
    let mut slots = vec![NONE; nodes.len()];
    if nodes.is_empty() {
        return (slots, 0);
    }
    slots[0] = 0;
    let (mut open, mut top) = (vec![0usize], 1);
    while open.len() < CLUSTERS {
        let size = |k: &usize| match nodes[*k].link() {
            Link::Children(_) => nodes[*k].spread(),
            Link::Light(_) => -1.0,
        };
        let largest = (0..open.len()).max_by(|&a, &b| size(&open[a]).total_cmp(&size(&open[b])));
        let Some(largest) = largest else { break };
        let Link::Children(first) = nodes[open[largest]].link() else { break };
        let first = first as usize;
        (slots[first], slots[first + 1]) = (top, top + 1);
        top += 2;
        open[largest] = first;
        open.push(first + 1);
    }
    (slots, top as usize)
}

#[cfg(test)]
mod tests;
