//! Reconstruction cuts [Walter05, 5]: cuts are computed only at some points of the picture. For each point in between,
//! the light trees are traversed, and the parts on which the nearby cuts agree are interpolated.
//!
//! 1. A **sample** is the cut at a corner of a block of pixels. It stores the light from each node of the cut and from
//!    each node above the cut; the light of a node above is the sum over the nodes below.
//! 2. At each node it has an **impostor**: parallel light that gives the sample exactly the light of the node. The
//!    impostor also illuminates other points nearby, with their own texture and normal.
//! 3. At a point within the block, all trees are traversed from the root. At each node, the samples' impostors
//!    illuminate the point, and there are four cases:
//!    - **discard** the node if it is dark in all samples;
//!    - **interpolate** if the samples agree up to a fraction of the whole;
//!    - **descend** if they disagree and all of them have a finer cut;
//!    - else trace a **shadow ray** to the representative. These clusters form a cut, which is then refined like any other.
//!
//! A sample is used only on the same material, with nearly the same normal and in nearly the same plane. If one of the
//! four samples fails this test, the point gets a cut of its own.

use gi_core::geometry::Surface;
use gi_core::math::Rgb;
use gi_core::scene::Scene;
use glam::Vec3;

use crate::cut::{Cut, Lit};
use crate::light::{At, Lights};
use crate::record::{Entry, Record};
use crate::tree::{Forest, NodeId};

/// Turn the light of representatives into impostors, from the cut up to `id`. Returns the light that the node brings.
fn sum_up(record: &mut Record, forest: &Forest, at: &At, slot: u32, id: NodeId) -> Rgb {
    let shape = &forest.trees[id.tree as usize];
    let entry = record.entries[slot as usize];
    if entry.child == 0 {
        let arriving = entry.arriving * shape.node(id.node).power;
        record.entries[slot as usize].arriving = arriving;
        return if arriving.is_black() { arriving } else { at.receiver.f_cos(entry.wi) * arriving };
    }
    let children = shape.node(id.node).children().expect("it was split");
    let below = [entry.child, entry.child + 1];
    let brings =
        [0, 1].map(|i| sum_up(record, forest, at, below[i], NodeId { node: children[i], ..id }));
    let parts = below.map(|k| record.entries[k as usize]);
    record.entries[slot as usize] = Entry { child: entry.child, ..impostor(at, parts, brings) };
    brings[0] + brings[1]
}

/// Parallel light that brings the sum of two others: from their mean direction, or from the direction of the stronger
/// one if the lobes of the surface are too sharp for the mean.
fn impostor(at: &At, parts: [Entry; 2], brings: [Rgb; 2]) -> Entry {
    let sum = brings[0] + brings[1];
    if sum.is_black() {
        return Entry { arriving: Rgb::BLACK, ..parts[0] };
    }
    let arriving = parts[0].arriving + parts[1].arriving;
    let [a, b] = brings.map(Rgb::luminance);
    let mean = (parts[0].wi * a + parts[1].wi * b).try_normalize();
    let stronger = parts[usize::from(b > a)].wi;
    let from = |wi: Vec3| {
        let scale = at.receiver.f_cos(wi).zip(sum, |f, s| if f > 0.0 { s / f } else { -1.0 });
        let arriving = scale.zip(arriving, |exact, sum| if exact < 0.0 { sum } else { exact });
        let lost = scale.zip(sum, |exact, s| if exact < 0.0 { s } else { 0.0 });
        (Entry { wi, arriving, child: 0 }, !lost.is_black())
    };
    if let Some((entry, lost)) = mean.map(from) {
        let strange = entry.arriving.luminance() / arriving.luminance();
        if !lost && (0.5..2.0).contains(&strange) {
            return entry;
        }
    }
    from(stronger).0
}

/// The sample at a corner of a block.
pub struct Sample {
    record: Record,
    surface: Surface,
    material: usize,
    /// Estimate of the total light, as luminance.
    total: f32,
    /// Number of shadow rays of its cut.
    pub rays: u32,
}

/// Smallest cosine between normals, and largest sine of the angle out of the plane, for which a sample is used.
const ALIKE_COS: f32 = 0.95;
const ALIKE_SIN: f32 = 0.15;

/// Largest relative difference between the samples' total light for which a point is reconstructed.
const MOST_APART: f32 = 0.1;

impl Sample {
    /// The sample of a point from its recorded cut; `lit` is the light of that cut.
    pub fn new(lights: &Lights, at: &At, mut record: Record, lit: &Lit) -> Self {
        for tree in 0..lights.forest.trees.len() as u32 {
            sum_up(&mut record, lights.forest, at, tree, NodeId { tree, node: 0 });
        }
        let surface = at.receiver.surface().expect("cuts are recorded on surfaces");
        Sample {
            record,
            surface: *surface,
            material: lights.scene.shapes()[surface.shape as usize].material,
            total: lit.all().luminance(),
            rays: lit.rays,
        }
    }

