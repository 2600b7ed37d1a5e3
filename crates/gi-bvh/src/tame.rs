//! Rays that the kernels cannot trace unchanged: origins far outside, extreme lengths, or values that are not finite.

use glam::Vec3;

use crate::bounds::Bounds;
use crate::ray::Ray;

/// Directions are rescaled if their largest component is outside [1 / LONGEST, LONGEST].
const LONGEST: f32 = 1_048_576.0;
/// Origins farther away than this multiple of the scene's largest coordinate are moved closer.
pub(super) const REACH: f32 = 2.0;

/// Whether the kernels can trace a ray unchanged in a scene of this `reach` (NaN fails every comparison).
#[inline(always)]
pub(super) fn is_tame(ray: &Ray, reach: f32) -> bool {
    let longest = ray.d.abs().max_element();
    ray.o.abs().cmple(Vec3::splat(reach)).all()
        && ray.d.abs().cmple(Vec3::splat(LONGEST)).all()
        && longest >= 1.0 / LONGEST
        && ray.tmin <= ray.tmax
}

/// A moved and rescaled ray; its parameter t' corresponds to t = (t' * scale + shift) of the original.
pub(super) struct Tamed {
    pub ray: Ray,
    scale: f64,
    shift: f64,
    original: Ray,
}

impl Tamed {
    /// The part of `ray` that passes the box, in a form that the kernels can trace; `None` if it cannot hit anything.
    pub(super) fn new(ray: &Ray, bounds: Bounds) -> Option<Self> {
        let longest = ray.d.abs().max_element();
        let sound = ray.o.is_finite() && ray.d.is_finite() && longest > 0.0 && ray.tmin <= ray.tmax;
        if !sound || bounds.is_empty() {
            return None;
        }
        let o = ray.o.to_array().map(f64::from);
        let scale = 1.0 / f64::from(longest);
        let d = ray.d.to_array().map(|x| f64::from(x) * scale);
        let [tmin, tmax] = [ray.tmin, ray.tmax].map(|t| f64::from(t) * f64::from(longest));
        // Enter a box that is slightly larger than the scene's.
        let (mut entry, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
        let margin = f64::from(bounds.min.abs().max(bounds.max.abs()).max_element()) / 1024.0;
        for axis in 0..3 {
            let low = f64::from(bounds.min[axis]) - margin - o[axis];
            let high = f64::from(bounds.max[axis]) + margin - o[axis];
            if d[axis] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let inverse = 1.0 / d[axis];
            let (a, b) = (low * inverse, high * inverse);
            entry = entry.max(a.min(b));
            exit = exit.min(a.max(b));
        }
        if entry > exit || entry > tmax || exit < tmin {
            return None;
        }
        let at = |k: usize| (o[k] + d[k] * entry) as f32;
        let moved = Ray {
            o: Vec3::new(at(0), at(1), at(2)),
            tmin: (tmin - entry) as f32,
            d: Vec3::new(d[0] as f32, d[1] as f32, d[2] as f32),
            tmax: (tmax - entry) as f32,
        };
        (moved.tmin <= moved.tmax).then_some(Tamed {
            ray: moved,
            scale,
            shift: entry * scale,
            original: *ray,
        })
    }

    /// The original's parameter, clamped to its interval against rounding.
    pub(super) fn untame(&self, t: f32) -> f32 {
        let t = (f64::from(t) * self.scale + self.shift) as f32;
        t.max(self.original.tmin.next_up()).min(self.original.tmax)
    }
}
