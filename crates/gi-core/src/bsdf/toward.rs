//! The directions from a point or a box toward a box: cones, cosines and solid angles.

use std::f32::consts::PI;

use glam::Vec3;

use crate::math::{Bounds, Frame, safe_sqrt, sqr};

/// The directions from a point, or from all points of a box, to all points of another box.
#[derive(Clone, Copy, Debug)]
pub struct Toward {
    /// Centre and half the extent of the box of all differences.
    middle: Vec3,
    half: Vec3,
}

/// A cone around these directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    /// Unit axis, and sine and cosine of the half angle. The whole sphere has a sine of 1 and a cosine of 0.
    pub(super) axis: Vec3,
    pub(super) sin: f32,
    pub(super) cos: f32,
}

/// Relative rounding error of a coordinate.
const ROUNDING: f32 = 5e-7;
/// Rounding error of a unit vector.
pub(super) const UNIT_ROUNDING: f32 = 2e-6;

impl Toward {
    /// Directions from `p` into a box.
    #[inline]
    pub fn new(p: Vec3, bounds: &Bounds) -> Self {
        let (low, high) = (bounds.min - p, bounds.max - p);
        let middle = 0.5 * (low + high);
        let half = 0.5 * (high - low) + (p.abs() + middle.abs()) * ROUNDING;
        Toward { middle, half }
    }

    /// Directions from the points of one box to the points of another. Their differences fill a box [Walter06, 4.2].
    #[inline]
    pub fn between(from: &Bounds, to: &Bounds) -> Self {
        let (low, high) = (to.min - from.max, to.max - from.min);
        let middle = 0.5 * (low + high);
        let largest = from.min.abs().max(from.max.abs());
        let half = 0.5 * (high - low) + (largest + middle.abs()) * ROUNDING;
        Toward { middle, half }
    }

    /// The cone of the bounding sphere of the box.
    #[inline]
    pub(super) fn cone(&self) -> Cone {
        let (distance_sq, radius_sq) = (self.middle.length_squared(), self.half.length_squared());
        if radius_sq >= distance_sq {
            return Cone { axis: Vec3::Z, sin: 1.0, cos: 0.0 };
        }
        let inverse = 1.0 / distance_sq;
        let sin_sq = radius_sq * inverse;
        Cone { axis: self.middle * inverse.sqrt(), sin: sin_sq.sqrt(), cos: (1.0 - sin_sq).sqrt() }
    }

    /// A cone around the directions: its axis, and sine and cosine of its half angle. All directions have a sine of 1
    /// and a cosine of 0.
    #[inline]
    pub fn around(&self) -> (Vec3, f32, f32) {
        let Cone { axis, sin, cos } = self.cone();
        (axis, sin, cos)
    }

    /// Smallest squared distance to the box.
    #[inline]
    pub fn min_distance_sq(&self) -> f32 {
        (self.middle.abs() - self.half).max(Vec3::ZERO).length_squared()
    }

    /// Squared distance to the centre of the box, and its squared radius.
    #[inline]
    pub fn middle_and_radius_sq(&self) -> [f32; 2] {
        [self.middle.length_squared(), self.half.length_squared()]
    }

    /// Solid angle of the cone around the directions.
    #[inline]
    pub fn solid_angle(&self) -> f32 {
        let cone = self.cone();
        if cone.sin >= 1.0 { 4.0 * PI } else { 2.0 * PI * (1.0 - cone.cos) }
    }

    /// The largest cosine of a direction with the frame's normal [Walter05, eq. 4], from the bounds of the box in that
    /// frame.
    #[inline]
    pub fn max_cos(&self, frame: &Frame) -> f32 {
        let extent = |axis: Vec3| axis.abs().dot(self.half);
        let z = self.middle.dot(frame.n) + extent(frame.n);
        let across = [frame.s, frame.t].map(|t| (self.middle.dot(t).abs(), extent(t)));
        let across_sq = if z > 0.0 {
            across.iter().map(|(m, h)| sqr((m - h).max(0.0))).sum::<f32>()
        } else {
            across.iter().map(|(m, h)| sqr(m + h)).sum::<f32>()
        };
        let length_sq = across_sq + z * z;
        if length_sq > 0.0 { (z / length_sq.sqrt() + UNIT_ROUNDING).min(1.0) } else { 1.0 }
    }
}

impl Cone {
    /// The largest cosine between a direction and the unit vector `d`.
    #[inline]
    pub(super) fn max_cos(&self, d: Vec3) -> f32 {
        if self.sin >= 1.0 {
            return 1.0;
        }
        let cos = self.axis.dot(d);
        if cos >= self.cos {
            return 1.0;
        }
        (cos * self.cos + safe_sqrt(1.0 - cos * cos) * self.sin + UNIT_ROUNDING).min(1.0)
    }
}
