//! The diffuse part of a BSDF, for techniques that know only irradiance.

use glam::Vec3;

use super::component::Component;
use super::lobe::Lobe;
use super::{Bsdf, Parts};
use crate::math::Rgb;

/// The diffuse part of a BSDF for one `wo`. Its radiance depends on irradiance only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffusePart {
    /// Its albedo: pi times its f, or the mean of that over the cosine-weighted hemisphere.
    pub albedo: Rgb,
    /// Unit normal of its cosine, on the side of `wo`.
    pub normal: Vec3,
}

/// (whole - part) / whole, or zero if they differ by rounding only.
#[inline]
fn share_left(whole: f32, part: f32) -> f32 {
    let left = if whole > 0.0 { 1.0 - part / whole } else { 0.0 };
    if left < 1e-5 { 0.0 } else { left }
}

impl Bsdf<'_> {
    /// The diffuse part, if there is one: the whole of a diffuse surface, the base of a plastic with the mean
    /// transmittance of its coat, and the constant part of other lobes. In a blend, only components that share the
    /// first diffuse normal are included.
    pub fn diffuse_part(&self, wo: Vec3) -> Option<DiffusePart> {
        let mut part: Option<DiffusePart> = None;
        for c in self.components() {
            let local = c.frame.to_local(wo);
            let albedo = c.lobe.diffuse_albedo(local) * (c.weight * c.mean_unshadowed());
            if albedo.is_black() || c.bend.is_some_and(|b| !b.is_seen(&c.frame, wo)) {
                continue;
            }
            let normal = c.frame.n;
            match &mut part {
                None => part = Some(DiffusePart { albedo, normal }),
                Some(part) if part.normal == normal => part.albedo += albedo,
                Some(_) => {}
            }
        }
        part
    }

    /// Fraction of [`Bsdf::f_cos`] that [`Bsdf::diffuse_part`] does not include. The whole base of a plastic counts as
    /// included, although its coat transmits slightly more light from above, and less from the side, than the mean.
    pub fn beside_diffuse(&self, part: &DiffusePart, wo: Vec3, wi: Vec3) -> Rgb {
        let diffuse = |c: &Component| {
            let unshadowed = c.bend.map_or(1.0, |b| b.unshadowed(&c.frame, wo, wi));
            let (wo, wi) = (c.frame.to_local(wo), c.frame.to_local(wi));
            c.lobe.diffuse_f(wo, wi) * (wi.z.max(0.0) * c.weight * unshadowed)
        };
        let alike = self.components().iter().filter(|c| c.frame.n == part.normal);
        let diffuse: Rgb = alike.map(diffuse).sum();
        self.f_cos(wo, wi).zip(diffuse, share_left)
    }

    /// [`Bsdf::diffuse_part`] if the BSDF is Lambertian only, and its normal is not bent.
    #[inline]
    pub fn diffuse_only(&self, wo: Vec3) -> Option<DiffusePart> {
        match &self.parts {
            Parts::One(Component {
                lobe: Lobe::Diffuse { albedo },
                weight,
                frame,
                bend: None,
                part: None,
                ..
            }) => {
                let lit = wo.dot(frame.n) > 0.0;
                let albedo = if lit { *albedo * *weight } else { Rgb::BLACK };
                Some(DiffusePart { albedo, normal: frame.n })
            }
            _ => None,
        }
    }

    /// The albedo if the BSDF is Lambertian only; black from behind.
    #[inline]
    pub fn lambertian(&self, wo: Vec3) -> Option<Rgb> {
        self.diffuse_only(wo).map(|part| part.albedo)
    }
}
