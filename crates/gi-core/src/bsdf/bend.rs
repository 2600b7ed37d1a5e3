//! Shading normals that a bump map or a normal map changes ("bent" normals).
//!
//! Two corrections follow. A bent normal may face away from the eye; it is then flipped about the unbent normal
//! \[Schuessler17\]. And light fades out toward the terminator of the unbent surface, where it would otherwise end at a
//! hard edge \[Estevez19\]. Both are defaults of Mitsuba 3.

use glam::Vec3;

use crate::material::BentNormals;
use crate::math::{Frame, sqr};

/// How a lobe's normal was bent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bend {
    /// The normal before bending, on the same side as the lobe's normal.
    normal: Vec3,
    /// Squared alpha of the facets that represent the bent surface, in [0, 1]; 0 disables shadowing.
    alpha_sq: f32,
    /// Whether the lobe's normal is flipped if it faces away from the eye.
    flips: bool,
}

impl Bend {
    /// A normal `bent` from `normal`, both unit.
    pub(super) fn new(normal: Vec3, bent: Vec3, how: BentNormals) -> Self {
        let alpha_sq = if how.shadowed { (0.125 * tan_sq(bent.dot(normal))).min(1.0) } else { 0.0 };
        Bend { normal, alpha_sq, flips: how.flipped }
    }

    /// The bending as seen from the other side of the surface.
    pub(super) fn turned(self) -> Self {
        Bend { normal: -self.normal, ..self }
    }

    /// The normal before bending.
    #[inline]
    pub(super) fn unbent(&self) -> Vec3 {
        self.normal
    }

    /// The frame for an eye in direction `eye`.
    #[inline]
    pub(super) fn seen_from(&self, frame: Frame, eye: Vec3) -> Frame {
        if self.is_seen(&frame, eye) || !self.flips { frame } else { self.flipped(frame) }
    }

    /// The frame rotated by half a turn about the unbent normal.
    pub(super) fn flipped(&self, frame: Frame) -> Frame {
        let n = self.normal * (2.0 * self.normal.dot(frame.n)) - frame.n;
        Frame::from_normal_tangent(n.normalize(), frame.s)
    }

    /// Fraction of the eye directions above the surface for which the normal is flipped.
    pub(super) fn share_flipped(&self, frame: &Frame) -> f32 {
        if !self.flips {
            return 0.0;
        }
        self.normal.dot(frame.n).clamp(-1.0, 1.0).acos() * std::f32::consts::FRAC_1_PI
    }

    /// Whether both normals are on the same side of a direction.
    #[inline]
    pub(super) fn is_seen(&self, frame: &Frame, d: Vec3) -> bool {
        d.dot(self.normal) * d.dot(frame.n) > 0.0
    }

    /// Factor on light from direction `light` toward `eye` for a lobe with this frame. It is zero if only one of the
    /// two normals faces one of the directions [Estevez19, eq. 4].
    #[inline]
    pub(super) fn unshadowed(&self, frame: &Frame, eye: Vec3, light: Vec3) -> f32 {
        if !self.is_seen(frame, eye) || !self.is_seen(frame, light) {
            return 0.0;
        }
        shadowing(self.alpha_sq, light.dot(self.normal))
    }

    /// Cosine-weighted mean of that factor over all light directions.
    pub(super) fn mean_unshadowed(&self) -> f32 {
        if self.alpha_sq == 0.0 {
            return 1.0;
        }
        // Midpoint rule: accurate to 0.2 % for the widest facets.
        const N: u32 = 8;
        let cos = |k| (k as f32 + 0.5) / N as f32;
        (0..N).map(|k| 2.0 * cos(k) * shadowing(self.alpha_sq, cos(k))).sum::<f32>() / N as f32
    }
}

/// Squared tangent of the angle that has this cosine.
fn tan_sq(cos: f32) -> f32 {
    (1.0 / sqr(cos) - 1.0).max(0.0)
}

/// Smith's shadowing by facets of the GGX distribution.
#[inline]
fn shadowing(alpha_sq: f32, cos: f32) -> f32 {
    if alpha_sq == 0.0 {
        return 1.0;
    }
    2.0 / (1.0 + (1.0 + alpha_sq * tan_sq(cos)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_the_shadowing_is_its_integral() {
        let (normal, n) = (Vec3::Z, 100_000);
        for tan in [0.3f32, 1.0, 10.0] {
            let bent = Vec3::new(tan, 0.0, 1.0).normalize();
            let bend = Bend::new(normal, bent, BentNormals::default());
            let integral = (0..n).map(|k| {
                let cos = (f64::from(k) + 0.5) / f64::from(n);
                2.0 * cos * f64::from(shadowing(bend.alpha_sq, cos as f32))
            });
            let exact = integral.sum::<f64>() / f64::from(n);
            let mean = f64::from(bend.mean_unshadowed());
            assert!((mean - exact).abs() < 4e-3, "{tan}: {mean}, {exact}");
        }
        // For the widest facets, it is 4 (ln 2 - 1/2).
        let widest =
            Bend::new(normal, Vec3::new(10.0, 0.0, 1.0).normalize(), BentNormals::default());
        assert!((widest.mean_unshadowed() - 4.0 * (2f32.ln() - 0.5)).abs() < 4e-3);
    }
}
