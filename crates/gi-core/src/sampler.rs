//! Stratified random numbers: padded (0,2)-sequences, Owen-scrambled, without tables \[Burley20\].
//!
//! Every number is a pure function of (seed, pixel or stream, sample index, dimension). Each pair of dimensions is
//! the two-dimensional Sobol sequence, scrambled and shuffled with a seed of its own: within every aligned block
//! of 2^k indices each pair is stratified in all elementary intervals, and pairs are independent of one another.

use crate::rng::{bits_to_unit, hash_u32, hash_words};

/// The numbers of one path.
#[derive(Clone, Debug)]
pub struct Sampler {
    /// Sample index: the pass for camera paths, the running number of the path for light paths.
    index: u32,
    /// Hash of the seed and the pixel or stream.
    key: u32,
    /// Next dimension.
    dimension: u32,
}

impl Sampler {
    /// The numbers of sample `index` in pixel or stream `stream`.
    pub fn new(seed: u32, stream: u32, index: u32) -> Self {
        Sampler { index, key: hash_words(&[seed, stream]), dimension: 0 }
    }

    /// Uniform in [0, 1).
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        let seed = self.next_seed();
        let shuffled = owen_scramble(self.index, seed);
        bits_to_unit(owen_scramble(shuffled.reverse_bits(), seed ^ 0xa511_e9b3))
    }

    /// Uniform in the unit square.
    #[inline]
    pub fn next_2d(&mut self) -> [f32; 2] {
        let seed = self.next_seed();
        let shuffled = owen_scramble(self.index, seed);
        let x = owen_scramble(shuffled.reverse_bits(), seed ^ 0xa511_e9b3);
        let y = owen_scramble(sobol_second(shuffled), seed ^ 0x63d8_3595);
        [bits_to_unit(x), bits_to_unit(y)]
    }

    /// Go on at dimension `d`, so that a use of the sampler that draws a varying number of numbers
    /// does not shift those that follow.
    #[inline]
    pub fn jump_to(&mut self, d: u32) {
        self.dimension = d;
    }

    #[inline]
    fn next_seed(&mut self) -> u32 {
        let seed = hash_u32(self.key ^ self.dimension.wrapping_mul(0x9e37_79b9));
        self.dimension += 1;
        seed
    }
}

/// Owen's nested scramble of all 32 bits, by the hash of Laine and Karras with Vegdahl's constants.
#[inline]
fn owen_scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// The second Sobol dimension: the Pascal matrix modulo 2 applied in five folding steps.
#[inline]
fn sobol_second(index: u32) -> u32 {
    let mut x = index.reverse_bits();
    x ^= (x & 0x0000_ffff) << 16;
    x ^= (x & 0x00ff_00ff) << 8;
    x ^= (x & 0x0f0f_0f0f) << 4;
    x ^= (x & 0x3333_3333) << 2;
    x ^= (x & 0x5555_5555) << 1;
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_dimension_equals_its_direction_numbers() {
        for i in (0..5000).chain([0x8000_0001, u32::MAX]) {
            let (mut bits, mut v, mut x) = (i, 1u32 << 31, 0);
            while bits != 0 {
                if bits & 1 != 0 {
                    x ^= v;
                }
                bits >>= 1;
                v ^= v >> 1;
            }
            assert_eq!(sobol_second(i), x, "index {i}");
        }
    }

    #[test]
    fn every_aligned_block_is_stratified_in_all_elementary_intervals() {
        for (stream, block) in [(0, 0u32), (7, 3), (99, 12)] {
            for dimension in [0, 5] {
                let points: Vec<[f32; 2]> = (0..64)
                    .map(|i| {
                        let mut s = Sampler::new(1, stream, block * 64 + i);
                        s.jump_to(dimension);
                        s.next_2d()
                    })
                    .collect();
                for log_x in 0..=6 {
                    let (nx, ny) = (1usize << log_x, 64 >> log_x);
                    let mut seen = [false; 64];
                    for [x, y] in &points {
                        let cell = (x * nx as f32) as usize * ny + (y * ny as f32) as usize;
                        assert!(
                            !std::mem::replace(&mut seen[cell], true),
                            "{nx} x {ny}: two points in cell {cell}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn dimensions_and_streams_are_uncorrelated() {
        let n = 4096;
        let column = |stream: u32, dimension: u32| -> Vec<f32> {
            (0..n)
                .map(|i| {
                    let mut s = Sampler::new(3, stream, i);
                    s.jump_to(dimension);
                    s.next_1d() - 0.5
                })
                .collect()
        };
        let correlation = |a: &[f32], b: &[f32]| {
            12.0 * a.iter().zip(b).map(|(x, y)| x * y).sum::<f32>() / n as f32
        };
        let base = column(0, 0);
        for other in [column(0, 1), column(0, 2), column(1, 0), column(2, 0)] {
            // Independent columns have a correlation of standard deviation 1/sqrt(n); five of them is 3e-7 likely.
            assert!(correlation(&base, &other).abs() < 5.0 / (n as f32).sqrt());
        }
    }
}
