use glam::Vec3;

/// A right-handed orthonormal frame (s, t, n): `s` and `t` span the tangent plane, `n` is the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent.
    pub s: Vec3,
    /// Second tangent, n x s.
    pub t: Vec3,
    /// Normal, the local z axis.
    pub n: Vec3,
}

impl Frame {
    /// A frame around a unit normal, without branches and without a singular direction \[Duff17\].
    #[inline]
    pub fn from_normal(n: Vec3) -> Self {
        let sign = 1f32.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Frame {
            s: Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            t: Vec3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// A frame around a unit normal whose `s` is the part of `tangent` perpendicular to `n`; an arbitrary frame if the
    /// tangent is zero or parallel to the normal.
    pub fn from_normal_tangent(n: Vec3, tangent: Vec3) -> Self {
        let across = tangent - n * n.dot(tangent);
        // For a parallel tangent, the rest is only rounding error: six bits of it do not define a direction.
        if across.length_squared() <= 1e-10 * tangent.length_squared() {
            return Self::from_normal(n);
        }
        // Orthogonalise twice, because normalising a nearly parallel tangent magnifies its error.
        let s = across.normalize();
        let s = (s - n * n.dot(s)).normalize();
        Frame { s, t: n.cross(s), n }
    }

    /// World to local.
    #[inline]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Local to world.
    #[inline]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Pcg;

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        let mut rng = Pcg::new(1, 0);
        for i in 0..10_000 {
            let mut n =
                Vec3::from_array([rng.next_f32(), rng.next_f32(), rng.next_f32()]) * 2.0 - 1.0;
            if i % 7 == 0 {
                n = Vec3::new(1e-6 * n.x, 1e-6 * n.y, -1.0); // the pole where Frisvad's construction fails
            }
            let n = n.normalize();
            for f in [
                Frame::from_normal(n),
                Frame::from_normal_tangent(n, Vec3::X),
                Frame::from_normal_tangent(n, n),
            ] {
                let dots = [
                    f.s.dot(f.t),
                    f.t.dot(f.n),
                    f.n.dot(f.s),
                    f.s.length() - 1.0,
                    f.t.length() - 1.0,
                ];
                assert!(dots.iter().all(|d| d.abs() < 1e-5), "case {i}: {f:?}");
                assert!(f.s.cross(f.t).dot(f.n) > 0.999, "case {i}: left-handed");
                assert!((f.to_world(f.to_local(Vec3::ONE)) - Vec3::ONE).length() < 1e-5);
            }
        }
    }
}
