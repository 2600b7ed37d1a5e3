//! Sums whose bits do not depend on the order of the terms, so that merged shards equal a single run.

use crate::bytes::{Reader, Writer};

/// N sums. Each is a double, and a float that holds what the roundings of the double have lost. So the doubles are nearly always the
/// exact sums, rounded once. The float is rounded too: with n terms, the last bit of about n in 2^24 doubles depends on the order of
/// the terms. Layers are in single precision, where hardly any of these differences remain.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sums<const N: usize> {
    high: [f64; N],
    low: [f32; N],
}

impl<const N: usize> Default for Sums<N> {
    fn default() -> Self {
        Sums { high: [0.0; N], low: [0.0; N] }
    }
}

impl<const N: usize> Sums<N> {
    /// The sums, rounded.
    #[inline]
    pub(super) fn get(&self, k: usize) -> f64 {
        self.high[k]
    }

    /// Add to one sum.
    #[inline]
    pub(super) fn add(&mut self, k: usize, x: f64) {
        self.add_parts(k, x, 0.0);
    }

    /// Add the sums of another pixel.
    pub(super) fn merge(&mut self, other: &Self) {
        (0..N).for_each(|k| self.add_parts(k, other.high[k], other.low[k]));
    }

    /// Add a term that is itself a double and a rest \[Knuth97, 4.2.2, theorem B\].
    #[inline]
    fn add_parts(&mut self, k: usize, x: f64, rest: f32) {
        let high = self.high[k];
        let sum = high + x;
        let of_x = sum - high;
        let lost = (high - (sum - of_x)) + (x - of_x);
        let low = lost + (f64::from(self.low[k]) + f64::from(rest));
        let rounded = sum + low;
        self.high[k] = rounded;
        self.low[k] = (low - (rounded - sum)) as f32;
    }

    /// Every bit.
    pub(super) fn write(&self, w: &mut Writer) {
        w.f64s(&self.high);
        w.f32s(&self.low);
    }

    /// What [`Sums::write`] wrote.
    pub(super) fn read(r: &mut Reader) -> Result<Self, String> {
        Ok(Sums { high: r.f64s()?, low: r.f32s()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Pcg;

    #[test]
    fn sums_do_not_depend_on_the_order_of_the_terms() {
        let mut rng = Pcg::new(7, 1);
        for _ in 0..200 {
            // Terms over twelve orders of magnitude, and products of two.
            let terms: Vec<f64> = (0..600)
                .map(|_| {
                    f64::from((40.0 * rng.next_f32() - 20.0).exp2()) * f64::from(rng.next_f32())
                })
                .collect();
            let sum = |terms: &[f64]| {
                let mut sum = Sums::<1>::default();
                terms.iter().for_each(|t| sum.add(0, *t));
                sum
            };
            let whole = sum(&terms);
            let mut pieces: Vec<Sums<1>> = terms.chunks(37).map(sum).collect();
            pieces.reverse();
            let mut merged = Sums::<1>::default();
            pieces.iter().for_each(|piece| merged.merge(piece));
            assert_eq!(whole.get(0), merged.get(0));
        }
    }
}
