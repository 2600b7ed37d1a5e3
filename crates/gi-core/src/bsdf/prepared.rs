//! Prepared materials: values that depend on the material alone, and simpler materials at the ends of parameter ranges.

use glam::Vec2;

use super::microfacet::Microfacets;
use super::principled::{Solid, Thin};
use super::{Coat, Lobe};
use crate::material::{Material, Roughness};
use crate::math::sqr;
use crate::texture::Texture;

/// A material, and values that depend on it alone.
#[derive(Clone, Debug)]
pub(crate) struct PreparedMaterial {
    pub(crate) material: Material,
    pub(super) coat: Option<Coat>,
    /// Whether any light passes straight through.
    pub(crate) has_null: bool,
    /// Whether a delta lobe scatters light.
    pub(crate) has_delta: bool,
    /// Whether light is refracted, and none passes straight through.
    pub(crate) refracts: bool,
    /// Whether the lobes depend on the directions of the texture coordinates.
    pub(super) needs_tangents: bool,
}

impl PreparedMaterial {
    /// Prepare `material`; its children are in `before`.
    pub(crate) fn new(material: Material, before: &[PreparedMaterial]) -> Self {
        let material = at_the_ends(material);
        let coat = match &material {
            Material::Plastic { eta, nonlinear, roughness, .. } => {
                let rough = roughness.as_ref().map(|r| (r.distribution, r.alpha_u.mean().mean()));
                Some(Coat::new(*eta, *nonlinear, rough))
            }
            _ => None,
        };
        let children: Vec<&PreparedMaterial> =
            material.children().into_iter().map(|c| &before[c]).collect();
        let has_null = matches!(
            material,
            Material::Null | Material::Mask { .. } | Material::ThinDielectric { .. }
        );
        let has_null = has_null || children.iter().any(|c| c.has_null);
        let refracts = match &material {
            Material::Dielectric { .. } => true,
            Material::Principled(p) => !p.spec_trans.is_black(),
            _ => false,
        };
        let bends = matches!(material, Material::Bump { .. } | Material::NormalMap { .. });
        PreparedMaterial {
            coat,
            has_null,
            refracts: !has_null && (refracts || children.iter().any(|c| c.refracts)),
            has_delta: has_delta(&material) || children.iter().any(|c| c.has_delta),
            needs_tangents: bends || is_anisotropic(&material),
            material,
        }
    }

    /// The lobe at texture coordinates `uv`; `None` for a material that has children.
    #[inline]
    pub(crate) fn lobe_at(&self, uv: Vec2) -> Option<Lobe<'_>> {
        let facets = |r: &Roughness| {
            Microfacets::new(r.distribution, Vec2::new(r.alpha_u.scalar(uv), r.alpha_v.scalar(uv)))
        };
        Some(match &self.material {
            Material::Diffuse { reflectance } => Lobe::Diffuse { albedo: reflectance.eval(uv) },
            Material::RoughDiffuse { reflectance, alpha } => Lobe::OrenNayar {
                albedo: reflectance.eval(uv),
                sigma_sq: sqr(alpha.scalar(uv)) * 0.5,
            },
            Material::Conductor { eta, k, reflectance, roughness } => {
                let (eta, k, tint) = (*eta, *k, reflectance.eval(uv));
                match roughness {
                    None => Lobe::Conductor { eta, k, tint },
                    Some(r) => Lobe::RoughConductor { eta, k, tint, facets: facets(r) },
                }
            }
            Material::Dielectric { eta, reflectance, transmittance, roughness } => {
                let (eta, reflect, transmit) = (*eta, reflectance.eval(uv), transmittance.eval(uv));
                match roughness {
                    None => Lobe::Dielectric { eta, reflect, transmit },
                    Some(r) => Lobe::RoughDielectric { eta, reflect, transmit, facets: facets(r) },
                }
            }
            Material::ThinDielectric { eta, reflectance, transmittance } => Lobe::ThinDielectric {
                eta: *eta,
                reflect: reflectance.eval(uv),
                transmit: transmittance.eval(uv),
            },
            Material::Plastic { diffuse, specular, .. } => Lobe::Plastic {
                coat: self.coat.as_ref()?,
                diffuse: diffuse.eval(uv),
                specular: specular.eval(uv),
            },
            Material::Phong { diffuse, specular, exponent } => Lobe::Phong {
                diffuse: diffuse.eval(uv),
                specular: specular.eval(uv),
                exponent: exponent.scalar(uv).max(0.0),
            },
            Material::Principled(p) => Lobe::Principled(Solid::at(p, uv)),
            Material::PrincipledThin(p) => Lobe::PrincipledThin(Thin::at(p, uv)),
            Material::Null => Lobe::Null,
            Material::Mask { .. }
            | Material::TwoSided { .. }
            | Material::Blend { .. }
            | Material::Bump { .. }
            | Material::NormalMap { .. } => return None,
        })
    }
}

