//! Nodes of the light tree, and their importance at a point.

use std::f32::consts::PI;

use glam::Vec3;

use super::bounds::LightBounds;
use super::vantage::{Facing, Vantage};

/// A node of the tree, prepared for [`Node::importance`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Node {
    /// A sphere around the lights.
    center: Vec3,
    radius: f32,
    /// The cone around their normals and axes.
    axis: Vec3,
    cos: f32,
    sin: f32,
    /// Cosine of the angle to the cone beyond which no light leaves.
    cos_spread: f32,
    /// Sum of the intensities.
    pub(super) intensity: f32,
    /// Index of the first of two children, which is even; or the index of a light times two plus one.
    link: u32,
}

/// What a node stands for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Link {
    /// Index of the first of two children; the second follows it.
    Children(u32),
    /// Index of a light.
    Light(u32),
}

/// Slack of angles and cosines, so that rounding never hides a light that contributes.
const SLACK: f32 = 2e-3;

impl Node {
    /// A cluster or a light with these bounds.
    pub(super) fn new(of: &LightBounds, link: Link) -> Self {
        let center = of.bounds.center();
        // Rounding of positions far from the origin moves the centre.
        let far = center.abs().max_element();
        let radius = 0.5 * of.bounds.extent().length() * 1.0001 + 4.0 * f32::EPSILON * far;
        let angle = (of.cone.angle + SLACK).min(PI);
        Node {
            center,
            radius,
            axis: of.cone.axis,
            cos: angle.cos(),
            sin: angle.sin().max(0.0),
            cos_spread: (of.spread + SLACK).min(PI).cos(),
            intensity: of.intensity,
            link: match link {
                Link::Children(first) => first,
                Link::Light(light) => 2 * light + 1,
            },
        }
    }

    /// The node's children or its light.
    #[inline]
    pub(super) fn link(&self) -> Link {
        if self.link & 1 == 0 { Link::Children(self.link) } else { Link::Light(self.link >> 1) }
    }

    /// How much the node's lights may differ: intensity times the squared radius.
    pub(super) fn spread(&self) -> f32 {
        self.intensity * self.radius * self.radius
    }

    /// An estimate of the irradiance from the node's lights: intensity times bounds of the cosines at the lights and at
    /// the receiver, over the squared distance, which is at least the squared radius [Conty18, 5]. Zero only if no
    /// light can contribute.
    #[inline]
    pub(super) fn importance(&self, at: &Vantage) -> f32 {
        let to = at.p - self.center;
        let distance_sq = to.length_squared();
        let radius_sq = self.radius * self.radius;
        if distance_sq <= radius_sq {
            return self.intensity / radius_sq.max(f32::MIN_POSITIVE);
        }
        let inverse = distance_sq.sqrt().recip();
        let w = to * inverse;
        let ball = Angle::of_sin(self.radius * inverse);
        let emitted = Angle::of(self.axis.dot(w)).minus(&Angle { cos: self.cos, sin: self.sin });
        let cos_emitted = emitted.minus(&ball).cos;
        if cos_emitted <= self.cos_spread {
            return 0.0;
        }
        let cos_received = match at.facing {
            Facing::Any => 1.0,
            Facing::Side(n) => Angle::of(-n.dot(w)).minus(&ball).cos,
            Facing::Both(n) => Angle::of(n.dot(w).abs()).minus(&ball).cos,
        };
        if cos_received <= -SLACK {
            return 0.0;
        }
        self.intensity * cos_emitted.max(SLACK) * cos_received.max(SLACK) * (inverse * inverse)
    }
}

/// An angle between 0 and pi.
struct Angle {
    cos: f32,
    sin: f32,
}

impl Angle {
    #[inline]
    fn of(cos: f32) -> Self {
        Angle { cos, sin: (1.0 - cos * cos).max(0.0).sqrt() }
    }

    /// An angle of at most a right angle.
    #[inline]
    fn of_sin(sin: f32) -> Self {
        Angle { cos: (1.0 - sin * sin).max(0.0).sqrt(), sin }
    }

    /// The difference, at least 0.
    #[inline]
    fn minus(&self, other: &Angle) -> Self {
        if self.cos >= other.cos {
            return Angle { cos: 1.0, sin: 0.0 };
        }
        Angle {
            cos: self.cos * other.cos + self.sin * other.sin,
            sin: (self.sin * other.cos - self.cos * other.sin).max(0.0),
        }
    }
}
