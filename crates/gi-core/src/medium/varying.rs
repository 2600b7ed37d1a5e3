//! Media whose density varies: delta tracking and ratio tracking.
//!
//! Both follow a ray through a medium that is filled up with fictitious matter, which changes nothing, to a constant
//! extinction: the majorant. Collisions with this sum are sampled exactly. Delta tracking decides at each whether it is
//! real \[Woodcock65\]. Ratio tracking multiplies by the probability that it is not \[Novak14\]. Both are unbiased. The
//! majorant is that of a block of a coarse grid.
//!
//! The coefficients have three channels, and the majorant is the largest of them. A collision is real with the
//! probability sum_c p_c sigma_t,c / majorant, where p_c is the share of channel c in the throughput so far. The weights
//! divide by it. This is the balance heuristic over the channels of each event \[Miller19\] \[Kutz17\]: the sum of the
//! weighted shares stays one, so the weight in channel c is at most one over its share at the start.

use glam::{Affine3A, Vec3};

use super::majorant::Majorants;
use super::volume::Volume;
use super::{Flight, channel_shares};
use crate::math::{Bounds, Rgb};
use crate::rng::{Pcg, hash_words};

/// A medium whose coefficients vary in space. Outside its box there is nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Varying {
    /// Extinction coefficient, per world unit.
    sigma_t: Volume,
    /// Scattering over extinction.
    albedo: Volume,
    domain: Domain,
    majorants: Majorants,
}

/// The box that contains a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Domain {
    /// The unit cube of the space that this leads to from world space.
    Cube(Affine3A),
    /// The axis-aligned box around that cube in world space.
    BoxAround(Affine3A),
}

impl Domain {
    /// World space to the space whose unit cube it is, or is around.
    pub fn to_cube(self) -> Affine3A {
        let (Domain::Cube(to_cube) | Domain::BoxAround(to_cube)) = self;
        to_cube
    }

    /// The box around the medium in world space.
    pub fn bounds(self) -> Bounds {
        UNIT.transformed(&self.to_cube().inverse())
    }
}

/// The unit cube.
const UNIT: Bounds = Bounds { min: Vec3::ZERO, max: Vec3::ONE };

/// Random numbers for tracking. Only media whose density varies draw any.
#[derive(Clone, Debug)]
pub struct Tracking {
    first: Option<f32>,
    rng: Pcg,
}

impl Tracking {
    /// Numbers for scenes in which no density varies. All walks would draw the same.
    pub fn none() -> Self {
        Tracking { first: None, rng: Pcg::new(0, 0) }
    }

    /// The stream of a pair of random numbers. The second of them is the first number, so that it keeps its
    /// stratification.
    #[inline]
    pub fn new([a, b]: [f32; 2]) -> Self {
        let [a, bits] = [a.to_bits(), b.to_bits()];
        let seed = u64::from(hash_words(&[a, bits])) << 32 | u64::from(hash_words(&[bits, a]));
        Tracking { first: Some(b), rng: Pcg::new(seed, 0) }
    }

    #[inline]
    fn next(&mut self) -> f32 {
        match self.first.take() {
            Some(first) => first,
            None => self.rng.next_f32(),
        }
    }

    /// Optical distance to the next collision.
    #[inline]
    fn distance(&mut self) -> f32 {
        -(1.0 - self.next()).ln()
    }
}

impl Varying {
    /// A medium with these coefficients inside `domain`.
    pub fn new(sigma_t: Volume, albedo: Volume, domain: Domain) -> Self {
        let to_local = match &sigma_t {
            Volume::Grid { to_local, .. } => *to_local,
            Volume::Constant(_) => domain.to_cube(),
        };
        let (local, clip) = match domain {
            Domain::Cube(m) => (UNIT.transformed(&(to_local * m.inverse())), None),
            Domain::BoxAround(_) => {
                let clip = domain.bounds();
                (clip.transformed(&to_local), Some(clip))
            }
        };
        let majorants = Majorants::new(&sigma_t, &to_local, local, clip);
        Varying { sigma_t, albedo, domain, majorants }
    }

    /// Memory that a medium takes at most besides its volumes, in bytes.
    pub const MAX_BYTES: u64 = Majorants::MAX_BYTES;

    /// Extinction coefficient, per world unit.
    pub fn sigma_t(&self) -> &Volume {
        &self.sigma_t
    }

    /// Scattering over extinction.
    pub fn albedo(&self) -> &Volume {
        &self.albedo
    }

    /// The box that contains the medium.
    pub fn domain(&self) -> Domain {
        self.domain
    }

    /// Translate everything by `by`.
    pub(crate) fn shift(&mut self, by: Vec3) {
        self.domain = match self.domain {
            Domain::Cube(m) => Domain::Cube(m * Affine3A::from_translation(-by)),
            Domain::BoxAround(m) => Domain::BoxAround(m * Affine3A::from_translation(-by)),
        };
        self.sigma_t.shift(by);
        self.albedo.shift(by);
        self.majorants.shift(by);
    }

    /// Delta tracking from `o` along the unit vector `d`, up to the distance `reach`, for a path with a `throughput` that
    /// is not black.
    pub fn track(
        &self,
        (o, d): (Vec3, Vec3),
        reach: f32,
        throughput: Rgb,
        random: &mut Tracking,
    ) -> Flight {
        let shares = channel_shares(throughput);
        let mut weight = Rgb::WHITE;
        let mut left = random.distance();
        for piece in self.majorants.pieces(o, d, reach) {
            let majorant = piece.most.max();
            // Optical distances within the piece.
            let (depth, mut at) = ((piece.to - piece.from) * majorant, left);
            while at < depth {
                let t = piece.from + at / majorant;
                at += random.distance();
                let real = (self.sigma_t.at(o + d * t) / majorant).map(|s| s.clamp(0.0, 1.0));
                let carried = shares * weight * real;
                let probability = carried.r + carried.g + carried.b;
                if random.next() < probability {
                    let albedo = self.albedo.at(o + d * t);
                    return Flight::Scattered { t, weight: weight * real * albedo / probability };
                }
                weight *= real.map(|r| 1.0 - r) / (1.0 - probability);
            }
            left = at - depth;
        }
        Flight::Passed { weight }
    }

    /// An estimate of the transmittance from `o` along the unit vector `d` over the distance `reach`: ratio tracking of
    /// what exceeds the block's smallest extinction, whose transmittance is known \[Novak14, 4.2\].
    pub fn transmittance(&self, (o, d): (Vec3, Vec3), reach: f32, random: &mut Tracking) -> Rgb {
        let mut passed = Rgb::WHITE;
        let mut left = random.distance();
        for piece in self.majorants.pieces(o, d, reach) {
            let length = piece.to - piece.from;
            passed *= piece.least.map(|s| (-s * length).exp());
            let majorant = (piece.most - piece.least).max();
            let (depth, mut at) = ((piece.to - piece.from) * majorant, left);
            while at < depth {
                let t = piece.from + at / majorant;
                at += random.distance();
                let excess = (self.sigma_t.at(o + d * t) - piece.least) / majorant;
                passed *= excess.map(|s| 1.0 - s.clamp(0.0, 1.0));
                if passed.max() < SMALL {
                    if random.next() >= SURVIVAL {
                        return Rgb::BLACK;
                    }
                    passed = passed / SURVIVAL;
                }
            }
            left = at - depth;
        }
        passed
    }
}

/// Russian roulette ends ratio tracking below this transmittance, with this probability of survival.
const SMALL: f32 = 0.05;
const SURVIVAL: f32 = 0.25;

#[cfg(test)]
mod tests;
