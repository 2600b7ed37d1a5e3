//! Reconstruction cuts [Walter05, 5]: the cuts of a few points of the picture, and for all points between them a walk down the
//! light tree that takes from those cuts what they agree on.
//!
//! 1. A **sample** is the cut of a corner of a block of pixels. It keeps what every node of the cut, and every node above
//!    it, brings: for nodes above, the sum of what is below.
//! 2. At each node it has an **impostor**: parallel light that brings the sample just what the node brings. It lights other
//!    points near by, whatever their texture and normal.
//! 3. At a point within the block, all trees are walked from the root. At each node the samples' impostors light the
//!    point, and there are four cases:
//!    - **discard** what all samples say is dark;
//!    - **interpolate** what they agree on, to a share of the whole;
//!    - **descend** where they do not agree, as long as all of them know more;
//!    - **ask** the representative otherwise, with a shadow ray. What was asked is then refined as any cut is, until no
//!      cluster's error is above the threshold.
//!
//! Only samples on the same material, with nearly the same normal and in nearly the same plane serve; where one of the four
//! does not, the point gets a cut of its own.

use gi_core::geometry::Surface;
use gi_core::math::Rgb;
use gi_core::scene::Scene;
use glam::Vec3;

use crate::cut::{Cut, Limits, Lit};
use crate::light::{At, Lights};
use crate::tree::Forest;

/// A node of a recorded cut, or above it.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// Unit direction of the impostor's light.
    wi: Vec3,
    /// Irradiance across it: while the cut is chosen, of a unit of power.
    arriving: Rgb,
    /// The first of two children; 0 on the cut.
    child: u32,
}

/// A cut with all nodes above it.
#[derive(Clone, Debug, Default)]
pub struct Record {
    entries: Vec<Entry>,
}

impl Record {
    /// Begin with the roots of so many trees, in their order.
    pub fn begin(&mut self, trees: usize) {
        (0..trees).for_each(|_| _ = self.push());
    }

    /// New entries for two children of one; where the first is.
    pub fn split(&mut self, slot: u32) -> u32 {
        let first = self.push();
        self.push();
        self.entries[slot as usize].child = first;
        first
    }

    /// The child has its parent's representative.
    pub fn inherit(&mut self, child: u32, parent: u32) {
        let Entry { wi, arriving, .. } = self.entries[parent as usize];
        self.note(child, wi, arriving);
    }

    /// What a representative says.
    pub fn note(&mut self, slot: u32, wi: Vec3, arriving: Rgb) {
        let entry = &mut self.entries[slot as usize];
        (entry.wi, entry.arriving) = (wi, arriving);
    }

    fn push(&mut self) -> u32 {
        self.entries.push(Entry { wi: Vec3::Z, arriving: Rgb::BLACK, child: 0 });
        self.entries.len() as u32 - 1
    }

    /// Turn what representatives said into impostors, from the cut up. Returns what the node brings.
    fn sum_up(&mut self, forest: &Forest, at: &At, slot: u32, (tree, node): (u32, u32)) -> Rgb {
        let shape = &forest.trees[tree as usize];
        let entry = self.entries[slot as usize];
        if entry.child == 0 {
            let arriving = entry.arriving * shape.node(node).power;
            self.entries[slot as usize].arriving = arriving;
            return if arriving.is_black() {
                arriving
            } else {
                at.receiver.f_cos(entry.wi) * arriving
            };
        }
        let children = shape.node(node).children().expect("it was split");
        let below = [entry.child, entry.child + 1];
        let brings = [0, 1].map(|i| self.sum_up(forest, at, below[i], (tree, children[i])));
        let parts = below.map(|k| self.entries[k as usize]);
        self.entries[slot as usize] = Entry { child: entry.child, ..impostor(at, parts, brings) };
        brings[0] + brings[1]
    }
}

/// Parallel light that brings what two others bring: from their mean direction, or, where the lobes of the surface are too
/// sharp for that, from the direction of the stronger.
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

/// The cut of a corner of a block.
pub struct Sample {
    record: Record,
    surface: Surface,
    material: usize,
    /// Estimate of the whole, as luminance.
    total: f32,
    /// Shadow rays that it took.
    pub rays: u32,
}

/// Cosine between normals, and sine of the angle out of the plane, of points that are alike.
const ALIKE_COS: f32 = 0.95;
const ALIKE_SIN: f32 = 0.15;

/// Difference between what samples say of the whole that is interpolated, relative: linear interpolation is off by a part.
const MOST_APART: f32 = 0.1;

