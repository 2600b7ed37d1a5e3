//! Pictures as half floats.

use half::f16;

/// Half floats, scaled so that the largest fits: 11 bits, from the largest down to a billionth of it; below, fewer.
pub struct Halves {
    /// Factor that gives the values back: a power of two.
    pub scale: f64,
    /// The bits, channel by channel.
    pub bits: Vec<u16>,
}

impl Halves {
    /// Value of element `i`.
    pub fn value(&self, i: usize) -> f64 {
        f16::from_bits(self.bits[i]).to_f64() * self.scale
    }
}

/// Scaled half floats of some channels.
pub fn halves<'a>(channels: impl Iterator<Item = &'a f32> + Clone) -> Halves {
    let finite = channels.clone().filter(|v| v.is_finite());
    let largest = finite.fold(0f32, |m, v| m.max(v.abs()));
    let exponent = match largest {
        0.0 => 0,
        largest => (f64::from(f16::MAX) / f64::from(largest)).log2().floor() as i32,
    };
    let factor = 2f64.powi(exponent);
    let bits = channels.map(|v| f16::from_f64(f64::from(*v) * factor).to_bits()).collect();
    Halves { scale: 1.0 / factor, bits }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_to_eleven_bits_over_nine_decades() {
        for top in [1e-20f32, 1.0, 65_504.0, 3e7, 3e38] {
            let values: Vec<f32> = (0..90)
                .map(|i| top * 10f32.powf(-0.1 * i as f32) * if i % 2 == 0 { 1.0 } else { -1.0 })
                .collect();
            let halves = halves(values.iter());
            for (i, v) in values.iter().enumerate() {
                let back = halves.value(i);
                let error = (back / f64::from(*v) - 1.0).abs();
                assert!(error <= 2f64.powi(-11), "{v} came back as {back}");
            }
        }
    }

    #[test]
    fn what_is_not_finite_stays_so_and_black_stays_black() {
        let broken = halves([f32::NAN, f32::INFINITY, 1.0].iter());
        assert!(broken.value(0).is_nan() && broken.value(1).is_infinite());
        assert_eq!(broken.value(2), 1.0);
        assert_eq!(halves([0.0; 3].iter()).bits, [0; 3]);
    }
}
