//! Stratified random numbers: padded (0,2)-sequences with Owen scrambling, without tables \[Burley20\].
//!
//! Every number is a pure function of (seed, pixel or stream, sample index, dimension). Each pair of dimensions is the
//! two-dimensional Sobol sequence, scrambled and shuffled with its own seed. Within every aligned block of 2^k indices,
//! each pair is stratified in all elementary intervals. Different pairs are independent.

use crate::rng::{bits_to_unit, hash_u32, hash_words};

/// The numbers of one path.
#[derive(Clone, Debug)]
pub struct Sampler {
    /// Sample index with its bits reversed: the pass for camera paths, the index of the path for light paths.
    reversed_index: u32,
    /// Hash of the seed and the pixel or stream.
    key: u32,
    /// Next dimension.
    dimension: u32,
}

/// Constants that make the scrambles of a pair's two dimensions differ from its shuffle, and from each other.
const FIRST: u32 = 0xa511_e9b3;
const SECOND: u32 = 0x63d8_3595;

impl Sampler {
    /// The numbers of sample `index` in pixel or stream `stream`.
    pub fn new(seed: u32, stream: u32, index: u32) -> Self {
        Sampler {
            reversed_index: index.reverse_bits(),
            key: hash_words(&[seed, stream]),
            dimension: 0,
        }
    }

    /// Uniform in [0, 1).
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        let (seed, index) = self.next_index();
        bits_to_unit(scramble(index, seed ^ FIRST).reverse_bits())
    }

    /// Uniform in the unit square.
    #[inline]
    pub fn next_2d(&mut self) -> [f32; 2] {
        let (seed, index) = self.next_index();
        let x = scramble(index, seed ^ FIRST).reverse_bits();
        let y = scramble(sobol_second_reversed(index), seed ^ SECOND).reverse_bits();
        [bits_to_unit(x), bits_to_unit(y)]
    }

    /// [`Sampler::next_1d`], or zero for a number that is not needed.
    #[inline]
    pub fn next_1d_if(&mut self, needed: bool) -> f32 {
        if needed {
            return self.next_1d();
        }
        self.skip();
        0.0
    }

    /// Skip a dimension, so that later ones keep their numbers.
    #[inline]
    pub fn skip(&mut self) {
        self.dimension += 1;
    }

    /// Continue at dimension `d`, so that a varying number of draws does not shift later dimensions.
    #[inline]
    pub fn jump_to(&mut self, d: u32) {
        self.dimension = d;
    }

    /// Seed of the next dimension, and the sample index after that dimension's shuffle. (The first Sobol dimension is
    /// the index with its bits reversed, and Owen's scramble works on reversed bits: the two reversals cancel.)
    #[inline]
    fn next_index(&mut self) -> (u32, u32) {
        let seed = hash_u32(self.key ^ self.dimension.wrapping_mul(0x9e37_79b9));
        self.dimension += 1;
        (seed, scramble(self.reversed_index, seed).reverse_bits())
    }
}

/// Owen's nested scramble of all 32 bits, lowest bit first: the hash of Laine and Karras with Vegdahl's constants.
#[inline]
fn scramble(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The second Sobol dimension of an index, with its bits reversed: the Pascal matrix modulo 2, applied in five folding
/// steps.
#[inline]
fn sobol_second_reversed(index: u32) -> u32 {
    let mut x = index;
    x ^= (x & 0xffff_0000) >> 16;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^ (x & 0xaaaa_aaaa) >> 1
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
            assert_eq!(sobol_second_reversed(i).reverse_bits(), x, "index {i}");
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
            // For independent columns, the correlation has a standard deviation of 1/sqrt(n); more than five of these
            // has a probability of 3e-7.
            assert!(correlation(&base, &other).abs() < 5.0 / (n as f32).sqrt());
        }
    }
}
