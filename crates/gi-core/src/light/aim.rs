//! Aims paths from lights at infinity at the points that matter: through nested discs around them. The last disc covers
//! the scene.
//!
//! A sun lights the whole scene uniformly, but the picture may show only a small part of it. Without aiming, paths
//! spread over the disc of the scene. Aimed paths are dense where they matter, and the power of each path compensates
//! for that.

use std::f32::consts::PI;

use glam::Vec3;

use super::ball::Ball;
use super::{Discrete, Emission, EmitterPoint, Light, Lights, PointSource};
use crate::math::{Bounds, Frame, Rgb, sqr};

/// A distribution of the lines along which light from infinity enters the scene.
#[derive(Clone, Debug)]
pub(crate) struct Aim {
    balls: Vec<Ball>,
    shares: Discrete,
    lights: Discrete,
    /// Light that is scattered far from this ball is aimed at it.
    goal: Ball,
}

/// A point that matters, and its weight.
pub(super) type Weighted = (Vec3, f32);

/// Number of balls around parts of the points, each with the same total weight. A power of two.
const PARTS: usize = 32;
/// Fraction of the paths that go through those balls. The others go through balls that double in size, from the ball
/// around half of all points to the whole scene, with the same number of paths through each. So the power of a path
/// grows with the square of its distance from the points. The probability that it reaches them after a scattering falls
/// at the same rate.
const SHARE: f32 = 0.6;
/// Smallest radius of a part, relative to the radius that contains half of the points.
const LEAST: f32 = 0.1;
/// Radius of the goal, relative to the radius that contains half of the ends. Scattering is aimed from beyond this many
/// such radii.
const GOAL: f32 = 2.0;
const FAR: f32 = 2.0;
/// Smallest such radius, relative to that of the scene.
const LEAST_CORE: f32 = 1e-4;

impl Aim {
    /// Aim at the points where light should be scattered first; light that is scattered far away is aimed at the points
    /// where it should end. `None` if no point has weight, or if no light is at infinity.
    pub(crate) fn new([mut points, mut ends]: [Vec<Weighted>; 2], lights: &Lights) -> Option<Self> {
        for list in [&mut points, &mut ends] {
            list.retain(|(p, w)| p.is_finite() && w.is_finite() && *w > 0.0);
        }
        if points.is_empty() || ends.is_empty() || !lights.all().iter().any(Light::is_infinite) {
            return None;
        }
        let (middle, radius) = lights.sphere();
        let core = core(&mut points, LEAST_CORE * radius);
        let goal = self::core(&mut ends, LEAST_CORE * radius);
        let goal = Ball { radius: GOAL * goal.radius, ..goal };
        let total: f64 = points.iter().map(|p| f64::from(p.1)).sum();
        let mut parts = Vec::with_capacity(PARTS);
        split(&mut points, PARTS, &mut |part| {
            let weight: f64 = part.iter().map(|p| f64::from(p.1)).sum();
            let ball = ball_round(part, LEAST * core.radius);
            parts.push((ball, SHARE * (weight / total) as f32));
        });
        let area = area(&parts).min(PI * sqr(radius));
        let mut rings = vec![core];
        while let Some(last) = rings.last().filter(|b| 2.0 * b.radius < radius) {
            rings.push(Ball { radius: 2.0 * last.radius, ..core });
        }
        // Enlarge it slightly, so that rounding leaves no point of the scene outside.
        rings.push(Ball { center: middle, radius: radius * 1.001 });
        let share = (1.0 - SHARE) / rings.len() as f32;
        parts.extend(rings.into_iter().map(|b| (b, share)));
        // A light at infinity is chosen by its power through the aimed area, not by its power over the whole scene.
        let seen = area / (PI * sqr(radius));
        let worth = |(k, light): (usize, &Light)| {
            lights.probability(k) * if light.is_infinite() { seen } else { 1.0 }
        };
        Some(Aim {
            shares: Discrete::new(parts.iter().map(|p| p.1)),
            lights: Discrete::new(lights.all().iter().enumerate().map(worth)),
            balls: parts.into_iter().map(|p| p.0).collect(),
            goal,
        })
    }

