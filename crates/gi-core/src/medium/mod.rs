//! Participating media: they absorb and scatter light between surfaces.
//!
//! Transmittance along a ray is T(t) = exp(-sigma_t t) in a homogeneous medium (Beer's law). Per unit of length, the
//! medium scatters the fraction sigma_s = albedo sigma_t of the light, distributed by the phase function [slide 34]
//! \[Jensen01, 10.1\]. If the density varies, sigma_t t becomes an integral along the ray, which `varying.rs` estimates.

mod majorant;
mod phase;
mod varying;
mod volume;

use glam::Vec3;

use crate::math::Rgb;
pub use phase::Phase;
pub use varying::{Domain, Tracking, Varying};
pub use volume::{Between, Cells, Grid, Outside, Volume};

/// Index of a medium in [`crate::scene::Scene::media`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MediumId(u32);

impl MediumId {
    /// The medium at `index` of the scene's media.
    pub fn new(index: usize) -> Self {
        MediumId(u32::try_from(index).expect("fewer than 2^32 media"))
    }

    /// Its index in the scene's media.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A medium.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Extinction coefficient, per world unit; the largest if it varies.
    pub sigma_t: Rgb,
    /// Scattering over extinction, in [0, 1]; the largest if it varies.
    pub albedo: Rgb,
    /// Distribution of the scattered light.
    pub phase: Phase,
    /// The coefficients at every point, if they vary.
    pub varying: Option<Box<Varying>>,
}

/// How a path crosses a part of a medium. The weight is a factor on the path's throughput or power: the fraction of
/// light, divided by the density of this event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flight {
    /// It is scattered after the distance `t`, world units: T(t) sigma_s divided by the density of `t`.
    Scattered {
        /// Distance, smaller than that of the far end.
        t: f32,
        /// Weight of scattered light, without the phase function.
        weight: Rgb,
    },
    /// It reaches the far end: T divided by the probability of this.
    Passed {
        /// Weight of the light that passes.
        weight: Rgb,
    },
}

/// The first of `media` that equals `id`: equal media count as one.
pub fn first_equal(media: &[Medium], id: MediumId) -> MediumId {
    media.iter().position(|m| *m == media[id.index()]).map_or(id, MediumId::new)
}

impl Medium {
    /// A medium whose coefficients are the same everywhere.
    pub fn homogeneous(sigma_t: Rgb, albedo: Rgb, phase: Phase) -> Self {
        Medium { sigma_t, albedo, phase, varying: None }
    }

    /// A medium whose coefficients vary.
    pub fn heterogeneous(varying: Varying, phase: Phase) -> Self {
        let (sigma_t, albedo) = (varying.sigma_t().most(), varying.albedo().most());
        Medium { sigma_t, albedo, phase, varying: Some(Box::new(varying)) }
    }

    /// Scattering coefficient, per world unit.
    #[inline]
    pub fn sigma_s(&self) -> Rgb {
        self.albedo * self.sigma_t
    }

    /// Transmittance of a homogeneous medium over `distance` world units, which may be infinite: exp(-sigma_t d).
    #[inline]
    pub fn transmittance(&self, distance: f32) -> Rgb {
        debug_assert!(self.varying.is_none(), "the density varies");
        // Without absorption, an infinite distance removes nothing.
        self.sigma_t.map(|s| if s > 0.0 { (-s * distance).exp() } else { 1.0 })
    }

    /// Transmittance from `o` along the unit vector `d` over `distance` world units, or an unbiased estimate of it.
    #[inline]
    pub fn transmittance_along(
        &self,
        o: Vec3,
        d: Vec3,
        distance: f32,
        random: &mut Tracking,
    ) -> Rgb {
        match &self.varying {
            None => self.transmittance(distance),
            Some(varying) => varying.transmittance((o, d), distance, random),
        }
    }

    /// Whether it only absorbs.
    #[inline]
    pub fn only_absorbs(&self) -> bool {
        (self.albedo * self.sigma_t).is_black()
    }

