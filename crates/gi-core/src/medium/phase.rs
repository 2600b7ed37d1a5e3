//! Phase functions: the distribution of light that a medium scatters.

use glam::Vec3;

use crate::math::{Frame, INV_PI, safe_sqrt, sin_cos_turns, sqr};

/// A phase function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// The same in all directions.
    Isotropic,
    /// Henyey-Greenstein with mean cosine `g` in (-1, 1) \[Henyey41\].
    HenyeyGreenstein {
        /// Mean cosine of the deflection.
        g: f32,
    },
    /// Particles much smaller than the wavelength, such as air: 3 (1 + cos^2) / 16 pi.
    Rayleigh,
}

/// Relative margin of the bound, against rounding.
const SAFETY: f32 = 1.0 + 5e-4;

impl Phase {
    /// Mean cosine of the deflection.
    pub fn mean_cosine(self) -> f32 {
        match self {
            Phase::Isotropic | Phase::Rayleigh => 0.0,
            Phase::HenyeyGreenstein { g } => g,
        }
    }

    /// Fraction of scattered light along `wi`, per solid angle. It integrates to 1, and is also the density of
    /// [`Phase::sample`]. Both directions are unit and point away from the point; `wo` points to where the path came
    /// from.
    #[inline]
    pub fn eval(self, wo: Vec3, wi: Vec3) -> f32 {
        match self {
            Phase::Isotropic => 0.25 * INV_PI,
            Phase::Rayleigh => 0.1875 * INV_PI * (1.0 + sqr(wo.dot(wi))),
            Phase::HenyeyGreenstein { g } => {
                // 1 + g^2 - 2 g cos with cos = -wo . wi, in a form that keeps sharp peaks accurate: (1 - g)^2 + 2 g (1
                // - cos).
                let squared = if g > 0.0 {
                    sqr(1.0 - g) + g * (wo + wi).length_squared()
                } else {
                    sqr(1.0 + g) - g * (wi - wo).length_squared()
                };
                0.25 * INV_PI * (1.0 - g * g) / (squared * squared.sqrt())
            }
        }
    }

    /// Upper bound of [`Phase::eval`] over a set of pairs of directions `wi` and `wo`. `ahead` returns an upper bound of the cosine
    /// between `wi` and `-wo`, and `back` of that between `wi` and `wo`. Each is called only if it matters.
    #[inline]
    pub fn bound(self, ahead: impl FnOnce() -> f32, back: impl FnOnce() -> f32) -> f32 {
        let bound = match self {
            Phase::Isotropic => 0.25 * INV_PI,
            Phase::Rayleigh => 0.1875 * INV_PI * (1.0 + sqr(ahead().max(back()).max(0.0))),
            Phase::HenyeyGreenstein { g } => {
                let cos = (if g > 0.0 { ahead() } else { back() }).clamp(-1.0, 1.0);
                let squared = sqr(1.0 - g.abs()) + 2.0 * g.abs() * (1.0 - cos);
                0.25 * INV_PI * (1.0 - g * g) / (squared * squared.sqrt())
            }
        };
        bound * SAFETY
    }

