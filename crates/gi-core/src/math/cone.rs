//! Cones of directions. They bound the normals of clusters of lights.

use std::f32::consts::PI;

use glam::Vec3;

/// All directions within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Unit axis.
    pub axis: Vec3,
    /// Half angle in [0, pi], radians.
    pub angle: f32,
}

/// Rounding of an angle between unit vectors: near zero, the arc cosine loses half the digits of its argument.
const ROUNDING: f32 = 1e-3;

impl Cone {
    /// One direction.
    pub fn new(axis: Vec3) -> Self {
        Cone { axis, angle: 0.0 }
    }

    /// The half angle of [`Cone::union`], the smallest cone around both.
    #[inline]
    pub fn union_angle(&self, other: &Cone) -> f32 {
        if self.axis == other.axis {
            return self.angle.max(other.angle);
        }
        let between = self.axis.dot(other.axis).clamp(-1.0, 1.0).acos() + ROUNDING;
        let (a, b) = (self.angle, other.angle);
        (0.5 * (between + a + b)).max(a).max(b).min(PI)
    }

    /// The smallest cone around both.
    pub fn union(&self, other: &Cone) -> Cone {
        let (wide, narrow) = if self.angle >= other.angle { (self, other) } else { (other, self) };
        let angle = self.union_angle(other);
        if angle <= wide.angle || angle >= PI {
            return Cone { axis: wide.axis, angle };
        }
        // Turn the axis of the wider cone toward the other.
        let cos = wide.axis.dot(narrow.axis);
        let turn = angle - wide.angle;
        let across = narrow.axis - wide.axis * cos;
        // For opposite axes, the cross product is only rounding error, and any perpendicular direction is correct.
        let across = if across.length_squared() < ROUNDING * ROUNDING {
            wide.axis.any_orthonormal_vector()
        } else {
            across.normalize()
        };
        let axis = (wide.axis * turn.cos() + across * turn.sin()).normalize();
        Cone { axis, angle: (angle + ROUNDING).min(PI) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Pcg;
    use crate::warp;

    #[test]
    fn a_union_contains_both_cones_and_is_no_wider_than_necessary() {
        let mut rng = Pcg::new(1, 2);
        let mut cone = |spread: f32| Cone {
            // The arc cosine below shows an error of 1e-7 in the length as an angle of 5e-4.
            axis: warp::sphere(rng.next_2d()).normalize(),
            angle: spread * rng.next_f32(),
        };
        for i in 0..10_000 {
            let (a, b) = (cone(1.5), cone(if i % 2 == 0 { 0.0 } else { 1.0 }));
            let union = a.union(&b);
            for c in [a, b] {
                let to = union.axis.dot(c.axis).clamp(-1.0, 1.0).acos();
                assert!(
                    to + c.angle <= union.angle + 6e-4 || union.angle == PI,
                    "{a:?} {b:?} {union:?}"
                );
            }
            let between = a.axis.dot(b.axis).clamp(-1.0, 1.0).acos();
            let least = (0.5 * (between + a.angle + b.angle)).max(a.angle).max(b.angle);
            assert!(union.angle <= (least + 3.0 * ROUNDING).min(PI), "{union:?} above {least}");
        }
    }

    #[test]
    fn a_cone_around_opposite_normals_contains_both() {
        let mut rng = Pcg::new(1, 3);
        for i in 0..10_000 {
            // Normals on both sides of a wall, exactly or nearly opposite.
            let n = warp::sphere(rng.next_2d());
            let beside = n.any_orthonormal_vector() * [0.0, 1e-7, 1e-4, 2e-3][i % 4];
            let (a, b) = (Cone::new(n), Cone::new((beside - n).normalize()));
            let union = a.union(&b);
            for c in [a, b] {
                let to = union.axis.dot(c.axis).clamp(-1.0, 1.0).acos();
                assert!(to <= union.angle + 6e-4, "{a:?} {b:?} {union:?}");
            }
            assert!(union.angle < 0.5 * PI + 3.0 * ROUNDING, "{union:?}");
        }
    }

    #[test]
    fn a_union_with_itself_is_itself() {
        let same = Cone::new(Vec3::Y).union(&Cone::new(Vec3::Y));
        assert_eq!(same, Cone::new(Vec3::Y));
    }
}
