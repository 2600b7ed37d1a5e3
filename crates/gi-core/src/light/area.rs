//! Shapes that emit light: sampling them from a point, by solid angle where that is stable.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use crate::math::{Frame, sin_cos_turns, sqr};
use crate::warp;

/// One emitting primitive. Light leaves on the side of the normal only.
#[derive(Clone, Copy, Debug)]
pub enum Emitter {
    /// A triangle.
    Triangle {
        /// Corners.
        v: [Vec3; 3],
        /// Unit normal of the emitting side.
        normal: Vec3,
        /// Centre of gravity.
        center: Vec3,
        /// Area, world units squared.
        area: f32,
    },
    /// A sphere, emitting outward (or inward).
    Sphere {
        /// Centre.
        center: Vec3,
        /// Radius.
        radius: f32,
        /// Whether it emits outward.
        outward: bool,
    },
    /// An ellipse.
    Disk {
        /// Centre.
        center: Vec3,
        /// Half axes.
        axes: [Vec3; 2],
        /// Unit normal of the emitting side.
        normal: Vec3,
    },
    /// The side of a cylinder.
    Cylinder {
        /// Ends of the axis.
        ends: [Vec3; 2],
        /// Radius.
        radius: f32,
        /// Whether it emits outward.
        outward: bool,
    },
}

/// A point on an emitter.
#[derive(Clone, Copy, Debug)]
pub struct EmitterPoint {
    /// Position.
    pub p: Vec3,
    /// Unit normal on the emitting side.
    pub normal: Vec3,
    /// Parameters, as u and v in [`crate::ray::Hit`].
    pub uv: Vec2,
}

/// Triangles whose area is below this fraction of the squared distance are sampled by area. Over such a small solid
/// angle (a page at arm's length), cosine and distance vary little, and spherical trigonometry costs ten times as much.
const FAR: f32 = 0.1;
/// A triangle that covers nearly the whole hemisphere is too inaccurate in spherical trigonometry.
const LARGEST_SOLID_ANGLE: f32 = 6.2;

impl Emitter {
    /// A triangle with these corners, which emits on the side of `normal`.
    pub fn triangle(v: [Vec3; 3], normal: Vec3) -> Self {
        let [a, b, c] = v;
        let area = 0.5 * (b - a).cross(c - a).length();
        Emitter::Triangle { v, normal, center: (a + b + c) * (1.0 / 3.0), area }
    }

    /// Area, world units squared.
    pub fn area(&self) -> f32 {
        match *self {
            Emitter::Triangle { area, .. } => area,
            Emitter::Sphere { radius, .. } => 4.0 * PI * sqr(radius),
            Emitter::Disk { axes: [du, dv], .. } => PI * du.cross(dv).length(),
            Emitter::Cylinder { ends: [p0, p1], radius, .. } => 2.0 * PI * radius * p0.distance(p1),
        }
    }

    /// A point uniform in area; its density is one over [`Emitter::area`].
    #[inline]
    pub fn sample_area(&self, u: [f32; 2]) -> EmitterPoint {
        match *self {
            Emitter::Triangle { v: [a, b, c], normal, .. } => {
                let [s, t] = warp::triangle(u);
                EmitterPoint { p: a * (1.0 - s - t) + b * s + c * t, normal, uv: Vec2::new(s, t) }
            }
            Emitter::Sphere { center, radius, outward } => {
                let n = warp::sphere(u);
                EmitterPoint {
                    p: center + n * radius,
                    normal: if outward { n } else { -n },
                    uv: Vec2::ZERO,
                }
            }
            Emitter::Disk { center, axes: [du, dv], normal } => {
                let q = warp::disk(u);
                EmitterPoint { p: center + du * q.x + dv * q.y, normal, uv: q }
            }
            Emitter::Cylinder { ends: [p0, p1], radius, outward } => {
                let frame = Frame::from_normal((p1 - p0).normalize());
                let (sin, cos) = sin_cos_turns(u[0]);
                let n = frame.s * cos + frame.t * sin;
                let normal = if outward { n } else { -n };
                EmitterPoint { p: p0.lerp(p1, u[1]) + n * radius, normal, uv: Vec2::new(u[1], 0.0) }
            }
        }
    }

    /// Sample a point that is visible from `p`; its density is per solid angle at `p`. `None` if the emitter faces
    /// away.
    #[inline]
    pub fn sample_from(&self, p: Vec3, u: [f32; 2]) -> Option<(EmitterPoint, f32)> {
        match *self {
            Emitter::Triangle { v, normal, center, area } => {
                if normal.dot(p - v[0]) <= 0.0 {
                    return None;
                }
                if is_near(p, center, area)
                    && let Some((corners, omega)) = seen_triangle(p, v)
                {
                    let [a, b, c] = corners;
                    let w = warp::spherical_triangle(u, a, b, c, omega)?;
                    return Some((on_triangle(p, w, v, normal)?, 1.0 / omega));
                }
            }
            Emitter::Sphere { center, radius, outward } => {
                if let Some((frame, one_minus_cos)) = cone_of(p, center, radius) {
                    if !outward {
                        return None; // every visible point faces away
                    }
                    let w = frame.to_world(warp::cone(u, one_minus_cos));
                    let normal = sphere_normal(p, w, center, radius);
                    let point =
                        EmitterPoint { p: center + normal * radius, normal, uv: Vec2::ZERO };
                    return Some((point, warp::cone_pdf(one_minus_cos)));
                }
            }
            Emitter::Disk { .. } | Emitter::Cylinder { .. } => {}
        }
        let point = self.sample_area(u);
        let pdf_w = self.area_pdf_w(p, point.p, point.normal);
        (pdf_w > 0.0).then_some((point, pdf_w))
    }

