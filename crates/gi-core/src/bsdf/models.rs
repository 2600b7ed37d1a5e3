//! The formulas of single lobes: panes, dielectrics, Oren-Nayar, Phong and rough dielectrics. Directions are local.

use glam::Vec3;

use super::fresnel::{self, reflect, reflect_z, refract};
use super::microfacet::Microfacets;
use super::principled::Drawn;
use super::{Scatter, Transport};
use crate::math::{Frame, Rgb, sqr};
use crate::warp;

/// Reflectance of a pane: both interfaces, with all internal reflections.
#[inline]
pub(super) fn thin_reflectance(wo: Vec3, eta: f32) -> f32 {
    let r = fresnel::dielectric(wo.z.abs(), eta).reflectance;
    2.0 * r / (1.0 + r)
}

pub(super) fn sample_dielectric(
    wo: Vec3,
    u: f32,
    eta: f32,
    reflect: Rgb,
    transmit: Rgb,
    transport: Transport,
) -> Option<Scatter> {
    let interface = fresnel::dielectric(wo.z, eta);
    if u < interface.reflectance {
        return Some(Scatter::delta(reflect_z(wo), reflect, interface.reflectance));
    }
    let wi = refract(wo, Vec3::Z, interface);
    let weight = transmit * transport.refraction(interface.eta);
    let refracted =
        Scatter { eta: interface.eta, ..Scatter::delta(wi, weight, 1.0 - interface.reflectance) };
    (wi.z * wo.z < 0.0).then_some(refracted)
}

/// The term of Oren-Nayar's model that does not depend on directions.
pub(super) fn oren_nayar_constant(sigma_sq: f32) -> f32 {
    1.0 - 0.5 * sigma_sq / (sigma_sq + 0.33)
}

/// The factors A and B of Oren-Nayar's model.
pub(super) fn oren_nayar_factors(sigma_sq: f32) -> [f32; 2] {
    [oren_nayar_constant(sigma_sq), 0.45 * sigma_sq / (sigma_sq + 0.09)]
}

/// Oren-Nayar's qualitative model, relative to Lambert's.
pub(super) fn oren_nayar(wo: Vec3, wi: Vec3, sigma_sq: f32) -> f32 {
    let (sin_o, sin_i) = ((1.0 - sqr(wo.z)).max(0.0).sqrt(), (1.0 - sqr(wi.z)).max(0.0).sqrt());
    let cos_delta = if sin_o > 1e-6 && sin_i > 1e-6 {
        (wo.x * wi.x + wo.y * wi.y) / (sin_o * sin_i)
    } else {
        0.0
    };
    let [a, b] = oren_nayar_factors(sigma_sq);
    // sin(larger angle) tan(smaller angle)
    let (sin_tan, cos) = (sin_o * sin_i, wo.z.max(wi.z));
    a + b * cos_delta.max(0.0) * sin_tan / cos
}

/// Sample a direction of the Phong lobe, around the mirror direction of `wo`.
pub(super) fn sample_phong(wo: Vec3, u: [f32; 2], exponent: f32) -> Vec3 {
    let cos = u[0].max(1e-20).powf(1.0 / (exponent + 1.0));
    let local = warp::cone([1.0, u[1]], 1.0 - cos);
    Frame::from_normal(reflect_z(wo)).to_world(local)
}

/// Fraction of samples for the lobe.
#[inline]
pub(super) fn phong_share(diffuse: Rgb, specular: Rgb) -> f32 {
    let (d, s) = (diffuse.mean(), specular.mean());
    if d + s > 0.0 { s / (d + s) } else { 0.0 }
}

/// Normal of the facet that scatters `wo` to `wi`, on the upper side, and the index of refraction as `wo` sees it.
/// `None` if there is no such facet.
#[inline]
pub(super) fn generalized_half(wo: Vec3, wi: Vec3, eta: f32) -> Option<(Vec3, f32)> {
    if wo.z == 0.0 || wi.z == 0.0 {
        return None;
    }
    let eta = if wo.z > 0.0 { eta } else { 1.0 / eta };
    let m = if wo.z * wi.z > 0.0 { wo + wi } else { wo + wi * eta }.try_normalize()?;
    let m = m * 1f32.copysign(m.z);
    (wo.dot(m) * wo.z > 0.0 && wi.dot(m) * wi.z > 0.0).then_some((m, eta))
}

/// Reflect or refract `wo` at a visible facet. `None` if the facet sends the light to the wrong side of the surface:
/// Smith's model counts it as lost.
pub(super) fn sample_rough_dielectric(
    wo: Vec3,
    u_choice: f32,
    u: [f32; 2],
    eta: f32,
    facets: &Microfacets,
) -> Option<Drawn> {
    let m = facets.sample_visible(wo * 1f32.copysign(wo.z), u);
    let interface = fresnel::dielectric(wo.dot(m), eta);
    let reflected = u_choice < interface.reflectance;
    let wi = if reflected { reflect(wo, m) } else { refract(wo, m, interface) };
    let eta = if reflected { 1.0 } else { interface.eta };
    (reflected == (wi.z * wo.z > 0.0)).then_some(Drawn { wi, eta })
}

/// f of a rough dielectric [Walter07, eqs. 20 and 21].
pub(super) fn rough_dielectric_f(
    wo: Vec3,
    wi: Vec3,
    eta: f32,
    reflect: Rgb,
    transmit: Rgb,
    facets: &Microfacets,
    transport: Transport,
) -> Rgb {
    let Some((m, eta_seen)) = generalized_half(wo, wi, eta) else { return Rgb::BLACK };
    let fresnel = fresnel::dielectric(wo.dot(m), eta).reflectance;
    let dg = facets.d(m) * facets.g(wo, wi, m) / (wo.z * wi.z).abs();
    if wo.z * wi.z > 0.0 {
        return reflect * (0.25 * fresnel * dg);
    }
    let (o, i) = (wo.dot(m), wi.dot(m));
    let jacobian = sqr(eta_seen) * (o * i).abs() / sqr(o + eta_seen * i);
    transmit * ((1.0 - fresnel) * dg * jacobian * transport.refraction(eta_seen))
}

/// Density of a rough dielectric [Walter07, eqs. 14 and 17].
pub(super) fn rough_dielectric_pdf(wo: Vec3, wi: Vec3, eta: f32, facets: &Microfacets) -> f32 {
    let Some((m, eta_seen)) = generalized_half(wo, wi, eta) else { return 0.0 };
    let fresnel = fresnel::dielectric(wo.dot(m), eta).reflectance;
    let visible = facets.visible_pdf(wo * 1f32.copysign(wo.z), m);
    let (o, i) = (wo.dot(m), wi.dot(m));
    if wo.z * wi.z > 0.0 {
        visible * fresnel / (4.0 * i.abs())
    } else {
        visible * (1.0 - fresnel) * sqr(eta_seen) * i.abs() / sqr(o + eta_seen * i)
    }
}