impl Sample {
    /// Choose and record the cut of a point.
    pub fn take<'a>(
        lights: &Lights<'_, 'a>,
        surface: &Surface,
        at: &At<'_, '_, 'a>,
        limits: &Limits,
    ) -> Self {
        let (mut record, mut cut) = (Record::default(), Cut::default());
        lights.choose(at, limits, &mut cut, &mut Some(&mut record));
        let lit = lights.add_up(&mut cut, limits);
        for t in 0..lights.forest.trees.len() as u32 {
            record.sum_up(lights.forest, at, t, (t, 0));
        }
        Sample {
            record,
            surface: *surface,
            material: lights.scene.shapes()[surface.shape as usize].material,
            total: lit.all().luminance(),
            rays: lit.rays,
        }
    }

    /// Whether what this sample says is worth something at a point.
    pub fn serves(&self, scene: &Scene, surface: &Surface) -> bool {
        let to = self.surface.p - surface.p;
        let out_of_plane = to.dot(surface.ng).abs().max(to.dot(self.surface.ng).abs());
        self.material == scene.shapes()[surface.shape as usize].material
            && self.surface.ns().dot(surface.ns()) > ALIKE_COS
            && self.surface.ng.dot(surface.ng) > ALIKE_COS
            && out_of_plane <= ALIKE_SIN * to.length()
    }

    /// What a node's impostor brings to a point.
    fn impostor(&self, at: &At, slot: u32) -> Rgb {
        let Entry { wi, arriving, .. } = self.record.entries[slot as usize];
        if arriving.is_black() { arriving } else { at.receiver.f_cos(wi) * arriving }
    }

    fn child(&self, slot: u32) -> Option<u32> {
        let child = self.record.entries[slot as usize].child;
        (child != 0).then_some(child)
    }

    /// What it occupies.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.record.entries[..])
    }
}

/// Four samples round a point, with bilinear weights.
pub type Corners<'s> = [(&'s Sample, f32); 4];

impl<'a> Lights<'_, 'a> {
    /// Whether samples say nearly the same of a point's whole light. Where they do not, many small differences, each of them
    /// nothing to speak of, add up: toward corners light falls off on one side and linear interpolation is far off.
    pub fn agree_on_the_whole(&self, at: &At, corners: &Corners) -> bool {
        let counted = || (0..self.forest.trees.len()).filter(|&t| at.counts(&self.forest.trees[t]));
        let whole =
            |s: &Sample| counted().map(|t| s.impostor(at, t as u32).luminance()).sum::<f32>();
        let wholes = corners.map(|(s, _)| whole(s));
        let (low, high) =
            wholes.iter().fold((f32::INFINITY, 0.0f32), |(l, h), w| (l.min(*w), h.max(*w)));
        high - low <= MOST_APART * high
    }

    /// Light a point by a reconstruction cut. Differences between samples of up to `agree` of the whole are interpolated.
    pub fn reconstruct(
        &self,
        at: &At<'_, '_, 'a>,
        corners: &Corners,
        limits: &Limits,
        agree: f32,
    ) -> Lit {
        let mut cut = Cut::default();
        let mut between = Lit::default();
        let whole: f32 = corners.iter().map(|(s, w)| s.total * w).sum();
        let mut open: Vec<(u32, u32, [u32; 4])> = (0..self.forest.trees.len() as u32)
            .rev()
            .filter(|&t| at.counts(&self.forest.trees[t as usize]))
            .map(|t| (t, 0, [t; 4]))
            .collect();
        while let Some((tree, node, slots)) = open.pop() {
            let brings: [Rgb; 4] = std::array::from_fn(|k| corners[k].0.impostor(at, slots[k]));
            let (mut low, mut high) = (f32::INFINITY, 0.0f32);
            brings
                .iter()
                .for_each(|b| (low, high) = (low.min(b.luminance()), high.max(b.luminance())));
            let shape = &self.forest.trees[tree as usize];
            // Discard what all say is dark.
            if high == 0.0 {
                continue;
            }
            // Interpolate what they agree on.
            if high - low <= agree * whole {
                let light = brings.iter().zip(corners).map(|(b, (_, w))| *b * *w).sum::<Rgb>();
                let part =
                    if shape.is_direct() { &mut between.direct } else { &mut between.indirect };
                *part += light;
                cut.total += f64::from(light.luminance());
                between.size += 1;
                continue;
            }
            let below: [Option<u32>; 4] = std::array::from_fn(|k| corners[k].0.child(slots[k]));
            match (below, shape.node(node).children()) {
                // Descend where all know more.
                ([Some(a), Some(b), Some(c), Some(d)], Some([first, second])) => {
                    open.push((tree, second, [a + 1, b + 1, c + 1, d + 1]));
                    open.push((tree, first, [a, b, c, d]));
                }
                // Ask the representative.
                _ => self.add(at, &mut cut, (tree, node), 0, &mut None),
            }
        }
        self.refine(at, limits, &mut cut, &mut None);
        let asked = self.add_up(&mut cut, limits);
        Lit {
            direct: between.direct + asked.direct,
            indirect: between.indirect + asked.indirect,
            size: between.size + asked.size,
            ..asked
        }
    }
}

#[cfg(test)]
mod tests;
