//! The sums of a pixel.

use super::sums::Sums;
use super::{Components, Sample, Show};
use crate::bytes::{Reader, Writer};

/// Sums over passes of weights W and of weighted radiance A. The value of the pixel is A / W.
#[derive(Clone, Debug, Default)]
pub(super) struct Pixel {
    pub(super) passes: u32,
    /// Number of first surfaces; an abandoned pass may have added one.
    surfaces: u32,
    sums: Sums<COUNT>,
}

/// Where the sums are. W.
const WEIGHT: usize = 0;
/// A by component and channel: direct, indirect, caustic.
const RADIANCE: usize = 1;
/// Of W W, and per channel of A W and A A of what is shown.
const WEIGHT_SQ: usize = 10;
const CROSS: usize = 11;
const SHOWN_SQ: usize = 14;
/// Of the first surfaces of the pixel's own samples.
const ALBEDO: usize = 17;
const NORMAL: usize = 20;
const DEPTH: usize = 23;
const COUNT: usize = 24;

impl Pixel {
    /// Number of bytes that [`Pixel::write`] writes.
    pub(super) const BYTES: usize = 8 + 12 * COUNT;

    /// Add a pass: the sum of filter weights and the weighted radiance.
    pub(super) fn add(&mut self, weight: f32, radiance: &Components, show: Show) {
        self.passes += 1;
        let w = f64::from(weight);
        self.sums.add(WEIGHT, w);
        self.sums.add(WEIGHT_SQ, w * w);
        for (c, part) in
            [radiance.direct, radiance.indirect, radiance.caustic].into_iter().enumerate()
        {
            self.add_three(RADIANCE + 3 * c, part.to_array());
        }
        for (k, a) in show.of(radiance).to_array().into_iter().enumerate() {
            let a = f64::from(a);
            self.sums.add(CROSS + k, a * w);
            self.sums.add(SHOWN_SQ + k, a * a);
        }
    }

    /// Add the first surface of the pixel's own sample.
    pub(super) fn add_surface(&mut self, sample: &Sample) {
        self.surfaces += 1;
        self.add_three(ALBEDO, sample.albedo.to_array());
        self.add_three(NORMAL, sample.normal.to_array());
        self.sums.add(DEPTH, f64::from(sample.depth));
    }

    fn add_three(&mut self, first: usize, values: [f32; 3]) {
        values.into_iter().enumerate().for_each(|(k, v)| self.sums.add(first + k, f64::from(v)));
    }

    /// Add the sums of another pixel, from other passes.
    pub(super) fn merge(&mut self, other: &Pixel) {
        self.passes += other.passes;
        self.surfaces += other.surfaces;
        self.sums.merge(&other.sums);
    }

    /// Every field, bit for bit.
    pub(super) fn write(&self, w: &mut Writer) {
        w.u32(self.passes);
        w.u32(self.surfaces);
        self.sums.write(w);
    }

    /// What [`Pixel::write`] wrote.
    pub(super) fn read(r: &mut Reader) -> Result<Self, String> {
        Ok(Pixel { passes: r.u32()?, surfaces: r.u32()?, sums: Sums::read(r)? })
    }

    /// Mean of channel `k` of the first surfaces' albedo.
    pub(super) fn albedo(&self, k: usize) -> f64 {
        self.mean(ALBEDO + k)
    }

    /// Mean of component `k` of their normals.
    pub(super) fn normal(&self, k: usize) -> f64 {
        self.mean(NORMAL + k)
    }

    /// Mean of their depths.
    pub(super) fn depth(&self) -> f64 {
        self.mean(DEPTH)
    }

    fn mean(&self, sum: usize) -> f64 {
        self.sums.get(sum) / f64::from(self.surfaces.max(1))
    }

    /// Radiance of channel `k` of a component.
    pub(super) fn component(&self, component: usize, k: usize) -> f64 {
        let weight = self.sums.get(WEIGHT);
        if weight == 0.0 { 0.0 } else { self.sums.get(RADIANCE + 3 * component + k) / weight }
    }

    /// What is shown of channel `k`.
    pub(super) fn shown(&self, k: usize, show: Show) -> f64 {
        match show {
            Show::All => (0..3).map(|c| self.component(c, k)).sum(),
            Show::Direct => self.component(0, k),
            Show::Indirect => self.component(1, k),
            Show::Caustic => self.component(2, k),
        }
    }

    /// Variance of what is shown of channel `k`: passes are independent, and for the ratio x = sum A / sum W it is
    /// sum (A - x W)^2 / (sum W)^2 in first order, n / (n - 1) times for n passes.
    pub(super) fn variance(&self, k: usize, show: Show) -> f64 {
        let weight = self.sums.get(WEIGHT);
        if self.passes < 2 || weight == 0.0 {
            return 0.0;
        }
        let (n, x) = (f64::from(self.passes), self.shown(k, show));
        let squares = self.sums.get(SHOWN_SQ + k) - 2.0 * x * self.sums.get(CROSS + k)
            + x * x * self.sums.get(WEIGHT_SQ);
        squares.max(0.0) / (weight * weight) * n / (n - 1.0)
    }
}
