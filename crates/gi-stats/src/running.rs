/// Running mean and variance \[Welford62\]; two of them can be merged \[Chan79\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Running {
    count: u64,
    mean: f64,
    deviation: f64,
}

impl Running {
    /// Add a number.
    pub fn push(&mut self, x: f64) {
        self.count += 1;
        let d = x - self.mean;
        self.mean += d / self.count as f64;
        self.deviation += d * (x - self.mean);
    }

    /// Add all numbers of another one.
    pub fn merge(&mut self, other: &Running) {
        let n = self.count + other.count;
        if other.count == 0 {
            return;
        }
        let (d, share) = (other.mean - self.mean, other.count as f64 / n as f64);
        self.mean += d * share;
        self.deviation += other.deviation + d * d * self.count as f64 * share;
        self.count = n;
    }

    /// The count of numbers.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The mean; 0 without numbers.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Unbiased estimate of the variance; 0 for fewer than two numbers.
    pub fn variance(&self) -> f64 {
        if self.count > 1 { self.deviation / (self.count - 1) as f64 } else { 0.0 }
    }

    /// Variance of the mean.
    pub fn variance_of_mean(&self) -> f64 {
        if self.count > 0 { self.variance() / self.count as f64 } else { 0.0 }
    }
}

impl FromIterator<f64> for Running {
    fn from_iter<I: IntoIterator<Item = f64>>(iter: I) -> Self {
        let mut running = Running::default();
        iter.into_iter().for_each(|x| running.push(x));
        running
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merging_equals_pushing_and_survives_a_large_offset() {
        let numbers: Vec<f64> = (0..1000).map(|i| 1e9 + f64::from(i * 37 % 101)).collect();
        let whole: Running = numbers.iter().copied().collect();
        let mut merged: Running = numbers[..300].iter().copied().collect();
        merged.merge(&numbers[300..].iter().copied().collect());
        merged.merge(&Running::default());
        let exact = numbers.iter().map(|x| (x - 1e9).powi(2)).sum::<f64>();
        let mean = numbers.iter().map(|x| x - 1e9).sum::<f64>() / 1000.0;
        let variance = (exact - 1000.0 * mean * mean) / 999.0;
        for r in [whole, merged] {
            assert!((r.mean() - 1e9 - mean).abs() < 1e-4);
            assert!(
                (r.variance() / variance - 1.0).abs() < 1e-6,
                "{} is not {variance}",
                r.variance()
            );
        }
    }
}
