//! The diffuse base: Burley's diffuse term with retro-reflection, its flattened form, and sheen.

use std::f32::consts::PI;

use glam::Vec3;

use super::schlick_weight;
use crate::math::{INV_PI, Rgb, safe_sqrt, sqr};

/// The diffuse base. Both directions are above.
#[derive(Clone, Copy, Debug)]
pub(super) struct Base {
    /// Colour, already multiplied by the fraction of the base.
    pub(super) color: Rgb,
    /// Colour of the sheen, already multiplied by its strength.
    pub(super) sheen: Rgb,
    pub(super) roughness: f32,
    /// Fraction of the flattened form.
    pub(super) flatness: f32,
}

/// Nodes and weights of the Gauss-Legendre rule with five points on [0, 1]: exact for the mean of the unflattened base.
const NODES: [[f32; 2]; 5] = [
    [0.046_910_077, 0.118_463_44],
    [0.230_765_34, 0.239_314_34],
    [0.5, 0.284_444_44],
    [0.769_234_66, 0.239_314_34],
    [0.953_089_9, 0.118_463_44],
];

/// The maximum of c (1 - c)^5, at c = 1/6.
const MOST_GRAZING: f32 = 0.066_98;

impl Base {
    /// f without the cosine.
    #[inline]
    pub(super) fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        let retro = self.directed_retro(wo.z, wi.z, cos_d_sq(wo, wi));
        self.diffuse_f(wo, wi) + self.color * (INV_PI * retro) + self.sheen_f(wo, wi)
    }

    /// f of the diffuse part: everything except the sheen and the directional part of the retro-reflection, which
    /// depend on direction too strongly. The constant part of the retro-reflection is included.
    #[inline]
    pub(super) fn diffuse_f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.color * (INV_PI * self.smooth(wo.z, wi.z, cos_d_sq(wo, wi)))
    }

    /// f of the sheen [Burley12, 5.3].
    #[inline]
    fn sheen_f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        if self.sheen.is_black() {
            return Rgb::BLACK;
        }
        self.sheen * schlick_weight(safe_sqrt(cos_d_sq(wo, wi)))
    }

    /// pi times [`Base::diffuse_f`], divided by the colour; `cos_d_sq` is the squared cosine of half the angle between
    /// the directions.
    #[inline]
    fn smooth(&self, cos_o: f32, cos_i: f32, cos_d_sq: f32) -> f32 {
        let (fo, fi) = (schlick_weight(cos_o), schlick_weight(cos_i));
        let retro = 2.0 * self.roughness * cos_d_sq;
        // [Burley12, 5.3; Burley15, eq. 4], without `directed_retro`.
        let diffuse = (1.0 - 0.5 * fo) * (1.0 - 0.5 * fi) + self.least_retro(cos_o) * fo;
        if self.flatness == 0.0 {
            return diffuse;
        }
        // After Hanrahan and Krueger [Burley12, 5.3].
        let ss90 = 0.5 * retro;
        let ss = (1.0 + (ss90 - 1.0) * fo) * (1.0 + (ss90 - 1.0) * fi);
        let flat = 1.25 * (ss * (1.0 / (cos_o + cos_i) - 0.5) + 0.5);
        diffuse + (flat - diffuse) * self.flatness
    }

    /// Smallest factor of the retro-reflection over all `wi` above.
    #[inline]
    fn least_retro(&self, cos_o: f32) -> f32 {
        self.roughness * (1.0 - safe_sqrt(1.0 - sqr(cos_o)))
    }

    /// The part of the retro-reflection that depends on `wi`; it is never negative.
    #[inline]
    fn directed_retro(&self, cos_o: f32, cos_i: f32, cos_d_sq: f32) -> f32 {
        let (fo, fi) = (schlick_weight(cos_o), schlick_weight(cos_i));
        let retro = 2.0 * self.roughness * cos_d_sq;
        let common = (retro - self.least_retro(cos_o)).max(0.0) * fo;
        (common + retro * fi * (1.0 + fo * (retro - 1.0))) * (1.0 - self.flatness)
    }

    /// pi times the mean of [`Base::diffuse_f`] over the cosine-weighted hemisphere of `wi`.
    pub(super) fn mean_albedo(&self, wo: Vec3) -> Rgb {
        let sin_o = safe_sqrt(1.0 - sqr(wo.z));
        let mut sum = 0.0;
        for [cos_i, weight] in NODES {
            // Two azimuths are enough for an exact mean, because the squared cosine of half the angle between the
            // directions is linear in the cosine of the azimuth.
            let across = sin_o * safe_sqrt(1.0 - sqr(cos_i)) * (0.25 * PI).cos();
            for across in [across, -across] {
                let cos_d_sq = 0.5 * (1.0 + wo.z * cos_i + across);
                sum += weight * cos_i * self.smooth(wo.z, cos_i, cos_d_sq);
            }
        }
        self.color * sum
    }

    /// Sampling weight of the base.
    pub(super) fn importance(&self) -> f32 {
        // The sheen's albedo at normal incidence is 0.01 pi times its colour, and larger at grazing angles.
        self.color.mean() + 0.2 * self.sheen.mean()
    }

    /// Upper bounds of f, and of f times the cosine, for `wi` with cosines up to `cos` and with the cosine of the angle
    /// to `wo` between `cos_between[0]` and `cos_between[1]`.
    pub(super) fn bound(&self, cos_o: f32, cos: f32, cos_between: [f32; 2]) -> [Rgb; 2] {
        let fo = schlick_weight(cos_o);
        let retro = self.roughness * (1.0 + cos_between[1]);
        // Linear in the Schlick weight of `wi`; both coefficients rise with the retro-reflection.
        let level = 1.0 - 0.5 * fo + retro * fo;
        let slope = retro * (1.0 + fo * (retro - 1.0)) - 0.5 * (1.0 - 0.5 * fo);
        let least = schlick_weight(cos);
        let f = level + slope * if slope > 0.0 { 1.0 } else { least };
        let f_cos = if slope > 0.0 {
            let grazing = if cos < 1.0 / 6.0 { cos * least } else { MOST_GRAZING };
            level * cos + slope * grazing
        } else {
            // This is largest at the largest cosine, because it falls only with the Schlick weight.
            (level + slope * least) * cos
        };
        let flat = 1.25 / (cos_o + cos);
        let mix = |diffuse: f32, flat: f32| diffuse + (flat - diffuse) * self.flatness;
        let half = safe_sqrt(0.5 * (1.0 + cos_between[0]));
        let sheen = self.sheen * schlick_weight(half);
        let color = self.color * INV_PI;
        [color * mix(f, 1.25 / cos_o) + sheen, color * mix(f_cos, flat * cos) + sheen * cos]
    }
}