    /// Sample a distance in a homogeneous medium in proportion to the transmittance of one channel, which is chosen in proportion to
    /// `throughput` (not black). Infinite if the medium only absorbs: paths then pass, attenuated. Infinite too if the
    /// density varies: [`Medium::flight_along`] samples it up to the far end.
    #[inline]
    pub fn distance(&self, throughput: Rgb, [u_channel, u]: [f32; 2]) -> f32 {
        if self.only_absorbs() || self.varying.is_some() {
            return f32::INFINITY;
        }
        let [r, g, b] = channel_shares(throughput).to_array();
        let sigma = if u_channel < r || (g == 0.0 && b == 0.0) {
            self.sigma_t.r
        } else if u_channel < r + g || b == 0.0 {
            self.sigma_t.g
        } else {
            self.sigma_t.b
        };
        if sigma > 0.0 { -(1.0 - u).ln() / sigma } else { f32::INFINITY }
    }

    /// The event of a distance `t` from [`Medium::distance`] with the same `throughput`, if the far end is `reach`
    /// away. Weights divide by the density over all channels, sum_c p_c sigma_t,c T_c(t) or sum_c p_c T_c(reach). In
    /// channel c they are at most 1 / p_c; in a grey medium they are the albedo and 1.
    #[inline]
    pub fn flight(&self, t: f32, reach: f32, throughput: Rgb) -> Flight {
        if self.only_absorbs() {
            return Flight::Passed { weight: self.transmittance(reach) };
        }
        let shares = channel_shares(throughput);
        let sum = |c: Rgb| c.r + c.g + c.b;
        if t < reach {
            let left = self.transmittance(t) * self.sigma_t;
            Flight::Scattered { t, weight: left * self.albedo / sum(shares * left) }
        } else {
            let left = self.transmittance(reach);
            Flight::Passed { weight: left / sum(shares * left) }
        }
    }

    /// The event on a ray from `o` along the unit vector `d`, whose far end is `reach` away: [`Medium::flight`] in a
    /// homogeneous medium, delta tracking in others. `t` is from [`Medium::distance`] with the same `throughput` and `u`.
    #[inline]
    pub fn flight_along(
        &self,
        (o, d): (Vec3, Vec3),
        (t, reach): (f32, f32),
        throughput: Rgb,
        u: [f32; 2],
    ) -> Flight {
        match &self.varying {
            None => self.flight(t, reach, throughput),
            Some(varying) if self.only_absorbs() => {
                let weight = varying.transmittance((o, d), reach, &mut Tracking::new(u));
                Flight::Passed { weight }
            }
            Some(varying) => varying.track((o, d), reach, throughput, &mut Tracking::new(u)),
        }
    }

    /// [`Medium::distance`] and [`Medium::flight`] in one.
    #[inline]
    pub fn fly(&self, reach: f32, throughput: Rgb, u: [f32; 2]) -> Flight {
        self.flight(self.distance(throughput, u), reach, throughput)
    }
}

/// Probability of each channel.
#[inline]
fn channel_shares(throughput: Rgb) -> Rgb {
    throughput / (throughput.r + throughput.g + throughput.b)
}

/// Sample a distance in (0, `reach`) along a ray in proportion to one over the squared distance from a point light
/// (equiangular sampling) \[Kulla12, 3.1\]. The point of the ray nearest to the light is at the distance `along`, and
/// the light is `across` away from it. Returns the distance and its density per world unit. `across` must be positive;
/// `reach` may be infinite.
#[inline]
pub fn equiangular(along: f32, across: f32, reach: f32, u: f32) -> (f32, f32) {
    let (from, to) = ((-along / across).atan(), ((reach - along) / across).atan());
    let x = across * (from + (to - from) * u).tan();
    (x + along, across / ((to - from) * (across * across + x * x)))
}

