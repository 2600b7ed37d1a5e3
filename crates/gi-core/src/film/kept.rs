//! The samples of a pass while they are filtered.

use super::{Components, Sample};
use crate::filter::FilterTable;

/// Samples of a pass, kept until the pixels round them have gathered them. A sample is a run of floats: the filter
/// along x at the pixels from `-reach` to `reach` of the sample's own, the same along y, then its radiance (direct,
/// indirect, caustic; nine numbers, and padding that lets four be added at once).
pub(super) struct Kept {
    /// Pixels in a run of weights: 2 reach + 1.
    pub(super) width: usize,
    pub(super) floats: Vec<f32>,
}

/// Floats of radiance a sample has.
pub(super) const RADIANCE: usize = 12;

impl Kept {
    pub(super) fn stride(&self) -> usize {
        2 * self.width + RADIANCE
    }

    /// The run of the sample in place `place`, as weights along x, along y, and radiance.
    #[inline]
    pub(super) fn read(&self, place: usize) -> (&[f32], &[f32], &[f32; RADIANCE]) {
        let run = &self.floats[place * self.stride()..(place + 1) * self.stride()];
        let (x, rest) = run.split_at(self.width);
        let (y, radiance) = rest.split_at(self.width);
        (x, y, radiance.first_chunk().expect("a run ends with its radiance"))
    }
}

/// Write a sample down as [`Kept`] has it.
pub(super) fn keep(run: &mut [f32], sample: &Sample, filter: &FilterTable) {
    let reach = filter.reach();
    let (along_x, rest) = run.split_at_mut(2 * reach + 1);
    let (along_y, radiance) = rest.split_at_mut(2 * reach + 1);
    for (axis, offset) in [along_x, along_y].into_iter().zip(sample.offset) {
        let mut x = -(reach as f32) - offset;
        for weight in axis {
            *weight = filter.weight(x);
            x += 1.0;
        }
    }
    let Components { direct: d, indirect: i, caustic: c } = sample.radiance;
    radiance.copy_from_slice(&[d.r, d.g, d.b, i.r, i.g, i.b, c.r, c.g, c.b, 0.0, 0.0, 0.0]);
}
