//! Discrete and piecewise constant distributions.

/// Samples indices in proportion to weights, by inversion: neighbouring random numbers give neighbouring indices, so
/// stratified numbers stay stratified. A guide table gives the start of the search \[Chen74\]: for any number of indices,
/// sampling takes about four steps, and waits for memory twice.
#[derive(Clone, Debug, Default)]
pub struct Discrete {
    /// Cumulative distribution function at the end of each index's step; the last value is exactly one.
    cdf: Vec<f32>,
    /// The unit interval has one part for every [`PER_PART`] indices. For each part, the first index whose step ends
    /// beyond its start.
    guide: Vec<u32>,
    /// Sum of the weights.
    total: f64,
}

/// A smaller guide stays in the cache, and the search takes more steps, but in one cache line.
const PER_PART: usize = 8;

impl Discrete {
    /// A distribution with the given weights, which must be finite and not negative. If it is empty or all weights are
    /// zero, sampling returns nothing.
    pub fn new(weights: impl IntoIterator<Item = f32>) -> Self {
        let mut total = 0.0f64;
        let sums: Vec<f64> = weights
            .into_iter()
            .map(|w| {
                total += f64::from(w);
                total
            })
            .collect();
        if total <= 0.0 {
            return Discrete { cdf: vec![0.0; sums.len()], guide: Vec::new(), total: 0.0 };
        }
        let mut cdf: Vec<f32> = sums.iter().map(|s| (s / total) as f32).collect();
        // Rounding must not make the last index with a weight end below one.
        let last = sums.iter().position(|&s| s == total).unwrap_or(0);
        cdf[last..].fill(1.0);
        let (n, mut k) = (cdf.len(), 0);
        let parts = n.div_ceil(PER_PART);
        let guide = (0..parts)
            .map(|i| {
                while cdf[k] <= i as f32 / parts as f32 && k + 1 < n {
                    k += 1;
                }
                k as u32
            })
            .collect();
        Discrete { cdf, guide, total }
    }

    /// Sum of the weights.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// Number of indices.
    pub fn len(&self) -> usize {
        self.cdf.len()
    }

    /// Whether there are no indices to sample.
    pub fn is_empty(&self) -> bool {
        self.guide.is_empty()
    }

    /// Sample an index for `u` in [0, 1). Returns the index, its probability, and the position of `u` within the
    /// index's step, rescaled to [0, 1).
    #[inline]
    pub fn sample(&self, u: f32) -> Option<(usize, f32, f32)> {
        let n = self.guide.len();
        // The rounded product may be one cell too large, so step back first.
        let mut k = *self.guide.get(((u * n as f32) as usize).min(n.wrapping_sub(1)))? as usize;
        while k > 0 && self.cdf[k - 1] > u {
            k -= 1;
        }
        while self.cdf[k] <= u {
            k += 1;
        }
        let low = if k == 0 { 0.0 } else { self.cdf[k - 1] };
        let p = self.cdf[k] - low;
        Some((k, p, ((u - low) / p).clamp(0.0, 1.0 - f32::EPSILON)))
    }

    /// Probability of an index.
    #[inline]
    pub fn probability(&self, k: usize) -> f32 {
        self.cdf[k] - if k == 0 { 0.0 } else { self.cdf[k - 1] }
    }
}

/// A density over the unit square that is constant in each cell.
#[derive(Clone, Debug)]
pub struct Grid {
    width: usize,
    rows: Discrete,
    columns: Vec<Discrete>,
}

impl Grid {
    /// A density in proportion to `weights`, given row by row.
    pub fn new(width: usize, weights: &[f32]) -> Self {
        let columns: Vec<Discrete> =
            weights.chunks(width).map(|row| Discrete::new(row.iter().copied())).collect();
        let rows = Discrete::new(columns.iter().map(|c| c.total() as f32));
        Grid { width, rows, columns }
    }

    /// A point and its density per unit area.
    #[inline]
    pub fn sample(&self, [u, v]: [f32; 2]) -> Option<([f32; 2], f32)> {
        let (y, p_y, v) = self.rows.sample(v)?;
        let (x, p_x, u) = self.columns[y].sample(u)?;
        let (w, h) = (self.width as f32, self.columns.len() as f32);
        Some(([(x as f32 + u) / w, (y as f32 + v) / h], p_x * p_y * w * h))
    }

    /// Density per unit area at a point.
    #[inline]
    pub fn pdf(&self, [u, v]: [f32; 2]) -> f32 {
        let (w, h) = (self.width as f32, self.columns.len() as f32);
        let x = ((u * w) as usize).min(self.width - 1);
        let y = ((v * h) as usize).min(self.columns.len() - 1);
        if self.rows.is_empty() || self.columns[y].is_empty() {
            return 0.0;
        }
        self.rows.probability(y) * self.columns[y].probability(x) * w * h
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_weights_are_never_drawn() {
        let d = Discrete::new([0.0, 2.0, 0.0, 6.0, 0.0]);
        for i in 0..1000 {
            let (k, p, within) = d.sample(i as f32 / 1000.0).expect("not empty");
            assert!((k == 1 && p == 0.25) || (k == 3 && p == 0.75), "{k} {p}");
            assert!((0.0..1.0).contains(&within));
        }
        assert_eq!(d.sample(1.0 - f32::EPSILON / 2.0).expect("not empty").0, 3);
        assert!(Discrete::new([0.0, 0.0]).sample(0.3).is_none());
        assert!(Discrete::new([]).sample(0.3).is_none());
    }

    #[test]
    fn the_guide_finds_what_a_search_finds() {
        let mut rng = crate::rng::Pcg::new(1, 3);
        for n in [1, 2, 7, 100, 5000] {
            let d = Discrete::new(
                (0..n).map(|i| if i % 3 == 1 { 0.0 } else { rng.next_f32().powi(8) }),
            );
            for i in 0..5000 {
                let u = if i == 0 { 1.0 - f32::EPSILON / 2.0 } else { rng.next_f32() };
                let k = d.sample(u).expect("not empty").0;
                assert_eq!(k, d.cdf.partition_point(|&c| c <= u), "{n} weights, u = {u}");
            }
        }
    }

    #[test]
    fn grid_density_is_what_it_draws() {
        let g = Grid::new(3, &[1.0, 0.0, 3.0, 0.0, 0.0, 4.0]);
        let n = 120;
        for i in 0..n * n {
            let u = [((i % n) as f32 + 0.5) / n as f32, ((i / n) as f32 + 0.5) / n as f32];
            let (p, pdf) = g.sample(u).expect("not empty");
            assert!((g.pdf(p) - pdf).abs() < 1e-5, "{p:?}");
        }
        assert_eq!(g.pdf([0.5, 0.2]), 0.0);
        assert!((g.pdf([0.9, 0.7]) - 3.0).abs() < 1e-5);
    }
}
