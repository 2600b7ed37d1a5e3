//! How far a record is good for: the error controls.

use std::f32::consts::PI;

use gi_core::math::Rgb;
use glam::Vec3;

use crate::gradients::Gradient;
use crate::hemisphere::Hemisphere;
use crate::hessian::{Hessian, eigen, geometric, occlusion};
pub use crate::options::{ErrorControl, SphereRadius};
use crate::site::RELAXED;

/// The controls with their numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Control {
    /// What the error is estimated by.
    pub error: ErrorControl,
    /// The split sphere's length.
    pub radius: SphereRadius,
    /// The accuracy a: the error that is allowed, relative. The lecture's w > 10 is 0.1.
    pub accuracy: f32,
}

/// The part of the plane round a record that it is good for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Validity {
    /// Half axes of an ellipse, world.
    pub radii: [f32; 2],
    /// Unit direction of the first, local.
    pub axis: Vec3,
}

/// Share of the error of going to an ellipse's rim that a Hessian's record may make, times the squared unit of length:
/// chosen so that the Hessians take about as many records as the bounded split sphere at the same accuracy in the Cornell box.
const HESSIAN_SCALE: f32 = 5e-4;

impl Control {
    /// How far the record of a hemisphere is good for, before the limits of picture and neighbours. `unit` is the radius of
    /// the scene, or the distance of the eye where that is less.
    pub fn validity(
        &self,
        h: &Hemisphere,
        e: Rgb,
        translational: &Gradient,
        unit: f32,
    ) -> Validity {
        match self.error {
            ErrorControl::SplitSphere => round(self.accuracy * self.sphere(h)),
            ErrorControl::Bounded => {
                let steepest = translational.0.iter().map(|g| g.length()).sum::<f32>() / 3.0;
                let limit = if steepest > 0.0 { e.mean() / steepest } else { f32::INFINITY };
                round(self.accuracy * self.sphere(h).min(limit))
            }
            ErrorControl::HessianGeometric => self.by_hessian(geometric(h), e, unit),
            ErrorControl::HessianOcclusion => self.by_hessian(occlusion(h).1, e, unit),
        }
    }

    fn sphere(&self, h: &Hemisphere) -> f32 {
        match self.radius {
            SphereRadius::Harmonic => h.harmonic_mean(),
            SphereRadius::Minimum => h.nearest(),
        }
    }

    /// The ellipse over which the integral of 1/2 |x' H x| is what is allowed: radii (4 error / (pi |eigenvalue|))^(1/4)
    /// \[Schwarzhaupt12, eq. 5\].
    fn by_hessian(&self, h: Hessian, e: Rgb, unit: f32) -> Validity {
        let ([large, small], axis) = eigen(h);
        let allowed = self.accuracy * HESSIAN_SCALE * unit * unit * e.mean();
        let radius = |eigenvalue: f64| {
            let eigenvalue = eigenvalue.abs() as f32;
            // A flat direction ends where the picture's limits say; a black one has nothing to get wrong.
            if eigenvalue > 0.0 {
                (4.0 * allowed / (PI * eigenvalue)).powf(0.25)
            } else {
                f32::INFINITY
            }
        };
        Validity { radii: [radius(large), radius(small)], axis: axis.as_vec2().extend(0.0) }
    }

    /// Whether limits of the picture and of neighbours hold for this control.
    pub fn has_limits(&self) -> bool {
        self.error != ErrorControl::SplitSphere
    }

    /// How fast the radius may grow with the distance to a neighbour: R as fast as that, and a record is
    /// good for a R \[Krivanek06\]. Radii by Hessians grow slower, so that a record does not cover its neighbours even where
    /// lookups are relaxed: one in the open, whose rays saw nothing, would answer in the corners far from it.
    pub fn slope(&self) -> f32 {
        match self.error {
            ErrorControl::SplitSphere | ErrorControl::Bounded => self.accuracy,
            ErrorControl::HessianGeometric | ErrorControl::HessianOcclusion => 1.0 / RELAXED,
        }
    }
}

fn round(radius: f32) -> Validity {
    Validity { radii: [radius; 2], axis: Vec3::X }
}
