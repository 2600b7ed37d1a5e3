//! Coefficients of incoming radiance, and their gradients, from the rays over a hemisphere \[Krivanek05\].

use std::f32::consts::PI;

use glam::{Vec2, Vec3, Vec3A};
use lightcache::hemisphere::{Hemisphere, Strata};

use crate::sh::{Basis, MAX_FUNCTIONS};

/// Smallest cosine of a ray, as a fraction of the last ring's cosine.
const GRAZING: f32 = 0.125;

/// Projection over the rays of a hemisphere.
pub(crate) struct Projection {
    basis: Basis,
    order: usize,
    /// Coefficients, then their gradients along the two tangents: three times as many as the order has functions.
    pub(crate) coefficients: Vec<Vec3A>,
}

impl Projection {
    /// All coefficients zero.
    pub(crate) fn new(basis: Basis, order: usize) -> Self {
        Projection { basis, order, coefficients: vec![Vec3A::ZERO; 3 * order * order] }
    }

    /// Add the coefficients, the integral of L y over the hemisphere. The weight of a ray is pi / (N cos), which is
    /// unbounded at the horizon, so cosines are limited to [`GRAZING`] times the last ring's cosine. This loses the
    /// fraction GRAZING / 2 of the last ring's solid angle.
    pub(crate) fn project(mut self, h: &Hemisphere, into: impl Fn(Vec3) -> Vec3) -> Self {
        let mut y = [0.0; MAX_FUNCTIONS];
        let least = GRAZING * (1.0 - h.strata.sin_sq(h.strata.rings - 1)).sqrt();
        let per_ray = PI / h.strata.count() as f32;
        for seen in h.all().iter().filter(|s| !s.radiance.is_black()) {
            self.basis.evaluate(self.order, into(seen.direction), &mut y);
            let weight = per_ray / seen.direction.z.max(least);
            let l = Vec3A::from_array((seen.radiance * weight).to_array());
            let coefficients = self.coefficients[..self.order * self.order].iter_mut();
            coefficients.zip(y).for_each(|(c, y)| *c += l * y);
        }
        self
    }

    /// Add the gradients. When the point moves, the walls between strata move; the speed is one over the distance of
    /// the nearer side. Where a wall moves, the radiance of one stratum replaces that of the other. This is the sum of
    /// \[Ward92\] with y instead of the cosine \[Krivanek05\].
    pub(crate) fn differentiate(
        mut self,
        h: &Hemisphere,
        into: impl Fn(Vec3) -> Vec3,
        along: impl Fn(Vec3) -> Vec2,
    ) -> Self {
        let Strata { rings, sectors } = h.strata;
        let sector = 2.0 * PI / sectors as f32;
        let angle = |j: usize| h.strata.sin_sq(j).sqrt().min(1.0).asin();
        let tangent = |phi: f32| Vec3::new(phi.cos(), phi.sin(), 0.0);
        for k in 0..sectors {
            let before = (k + sectors - 1) % sectors;
            let (middle, first) =
                (tangent(h.strata.phi(k) + 0.5 * sector), tangent(h.strata.phi(k)));
            let (u, v) = (along(middle), along(Vec3::Z.cross(first)));
            for j in 0..rings {
                let here = h.at(j, k);
                let at =
                    |azimuth: Vec3, angle: f32| into(azimuth * angle.sin() + Vec3::Z * angle.cos());
                if j > 0 {
                    let inner = h.at(j - 1, k);
                    let r = here.distance.min(inner.distance);
                    let (sin, cos) = angle(j).sin_cos();
                    let change = (here.radiance - inner.radiance) * (sector * sin * cos / r);
                    self.add_wall(change.to_array(), u, at(middle, angle(j)));
                }
                let side = h.at(j, before);
                let r = here.distance.min(side.distance);
                let (low, high) = (angle(j), angle(j + 1));
                let change = (here.radiance - side.radiance) * ((high - low) / r);
                self.add_wall(change.to_array(), v, at(first, 0.5 * (low + high)));
            }
        }
        self
    }

    /// Add the change of radiance at a wall between two strata that moves with `along` and is seen in `direction`.
    fn add_wall(&mut self, change: [f32; 3], along: Vec2, direction: Vec3) {
        let change = Vec3A::from_array(change);
        if change == Vec3A::ZERO {
            return;
        }
        let mut y = [0.0; MAX_FUNCTIONS];
        self.basis.evaluate(self.order, direction, &mut y);
        let count = self.order * self.order;
        let (by_s, by_t) = self.coefficients[count..].split_at_mut(count);
        let (s, t) = (change * along.x, change * along.y);
        for k in 0..count {
            by_s[k] += s * y[k];
            by_t[k] += t * y[k];
        }
    }
}