    /// Sample the direction in which a path continues.
    #[inline]
    pub fn sample(self, wo: Vec3, [u, v]: [f32; 2]) -> Vec3 {
        let x = 2.0 * u - 1.0;
        let cos = match self {
            Phase::Isotropic => x,
            Phase::HenyeyGreenstein { g } => {
                // Henyey and Greenstein's inversion, expanded so that there is no division by g.
                let numerator = 2.0 * x + g * (x * x + 3.0) + g * g * (2.0 * x + g * (x * x - 1.0));
                numerator / (2.0 * sqr(1.0 + g * x))
            }
            // The root of cos^3 + 3 cos = 4 x, by Cardano's formula \[Frisvad11\].
            Phase::Rayleigh => {
                let root = (2.0 * x + (4.0 * x * x + 1.0).sqrt()).cbrt();
                root - root.recip()
            }
        };
        let cos = cos.clamp(-1.0, 1.0);
        let r = safe_sqrt(1.0 - cos * cos);
        let (sin_phi, cos_phi) = sin_cos_turns(v);
        Frame::from_normal(-wo).to_world(Vec3::new(r * cos_phi, r * sin_phi, cos))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Toward;
    use crate::math::Bounds;
    use crate::rng::Pcg;

    #[test]
    fn the_mean_cosine_is_g() {
        let wo = Vec3::new(0.6, -0.64, 0.48);
        for g in [-0.9, -0.3, 0.0, 1e-6, 0.02, 0.5, 0.95] {
            let phase = Phase::HenyeyGreenstein { g };
            let mut rng = Pcg::new(3, 1);
            let n = 100_000;
            let (mut sum, mut squares) = (0.0f64, 0.0f64);
            for _ in 0..n {
                let wi = phase.sample(wo, [rng.next_f32(), rng.next_f32()]);
                let cos = f64::from(-wo.dot(wi));
                sum += cos;
                squares += cos * cos;
            }
            let n = f64::from(n);
            let mean = sum / n;
            let error = ((squares / n - mean * mean) / n).sqrt();
            assert!((mean - f64::from(g)).abs() < 4.0 * error, "{mean} +- {error}, not {g}");
        }
    }

    #[test]
    fn no_direction_of_a_box_exceeds_the_bound() {
        let mut rng = Pcg::new(4, 1);
        let phases = [
            Phase::Isotropic,
            Phase::Rayleigh,
            Phase::HenyeyGreenstein { g: 0.9 },
            Phase::HenyeyGreenstein { g: -0.6 },
        ];
        let mut corner = |size: f32| Vec3::from([0; 3].map(|_| size * (rng.next_f32() - 0.5)));
        let mut tight = 0;
        for k in 0..4000 {
            let phase = phases[k % 4];
            let (middle, half) = (corner(4.0), corner([0.01, 0.3, 2.0][k % 3]).abs());
            let bounds = Bounds { min: middle - half, max: middle + half };
            let wo = corner(2.0).normalize();
            let toward = Toward::new(Vec3::ZERO, &bounds);
            let most = |n: Vec3| toward.max_cos(&Frame::from_normal(n));
            let bound = phase.bound(|| most(-wo), || most(wo));
            for _ in 0..20 {
                let wi = (middle + 2.0 * half * corner(1.0)).normalize();
                let value = phase.eval(wo, wi);
                assert!(value <= bound, "{phase:?}: {value} is above {bound}");
                tight += u32::from(value > 0.9 * bound);
            }
        }
        assert!(tight > 30_000, "{tight} of 80,000 values are near the bound");
    }

    #[test]
    fn phase_functions_are_reciprocal() {
        let (a, b) = (Vec3::new(0.6, 0.8, 0.0), Vec3::new(-0.48, 0.6, 0.64));
        for phase in [Phase::HenyeyGreenstein { g: 0.7 }, Phase::Rayleigh] {
            assert_eq!(phase.eval(a, b), phase.eval(b, a));
            assert_eq!(phase.eval(a, b), phase.eval(-a, -b));
        }
    }

    /// The distribution of the cosine is (x^3 + 3 x + 4) / 8: sampling inverts it.
    #[test]
    fn rayleigh_scattering_is_sampled_as_it_is_evaluated() {
        let wo = Vec3::new(0.6, -0.64, 0.48);
        for k in 0..=1000 {
            let u = k as f32 / 1000.0;
            let cos = -wo.dot(Phase::Rayleigh.sample(wo, [u, 0.3]));
            let distribution = (cos.powi(3) + 3.0 * cos + 4.0) / 8.0;
            assert!((distribution - u).abs() < 1e-6, "{u} {cos}");
        }
        // Straight ahead, across and back.
        let [ahead, across, back] = [-wo, Vec3::new(0.0, 0.6, 0.8), wo];
        let along = |wi: Vec3| Phase::Rayleigh.eval(wo, wi) * 16.0 / (3.0 * INV_PI);
        assert!([ahead, back].iter().all(|&wi| (along(wi) - 2.0).abs() < 1e-5));
        assert!((along(across) - 1.0).abs() < 1e-5);
    }
}
