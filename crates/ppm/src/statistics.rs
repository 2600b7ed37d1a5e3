//! What a region of the picture knows of its photons: R, N and tau [slides 40 to 42].

use std::f64::consts::PI;

/// What one pass found within the radius.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pass {
    /// M: photons that contribute. Those from behind, of another surface, or that the BSDF scatters nowhere do not.
    pub photons: u64,
    /// Sum over them of f times power, weighted as the picture sees it; power already divided by the paths of the pass.
    pub flux: [f64; 3],
}

/// The statistics of a region: of one hit point (`ppm`), or shared by all that a pixel sees (`sppm`) \[Hachisuka09\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// R(x), world units.
    pub radius: f64,
    /// N(x): photons that the density still counts.
    pub photons: f64,
    /// tau(x): their flux, scaled down with the disc; powers already divided by the paths of their pass.
    pub flux: [f64; 3],
}

impl Statistics {
    /// Nothing found yet.
    pub fn new(radius: f64) -> Self {
        Statistics { radius, ..Statistics::default() }
    }

    /// R'^2 / R^2 after a pass that found `photons`: at the density found, a share `alpha` of them stays.
    pub fn shrinkage(&self, photons: u64, alpha: f64) -> f64 {
        // d'(x) = (N + M) / (pi R^2) [slide 41]
        let (n, m) = (self.photons, photons as f64);
        // R' = R sqrt((N + alpha M) / (N + M)) [slide 42]
        if n + m > 0.0 { (n + alpha * m) / (n + m) } else { 1.0 }
    }

    /// Take a pass in that was gathered with the radius as it is.
    pub fn add(&mut self, pass: &Pass) {
        self.photons += pass.photons as f64;
        self.flux.iter_mut().zip(pass.flux).for_each(|(tau, found)| *tau += found);
    }

    /// Scale the disc's area; photons and flux go with it: N' = (N + M) R'^2 / R^2, which is N + alpha M after
    /// [`Statistics::shrinkage`], and tau' = (tau + tau_M) R'^2 / R^2 [Hachisuka08, eqs. 8 and 10].
    pub fn scale(&mut self, share: f64) {
        self.radius *= share.sqrt();
        self.photons *= share;
        self.flux.iter_mut().for_each(|tau| *tau *= share);
    }

    /// Radiance after `passes` passes: tau / (pi R^2) over their number.
    pub fn radiance(&self, passes: u32) -> [f64; 3] {
        let area = PI * self.radius * self.radius * f64::from(passes);
        self.flux.map(|tau| if area > 0.0 { tau / area } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pass(photons: u64) -> Pass {
        Pass { photons, flux: [photons as f64 * 0.3; 3] }
    }

    /// A pass of slides 41 and 42.
    fn progress(s: &mut Statistics, pass: &Pass, alpha: f64) {
        let share = s.shrinkage(pass.photons, alpha);
        s.add(pass);
        s.scale(share);
    }

    #[test]
    fn for_a_constant_number_of_photons_a_pass_the_radius_follows_the_closed_product() {
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
        // M is then proportional to R^2, and R^2 ~ k^(alpha - 1), N ~ k^alpha: n R^2 ~ k^alpha for n ~ k emitted.
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
    fn the_estimate_is_the_mean_of_the_passes_own_estimates() {
        // tau / R^2 gains exactly flux / R^2 of each pass, R being the radius that the pass was gathered with.
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
