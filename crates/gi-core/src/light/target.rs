//! Starts light paths toward chosen shapes, like projection maps \[Jensen01, 5.2\] but without cells. For light from
//! infinity, most paths can also be started toward where the eye looks: see [`super::aim`].

use std::f32::consts::PI;

use glam::Vec3;

use super::aim::{Aim, Weighted};
use super::ball::{Ball, joined};
use super::{Emission, EmitterPoint, Light, Lights, PointSource};
use crate::geometry::{Geometry, Shape};
use crate::math::{Frame, Rgb, one_minus_cos, sqr};
use crate::warp;

/// Balls that contain everything that paths are aimed at.
#[derive(Clone, Debug, Default)]
pub struct Targets {
    spheres: Vec<Ball>,
    /// If set, it replaces the balls. Every path can then be sampled.
    aim: Option<Aim>,
}

/// Maximum number of balls. The start of each path tests all of them.
const MOST: usize = 32;

impl Targets {
    /// Balls around shapes or copies of shapes, given as centre and radius.
    pub fn new(spheres: impl IntoIterator<Item = (Vec3, f32)>) -> Self {
        // Slightly enlarged, so that rounding leaves no point of the shape outside.
        let ball = |(center, radius): (Vec3, f32)| Ball { center, radius: radius * 1.001 };
        let mut spheres: Vec<Ball> = spheres.into_iter().map(ball).collect();
        while spheres.len() > MOST {
            spheres = spheres.chunks(2).map(joined).collect();
        }
        Targets { spheres, aim: None }
    }

    /// Aim paths from infinity mostly at weighted points: where they are scattered first, and where they end. Every
    /// path of `lights` can be sampled. `None` if no point has weight, or no light is at infinity.
    pub(crate) fn around(points: [Vec<Weighted>; 2], lights: &Lights) -> Option<Self> {
        Aim::new(points, lights).map(|aim| Targets { aim: Some(aim), ..Targets::default() })
    }

    /// The cone toward the goal for light that is scattered at `p`: its axis, and 1 - cos of its half angle. `None`
    /// unless `p` is far from all ends.
    pub(crate) fn goal_from(&self, p: Vec3) -> Option<(Frame, f32)> {
        self.aim.as_ref()?.goal_from(p)
    }

    /// Whether there is nothing to aim at.
    pub fn is_empty(&self) -> bool {
        self.spheres.is_empty() && self.aim.is_none()
    }

    /// Sample a direction from `p` into the cones of the targets, uniformly by solid angle. Returns the direction, and
    /// one over its density. `None` inside a target, or if the cones together are not smaller than `most` steradians.
    fn sample_cones(
        &self,
        p: Vec3,
        normal: Option<Vec3>,
        u: [f32; 2],
        most: f32,
    ) -> Option<(Vec3, f32)> {
        let faces = |b: &Ball| normal.is_none_or(|n| (b.center - p).dot(n) > -b.radius);
        let mut total = 0.0;
        for b in self.spheres.iter().filter(|b| faces(b)) {
            total += 2.0 * PI * b.one_minus_cos(p)?;
        }
        if total >= most || total <= 0.0 {
            return None;
        }
        let mut rest = u[0] * total;
        let mut chosen = None;
        for b in self.spheres.iter().filter(|b| faces(b)) {
            let one_minus_cos = b.one_minus_cos(p)?;
            let omega = 2.0 * PI * one_minus_cos;
            chosen = Some((b, one_minus_cos, (rest / omega).min(1.0)));
            if rest < omega {
                break;
            }
            rest -= omega;
        }
        let (ball, one_minus_cos, u0) = chosen?;
        let axis = Frame::from_normal((ball.center - p).normalize());
        let d = axis.to_world(warp::cone([u0, u[1]], one_minus_cos));
        // A direction in the overlap of several cones may come from each of them.
        let hit = |b: &&Ball| {
            let to = b.center - p;
            to.dot(d) > 0.0 && to.cross(d).length_squared() <= sqr(b.radius)
        };
        let count = self.spheres.iter().filter(|b| faces(b)).filter(hit).count().max(1);
        Some((d, total / count as f32))
    }

    /// Sample a line along `d` through the projections of the targets onto a plane perpendicular to `d`, uniformly by
    /// area. Returns a point of the line, and one over its density per area. `None` if the projections together are not
    /// smaller than `most`.
    fn sample_shadows(&self, d: Vec3, u: [f32; 2], most: f32) -> Option<(Vec3, f32)> {
        let total: f32 = self.spheres.iter().map(Ball::shadow).sum();
        if total >= most || total <= 0.0 {
            return None;
        }
        let mut rest = u[0] * total;
        let mut chosen = None;
        for b in &self.spheres {
            let area = b.shadow();
            chosen = Some((b, (rest / area).min(1.0)));
            if rest < area {
                break;
            }
            rest -= area;
        }
        let (ball, u0) = chosen?;
        let p = ball.point_of_shadow(&Frame::from_normal(d), [u0, u[1]]);
        let count = self.spheres.iter().filter(|b| b.is_on_line(p, d)).count().max(1);
        Some((p, total / count as f32))
    }
}

