//! Microfacet distributions: density, shadowing, and sampling of the visible facets.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use crate::material::Distribution;
use crate::math::{INV_PI, safe_sqrt, sin_cos_turns, sqr};
use crate::warp;

/// Facet normals around +z with widths `alpha` along x and y. All directions are local.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Microfacets {
    distribution: Distribution,
    alpha: Vec2,
}

/// Narrower lobes are treated as mirrors.
const MIN_ALPHA: f32 = 1e-4;

impl Microfacets {
    pub(crate) fn new(distribution: Distribution, alpha: Vec2) -> Self {
        Microfacets { distribution, alpha: alpha.max(Vec2::splat(MIN_ALPHA)) }
    }

    /// Alpha along the narrower axis.
    pub(crate) fn width(&self) -> f32 {
        self.alpha.min_element()
    }

    /// Density D(m) of facet area per surface area and solid angle; zero for m below.
    #[inline]
    pub(crate) fn d(&self, m: Vec3) -> f32 {
        if m.z <= 0.0 {
            return 0.0;
        }
        let area = PI * self.alpha.x * self.alpha.y;
        let stretched = sqr(m.x / self.alpha.x) + sqr(m.y / self.alpha.y);
        let value = match self.distribution {
            Distribution::Ggx => 1.0 / (area * sqr(stretched + sqr(m.z))),
            Distribution::Beckmann => {
                let cos2 = sqr(m.z);
                (-stretched / cos2).exp() / (area * sqr(cos2))
            }
        };
        if value * m.z > 1e-20 { value } else { 0.0 }
    }

    /// Smith's shadowing of direction `w` by facets; zero if facet `m` faces away from `w`.
    #[inline]
    pub(crate) fn g1(&self, w: Vec3, m: Vec3) -> f32 {
        if w.dot(m) * w.z <= 0.0 {
            return 0.0;
        }
        let tan_alpha_sq = (sqr(w.x * self.alpha.x) + sqr(w.y * self.alpha.y)) / sqr(w.z);
        if tan_alpha_sq == 0.0 {
            return 1.0;
        }
        match self.distribution {
            Distribution::Ggx => 2.0 / (1.0 + (1.0 + tan_alpha_sq).sqrt()),
            // Like other renderers, use the rational fit to Smith's integral [Walter07, eq. 27]; it is accurate to 0.35
            // %.
            Distribution::Beckmann => {
                let a = 1.0 / tan_alpha_sq.sqrt();
                if a >= 1.6 {
                    1.0
                } else {
                    (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a)
                }
            }
        }
    }

    /// Upper bound of [`Microfacets::d`] over unnormalised facet normals in a ball; normals of either sign count.
    #[inline]
    pub(crate) fn d_bound(&self, center: Vec3, radius: f32) -> f32 {
        let (low, high) = (self.alpha.min_element(), self.alpha.max_element());
        let mut stretched = sqr(least_tangent(center, radius) / high);
        if low < high {
            // The same for each axis separately, with the width of that axis.
            let across = ((center.truncate().abs() - radius).max(Vec2::ZERO)) / self.alpha;
            stretched = stretched.max(across.length_squared() / sqr(center.z.abs() + radius));
        }
        // With q as the squared stretched tangent, 1 / cos^2 is at most 1 + q alpha^2.
        let (area, a) = (PI * self.alpha.x * self.alpha.y, sqr(high));
        match self.distribution {
            Distribution::Ggx if a < 1.0 => sqr((1.0 + a * stretched) / (1.0 + stretched)) / area,
            Distribution::Ggx => sqr(a) / area,
            Distribution::Beckmann => {
                let q = stretched.max(2.0 - 1.0 / a);
                (-q).exp() * sqr(1.0 + a * q) / area
            }
        }
    }

    /// [`Microfacets::g1`] for a facet that is visible from `w`.
    #[inline]
    pub(crate) fn g1_seen(&self, w: Vec3) -> f32 {
        self.g1(w, Vec3::Z)
    }

    /// Upper bounds of G1, and of G1 over the cosine, for directions whose cosine is at most `cos`.
    #[inline]
    pub(crate) fn g1_bounds(&self, cos: f32) -> [f32; 2] {
        let (low, high) = (self.alpha.min_element(), self.alpha.max_element());
        let g1 = match cos {
            c if c <= 0.0 => 0.0,
            c => {
                let grazing = Vec3::new(safe_sqrt(1.0 - c * c) * low / self.alpha.x, 0.0, c);
                self.g1_seen(grazing)
            }
        };
        // Toward grazing directions, G1 falls in proportion to the cosine. The slope there, which differs between the
        // models, is the largest.
        let slope = match self.distribution {
            Distribution::Ggx => 2.0 / low.min(1.0),
            Distribution::Beckmann => 3.535 / low * (1.0 + 2.56 * sqr(high)).sqrt(),
        };
        [g1, slope]
    }

    /// Shadowing and masking, uncorrelated.
    #[inline]
    pub(crate) fn g(&self, wo: Vec3, wi: Vec3, m: Vec3) -> f32 {
        self.g1(wo, m) * self.g1(wi, m)
    }

    /// Density per solid angle of the facets that are visible from `wo` (above).
    #[inline]
    pub(crate) fn visible_pdf(&self, wo: Vec3, m: Vec3) -> f32 {
        self.d(m) * self.g1(wo, m) * wo.dot(m).abs() / wo.z
    }

