//! Error control: the region in which a record is valid.

use std::f32::consts::PI;

use gi_core::math::Rgb;
use glam::Vec3;

use crate::gradients::Gradient;
use crate::hemisphere::Hemisphere;
use crate::hessian::{Hessian, eigen, geometric, occlusion};
pub use crate::options::{ErrorControl, SphereRadius};
use crate::site::RELAXED;

/// Settings of error control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Control {
    /// How the error is estimated.
    pub error: ErrorControl,
    /// Which distance is the radius of the split sphere.
    pub radius: SphereRadius,
    /// The accuracy a, the allowed relative error; 0.1 is w > 10 in the lecture.
    pub accuracy: f32,
}

/// The ellipse in the tangent plane in which a record is valid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Validity {
    /// Half axes of the ellipse, world.
    pub radii: [f32; 2],
    /// Unit direction of the first half axis, local.
    pub axis: Vec3,
}

/// Allowed error at the ellipse boundary for Hessians, per squared unit of length. Tuned in the Cornell box to match
/// the record count of the bounded split sphere at equal accuracy.
const HESSIAN_SCALE: f32 = 5e-4;

impl Control {
    /// The region of validity of a hemisphere's record, before the limits by pixels and neighbours. `unit` is the
    /// smaller of scene radius and distance to the eye.
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

    /// The ellipse over which the integral of 1/2 |x' H x| is the allowed error. Its radii are (4 error / (pi
    /// |eigenvalue|))^(1/4) \[Schwarzhaupt12, eq. 5\].
    fn by_hessian(&self, h: Hessian, e: Rgb, unit: f32) -> Validity {
        let ([large, small], axis) = eigen(h);
        let allowed = self.accuracy * HESSIAN_SCALE * unit * unit * e.mean();
        let radius = |eigenvalue: f64| {
            let eigenvalue = eigenvalue.abs() as f32;
            // Without curvature, or without light, only the limits by pixels apply.
            if eigenvalue > 0.0 {
                (4.0 * allowed / (PI * eigenvalue)).powf(0.25)
            } else {
                f32::INFINITY
            }
        };
        Validity { radii: [radius(large), radius(small)], axis: axis.as_vec2().extend(0.0) }
    }

    /// Whether the limits by pixels and by neighbours apply.
    pub fn has_limits(&self) -> bool {
        self.error != ErrorControl::SplitSphere
    }

    /// Largest growth of the radius per distance to a neighbour. The slide's R may grow as fast as the distance, and a
    /// record is valid within a R \[Krivanek06\]. Radii by Hessians grow more slowly, so that a record does not cover
    /// its neighbours even in relaxed lookups: otherwise a record in the open, whose rays hit nothing, would be used in
    /// distant corners.
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
