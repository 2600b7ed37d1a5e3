//! The sums of a pixel.

use glam::Vec3;

use super::{Components, Sample, Show};
use crate::bytes::{Reader, Writer};
use crate::math::Rgb;

/// Sums over passes of weights W and of weighted radiance A. The value of the pixel is A / W.
#[derive(Clone, Debug, Default)]
pub(super) struct Pixel {
    pub(super) passes: u32,
    /// W.
    weight: f64,
    /// A by component: direct, indirect, caustic.
    sums: [[f64; 3]; 3],
    /// Sums over passes of W W, and of A W and A A of what is shown.
    weight_sq: f64,
    cross: [f64; 3],
    shown_sq: [f64; 3],
    /// Running means of the pixel's own samples.
    pub(super) albedo: Rgb,
    pub(super) normal: Vec3,
    pub(super) depth: f32,
}

impl Pixel {
    /// Add a pass: the sum of filter weights and the weighted radiance.
    pub(super) fn add(&mut self, weight: f32, radiance: &Components, show: Show) {
        self.passes += 1;
        let w = f64::from(weight);
        self.weight += w;
        self.weight_sq += w * w;
        let parts = [radiance.direct, radiance.indirect, radiance.caustic];
        for (sum, part) in self.sums.iter_mut().zip(parts) {
            sum.iter_mut().zip(part.to_array()).for_each(|(s, v)| *s += f64::from(v));
        }
        for (k, a) in show.of(radiance).to_array().into_iter().enumerate() {
            let a = f64::from(a);
            self.cross[k] += a * w;
            self.shown_sq[k] += a * a;
        }
    }

    /// Add the first surface of the pixel's own sample.
    pub(super) fn add_surface(&mut self, sample: &Sample) {
        let share = 1.0 / (self.passes + 1) as f32;
        self.albedo = self.albedo.lerp(sample.albedo, share);
        self.normal = self.normal.lerp(sample.normal, share);
        self.depth += (sample.depth - self.depth) * share;
    }

    /// Add the sums of another pixel, from other passes.
    pub(super) fn merge(&mut self, other: &Pixel) {
        let passes = self.passes + other.passes;
        let share = if passes > 0 { other.passes as f32 / passes as f32 } else { 0.0 };
        self.passes = passes;
        self.weight += other.weight;
        self.weight_sq += other.weight_sq;
        let add = |a: &mut [f64; 3], b: &[f64; 3]| a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        self.sums.iter_mut().zip(&other.sums).for_each(|(a, b)| add(a, b));
        add(&mut self.cross, &other.cross);
        add(&mut self.shown_sq, &other.shown_sq);
        self.albedo = self.albedo.lerp(other.albedo, share);
        self.normal = self.normal.lerp(other.normal, share);
        self.depth += (other.depth - self.depth) * share;
    }

    /// Every field, bit for bit.
    pub(super) fn write(&self, w: &mut Writer) {
        w.u32(self.passes);
        w.f64(self.weight);
        self.sums.iter().for_each(|s| w.f64s(s));
        w.f64(self.weight_sq);
        w.f64s(&self.cross);
        w.f64s(&self.shown_sq);
        w.rgb(self.albedo);
        w.vec3(self.normal);
        w.f32(self.depth);
    }

    /// What [`Pixel::write`] wrote.
    pub(super) fn read(r: &mut Reader) -> Result<Self, String> {
        Ok(Pixel {
            passes: r.u32()?,
            weight: r.f64()?,
            sums: [r.f64s()?, r.f64s()?, r.f64s()?],
            weight_sq: r.f64()?,
            cross: r.f64s()?,
            shown_sq: r.f64s()?,
            albedo: r.rgb()?,
            normal: r.vec3()?,
            depth: r.f32()?,
        })
    }

    /// Radiance of channel `k` of a component.
    pub(super) fn component(&self, component: usize, k: usize) -> f64 {
        if self.weight == 0.0 { 0.0 } else { self.sums[component][k] / self.weight }
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
        if self.passes < 2 || self.weight == 0.0 {
            return 0.0;
        }
        let (n, x) = (f64::from(self.passes), self.shown(k, show));
        let squares = self.shown_sq[k] - 2.0 * x * self.cross[k] + x * x * self.weight_sq;
        squares.max(0.0) / (self.weight * self.weight) * n / (n - 1.0)
    }
}