/// A relative index of refraction this close to 1 has no visible effect, and half vectors of a rough interface lose all
/// precision.
const SAME_INDEX: f32 = 1e-4;
/// Facets with a smaller alpha reflect like a mirror. Only BSDF sampling could find light in such a lobe.
const SMOOTH: f32 = 1e-3;

/// Simplify a material at the end of a parameter range: an interface between equal indices lets light pass straight
/// through, and facets without width are a smooth surface.
fn at_the_ends(mut material: Material) -> Material {
    let smooth = |r: &mut Roughness| {
        let narrow = |t: &Texture| matches!(t, Texture::Constant(a) if a.mean() < SMOOTH);
        narrow(&r.alpha_u) && narrow(&r.alpha_v)
    };
    match &mut material {
        Material::Conductor { roughness, .. }
        | Material::Dielectric { roughness, .. }
        | Material::Plastic { roughness, .. } => {
            roughness.take_if(smooth);
        }
        _ => {}
    }
    match material {
        Material::Dielectric { eta, reflectance, transmittance, .. }
            if (eta - 1.0).abs() < SAME_INDEX =>
        {
            Material::ThinDielectric { eta: 1.0, reflectance, transmittance }
        }
        other => other,
    }
}

/// Whether the material itself, without its children, has a delta lobe that does more than pass light straight through.
fn has_delta(material: &Material) -> bool {
    match material {
        Material::Conductor { roughness: None, .. }
        | Material::Dielectric { roughness: None, .. }
        | Material::Plastic { roughness: None, .. } => true,
        Material::ThinDielectric { eta, .. } => *eta != 1.0,
        _ => false,
    }
}

/// Whether every child comes before its parent, as [`Material`] requires.
pub(crate) fn check_children(materials: &[Material]) -> bool {
    materials.iter().enumerate().all(|(k, m)| m.children().into_iter().all(|c| c < k))
}

/// Maximum number of lobes at a point, for each material. Materials may share children, so each is counted once.
pub(crate) fn component_counts(materials: &[Material]) -> Vec<usize> {
    let mut counts: Vec<usize> = Vec::with_capacity(materials.len());
    for material in materials {
        counts.push(match material {
            Material::Mask { inner, .. } => counts[*inner].saturating_add(1),
            Material::Bump { inner, .. } | Material::NormalMap { inner, .. } => counts[*inner],
            Material::TwoSided { front, back } => counts[*front].max(counts[*back]),
            Material::Blend { first, second, .. } => counts[*first].saturating_add(counts[*second]),
            _ => 1,
        });
    }
    counts
}

/// Whether the facets are anisotropic.
fn is_anisotropic(material: &Material) -> bool {
    let differ = |r: &Roughness| match (&r.alpha_u, &r.alpha_v) {
        (Texture::Constant(u), Texture::Constant(v)) => u != v,
        _ => true,
    };
    match material {
        Material::Conductor { roughness, .. } | Material::Dielectric { roughness, .. } => {
            roughness.as_ref().is_some_and(differ)
        }
        Material::Principled(p) => !p.anisotropic.is_black(),
        Material::PrincipledThin(p) => !p.anisotropic.is_black(),
        _ => false,
    }
}