/// Centre and radius of a sphere around a shape.
pub(crate) fn sphere_round(shape: &Shape) -> (Vec3, f32) {
    let center = shape.geometry.bounds().center();
    match &shape.geometry {
        Geometry::Sphere { radius, .. } => (center, *radius),
        Geometry::Mesh(mesh) => {
            let far = mesh.positions.iter().map(|p| p.distance_squared(center));
            (center, far.fold(0.0, f32::max).sqrt())
        }
        other => (center, 0.5 * other.bounds().extent().length()),
    }
}

impl Lights {
    /// Like [`Lights::emit`], but samples only paths that may hit a target first; the powers of these paths are
    /// unbiased, and all other paths are missing. For a light that is surrounded by targets, or nearly so, it falls
    /// back to the usual emission. With targets around points, no paths are missing.
    pub(crate) fn emit_toward(
        &self,
        targets: &Targets,
        u_light: f32,
        u_p: [f32; 2],
        u_d: [f32; 2],
        emission: impl Fn(u32, u32, &EmitterPoint) -> Rgb,
    ) -> Option<Emission> {
        if let Some(aim) = &targets.aim {
            return aim.emit(self, (u_light, u_p, u_d), emission);
        }
        let start = self.emit(u_light, u_p, u_d, emission)?;
        let cones = |normal, most| targets.sample_cones(start.p, normal, u_d, most);
        let aimed = match start.source {
            PointSource::Oriented(seen) => cones(Some(start.ng), PI).map(|(d, inverse_pdf)| {
                let power = seen * (d.dot(start.ng).max(0.0) * inverse_pdf);
                Emission { d, power, ..start }
            }),
            PointSource::Omni(intensity) => cones(None, 4.0 * PI).map(|(d, inverse_pdf)| {
                Emission { ng: d, d, power: intensity * inverse_pdf, ..start }
            }),
            PointSource::Spot(intensity) => {
                let light = &self.all()[start.light as usize];
                let Light::Spot { cutoff, .. } = light else { unreachable!("the light is a spot") };
                cones(None, 2.0 * PI * one_minus_cos(*cutoff)).map(|(d, inverse_pdf)| {
                    let power = intensity * (light.spot_fade(d) * inverse_pdf);
                    Emission { ng: d, d, power, ..start }
                })
            }
            PointSource::Directional(irradiance) => {
                let shadows = targets.sample_shadows(start.d, u_p, PI * sqr(self.sphere.1));
                shadows.map(|(q, area)| {
                    let p = self.entrance(q, start.d);
                    Emission { p, power: irradiance * area, ..start }
                })
            }
        };
        Some(aimed.unwrap_or(start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Pcg;

    #[test]
    fn densities_of_cones_and_shadows_integrate_to_the_solid_angle_and_area_of_their_union() {
        let balls = [
            (Vec3::new(0.0, 0.0, 3.0), 1.0),
            (Vec3::new(0.8, 0.0, 4.0), 1.0),
            (Vec3::new(-4.0, 0.0, 0.5), 0.7),
        ];
        let targets = Targets::new(balls);
        let mut rng = Pcg::new(8, 0);
        let n = 400_000;
        let hits = |d: Vec3| {
            targets.spheres.iter().any(|b| {
                b.center.dot(d) > 0.0 && b.center.cross(d).length_squared() <= sqr(b.radius)
            })
        };
        // The size of the union, from random directions that are not aimed, and as the mean of one over the density.
        let blind =
            (0..n).filter(|_| hits(warp::sphere(rng.next_2d()))).count() as f64 / f64::from(n);
        let inverse: f64 = (0..n)
            .map(|_| {
                targets
                    .sample_cones(Vec3::ZERO, None, rng.next_2d(), 99.0)
                    .map_or(0.0, |s| f64::from(s.1))
            })
            .sum::<f64>()
            / f64::from(n);
        let union = blind * 4.0 * std::f64::consts::PI;
        let error = 4.0 * std::f64::consts::PI * (blind / f64::from(n)).sqrt();
        assert!((inverse - union).abs() < 4.0 * error, "{inverse} is not {union} +- {error}");
        let shadow = |p: Vec3| {
            targets
                .spheres
                .iter()
                .any(|b| (b.center - p).cross(Vec3::Z).length_squared() <= sqr(b.radius))
        };
        let square = 12.0;
        let blind = (0..n)
            .filter(|_| {
                shadow(Vec3::new(
                    square * (rng.next_f32() - 0.5),
                    square * (rng.next_f32() - 0.5),
                    0.0,
                ))
            })
            .count() as f64
            / f64::from(n);
        let area: f64 = (0..n)
            .map(|_| {
                targets.sample_shadows(Vec3::Z, rng.next_2d(), 99.0).map_or(0.0, |s| f64::from(s.1))
            })
            .sum::<f64>()
            / f64::from(n);
        let union = blind * f64::from(square * square);
        let error = f64::from(square * square) * (blind / f64::from(n)).sqrt();
        assert!((area - union).abs() < 4.0 * error, "{area} is not {union} +- {error}");
    }

    #[test]
    fn joined_spheres_contain_all_spheres() {
        let mut rng = Pcg::new(3, 1);
        let balls: Vec<(Vec3, f32)> = (0..200)
            .map(|_| {
                (Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()), 0.05 * rng.next_f32())
            })
            .collect();
        let targets = Targets::new(balls.iter().copied());
        assert!(targets.spheres.len() <= MOST);
        for (center, radius) in balls {
            let held = |b: &Ball| b.center.distance(center) + radius <= b.radius * 1.000_01;
            assert!(targets.spheres.iter().any(held), "{center} {radius}");
        }
    }
}
