//! The statistics of a pixel or a hit point: R, N and tau [slides 40 to 42]. [`crate::update`] adds a pass.

use std::f64::consts::PI;

/// The photons that one pass found within the radius.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pass {
    /// M: number of photons that contribute. Photons from behind, on another surface, or with f = 0 do not.
    pub photons: u64,
    /// Sum of f times power over these photons, weighted by the path throughput; the power is already divided by the
    /// number of paths of the pass.
    pub flux: [f64; 3],
}

/// The statistics of one hit point (`ppm`), or of everything that a pixel sees (`sppm`) \[Hachisuka09\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// R(x), world units.
    pub radius: f64,
    /// N(x): number of photons that the density counts.
    pub photons: f64,
    /// tau(x): their flux, scaled with the disc; powers are already divided by the number of paths of their pass.
    pub flux: [f64; 3],
}

impl Statistics {
    /// No photons so far.
    pub fn new(radius: f64) -> Self {
        Statistics { radius, ..Statistics::default() }
    }

    /// Scale the area of the disc by `share`, together with photons and flux.
    pub fn scale(&mut self, share: f64) {
        self.radius *= share.sqrt();
        self.photons *= share;
        self.flux.iter_mut().for_each(|tau| *tau *= share);
    }

    /// Radiance after `passes` passes: tau / (pi R^2), divided by their number.
    pub fn radiance(&self, passes: u32) -> [f64; 3] {
        let area = PI * self.radius * self.radius * f64::from(passes);
        self.flux.map(|tau| if area > 0.0 { tau / area } else { 0.0 })
    }
}

/// Counts since the start of the run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Counts {
    pub(crate) passes: u32,
    pub(crate) paths: u64,
    pub(crate) stored: u64,
    /// Number of photons that contributed, over all pixels and passes.
    pub(crate) contributed: u64,
    /// The latest estimate of the picture's error; infinite if there is none yet.
    pub(crate) error: f64,
}

impl Counts {
    /// These counts of a stored run, added to those of the runs before. The error is that of the last run. A damaged checkpoint may
    /// state any counts, so that a sum stops at the largest number.
    pub(crate) fn after(self, before: &Counts) -> Counts {
        Counts {
            passes: before.passes.saturating_add(self.passes),
            paths: before.paths.saturating_add(self.paths),
            stored: before.stored.saturating_add(self.stored),
            contributed: before.contributed.saturating_add(self.contributed),
            error: self.error,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::update as progress;

    fn pass(photons: u64) -> Pass {
        Pass { photons, flux: [photons as f64 * 0.3; 3] }
    }

    #[test]
    fn with_a_constant_number_of_photons_per_pass_the_radius_follows_the_closed_form() {
        // With N = j alpha M after j passes: (R_k / R_0)^2 = prod alpha (j + 1) / (alpha j + 1), j from 0 to k - 1.
        for alpha in [0.5, 0.6, 2.0 / 3.0, 0.7, 0.9, 1.0] {
            for photons in [1, 37] {
                let mut s = Statistics::new(2.0);
                let mut product = 4.0;
                for j in 0..1000 {
                    progress(&mut s, &pass(photons), alpha);
                    product *= alpha * f64::from(j + 1) / (alpha * f64::from(j) + 1.0);
                    let error = s.radius * s.radius / product - 1.0;
                    assert!(error.abs() < 1e-11, "alpha {alpha}, pass {j}: {error:e}");
                }
                assert!((s.photons / (1000.0 * alpha * photons as f64) - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn alpha_one_keeps_the_radius_and_every_photon() {
        let mut s = Statistics::new(0.25);
        (0..100).for_each(|_| progress(&mut s, &pass(3), 1.0));
        assert_eq!((s.radius, s.photons), (0.25, 300.0));
    }

    #[test]
    fn at_constant_density_the_radius_goes_to_zero_and_the_photons_to_infinity() {
        // M is proportional to R^2, with R^2 ~ k^(alpha - 1) and N ~ k^alpha. For n ~ k emitted photons, n R^2 ~
        // k^alpha.
        for alpha in [0.5, 2.0 / 3.0, 0.9] {
            let mut s = Statistics::new(1.0);
            let mut at = Vec::new();
            for k in 1..=100_000 {
                let photons = (1e7 * s.radius * s.radius).round() as u64;
                progress(&mut s, &pass(photons), alpha);
                if k == 1000 || k == 100_000 {
                    at.push((f64::from(k), s.radius * s.radius, s.photons));
                }
            }
            let slope = |a: f64, b: f64| (b / a).ln() / (at[1].0 / at[0].0).ln();
            assert!((slope(at[0].1, at[1].1) - (alpha - 1.0)).abs() < 0.01, "{alpha}: {at:?}");
            assert!((slope(at[0].2, at[1].2) - alpha).abs() < 0.01, "{alpha}: {at:?}");
            assert!(at[1].0 * at[1].1 > at[0].0 * at[0].1);
        }
    }

    #[test]
    fn a_pass_without_photons_changes_nothing_but_the_mean() {
        let mut s = Statistics::new(0.5);
        progress(&mut s, &pass(10), 0.7);
        let before = s;
        progress(&mut s, &Pass::default(), 0.7);
        assert_eq!(s, before);
        assert!((s.radiance(2)[0] / before.radiance(1)[0] - 0.5).abs() < 1e-15);
    }

    #[test]
    fn the_estimate_is_the_mean_of_the_estimates_of_all_passes() {
        // In each pass, tau / R^2 increases by exactly flux / R^2, where R is the radius of that pass.
        let mut s = Statistics::new(0.3);
        let mut rng = gi_core::rng::Pcg::new(4, 4);
        let mut sum = 0.0;
        for k in 1..500 {
            let photons = u64::from(rng.next_below(6));
            let found = Pass { photons, flux: [f64::from(rng.next_f32()) * photons as f64; 3] };
            sum += found.flux[0] / (PI * s.radius * s.radius);
            progress(&mut s, &found, 0.7);
            let mean = sum / f64::from(k);
            assert!((s.radiance(k)[0] - mean).abs() < 1e-12 * mean.max(1.0), "pass {k}");
        }
    }
}