/// Density with which [`equiangular`] samples the distance `t`.
#[inline]
pub fn equiangular_pdf(along: f32, across: f32, reach: f32, t: f32) -> f32 {
    let (from, to) = ((-along / across).atan(), ((reach - along) / across).atan());
    let x = t - along;
    across / ((to - from) * (across * across + x * x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Pcg;

    fn coloured() -> Medium {
        let (sigma_t, albedo) = (Rgb::new(0.3, 1.0, 4.0), Rgb::new(0.9, 0.5, 0.2));
        Medium::homogeneous(sigma_t, albedo, Phase::Isotropic)
    }

    #[test]
    fn transmittance_is_beers_law_and_multiplies() {
        let m = coloured();
        let expected = Rgb::new((-0.6f32).exp(), (-2.0f32).exp(), (-8.0f32).exp());
        assert_eq!(m.transmittance(2.0), expected);
        let parts = m.transmittance(0.7) * m.transmittance(1.3);
        for (a, b) in parts.to_array().into_iter().zip(expected.to_array()) {
            assert!((a / b - 1.0).abs() < 2e-6, "{a} is not {b}");
        }
        let clear = Medium { sigma_t: Rgb::BLACK, ..m };
        assert_eq!(clear.transmittance(f32::INFINITY), Rgb::WHITE);
    }

    /// Mean weights of passing, and of scattering beyond `from` and before the far end, for one channel, with their
    /// standard errors.
    fn mean(m: &Medium, reach: f32, throughput: Rgb, channel: usize) -> [(f64, f64); 2] {
        let mut rng = Pcg::new(5, 1);
        let n = 200_000;
        let (mut sum, mut squares) = ([0.0f64; 2], [0.0f64; 2]);
        for _ in 0..n {
            let u = [rng.next_f32(), rng.next_f32()];
            let (k, weight) = match m.fly(reach, throughput, u) {
                Flight::Passed { weight } => (0, weight),
                Flight::Scattered { t, weight } => {
                    assert!((0.0..reach).contains(&t));
                    (1, weight)
                }
            };
            let w = f64::from(weight.to_array()[channel]);
            sum[k] += w;
            squares[k] += w * w;
        }
        let n = f64::from(n);
        [0, 1].map(|k| {
            let mean = sum[k] / n;
            (mean, ((squares[k] / n - mean * mean) / n).sqrt())
        })
    }

    #[test]
    fn weights_of_flights_average_to_the_transmitted_and_scattered_light() {
        let m = coloured();
        let reach = 0.8;
        for throughput in [Rgb::WHITE, Rgb::new(0.1, 0.5, 3.0), Rgb::new(1.0, 0.0, 0.02)] {
            for channel in 0..3 {
                if throughput.to_array()[channel] == 0.0 {
                    continue;
                }
                let pass = f64::from(m.transmittance(reach).to_array()[channel]);
                let scatter = f64::from(m.albedo.to_array()[channel]) * (1.0 - pass);
                let found = mean(&m, reach, throughput, channel);
                for ((mean, error), expected) in found.into_iter().zip([pass, scatter]) {
                    assert!(
                        (mean - expected).abs() < 4.5 * error + 1e-6,
                        "channel {channel}, {throughput:?}: {mean} +- {error}, not {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn grey_media_scatter_with_their_albedo_and_absorbing_ones_let_all_paths_pass() {
        let grey = Medium { sigma_t: Rgb::grey(2.0), albedo: Rgb::grey(0.7), ..coloured() };
        let Flight::Scattered { weight, .. } = grey.fly(f32::INFINITY, Rgb::WHITE, [0.3, 0.9])
        else {
            panic!("nothing passes through an infinite medium");
        };
        assert!((weight.r - 0.7).abs() < 1e-6);
        let dark = Medium { albedo: Rgb::BLACK, ..grey };
        let weight = dark.transmittance(3.0);
        assert_eq!(dark.fly(3.0, Rgb::WHITE, [0.3, 0.9]), Flight::Passed { weight });
    }

    #[test]
    fn equiangular_distances_have_their_density() {
        for (along, across, reach) in
            [(1.0f32, 0.3f32, 2.5f32), (-0.5, 1.0, f32::INFINITY), (4.0, 0.1, 2.0)]
        {
            // The distance as a function of u has the slope 1 / density.
            for k in 1..40 {
                let u = k as f32 / 40.0;
                let h = 1e-3;
                let slope = (equiangular(along, across, reach, u + h).0
                    - equiangular(along, across, reach, u - h).0)
                    / (2.0 * h);
                let (t, pdf) = equiangular(along, across, reach, u);
                let again = equiangular_pdf(along, across, reach, t);
                assert!((again / pdf - 1.0).abs() < 1e-3, "{again} is not {pdf}");
                assert!(t > 0.0 && t < reach);
                // Central differences have an error of a sixth of h^2 times the third derivative: below 1 % away from
                // the ends.
                assert!((slope * pdf - 1.0).abs() < 0.02, "{along} {across} {u}: {slope} {pdf}");
            }
        }
    }
}