    /// Whether the sample can be used at a point.
    pub fn serves(&self, scene: &Scene, surface: &Surface) -> bool {
        let to = self.surface.p - surface.p;
        let out_of_plane = to.dot(surface.ng).abs().max(to.dot(self.surface.ng).abs());
        self.material == scene.shapes()[surface.shape as usize].material
            && self.surface.ns().dot(surface.ns()) > ALIKE_COS
            && self.surface.ng.dot(surface.ng) > ALIKE_COS
            && out_of_plane <= ALIKE_SIN * to.length()
    }

    /// The light that a node's impostor brings to a point.
    fn impostor(&self, at: &At, slot: u32) -> Rgb {
        let Entry { wi, arriving, .. } = self.record.entries[slot as usize];
        if arriving.is_black() { arriving } else { at.receiver.f_cos(wi) * arriving }
    }

    fn child(&self, slot: u32) -> Option<u32> {
        let child = self.record.entries[slot as usize].child;
        (child != 0).then_some(child)
    }

    /// Memory of the sample in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.record.entries[..])
    }
}

/// Four samples around a point, with bilinear weights.
pub type Corners<'s> = [(&'s Sample, f32); 4];

impl<'a> Lights<'_, 'a> {
    /// Whether the samples agree on the total light of a point. Otherwise many small differences add up: for example,
    /// near a corner of the room light falls off on one side only, and linear interpolation fails.
    pub fn agree_on_the_whole(&self, at: &At, corners: &Corners) -> bool {
        let counted = || (0..self.forest.trees.len()).filter(|&t| at.counts(&self.forest.trees[t]));
        let whole =
            |s: &Sample| counted().map(|t| s.impostor(at, t as u32).luminance()).sum::<f32>();
        let wholes = corners.map(|(s, _)| whole(s));
        let (low, high) =
            wholes.iter().fold((f32::INFINITY, 0.0f32), |(l, h), w| (l.min(*w), h.max(*w)));
        high - low <= MOST_APART * high
    }

    /// Traverse all trees for a point between samples. Where the samples differ by at most `agree` times the total
    /// light, they are interpolated. The clusters on which they disagree form a cut, which is still to be refined.
    pub fn interpolate(&self, at: &At<'_, '_, 'a>, corners: &Corners, agree: f32) -> Interpolated {
        let mut cut = Cut::default();
        let mut lit = Lit::default();
        let whole: f32 = corners.iter().map(|(s, w)| s.total * w).sum();
        let mut open: Vec<Open> = (0..self.forest.trees.len() as u32)
            .rev()
            .filter(|&t| at.counts(&self.forest.trees[t as usize]))
            .map(|tree| Open { id: NodeId { tree, node: 0 }, slots: [tree; 4] })
            .collect();
        while let Some(Open { id, slots }) = open.pop() {
            let brings: [Rgb; 4] = std::array::from_fn(|k| corners[k].0.impostor(at, slots[k]));
            let (mut low, mut high) = (f32::INFINITY, 0.0f32);
            brings
                .iter()
                .for_each(|b| (low, high) = (low.min(b.luminance()), high.max(b.luminance())));
            let tree = &self.forest.trees[id.tree as usize];
            // Discard what is dark in all samples.
            if high == 0.0 {
                continue;
            }
            // Interpolate where the samples agree.
            if high - low <= agree * whole {
                let light = brings.iter().zip(corners).map(|(b, (_, w))| *b * *w).sum::<Rgb>();
                *(if tree.is_direct() { &mut lit.direct } else { &mut lit.indirect }) += light;
                cut.total += f64::from(light.luminance());
                lit.size += 1;
                continue;
            }
            let below: [Option<u32>; 4] = std::array::from_fn(|k| corners[k].0.child(slots[k]));
            match (below, tree.node(id.node).children()) {
                // Descend where all samples have a finer cut.
                ([Some(a), Some(b), Some(c), Some(d)], Some([first, second])) => {
                    let slots = [a + 1, b + 1, c + 1, d + 1];
                    open.push(Open { id: NodeId { node: second, ..id }, slots });
                    open.push(Open { id: NodeId { node: first, ..id }, slots: [a, b, c, d] });
                }
                // Else trace a shadow ray to the representative.
                _ => self.add(at, &mut cut, id, 0, &mut None),
            }
        }
        Interpolated { lit, cut }
    }
}

/// A node to be visited, and its entries in the four samples.
struct Open {
    id: NodeId,
    slots: [u32; 4],
}

/// The result of [`Lights::interpolate`].
pub struct Interpolated {
    /// The interpolated light.
    pub lit: Lit,
    /// The clusters that are not interpolated. Its total includes the interpolated light.
    pub cut: Cut,
}

impl Interpolated {
    /// Add the light of the refined cut.
    pub fn with(&self, refined: Lit) -> Lit {
        Lit {
            direct: self.lit.direct + refined.direct,
            indirect: self.lit.indirect + refined.indirect,
            size: self.lit.size + refined.size,
            ..refined
        }
    }
}

#[cfg(test)]
mod tests;
