//! Maps from the unit square to directions and shapes, each with its density.
//!
//! `x_pdf` returns the density at a point that `x` returned, in the measure that its name or doc states.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use glam::{Vec2, Vec3};

use crate::math::{INV_PI, safe_sqrt, sin_cos_eighth, sin_cos_turns, sqr};

/// The unit disk; preserves areas, and nearly preserves shapes \[Shirley97\].
#[inline]
pub fn disk([u, v]: [f32; 2]) -> Vec2 {
    let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if x == 0.0 && y == 0.0 {
        return Vec2::ZERO;
    }
    // The angle from the x axis, or from the y axis if that is nearer.
    if x.abs() > y.abs() {
        let (sin, cos) = sin_cos_eighth(0.25 * PI * (y / x));
        Vec2::new(x * cos, x * sin)
    } else {
        let (sin, cos) = sin_cos_eighth(0.25 * PI * (x / y));
        Vec2::new(y * sin, y * cos)
    }
}

/// Density of [`disk`], per area of the unit disk.
#[inline]
pub fn disk_pdf() -> f32 {
    INV_PI
}

/// The hemisphere around +z in proportion to the cosine: the disk projected up (Malley's method).
#[inline]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let p = disk(u);
    Vec3::new(p.x, p.y, safe_sqrt(1.0 - p.length_squared()))
}

/// Density of [`cosine_hemisphere`], per solid angle.
#[inline]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * INV_PI
}

/// The unit sphere.
#[inline]
pub fn sphere([u, v]: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u;
    let (sin, cos) = sin_cos_turns(v);
    let r = safe_sqrt(1.0 - z * z);
    Vec3::new(r * cos, r * sin, z)
}

/// Density of [`sphere`], per solid angle.
#[inline]
pub fn sphere_pdf() -> f32 {
    0.25 * INV_PI
}

/// The hemisphere around +z.
#[inline]
pub fn hemisphere([u, v]: [f32; 2]) -> Vec3 {
    sphere([0.5 * u, v])
}

/// Density of [`hemisphere`], per solid angle.
#[inline]
pub fn hemisphere_pdf() -> f32 {
    0.5 * INV_PI
}

/// The unit sphere, unfolded from a square: equal areas are equal solid angles, and neighbours stay neighbours
/// \[Clarberg08\]. The centre of the square is +z, its corners are -z.
pub fn folded_sphere(p: Vec2) -> Vec3 {
    let (u, v) = (2.0 * p.x - 1.0, 2.0 * p.y - 1.0);
    let (up, vp) = (u.abs(), v.abs());
    let distance = 1.0 - (up + vp);
    let r = 1.0 - distance.abs();
    let phi = if r == 0.0 { FRAC_PI_4 } else { ((vp - up) / r + 1.0) * FRAC_PI_4 };
    let z = (1.0 - r * r).copysign(distance);
    let side = r * (2.0 - r * r).max(0.0).sqrt();
    Vec3::new((phi.cos() * side).copysign(u), (phi.sin() * side).copysign(v), z)
}

/// The point of the square that [`folded_sphere`] maps to the unit vector `d`.
pub fn unfolded_sphere(d: Vec3) -> Vec2 {
    let [x, y, z] = d.abs().to_array();
    let r = (1.0 - z).max(0.0).sqrt();
    // The angle in the first quadrant, as a fraction of a right angle.
    let part = if x == 0.0 && y == 0.0 { 0.0 } else { y.atan2(x) / FRAC_PI_2 };
    let (mut u, mut v) = (r * (1.0 - part), r * part);
    if d.z < 0.0 {
        // The lower half is folded outward over the diagonals.
        (u, v) = (1.0 - v, 1.0 - u);
    }
    0.5 * (Vec2::new(u.copysign(d.x), v.copysign(d.y)) + Vec2::ONE)
}

/// Directions within a cone around +z. The size is given as `one_minus_cos` of the half angle, which is accurate for
/// narrow cones.
#[inline]
pub fn cone([u, v]: [f32; 2], one_minus_cos: f32) -> Vec3 {
    let h = u * one_minus_cos; // 1 - cos(theta)
    let r = safe_sqrt(h * (2.0 - h));
    let (sin, cos) = sin_cos_turns(v);
    Vec3::new(r * cos, r * sin, 1.0 - h)
}

/// Density of [`cone`], per solid angle.
#[inline]
pub fn cone_pdf(one_minus_cos: f32) -> f32 {
    0.5 * INV_PI / one_minus_cos
}

/// Barycentric weights of the second and third corner of a triangle, uniform in its area \[Heitz19\].
#[inline]
pub fn triangle([u, v]: [f32; 2]) -> [f32; 2] {
    // Fold the square along its diagonal without crossing strata.
    if u < v {
        let x = 0.5 * u;
        [x, v - x]
    } else {
        let y = 0.5 * v;
        [u - y, y]
    }
}

