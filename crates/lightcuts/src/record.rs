//! A recorded cut: the cut of a point with all nodes above it, for reconstruction.

use gi_core::math::Rgb;
use glam::Vec3;

/// A node of a recorded cut, or above it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    /// Unit direction of the impostor's light.
    pub(crate) wi: Vec3,
    /// Irradiance on a plane perpendicular to `wi`; for unit power while the cut is being chosen.
    pub(crate) arriving: Rgb,
    /// The first of two children; 0 on the cut.
    pub(crate) child: u32,
}

/// A cut with all nodes above it.
#[derive(Clone, Debug, Default)]
pub struct Record {
    pub(crate) entries: Vec<Entry>,
}

impl Record {
    /// Begin with one entry per tree, for its root.
    pub fn begin(&mut self, trees: usize) {
        (0..trees).for_each(|_| _ = self.push());
    }

    /// Add entries for the two children of an entry, and return the index of the first.
    pub fn split(&mut self, slot: u32) -> u32 {
        let first = self.push();
        self.push();
        self.entries[slot as usize].child = first;
        first
    }

    /// Copy the light of the parent to the child that has the same representative.
    pub fn inherit(&mut self, child: u32, parent: u32) {
        let Entry { wi, arriving, .. } = self.entries[parent as usize];
        self.note(child, wi, arriving);
    }

    /// Store the light of a representative.
    pub fn note(&mut self, slot: u32, wi: Vec3, arriving: Rgb) {
        let entry = &mut self.entries[slot as usize];
        (entry.wi, entry.arriving) = (wi, arriving);
    }

    fn push(&mut self) -> u32 {
        self.entries.push(Entry { wi: Vec3::Z, arriving: Rgb::BLACK, child: 0 });
        self.entries.len() as u32 - 1
    }
}