    /// As [`Lights::emit`], but the origins of parallel light are aimed.
    pub(crate) fn emit(
        &self,
        lights: &Lights,
        (u_light, u_p, u_d): (f32, [f32; 2], [f32; 2]),
        emission: impl Fn(u32, u32, &EmitterPoint) -> Rgb,
    ) -> Option<Emission> {
        let (light, probability, _) = self.lights.sample(u_light)?;
        let start = lights.emit_from((light, probability), u_p, u_d, emission)?;
        let PointSource::Directional(irradiance) = start.source else { return Some(start) };
        let (q, density) = self.sample(start.d, u_p)?;
        let p = lights.entrance(q, start.d);
        Some(Emission { p, power: irradiance / density, ..start })
    }

    /// The cone that contains the goal as seen from far away: its axis, and 1 - cos of its half angle.
    pub(super) fn goal_from(&self, p: Vec3) -> Option<(Frame, f32)> {
        let to = self.goal.center - p;
        if to.length_squared() < sqr(FAR * self.goal.radius) {
            return None;
        }
        Some((Frame::from_normal(to.normalize()), self.goal.one_minus_cos(p)?))
    }

    /// Sample a line along the unit vector `d`: a point of it, and its density per area perpendicular to `d`.
    fn sample(&self, d: Vec3, u: [f32; 2]) -> Option<(Vec3, f32)> {
        let (chosen, _, u0) = self.shares.sample(u[0])?;
        let q = self.balls[chosen].point_of_shadow(&Frame::from_normal(d), [u0, u[1]]);
        let density = |(k, ball): (usize, &Ball)| {
            let inside = k == chosen || ball.is_on_line(q, d);
            if inside { self.shares.probability(k) / ball.shadow() } else { 0.0 }
        };
        Some((q, self.balls.iter().enumerate().map(density).sum()))
    }
}

/// A ball that contains half of the weight.
fn core(points: &mut [Weighted], least: f32) -> Ball {
    let center = Vec3::from_array([0, 1, 2].map(|axis| {
        let half = sorted_half(points, |p| p[axis]);
        points[half].0[axis]
    }));
    let half = sorted_half(points, |p| p.distance_squared(center));
    Ball { center, radius: points[half].0.distance(center).max(least) }
}

/// Sort points; return the index at which half of the weight is reached.
fn sorted_half(points: &mut [Weighted], key: impl Fn(Vec3) -> f32) -> usize {
    points.sort_by(|a, b| key(a.0).total_cmp(&key(b.0)));
    let total: f64 = points.iter().map(|p| f64::from(p.1)).sum();
    let mut sum = 0.0;
    let reached = |p: &Weighted| {
        sum += f64::from(p.1);
        2.0 * sum >= total
    };
    points.iter().position(reached).unwrap_or(points.len() - 1)
}

/// Split points in halves of equal weight along their longest extent, until there are enough parts.
fn split(points: &mut [Weighted], parts: usize, take: &mut impl FnMut(&[Weighted])) {
    if parts == 1 || points.len() < 2 {
        return take(points);
    }
    let extent = bounds(points).extent();
    let axis = (0..3).fold(0, |a, b| if extent[b] > extent[a] { b } else { a });
    let half = sorted_half(points, |p| p[axis]).clamp(1, points.len() - 1);
    let (low, high) = points.split_at_mut(half);
    split(low, parts / 2, take);
    split(high, parts / 2, take);
}

fn bounds(points: &[Weighted]) -> Bounds {
    Bounds::of(points.iter().map(|p| p.0))
}

fn ball_round(points: &[Weighted], least: f32) -> Ball {
    let bounds = bounds(points);
    Ball { center: bounds.center(), radius: (0.5 * bounds.extent().length()).max(least) }
}