/// Solid angle of the spherical triangle through three unit vectors \[VanOosterom83\].
#[inline]
pub fn solid_angle(a: Vec3, b: Vec3, c: Vec3) -> f32 {
    let volume = a.dot(b.cross(c)).abs();
    2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a)).abs()
}

/// A direction uniform in the spherical triangle through three unit vectors, given its [`solid_angle`] \[Arvo95\].
/// Its density per solid angle is one over that. `None` for a degenerate triangle.
#[inline]
pub fn spherical_triangle(
    [u, v]: [f32; 2],
    a: Vec3,
    b: Vec3,
    c: Vec3,
    solid_angle: f32,
) -> Option<Vec3> {
    // The angle at a, between the planes through the edges a b and a c.
    let (n_ab, n_ac) = (a.cross(b), a.cross(c));
    let norm = (n_ab.length_squared() * n_ac.length_squared()).sqrt();
    let cos_alpha = (n_ab.dot(n_ac) / norm).clamp(-1.0, 1.0);
    let sin_alpha = safe_sqrt(1.0 - sqr(cos_alpha));
    // Choose the sub-triangle (a, b, c') whose area is u times that of the whole: s and t are the sine and cosine of
    // its area minus alpha.
    let (sin_area, cos_area) = sin_cos_turns(u * solid_angle * (0.5 * INV_PI));
    let s = sin_area * cos_alpha - cos_area * sin_alpha;
    let t = cos_area * cos_alpha + sin_area * sin_alpha;
    let (p, q) = (t - cos_alpha, s + sin_alpha * a.dot(b));
    let denominator = (q * s + p * t) * sin_alpha;
    if denominator.abs() < 1e-20 {
        return None;
    }
    let cos_b = (((t * q - s * p) * cos_alpha - q) / denominator).clamp(-1.0, 1.0);
    // The point on the great circle from x through y.
    let toward =
        |x: Vec3, y: Vec3, cos: f32, sin: f32| x * cos + (y - x * y.dot(x)).normalize() * sin;
    let c_new = toward(a, c, cos_b, safe_sqrt(1.0 - sqr(cos_b)));
    // Choose a point of the arc from b to c'.
    let h = v * (1.0 - c_new.dot(b)); // 1 - cos
    let w = toward(b, c_new, 1.0 - h, safe_sqrt(h * (2.0 - h)));
    w.is_finite().then_some(w)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Pcg;

    #[test]
    fn the_folded_sphere_and_its_square_are_inverse() {
        for k in 0..500 {
            let p = Vec2::new((k as f32 * 0.618_034).fract(), (k as f32 + 0.5) / 500.0);
            let d = folded_sphere(p);
            assert!((d.length() - 1.0).abs() < 1e-5, "{p} {d}");
            let back = unfolded_sphere(d);
            assert!((back - p).length() < 1e-3, "{p} {d} {back}");
        }
        assert_eq!(unfolded_sphere(Vec3::Z), Vec2::splat(0.5));
    }

    #[test]
    fn the_octant_has_solid_angle_half_pi() {
        assert!((solid_angle(Vec3::X, Vec3::Y, Vec3::Z) - 0.5 * PI).abs() < 1e-6);
    }

    #[test]
    fn spherical_triangles_are_sampled_inside_and_with_the_right_centroid() {
        let mut rng = Pcg::new(5, 0);
        for case in 0..200 {
            let [a, b, c] = std::array::from_fn(|_| sphere(rng.next_2d()));
            if solid_angle(a, b, c) < 0.05 {
                continue;
            }
            // The vector area of a spherical triangle is half the sum of its edges' angles times their normals. It
            // equals the integral of the direction over the triangle.
            let edge = |p: Vec3, q: Vec3| p.cross(q).normalize() * p.dot(q).acos() * 0.5;
            let orientation = a.dot(b.cross(c)).signum();
            let expected = (edge(a, b) + edge(b, c) + edge(c, a)) * orientation;
            let n = 64;
            let mut sum = Vec3::ZERO;
            for i in 0..n * n {
                let u = [((i % n) as f32 + 0.5) / n as f32, ((i / n) as f32 + 0.5) / n as f32];
                let w =
                    spherical_triangle(u, a, b, c, solid_angle(a, b, c)).expect("not degenerate");
                for (p, q) in [(a, b), (b, c), (c, a)] {
                    assert!(w.dot(p.cross(q)) * orientation > -1e-4, "case {case}: {w} is outside");
                }
                sum += w;
            }
            let mean = sum / (n * n) as f32 * solid_angle(a, b, c);
            assert!(
                (mean - expected).length() < 5e-3 * solid_angle(a, b, c),
                "case {case}: {mean} is not {expected}"
            );
        }
    }
}
