//! Reflection at smooth interfaces.

use glam::Vec3;

use crate::math::{Rgb, safe_sqrt, sqr};

/// Reflection and refraction of light that hits a dielectric interface at some angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interface {
    /// Fraction of the power that is reflected.
    pub(crate) reflectance: f32,
    /// Cosine of the refracted direction, with the sign opposite to that of the incident one; 0 for total reflection.
    pub(crate) cos_t: f32,
    /// Index behind the interface over index in front, for the incident direction.
    pub(crate) eta: f32,
}

/// Fresnel's equations for unpolarised light. `cos_i` is signed: it is negative for light from the inside. `eta` is the
/// index inside over the index outside.
#[inline]
pub(crate) fn dielectric(cos_i: f32, eta: f32) -> Interface {
    let eta = if cos_i >= 0.0 { eta } else { 1.0 / eta };
    let cos_t_sq = 1.0 - (1.0 - sqr(cos_i)) / sqr(eta);
    if cos_t_sq <= 0.0 {
        return Interface { reflectance: 1.0, cos_t: 0.0, eta };
    }
    let (ci, ct) = (cos_i.abs(), cos_t_sq.sqrt());
    let s = (ci - eta * ct) / (ci + eta * ct);
    let p = (eta * ci - ct) / (eta * ci + ct);
    Interface { reflectance: 0.5 * (s * s + p * p), cos_t: -ct.copysign(cos_i), eta }
}

/// Fresnel's equations for a metal with complex index `eta + i k`, `cos_i` in [0, 1].
#[inline]
pub(crate) fn conductor(cos_i: f32, eta: Rgb, k: Rgb) -> Rgb {
    let cos2 = sqr(cos_i);
    let sin2 = 1.0 - cos2;
    eta.zip(k, |eta, k| {
        let t0 = eta * eta - k * k - sin2;
        let a2_b2 = (t0 * t0 + 4.0 * eta * eta * k * k).sqrt();
        let a = safe_sqrt(0.5 * (a2_b2 + t0));
        let (t1, t2) = (a2_b2 + cos2, 2.0 * a * cos_i);
        let s = (t1 - t2) / (t1 + t2);
        let (t3, t4) = (a2_b2 * cos2 + sqr(sin2), t2 * sin2);
        0.5 * s * (1.0 + (t3 - t4) / (t3 + t4))
    })
}

/// Upper bound of [`conductor`] for cosines from `cos_i` to 1. Toward grazing angles, the s-polarised reflectance only
/// rises; the p-polarised one falls to a single minimum and then rises to 1, so it is largest at one end.
pub(crate) fn conductor_bound(cos_i: f32, eta: Rgb, k: Rgb) -> Rgb {
    let [s, p] = conductor_polarised(cos_i, eta, k);
    let normal = conductor(1.0, eta, k);
    (s + p.zip(normal, f32::max)) * 0.5
}

/// Fresnel's equations for a metal, s and p polarised.
fn conductor_polarised(cos_i: f32, eta: Rgb, k: Rgb) -> [Rgb; 2] {
    let (cos2, sin2) = (sqr(cos_i), 1.0 - sqr(cos_i));
    let s = eta.zip(k, |eta, k| {
        let t0 = eta * eta - k * k - sin2;
        let a2_b2 = (t0 * t0 + 4.0 * eta * eta * k * k).sqrt();
        let t2 = 2.0 * safe_sqrt(0.5 * (a2_b2 + t0)) * cos_i;
        (a2_b2 + cos2 - t2) / (a2_b2 + cos2 + t2)
    });
    let unpolarised = conductor(cos_i, eta, k);
    [s, unpolarised * 2.0 - s]
}

/// Reflectance of a smooth dielectric under uniform light, 2 int F(c) c dc; `eta` is the index behind the surface over
/// that in front, where the light comes from.
pub fn dielectric_hemispherical(eta: f32) -> f32 {
    const N: usize = 4096; // midpoint rule; the kink at the critical angle costs less than 1e-6
    let f = |i: usize| {
        let c = (i as f32 + 0.5) / N as f32;
        dielectric(c, eta).reflectance * c
    };
    2.0 * (0..N).map(f).sum::<f32>() / N as f32
}

/// Mirror `w` about the z axis.
#[inline]
pub(crate) fn reflect_z(w: Vec3) -> Vec3 {
    Vec3::new(-w.x, -w.y, w.z)
}

/// Mirror `w` about `m`.
#[inline]
pub(crate) fn reflect(w: Vec3, m: Vec3) -> Vec3 {
    m * (2.0 * w.dot(m)) - w
}

/// Refract `w` at a facet with normal `m`; `interface` is the result of [`dielectric`] for `w . m`.
#[inline]
pub(crate) fn refract(w: Vec3, m: Vec3, interface: Interface) -> Vec3 {
    let scale = 1.0 / interface.eta;
    m * (w.dot(m) * scale + interface.cos_t) - w * scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_incidence_and_the_critical_angle() {
        assert!((dielectric(1.0, 1.5).reflectance - 0.04).abs() < 1e-6);
        assert!((dielectric(-1.0, 1.5).reflectance - 0.04).abs() < 1e-6);
        let critical = (1.0 - sqr(1.0 / 1.5f32)).sqrt();
        assert_eq!(dielectric(-critical + 1e-3, 1.5).reflectance, 1.0);
        assert!(dielectric(-critical - 1e-3, 1.5).reflectance < 1.0);
        let mirror = conductor(0.3, Rgb::BLACK, Rgb::WHITE);
        assert!((mirror.r - 1.0).abs() < 1e-6, "eta = 0, k = 1 reflects all: {mirror:?}");
    }

    #[test]
    fn refraction_obeys_snell_both_ways() {
        for (cos, side) in [(0.9f32, 1.0f32), (0.3, 1.0), (0.9, -1.0)] {
            let w = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos * side);
            let i = dielectric(w.z, 1.5);
            let t = refract(w, Vec3::Z, i);
            assert!((t.length() - 1.0).abs() < 1e-5);
            assert!((t.x + w.x / i.eta).abs() < 1e-6, "sines in the ratio of the indices");
            assert!(t.z * w.z < 0.0);
        }
    }

    #[test]
    fn hemispherical_reflectance_matches_the_published_value() {
        // Internal diffuse reflectance of index 1.5: 0.596 [Egan73].
        assert!((dielectric_hemispherical(1.0 / 1.5) - 0.596).abs() < 1e-3);
        assert!((dielectric_hemispherical(1.5) - 0.0918).abs() < 1e-3);
    }
}