/// The geometric mean of the area that one path represents at a weighted point.
fn area(parts: &[(Ball, f32)]) -> f32 {
    let share: f32 = parts.iter().map(|p| p.1).sum();
    let mean: f32 = parts.iter().map(|(b, s)| s / share * (b.shadow() * share / s).ln()).sum();
    mean.exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::LightSource;
    use crate::rng::Pcg;

    /// Points of a court of 4 m in a scene of 300 m, and a few points farther away; the sun is one of `lights`.
    fn aimed(sources: Vec<LightSource>) -> (Option<Aim>, Lights) {
        let mut rng = Pcg::new(5, 5);
        let mut point = |size: f32| {
            let [x, z] = rng.next_2d().map(|u| size * (u - 0.5));
            (Vec3::new(x, rng.next_f32(), z), rng.next_f32())
        };
        let points: Vec<_> =
            (0..2000).map(|k| point(if k % 50 == 0 { 100.0 } else { 4.0 })).collect();
        let lights = Lights::new(&[], sources, (Vec3::new(1.0, 2.0, 3.0), 300.0));
        (Aim::new([points.clone(), points], &lights), lights)
    }

    fn sun() -> LightSource {
        LightSource::Directional { direction: -Vec3::Y, irradiance: Rgb::WHITE }
    }

    #[test]
    fn sampled_lines_integrate_functions_near_to_and_far_from_the_goal() {
        let (aim, lights) = aimed(vec![sun()]);
        let aim = aim.expect("a light at infinity");
        let d = Vec3::new(0.3, -0.9, 0.2).normalize();
        // The integral over the scene's disc of a Gaussian with width s, 2 pi s^2, around the court and far from it.
        let bumps = [(Vec3::ZERO, 1.0f32), (Vec3::X * 30.0, 8.0), (Vec3::Z * -150.0, 30.0)];
        let (mut rng, n) = (Pcg::new(1, 2), 200_000);
        let mut sums = [[0.0f64; 2]; 3];
        for _ in 0..n {
            let (q, density) = aim.sample(d, rng.next_2d()).expect("shares");
            for ((center, s), sum) in bumps.iter().zip(&mut sums) {
                let off = (q - *center).cross(d).length_squared();
                let x = f64::from((-0.5 * off / (s * s)).exp() / density);
                (sum[0], sum[1]) = (sum[0] + x, sum[1] + x * x);
            }
        }
        for ((_, s), [sum, squares]) in bumps.iter().zip(sums) {
            let (mean, n) = (sum / f64::from(n), f64::from(n));
            let error = ((squares / n - mean * mean) / n).sqrt();
            let exact = f64::from(2.0 * PI * s * s);
            assert!(
                error < 0.05 * exact && (mean - exact).abs() < 4.0 * error,
                "{mean} +- {error}: {exact}"
            );
        }
        // More than half of all paths go through a thousandth of the disc.
        assert!(lights.sphere().1 == 300.0);
        let mut near = || aim.sample(d, rng.next_2d()).expect("shares").0.cross(d).length() < 10.0;
        assert!((0..10_000).filter(|_| near()).count() > 5000);
    }

    #[test]
    fn a_lamp_gets_its_paths_beside_a_sun_that_illuminates_all_the_ground() {
        // The sun has irradiance 1 over an aimed area of 100 m^2, and the lamp has the power 100. The power of the
        // whole sun is 280 000, so the lamp would get hardly any paths without aiming.
        let lamp =
            LightSource::Point { position: Vec3::Y, intensity: Rgb::grey(100.0 / (4.0 * PI)) };
        let (aim, lights) = aimed(vec![sun(), lamp]);
        let aim = aim.expect("a light at infinity");
        assert!(lights.probability(1) < 1e-3);
        assert!(aim.lights.probability(1) > 0.3, "{}", aim.lights.probability(1));
        assert!((aim.lights.probability(0) + aim.lights.probability(1) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn without_points_or_lights_at_infinity_there_is_no_aim() {
        let lamp = LightSource::Point { position: Vec3::Y, intensity: Rgb::WHITE };
        assert!(aimed(vec![lamp]).0.is_none());
        let (_, lights) = aimed(vec![sun()]);
        assert!(Aim::new([Vec::new(), Vec::new()], &lights).is_none());
        assert!(Aim::new([vec![(Vec3::NAN, 1.0)], vec![(Vec3::X, 0.0)]], &lights).is_none());
        let one =
            Aim::new([vec![(Vec3::X, 1.0); 7], vec![(Vec3::X, 1.0)]], &lights).expect("a point");
        let (q, density) = one.sample(Vec3::Z, [0.1, 0.5]).expect("shares");
        assert!(q.is_finite() && density.is_finite() && density > 0.0);
    }
}
