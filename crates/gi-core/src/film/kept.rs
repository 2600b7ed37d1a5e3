//! The samples of a pass while they are filtered.

use super::{Components, Sample};
use crate::filter::FilterTable;
use crate::math::Rgb;

/// Samples of a pass, kept until the pixels round them have gathered them. A sample is a run of floats: the filter
/// along x at the pixels from `-reach` to `reach` of the sample's own, the same along y, then its nine numbers of
/// radiance (direct, indirect, caustic).
pub(super) struct Kept {
    /// Pixels in a run of weights: 2 reach + 1.
    pub(super) width: usize,
    pub(super) floats: Vec<f32>,
}

/// Numbers of radiance a sample has.
pub(super) const RADIANCE: usize = 9;

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
        (x, y, radiance.first_chunk().expect("nine numbers"))
    }
}

/// Write a sample down as [`Kept`] has it.
pub(super) fn keep(run: &mut [f32], sample: &Sample, filter: &FilterTable) {
    let reach = filter.reach();
    let width = 2 * reach + 1;
    for (axis, offset) in sample.offset.into_iter().enumerate() {
        for (k, weight) in run[axis * width..(axis + 1) * width].iter_mut().enumerate() {
            *weight = filter.weight(k as f32 - reach as f32 - offset);
        }
    }
    let Components { direct, indirect, caustic } = sample.radiance;
    let numbers = [direct, indirect, caustic].into_iter().flat_map(Rgb::to_array);
    run[2 * width..].iter_mut().zip(numbers).for_each(|(to, from)| *to = from);
}