/// Squared cosine of half the angle between two directions.
#[inline]
fn cos_d_sq(wo: Vec3, wi: Vec3) -> f32 {
    0.5 * (1.0 + wo.dot(wi))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::warp;

    #[test]
    fn the_mean_albedo_of_a_smooth_base_from_above_has_a_closed_form() {
        // 2 int (1 - (1 - c)^5 / 2) c dc = 1 - 1/42
        let base = Base { color: Rgb::grey(0.8), sheen: Rgb::BLACK, roughness: 0.0, flatness: 0.0 };
        assert!((base.mean_albedo(Vec3::Z).r - 0.8 * (1.0 - 1.0 / 42.0)).abs() < 1e-6);
    }

    #[test]
    fn the_mean_albedo_of_the_base_agrees_with_a_fine_grid() {
        for (roughness, flatness, tolerance) in
            [(0.0, 0.0, 5e-4), (0.5, 0.0, 5e-4), (1.0, 0.0, 5e-4), (0.7, 0.6, 4e-3)]
        {
            let base = Base { color: Rgb::grey(0.8), sheen: Rgb::BLACK, roughness, flatness };
            for wo in [Vec3::Z, Vec3::new(0.8, 0.0, 0.6), Vec3::new(0.98, 0.0, 0.199)] {
                let n = 400; // accurate to 2e-4
                let mut sum = 0.0f64;
                for i in 0..n * n {
                    let u = [((i % n) as f32 + 0.5) / n as f32, ((i / n) as f32 + 0.5) / n as f32];
                    sum += f64::from(base.diffuse_f(wo, warp::cosine_hemisphere(u)).r);
                }
                let expected = sum as f32 * PI / (n * n) as f32;
                let found = base.mean_albedo(wo).r;
                assert!(
                    (found / expected - 1.0).abs() < tolerance,
                    "{roughness} {flatness} {wo}: {found} is not {expected}"
                );
            }
        }
    }
}