    /// Density per solid angle at `p` with which [`Emitter::sample_from`] returns the point `q` with normal `normal`.
    pub fn pdf_w(&self, p: Vec3, q: Vec3, normal: Vec3) -> f32 {
        match *self {
            Emitter::Triangle { v, center, area, .. } => {
                if is_near(p, center, area)
                    && let Some((_, omega)) = seen_triangle(p, v)
                {
                    return 1.0 / omega;
                }
            }
            Emitter::Sphere { center, radius, .. } => {
                if let Some((_, one_minus_cos)) = cone_of(p, center, radius) {
                    return warp::cone_pdf(one_minus_cos);
                }
            }
            Emitter::Disk { .. } | Emitter::Cylinder { .. } => {}
        }
        self.area_pdf_w(p, q, normal)
    }

    /// Density per solid angle at `p` of the point `q` with normal `normal`, if points are sampled by area; 0 if it
    /// faces away.
    #[inline]
    fn area_pdf_w(&self, p: Vec3, q: Vec3, normal: Vec3) -> f32 {
        let to = q - p;
        let (distance_sq, projected) = (to.length_squared(), -normal.dot(to));
        // The squared distance over the cosine, which is `projected` over the distance.
        if projected > 0.0 {
            distance_sq * (distance_sq.sqrt() / (projected * self.area()))
        } else {
            0.0
        }
    }
}

/// Whether a triangle is so close to `p` that it is sampled by solid angle.
#[inline]
fn is_near(p: Vec3, center: Vec3, area: f32) -> bool {
    area >= FAR * center.distance_squared(p)
}

/// Unit directions to the corners, and the solid angle, of a triangle; `None` if it is sampled by area because the
/// solid angle is inaccurate.
fn seen_triangle(p: Vec3, v: [Vec3; 3]) -> Option<([Vec3; 3], f32)> {
    let [a, b, c] = v.map(|v| (v - p).try_normalize());
    let [a, b, c] = [a?, b?, c?]; // a corner at p has no direction
    let omega = warp::solid_angle(a, b, c);
    (omega > 1e-4 && omega < LARGEST_SOLID_ANGLE).then_some(([a, b, c], omega))
}

/// The intersection of the ray from `p` along `w` with the triangle's plane, as a point of the triangle.
fn on_triangle(p: Vec3, w: Vec3, v: [Vec3; 3], normal: Vec3) -> Option<EmitterPoint> {
    let t = normal.dot(v[0] - p) / normal.dot(w);
    // If p is in the plane itself, rounding errors may give any value.
    if !(t > 0.0 && t.is_finite()) {
        return None;
    }
    let q = p + w * t - v[0];
    // Barycentric coordinates in the plane, clamped to the triangle after rounding.
    let (e1, e2) = (v[1] - v[0], v[2] - v[0]);
    let (d11, d12, d22) = (e1.dot(e1), e1.dot(e2), e2.dot(e2));
    let (q1, q2) = (q.dot(e1), q.dot(e2));
    let det = d11 * d22 - d12 * d12;
    let (s, r) = ((d22 * q1 - d12 * q2) / det, (d11 * q2 - d12 * q1) / det);
    if !(s.is_finite() && r.is_finite()) {
        return None;
    }
    let s = s.clamp(0.0, 1.0);
    let r = r.clamp(0.0, 1.0 - s);
    Some(EmitterPoint { p: v[0] + e1 * s + e2 * r, normal, uv: Vec2::new(s, r) })
}

/// The cone that a sphere covers as seen from `p`: a frame along its axis, and 1 - cos of its half angle. `None` from
/// inside, or if the cone is as wide as the hemisphere.
fn cone_of(p: Vec3, center: Vec3, radius: f32) -> Option<(Frame, f32)> {
    let to = center - p;
    let distance_sq = to.length_squared();
    let sin_sq = sqr(radius) / distance_sq;
    // 1 - cos = sin^2 / (1 + cos), which is accurate for small spheres.
    (sin_sq < 0.9999).then(|| {
        (Frame::from_normal(to / distance_sq.sqrt()), sin_sq / (1.0 + (1.0 - sin_sq).sqrt()))
    })
}

/// Normal at the first intersection of the ray from `p` along `w` with the sphere, or at the nearest point if rounding
/// makes it miss.
fn sphere_normal(p: Vec3, w: Vec3, center: Vec3, radius: f32) -> Vec3 {
    let to = center - p;
    let along = to.dot(w);
    let across = w * along - to; // from the centre to the nearest point of the ray
    let half_chord = (sqr(radius) - across.length_squared()).max(0.0).sqrt();
    (across - w * half_chord).normalize()
}