    /// Sample a facet that is visible from `wo` (above).
    #[inline]
    pub(crate) fn sample_visible(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        let stretched = Vec3::new(wo.x * self.alpha.x, wo.y * self.alpha.y, wo.z).normalize();
        match self.distribution {
            Distribution::Ggx => {
                let m = visible_hemisphere(stretched, u);
                Vec3::new(m.x * self.alpha.x, m.y * self.alpha.y, m.z.max(1e-6)).normalize()
            }
            Distribution::Beckmann => {
                // Slopes of the unit distribution in the plane of incidence and perpendicular to it, rotated and
                // stretched back.
                let sin = safe_sqrt(1.0 - sqr(stretched.z));
                let slope = beckmann_slopes(stretched.z, sin, u);
                let (cos_phi, sin_phi) =
                    if sin > 1e-7 { (stretched.x / sin, stretched.y / sin) } else { (1.0, 0.0) };
                let x = cos_phi * slope.x - sin_phi * slope.y;
                let y = sin_phi * slope.x + cos_phi * slope.y;
                Vec3::new(-x * self.alpha.x, -y * self.alpha.y, 1.0).normalize()
            }
        }
    }
}

/// Smallest tangent of the angle between the z axis, of either sign, and a vector in a ball: that of the angle to the
/// centre minus the half angle of the cone around the ball.
#[inline]
pub(super) fn least_tangent(center: Vec3, radius: f32) -> f32 {
    let length = center.length();
    if radius >= length {
        return 0.0;
    }
    let (sin_cone, sin, cos) =
        (radius / length, center.truncate().length() / length, center.z.abs() / length);
    let cos_cone = safe_sqrt(1.0 - sqr(sin_cone));
    let sin_least = sin * cos_cone - cos * sin_cone;
    if sin_least > 0.0 { sin_least / (cos * cos_cone + sin * sin_cone) } else { 0.0 }
}

/// Sample the visible part of the unit hemisphere of normals: the half disk that is visible from `v`, by warping a disk
/// \[Heitz18\].
#[inline]
fn visible_hemisphere(v: Vec3, u: [f32; 2]) -> Vec3 {
    let across = v.x * v.x + v.y * v.y;
    let t1 = if across > 0.0 { Vec3::new(-v.y, v.x, 0.0) / across.sqrt() } else { Vec3::X };
    let t2 = v.cross(t1);
    let p = warp::disk(u);
    let s = 0.5 * (1.0 + v.z);
    let y = (1.0 - s) * safe_sqrt(1.0 - p.x * p.x) + s * p.y;
    t1 * p.x + t2 * y + v * safe_sqrt(1.0 - p.x * p.x - y * y)
}

/// Slopes of a Beckmann surface of unit width seen at an angle with the given cosine and sine [Heitz14, app. A].
/// The slope along the plane of incidence has the distribution function
/// (1 + erf(x) + tan(theta) exp(-x^2) / sqrt(pi)) / (the same at cot(theta)) on (-inf, cot(theta)].
fn beckmann_slopes(cos: f32, sin: f32, u: [f32; 2]) -> Vec2 {
    let across = erf_inv(2.0 * u[1].clamp(1e-6, 1.0 - 1e-6) - 1.0);
    if sin < 1e-4 {
        // At normal incidence, all facets are equally visible.
        let r = (-(1.0 - u[0]).max(1e-20).ln()).sqrt();
        let (s, c) = sin_cos_turns(u[1]);
        return Vec2::new(r * c, r * s);
    }
    let (tan, cot) = (sin / cos.max(1e-6), cos / sin);
    let inv_sqrt_pi = INV_PI.sqrt();
    let unnormalised = |b: f32, x: f32| 1.0 + b + tan * inv_sqrt_pi * (-x * x).exp();
    let erf_cot = erf(cot);
    let target = u[0].clamp(1e-6, 1.0 - 1e-6) * unnormalised(erf_cot, cot);
    // Newton's method in b = erf(x), limited to a shrinking interval; the derivative by b is 1 - x tan.
    let (mut low, mut high) = (-1.0f32, erf_cot);
    let mut b = low + (high - low) * u[0];
    let mut x = erf_inv(b);
    for _ in 0..24 {
        let error = unnormalised(b, x) - target;
        if error.abs() < 2e-6 {
            break;
        }
        if error > 0.0 {
            high = b
        } else {
            low = b
        }
        let newton = b - error / (1.0 - x * tan);
        b = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        x = erf_inv(b);
    }
    Vec2::new(x, across)
}

/// The error function, to 1.5e-7 [Abramowitz64, 7.1.26].
fn erf(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs());
    let poly = ((((1.061_405_4 * t - 1.453_152_1) * t + 1.421_413_8) * t - 0.284_496_74) * t
        + 0.254_829_6)
        * t;
    (1.0 - poly * (-x * x).exp()).copysign(x)
}

/// Inverse of the error function in single precision \[Giles12\].
fn erf_inv(x: f32) -> f32 {
    let w = -((1.0 - x) * (1.0 + x)).max(1e-30).ln();
    let horner = |w: f32, c: [f32; 9]| c.into_iter().reduce(|p, c| p * w + c).unwrap_or(0.0);
    let p = if w < 5.0 {
        let c = [
            2.810_226_4e-8,
            3.432_739_4e-7,
            -3.523_387_7e-6,
            -4.391_506_5e-6,
            0.000_218_580_87,
            -0.001_253_725,
            -0.004_177_681_6,
            0.246_640_73,
            1.501_409_4,
        ];
        horner(w - 2.5, c)
    } else {
        let c = [
            -0.000_200_214_26,
            0.000_100_950_56,
            0.001_349_343_2,
            -0.003_673_428_4,
            0.005_739_507_7,
            -0.007_622_461_3,
            0.009_438_870_5,
            1.001_674,
            2.832_976_8,
        ];
        horner(w.sqrt() - 3.0, c)
    };
    p * x
}

#[cfg(test)]
mod tests;
