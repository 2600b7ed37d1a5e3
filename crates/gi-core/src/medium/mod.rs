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
mod tests;
