//! Counter-based random numbers: hashes, and PCG32 streams for emission and tests.

/// Turn 32 random bits into a float in [0, 1).
#[inline]
pub fn bits_to_unit(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// PCG's RXS-M-XS output function as a 32-bit hash \[Jarzynski20\].
#[inline]
pub fn hash_u32(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Mix several words into one hash that depends on their order.
#[inline]
pub fn hash_words(words: &[u32]) -> u32 {
    words.iter().fold(0x9e37_79b9, |h, &w| hash_u32(h ^ w).wrapping_add(h.rotate_left(5)))
}

/// PCG32 (XSH-RR 64/32) \[ONeill14\]: a stream of random numbers.
#[derive(Clone, Debug)]
pub struct Pcg {
    state: u64,
    increment: u64,
}

impl Pcg {
    /// Stream `stream` of the generator with this seed; different streams never overlap.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut rng = Pcg { state: 0, increment: (stream << 1) | 1 };
        rng.next_u32();
        rng.state = rng.state.wrapping_add(seed);
        rng.next_u32();
        rng
    }

    /// 32 uniform bits.
    #[inline]
    pub fn next_u32(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(self.increment);
        let xorshifted = (((old >> 18) ^ old) >> 27) as u32;
        xorshifted.rotate_right((old >> 59) as u32)
    }

    /// Uniform in [0, 1).
    #[inline]
    pub fn next_f32(&mut self) -> f32 {
        bits_to_unit(self.next_u32())
    }

    /// Uniform in the unit square.
    #[inline]
    pub fn next_2d(&mut self) -> [f32; 2] {
        [self.next_f32(), self.next_f32()]
    }

    /// Uniform in 0..n (n > 0); for n below 2^24, the modulo bias is negligible.
    #[inline]
    pub fn next_below(&mut self, n: u32) -> u32 {
        ((u64::from(self.next_u32()) * u64::from(n)) >> 32) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pcg_matches_the_published_sequence() {
        // The demo of the reference distribution: pcg32_srandom(42, 54).
        let mut rng = Pcg::new(42, 54);
        let first: Vec<u32> = (0..6).map(|_| rng.next_u32()).collect();
        assert_eq!(
            first,
            [0xa15c_02b7, 0x7b47_f409, 0xba1d_3330, 0x83d2_f293, 0xbfa4_784b, 0xcbed_606e]
        );
    }

    #[test]
    fn unit_floats_stay_below_one() {
        assert_eq!(bits_to_unit(0), 0.0);
        assert!(bits_to_unit(u32::MAX) < 1.0);
    }
}
