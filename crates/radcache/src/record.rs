//! What is kept of a point of a glossy surface: its irradiance, and the light that comes to it, direction by direction,
//! as coefficients with gradients \[Krivanek05\].

use std::f32::consts::PI;

use gi_core::math::Frame;
use glam::{Vec2, Vec3, Vec3A};
use lightcache::hemisphere::{Hemisphere, Strata};
use lightcache::record::Record;
use lightcache::site::{Query, RELAXED, Site, Sited};

use crate::rotate::about_z;
use crate::sh::{Basis, Coefficients, MAX_FUNCTIONS};

/// A radiance record.
///
/// Spherical harmonics are those of world directions. A band-limited function stays one however it is turned, so
/// that nothing is lost against each record's own frame; records of different normals then add up as they are, and their
/// mean is turned into the shading frame once. Hemispherical harmonics know no such turn: they stand in the
/// frame that [`Frame::from_normal`] makes of the record's normal.
#[derive(Clone, Debug, PartialEq)]
pub struct RadianceRecord {
    /// Place, reach and irradiance.
    pub irradiance: Record,
    /// Coefficients of incoming indirect radiance, then their gradients along the tangents that [`Frame::from_normal`]
    /// makes, per world unit: three times as many as the order has functions.
    pub light: Box<[Vec3A]>,
}

impl Sited for RadianceRecord {
    fn site(&self) -> &Site {
        &self.irradiance.site
    }

    fn site_mut(&mut self) -> &mut Site {
        &mut self.irradiance.site
    }
}

impl RadianceRecord {
    /// The record of what was seen, directions in `frame`; `irradiance` is what the same rays say of that.
    pub fn new(
        irradiance: Record,
        frame: &Frame,
        h: &Hemisphere,
        basis: Basis,
        order: usize,
    ) -> Self {
        let own = Frame::from_normal(irradiance.site.n);
        let into = |local: Vec3| {
            let world = frame.to_world(local);
            if basis == Basis::Sh { world } else { own.to_local(world) }
        };
        let along = |local: Vec3| own.to_local(frame.to_world(local)).truncate();
        let sums = Sums { basis, order, light: vec![Vec3A::ZERO; 3 * order * order] };
        let mut light = sums.project(h, into).differentiate(h, into, along).light;
        limit(&mut light, RELAXED * irradiance.site.reach());
        RadianceRecord { irradiance, light: light.into() }
    }

    /// Add the light at the query, `weight` times, extrapolated along the gradients if asked for. `frame` is that of the query.
    #[inline]
    pub fn add_to(
        &self,
        out: &mut Coefficients,
        q: &Query,
        frame: &Frame,
        basis: Basis,
        (gradients, weight): (bool, f32),
    ) {
        let Site { n, p, .. } = self.irradiance.site;
        let own = Frame::from_normal(n);
        let moved = if gradients { own.to_local(q.p - p).truncate() } else { Vec2::ZERO };
        let count = self.light.len() / 3;
        let (value, slopes) = self.light.split_at(count);
        let (by_s, by_t) = slopes.split_at(count);
        let (s, t) = (weight * moved.x, weight * moved.y);
        let extrapolated = |k: usize| value[k] * weight + by_s[k] * s + by_t[k] * t;
        match basis {
            Basis::Sh => {
                out[..count].iter_mut().enumerate().for_each(|(k, c)| *c += extrapolated(k));
            }
            Basis::Hsh => {
                // Bring the frame along to the query's normal, and turn it there.
                let mut turned = [Vec3A::ZERO; MAX_FUNCTIONS];
                turned[..count].iter_mut().enumerate().for_each(|(k, c)| *c = extrapolated(k));
                let axis = Vec2::new(own.s.dot(frame.s), own.s.dot(frame.t)).normalize_or(Vec2::X);
                about_z(count.isqrt(), axis.to_array(), &mut turned);
                out[..count].iter_mut().zip(turned).for_each(|(c, turned)| *c += turned);
            }
        }
    }
}

/// Let no channel's gradient lead to more than twice its norm within `reach`, as that of irradiance.
fn limit(light: &mut [Vec3A], reach: f32) {
    let (value, slopes) = light.split_at_mut(light.len() / 3);
    let norm = |c: &[Vec3A]| Vec3::from(c.iter().map(|v| *v * *v).sum::<Vec3A>()).map(f32::sqrt);
    let (value, slope) = (norm(value), norm(slopes));
    let factor = |k: usize| {
        let f = (value[k] / (slope[k] * reach)).min(1.0);
        if f.is_finite() { f } else { 0.0 }
    };
    let factor = Vec3A::new(factor(0), factor(1), factor(2));
    slopes.iter_mut().for_each(|s| *s *= factor);
}

/// Share of the last ring's cosine below which rays do not count for more.
const GRAZING: f32 = 0.125;

