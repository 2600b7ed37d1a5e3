//! How far light spreads in a solid before it leaves \[Jensen01b\].

use std::f32::consts::PI;
use std::sync::LazyLock;

use gi_core::bsdf::dielectric_hemispherical;
use gi_core::math::Rgb;
use gi_core::medium::Medium;

/// The field of two point sources over a half-space: a real one a mean free path z_r below the surface, and a virtual one z_v above
/// it that keeps the diffused light from coming back in (but for what the surface reflects inward).
#[derive(Clone, Copy, Debug)]
pub(super) struct Dipole {
    /// alpha' / 4 pi.
    share: Rgb,
    /// Depth of the real source, world units.
    z_r: Rgb,
    /// Height of the virtual one, world units.
    z_v: Rgb,
    /// Effective extinction, sqrt(3 sigma_a sigma_t'), one over world units.
    sigma_tr: Rgb,
    /// Share of diffused light that the surface lets out.
    lets_out: f32,
}

impl Dipole {
    /// The dipole of a medium; `eta` is its index relative to the outside.
    pub(super) fn new(medium: &Medium, eta: f32) -> Self {
        let sigma_s = medium.sigma_s();
        let sigma_a = medium.sigma_t - sigma_s;
        // Similarity: forward-peaked scattering acts like less isotropic scattering.
        let scattered = sigma_s * (1.0 - medium.phase.mean_cosine());
        let extinct = sigma_a + scattered;
        // Without extinction nothing is scattered; any depth works.
        let z_r = extinct.map(|s| if s > 0.0 { 1.0 / s } else { 1.0 });
        let reflected = internal_reflectance(eta);
        let a = (1.0 + reflected) / (1.0 - reflected);
        Dipole {
            share: scattered * z_r * (0.25 / PI),
            z_r,
            z_v: z_r * (1.0 + 4.0 / 3.0 * a),
            sigma_tr: (sigma_a * extinct * 3.0).map(f32::sqrt),
            lets_out: 1.0 - reflected,
        }
    }

    /// R_d: exitance per unit of power, at squared distance `r_sq` from its point of entry (world units).
    #[inline]
    pub(super) fn reflectance(&self, r_sq: f32) -> Rgb {
        let source = |z: f32, sigma: f32| {
            let d_sq = z * z + r_sq;
            let x = sigma * d_sq.sqrt();
            z * (1.0 + x) * (-x).exp() / (d_sq * d_sq.sqrt())
        };
        self.share * (self.z_r.zip(self.sigma_tr, source) + self.z_v.zip(self.sigma_tr, source))
    }

    /// Isotropic radiance L just inside the surface that causes `exitance`. Of the irradiance pi L from inside, the part that is not
    /// reflected leaves.
    #[inline]
    pub(super) fn radiance_inside(&self, exitance: Rgb) -> Rgb {
        exitance / (PI * self.lets_out)
    }
}

/// Steps of the table of internal reflectances, and the logarithm of the index at its end, as far below 1 as above.
const STEPS: usize = 512;
const LARGEST: f32 = 1.4;

/// Share of diffuse light that the surface of a body reflects inward, whose index is `eta` times that outside.
fn internal_reflectance(eta: f32) -> f32 {
    static TABLE: LazyLock<[f32; STEPS + 1]> = LazyLock::new(|| {
        let index = |k: usize| ((2.0 * k as f32 / STEPS as f32 - 1.0) * LARGEST).exp();
        std::array::from_fn(|k| dielectric_hemispherical(1.0 / index(k)))
    });
    let x = (0.5 + 0.5 * eta.ln() / LARGEST) * STEPS as f32;
    let x = x.clamp(0.0, STEPS as f32 - 1e-3);
    let (k, f) = (x as usize, x.fract());
    TABLE[k] + (TABLE[k + 1] - TABLE[k]) * f
}

#[cfg(test)]
mod tests {
    use super::*;
    use gi_core::medium::Phase;

    fn media() -> [Medium; 3] {
        let phase = Phase::HenyeyGreenstein { g: 0.8 };
        [
            Medium::homogeneous(
                Rgb::new(11.0, 12.5, 14.0),
                Rgb::new(0.997, 0.99, 0.9),
                Phase::Isotropic,
            ),
            Medium::homogeneous(Rgb::new(1.0, 20.0, 300.0), Rgb::new(0.5, 1.0, 0.0), phase),
            Medium::homogeneous(Rgb::BLACK, Rgb::WHITE, phase),
        ]
    }

    #[test]
    fn over_a_plane_it_adds_up_to_the_published_total() {
        // alpha' / 2 (1 + exp(-4/3 A s)) exp(-s), s = sqrt(3 (1 - alpha')) [Jensen01b, eq. 15 in Jensen02].
        for medium in media() {
            for eta in [0.9, 1.0, 1.3, 1.5] {
                let dipole = Dipole::new(&medium, eta);
                for c in 0..3 {
                    let sigma_t = medium.sigma_t.to_array()[c];
                    if sigma_t == 0.0 {
                        assert_eq!(dipole.reflectance(1.0).to_array()[c], 0.0);
                        continue;
                    }
                    let g = medium.phase.mean_cosine();
                    let albedo = f64::from(medium.albedo.to_array()[c]);
                    let scattered = albedo * f64::from(1.0 - g);
                    let alpha = scattered / (scattered + 1.0 - albedo);
                    let f = f64::from(dielectric_hemispherical(1.0 / eta));
                    let (a, s) = ((1.0 + f) / (1.0 - f), (3.0 * (1.0 - alpha)).sqrt());
                    let expected = 0.5 * alpha * (1.0 + (-4.0 / 3.0 * a * s).exp()) * (-s).exp();
                    // Logarithmic rings; beyond the last lies 1 / 3000 of what is not absorbed before.
                    let z = f64::from(1.0 / sigma_t) * (1.0 / f64::from(1.0 - g)).min(50.0);
                    let (mut sum, n) = (0.0, 4000);
                    for k in 0..n {
                        let at = |k: f64| z * 1e-4 * (k / f64::from(n) * 18.5).exp();
                        let (r0, r1) = (at(f64::from(k)), at(f64::from(k + 1)));
                        let r = (r0 * r1).sqrt();
                        let rd = dipole.reflectance((r * r) as f32).to_array()[c];
                        sum += f64::from(rd) * std::f64::consts::PI * (r1 * r1 - r0 * r0);
                    }
                    assert!(
                        (sum - expected).abs() < 2e-3 * expected + 1e-9,
                        "{medium:?}, eta {eta}, channel {c}: {sum} is not {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_table_of_internal_reflectances_is_what_it_stands_for() {
        for eta in [0.25, 0.6, 0.9, 0.999, 1.0, 1.003, 1.1, 1.35, 1.5, 2.4, 4.0] {
            let (found, exact) = (internal_reflectance(eta), dielectric_hemispherical(1.0 / eta));
            assert!((found - exact).abs() < 2e-4, "{eta}: {found} is not {exact}");
        }
    }

    #[test]
    fn what_leaves_is_what_the_surface_lets_out_of_the_radiance_inside() {
        // 1 - F_out = eta^2 (1 - F_in): the squeezed radiance that leaves has the exitance that was asked for.
        let eta = 1.5;
        let dipole = Dipole::new(&media()[0], eta);
        let inside = dipole.radiance_inside(Rgb::WHITE).r;
        let leaves = PI * inside / (eta * eta) * (1.0 - dielectric_hemispherical(eta));
        assert!((leaves - 1.0).abs() < 1e-3, "{leaves}");
    }
}
