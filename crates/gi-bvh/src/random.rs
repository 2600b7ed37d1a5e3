//! Random numbers for the tests and the benchmark. The renderer's own generators are in `gi-core`, above this crate.

/// PCG32 (XSH-RR 64/32) \[ONeill14\].
pub(crate) struct Pcg {
    state: u64,
    increment: u64,
}

impl Pcg {
    /// Stream `stream` of the generator with this seed.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        let mut rng = Pcg { state: 0, increment: (stream << 1) | 1 };
        rng.next_u32();
        rng.state = rng.state.wrapping_add(seed);
        rng.next_u32();
        rng
    }

    /// 32 uniform bits.
    pub(crate) fn next_u32(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(self.increment);
        let xorshifted = (((old >> 18) ^ old) >> 27) as u32;
        xorshifted.rotate_right((old >> 59) as u32)
    }

    /// Uniform in [0, 1).
    pub(crate) fn next_f32(&mut self) -> f32 {
        (self.next_u32() >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    /// Uniform in the unit square.
    pub(crate) fn next_2d(&mut self) -> [f32; 2] {
        [self.next_f32(), self.next_f32()]
    }
}
