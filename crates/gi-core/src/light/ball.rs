//! Balls that light paths are aimed at.

use std::f32::consts::PI;

use glam::Vec3;

use crate::math::{Frame, sqr};
use crate::warp;

/// A ball, world units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub(super) center: Vec3,
    pub(super) radius: f32,
}

impl Ball {
    /// Area of its projection onto a plane.
    pub(super) fn shadow(&self) -> f32 {
        PI * sqr(self.radius)
    }

    /// A point of its projection along the normal of `frame`, uniform in area, in the plane through its centre.
    pub(super) fn point_of_shadow(&self, frame: &Frame, u: [f32; 2]) -> Vec3 {
        let q = warp::disk(u) * self.radius;
        self.center + frame.s * q.x + frame.t * q.y
    }

    /// Whether the line through `p` along unit `d` hits the ball.
    pub(super) fn is_on_line(&self, p: Vec3, d: Vec3) -> bool {
        (self.center - p).cross(d).length_squared() <= sqr(self.radius)
    }

    /// 1 - cos of the half angle of the cone in which the ball is seen from `p`; `None` from inside.
    pub(super) fn one_minus_cos(&self, p: Vec3) -> Option<f32> {
        let sin_sq = sqr(self.radius) / (self.center - p).length_squared();
        (sin_sq < 0.9999).then(|| sin_sq / (1.0 + (1.0 - sin_sq).sqrt()))
    }
}

/// A ball that contains one or two balls.
pub(super) fn joined(balls: &[Ball]) -> Ball {
    let [a, b] = *balls else { return balls[0] };
    let distance = a.center.distance(b.center);
    if distance + b.radius <= a.radius {
        return a;
    }
    if distance + a.radius <= b.radius {
        return b;
    }
    let radius = 0.5 * (distance + a.radius + b.radius);
    let along = (b.center - a.center) / distance.max(f32::MIN_POSITIVE);
    Ball { center: a.center + along * (radius - a.radius), radius: radius * 1.000_01 }
}
