//! The light from a node of the light tree in a region, as a factor on the node's importance. The factor is zero if the
//! node is hidden. Otherwise it has a normal distribution of unknown mean and variance, with the conjugate prior: a
//! normal-inverse-gamma distribution. The probability of zero has a beta distribution.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Steps per unit of the sums of factors and of their squares; larger factors than this count as this.
const STEPS: [f32; 2] = [1_048_576.0, 65_536.0];
const MOST: f32 = 4096.0;

/// The sums for one node in one region.
#[derive(Debug, Default)]
pub(super) struct Sums {
    /// Number of samples in the low half, number of those that are not zero in the high half.
    counts: AtomicU64,
    /// Sum of the factors, and of their squares.
    factors: [AtomicU64; 2],
}

/// The sums as numbers.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Data {
    samples: f64,
    lit: f64,
    sum: f64,
    squares: f64,
}

impl Sums {
    /// All sums, for a checkpoint.
    pub(super) fn all(&self) -> impl Iterator<Item = &AtomicU64> {
        [&self.counts].into_iter().chain(&self.factors)
    }

    /// Add a sample: the light over the importance.
    #[inline]
    pub(super) fn add(&self, factor: f32) {
        let factor = factor.clamp(0.0, MOST);
        let lit = u64::from(factor > 0.0);
        self.counts.fetch_add(1 | lit << 32, Relaxed);
        if factor > 0.0 {
            let parts = [factor * STEPS[0], factor * factor * STEPS[1]];
            let sums = self.factors.iter().zip(parts);
            sums.for_each(|(sum, part)| _ = sum.fetch_add(part as u64, Relaxed));
        }
    }

    /// The sums as numbers.
    pub(super) fn data(&self) -> Data {
        let counts = self.counts.load(Relaxed);
        let [sum, squares] =
            [0, 1].map(|k| self.factors[k].load(Relaxed) as f64 / f64::from(STEPS[k]));
        Data { samples: (counts & 0xffff_ffff) as f64, lit: (counts >> 32) as f64, sum, squares }
    }
}

/// Weight of the prior mean, in samples, and the shape of the prior distribution of the variance.
const PRIOR_SAMPLES: f64 = 2.0;
const PRIOR_SHAPE: f64 = 2.0;
/// Both parameters of the beta prior for the probability that a sample is not zero. The prior mean is one half.
const PRIOR_BETA: f64 = 1.0;

impl Data {
    /// Add the samples of another node or region.
    pub(super) fn include(&mut self, other: Data) {
        self.samples += other.samples;
        self.lit += other.lit;
        self.sum += other.sum;
        self.squares += other.squares;
    }

    /// Mean of the factors that are not zero.
    pub(super) fn mean(self) -> Option<f64> {
        (self.lit > 0.0).then(|| self.sum / self.lit)
    }

    /// The root of the predicted second moment of the factor, if its mean is `mean` before all samples.
    pub(super) fn root_of_moment(self, mean: f64) -> f32 {
        let Data { samples, lit, sum, squares } = self;
        let visible = (lit + PRIOR_BETA) / (samples + 2.0 * PRIOR_BETA);
        let own = sum / lit.max(1.0);
        let weight = PRIOR_SAMPLES + lit;
        let mu = (PRIOR_SAMPLES * mean + sum) / weight;
        let shape = PRIOR_SHAPE + 0.5 * lit;
        let scatter = (squares - lit * own * own).max(0.0);
        let apart = PRIOR_SAMPLES * lit * (own - mean).powi(2) / weight;
        let scale = mean * mean + 0.5 * (scatter + apart);
        let variance = scale * (weight + 1.0) / ((shape - 1.0) * weight);
        (visible * (mu * mu + variance)).sqrt() as f32
    }
}