/// Sums over the rays of a hemisphere.
struct Sums {
    basis: Basis,
    order: usize,
    light: Vec<Vec3A>,
}

impl Sums {
    /// Coefficients: the integral of L y over the hemisphere. A ray stands for pi / (N cos), which has no bound at the
    /// horizon: rays within [`GRAZING`] of the last ring's cosine count as if they were there. The solid angle that is
    /// lost is GRAZING / 2 of the ring's, where cosines are next to nothing.
    fn project(mut self, h: &Hemisphere, into: impl Fn(Vec3) -> Vec3) -> Self {
        let mut y = [0.0; MAX_FUNCTIONS];
        let least = GRAZING * (1.0 - h.strata.sin_sq(h.strata.rings - 1)).sqrt();
        let per_ray = PI / h.strata.count() as f32;
        for seen in h.all().iter().filter(|s| !s.radiance.is_black()) {
            self.basis.evaluate(self.order, into(seen.direction), &mut y);
            let weight = per_ray / seen.direction.z.max(least);
            let l = Vec3A::from_array((seen.radiance * weight).to_array());
            let coefficients = self.light[..self.order * self.order].iter_mut();
            coefficients.zip(y).for_each(|(c, y)| *c += l * y);
        }
        self
    }

    /// Gradients: when the point moves, walls between strata move, faster the nearer the nearer of both sides is; where
    /// they do, one stratum's radiance takes the other's place. The sum of \[Ward92\] with y for the
    /// cosine \[Krivanek05\].
    fn differentiate(
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

    fn add_wall(&mut self, change: [f32; 3], along: Vec2, direction: Vec3) {
        let change = Vec3A::from_array(change);
        if change == Vec3A::ZERO {
            return;
        }
        let mut y = [0.0; MAX_FUNCTIONS];
        self.basis.evaluate(self.order, direction, &mut y);
        let count = self.order * self.order;
        let (by_s, by_t) = self.light[count..].split_at_mut(count);
        let (s, t) = (change * along.x, change * along.y);
        for k in 0..count {
            by_s[k] += s * y[k];
            by_t[k] += t * y[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::index;
    use crate::sh::tests::gauss_legendre;
    use gi_core::math::Rgb;
    use gi_core::rng::Pcg;
    use lightcache::gradients::Gradient;
    use lightcache::hemisphere::Seen;

    const ORDER: usize = 5;

    fn site(reach: f32) -> Site {
        Site { n: Vec3::Z, p: Vec3::ZERO, radii: [reach; 2], axis: Vec3::X, least: 0.0, clear: 1.0 }
    }

    fn irradiance(e: Rgb, reach: f32) -> Record {
        let gradient = Gradient::default();
        Record { e, site: site(reach), rotational: gradient, translational: gradient }
    }

    fn see(rays: u32, seed: u64, look: impl Fn(Vec3) -> (f32, f32)) -> Hemisphere {
        let mut rng = Pcg::new(seed, 11);
        Hemisphere::gather(
            Strata::of(rays),
            |_| rng.next_2d(),
            |_, direction| {
                let (l, distance) = look(direction);
                Seen { direction, radiance: Rgb::grey(l), distance, normal: -Vec3::Z }
            },
        )
    }

    /// A bright rectangle in a ceiling at height 1.
    const LOW: Vec2 = Vec2::new(-0.2, -0.5);
    const HIGH: Vec2 = Vec2::new(0.9, 0.4);

    fn rectangle(w: Vec3) -> (f32, f32) {
        let q = w / w.z;
        let inside = q.x > LOW.x && q.x < HIGH.x && q.y > LOW.y && q.y < HIGH.y;
        (f32::from(u8::from(inside)), q.length())
    }

    /// Its coefficients at a moved point, by brute force over the ceiling.
    fn exact(basis: Basis, moved: Vec2) -> Vec<f64> {
        let (n, mut y) = (200, [0.0; MAX_FUNCTIONS]);
        let step = (HIGH - LOW) / n as f32;
        let mut sum = vec![0.0; ORDER * ORDER];
        for i in 0..n * n {
            let q = LOW + step * (Vec2::new((i % n) as f32, (i / n) as f32) + 0.5) - moved;
            let to = q.extend(1.0);
            basis.evaluate(ORDER, to.normalize(), &mut y);
            let solid_angle = f64::from(step.x * step.y) / f64::from(to.length()).powi(3);
            sum.iter_mut().zip(y).for_each(|(s, y)| *s += solid_angle * f64::from(y));
        }
        sum
    }

    fn mean_and_error(values: &[f64]) -> (f64, f64) {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, (variance / n).sqrt())
    }

    #[test]
    fn coefficients_and_gradients_are_those_of_a_rectangle_and_its_finite_differences() {
        let own = Frame::from_normal(Vec3::Z);
        // Records are not limited here: their reach is small.
        let record = |basis, seed| {
            let h = see(2000, seed, rectangle);
            RadianceRecord::new(irradiance(Rgb::WHITE, 1e-9), &own, &h, basis, ORDER)
        };
        for basis in [Basis::Sh, Basis::Hsh] {
            let records: Vec<_> = (0..100).map(|seed| record(basis, seed)).collect();
            let count = ORDER * ORDER;
            let value = exact(basis, Vec2::ZERO);
            let d = 1e-2;
            let difference = |v: Vec2| -> Vec<f64> {
                let (ahead, back) = (exact(basis, v * d), exact(basis, -v * d));
                ahead.iter().zip(back).map(|(a, b)| (a - b) / f64::from(2.0 * d)).collect()
            };
            let [by_s, by_t] = [own.s, own.t].map(|v| difference(v.truncate()));
            let all = [value, by_s, by_t].concat();
            let largest = |part: usize| {
                all[part * count..(part + 1) * count].iter().fold(0.0f64, |m, v| m.max(v.abs()))
            };
            for (k, exact) in all.iter().enumerate() {
                let found: Vec<f64> = records.iter().map(|r| f64::from(r.light[k].x)).collect();
                let (found, error) = mean_and_error(&found);
                // Walls stand at strata's borders and not at the rectangle's: half of one of 25 rings.
                let bias = if k < count { 0.0 } else { 0.5 / 25.0 * largest(k / count) };
                assert!(
                    (found - exact).abs() < bias + 4.5 * error + 1e-4,
                    "{basis:?}, {k}: {found} +- {error} is not {exact}"
                );
            }
        }
    }

    #[test]
    fn with_the_cosine_for_a_brdf_the_dot_product_is_the_irradiance() {
        // The cosine in both bases, by quadrature over the upper half.
        let order = 10;
        let (own, mut y) = (Frame::from_normal(Vec3::Z), [0.0; MAX_FUNCTIONS]);
        for basis in [Basis::Sh, Basis::Hsh] {
            let mut cosine = [0.0f64; MAX_FUNCTIONS];
            for (z, w) in gauss_legendre(20).into_iter().map(|(x, w)| (0.5 + 0.5 * x, 0.5 * w)) {
                basis.evaluate(
                    order,
                    Vec3::new((1.0 - z * z).sqrt() as f32, 0.0, z as f32),
                    &mut y,
                );
                for l in 0..order {
                    let k = index(l, 0);
                    cosine[k] += w * std::f64::consts::TAU * z * f64::from(y[k]);
                }
            }
            let off = |seed| {
                let h = see(1000, seed, |w| (0.2 + (2.0 * w.x).max(w.z), 1.0));
                let e = h.irradiance();
                let record = RadianceRecord::new(irradiance(e, 1.0), &own, &h, basis, order);
                let dot = |k: usize| f64::from(record.light[k].x) * cosine[k];
                (0..order * order).map(dot).sum::<f64>() / f64::from(e.r) - 1.0
            };
            let (mean, error) = mean_and_error(&(0..50).map(off).collect::<Vec<_>>());
            // Bands from 10 on hold 3e-4 of the cosine's energy; hemispherical ones hold it whole.
            assert!(mean.abs() < 2e-3 + 4.5 * error, "{basis:?}: {mean} +- {error}");
        }
    }

    #[test]
    fn at_home_a_record_gives_its_light_whichever_way_the_query_looks() {
        let h = see(500, 3, |w| (w.x.max(0.0) + 0.2, 1.0));
        let own = Frame::from_normal(Vec3::Z);
        let q = Query { p: Vec3::ZERO, n: Vec3::Z };
        let mut y = [0.0; MAX_FUNCTIONS];
        for basis in [Basis::Sh, Basis::Hsh] {
            let record = RadianceRecord::new(irradiance(Rgb::WHITE, 1.0), &own, &h, basis, ORDER);
            let direction = Vec3::new(0.6, 0.2, 0.5).normalize();
            let mut seen = Vec::new();
            for angle in [0.0f32, 0.7, 2.5] {
                let s = Vec3::new(angle.cos(), angle.sin(), 0.0);
                let frame = Frame { s, t: Vec3::Z.cross(s), n: Vec3::Z };
                let mut light = [Vec3A::ZERO; MAX_FUNCTIONS];
                record.add_to(&mut light, &q, &frame, basis, (true, 1.0));
                if basis == Basis::Sh {
                    crate::rotate::Turn::into_frame(&frame).apply(ORDER, &mut light);
                }
                basis.evaluate(ORDER, frame.to_local(direction), &mut y);
                seen.push(light.iter().zip(y).map(|(c, y)| c.x * y).sum::<f32>());
            }
            assert!(
                (seen[0] - seen[1]).abs() < 1e-5 && (seen[0] - seen[2]).abs() < 1e-5,
                "{seen:?}"
            );
        }
    }
}
