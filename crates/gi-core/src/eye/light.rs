//! Light that the eye walk adds up.

use std::borrow::Cow;

use glam::Vec3;

use super::{Answered, EyePath, Prefix, Supplied, Supplier};
use crate::bsdf::Bsdf;
use crate::film::{Components, Show};
use crate::geometry::Surface;
use crate::math::Rgb;
use crate::nee::{direct_light, direct_light_through_media, emitter_weight};
use crate::sampler::Sampler;

impl<'a> EyePath<'a> {
    /// Whether light that is sampled where the path is scattered now is asked for.
    #[inline]
    pub(super) fn wants_direct(&self, prefix: &Prefix) -> bool {
        match self.show {
            Show::All => true,
            Show::Direct => prefix.rough == 0,
            Show::Indirect => prefix.rough > 0,
            Show::Caustic => false,
        }
    }

    /// The part of `bsdf` that light straight from lights has not been supplied for.
    #[inline]
    pub(super) fn left_for_lights<'b>(
        &self,
        bsdf: &'b Bsdf<'a>,
        supplied: Option<&Supplied>,
    ) -> Option<Cow<'b, Bsdf<'a>>> {
        match supplied {
            Some(Supplied { direct: Some(_), answered, .. }) => match *answered {
                Answered::Straight { min_roughness, .. } if bsdf.is_sharp(min_roughness) => {
                    Some(Cow::Owned(bsdf.with_broad(min_roughness, Rgb::BLACK)))
                }
                _ => None,
            },
            _ => Some(Cow::Borrowed(bsdf)),
        }
    }

    /// Light that is sampled and scattered here.
    #[inline]
    pub(super) fn add_direct<S: Supplier<'a>>(
        &self,
        surface: &Surface,
        bsdf: &Bsdf,
        wo: Vec3,
        (prefix, here): (&Prefix, Rgb),
        sampler: &mut Sampler,
        out: &mut Components,
    ) {
        if !self.wants_direct(prefix) || here.is_black() {
            return sampler.skip();
        }
        let direct = if S::MEDIA {
            let place = (surface, prefix.medium);
            direct_light_through_media(self.scene, place, bsdf, wo, sampler)
        } else {
            direct_light(self.scene, surface, bsdf, wo, sampler)
        };
        *out.of_path(prefix.rough + 1, false) += prefix.throughput * here * direct;
    }

    /// Light of a surface that the path has met, weighted against having sampled it as a light.
    #[inline]
    pub(super) fn add_emitted(
        &self,
        surface: &Surface,
        wo: Vec3,
        prefix: &Prefix,
        out: &mut Components,
    ) {
        let emitted = self.scene.emitted(surface, wo);
        let left = prefix.lights_left();
        if emitted.is_black() || left.is_black() {
            return;
        }
        let weight = match prefix.last {
            Some((p, pdf_w)) => emitter_weight(Some(pdf_w), self.scene.light_pdf_w(p, surface)),
            None => 1.0,
        };
        *out.of_path(prefix.rough, prefix.after_delta) +=
            prefix.throughput * left * emitted * weight;
    }

    /// Light from infinity, where the path has left the scene.
    #[inline]
    pub(super) fn add_background(&self, d: Vec3, prefix: &Prefix, out: &mut Components) {
        let left = prefix.lights_left();
        if left.is_black() {
            return;
        }
        for (radiance, pdf_light) in self.scene.escaped(d) {
            let weight = emitter_weight(prefix.last.map(|(_, pdf_w)| pdf_w), pdf_light);
            *out.of_path(prefix.rough, prefix.after_delta) +=
                prefix.throughput * left * radiance * weight;
        }
    }
}

/// Add what a technique supplied at a vertex, where `here` was not answered for before.
#[inline]
pub(super) fn add_supplied(
    supplied: Option<&Supplied>,
    prefix: &Prefix,
    here: Rgb,
    out: &mut Components,
) {
    let Some(supplied) = supplied else { return };
    let factor = prefix.throughput * here;
    *out.of_path(prefix.rough + 2, false) += factor * supplied.indirect;
    if let Some(direct) = supplied.direct {
        *out.of_path(prefix.rough + 1, false) += factor * direct;
    }
    if let Some(caustic) = supplied.caustic {
        *out.of_path(prefix.rough + 1, true) += factor * caustic;
    }
}
