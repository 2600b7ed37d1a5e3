//! The light that the eye walk adds up.

use super::{Covers, Estimate, EyeVertex, EyeWalk};
use crate::bsdf::Bsdf;
use crate::film::Show;
use crate::light::{LightSample, Vantage};
use crate::math::Rgb;
use crate::nee::{direct_light, direct_light_through_media, emitter_weight};

impl<'a> EyeWalk<'a> {
    /// Add the light that the surface at `v` emits. Next-event estimation may find it too: the power heuristic weights
    /// both.
    #[inline(always)]
    pub fn add_emitted(&mut self, v: &EyeVertex) {
        let emitted = self.scene.emitted(&v.surface, v.wo);
        let left = self.remainder.emitted(self.after_delta);
        if emitted.is_black() || left.is_black() || self.source_is_left_out() {
            return;
        }
        let weight = match self.last {
            Some(last) => {
                emitter_weight(Some(last.pdf_w), self.scene.light_pdf_w_from(&last.at, &v.surface))
            }
            None => 1.0,
        };
        *self.sample.radiance.of_path(self.non_delta, self.after_delta) +=
            self.throughput * left * emitted * weight;
    }

    /// Whether [`super::SourceRays`] find the light sources that the path sees now.
    #[inline(always)]
    pub fn source_is_left_out(&self) -> bool {
        self.leaves_out_sources && self.non_delta == 0
    }

    /// Add light from infinity, weighted in the same way.
    #[inline]
    pub(super) fn add_background(&mut self) {
        let left = self.remainder.emitted(self.after_delta);
        let is_hidden = self.hides_background && self.segments == 1;
        if left.is_black() || is_hidden || self.source_is_left_out() {
            return;
        }
        for (radiance, pdf_light) in
            self.scene.escaped_from(self.last.map(|last| last.at), self.ray.d)
        {
            let weight = emitter_weight(self.last.map(|last| last.pdf_w), pdf_light);
            *self.sample.radiance.of_path(self.non_delta, self.after_delta) +=
                self.throughput * left * radiance * weight;
        }
    }

    /// Add a technique's estimate at `v`. Call it at most once per vertex, only if [`EyeVertex::wants_estimate`] holds,
    /// and before [`EyeWalk::add_direct`] and [`EyeWalk::scatter`]: they leave out the light that it covers.
    #[inline]
    pub fn add_estimate(&mut self, v: &EyeVertex, estimate: Estimate) {
        debug_assert!(
            v.wants_estimate() && self.estimate.is_none(),
            "light would be counted twice"
        );
        let radiance = &mut self.sample.radiance;
        *radiance.of_path(self.non_delta + 2, false) += v.throughput * estimate.indirect;
        if let Some(direct) = estimate.direct {
            *radiance.of_path(self.non_delta + 1, false) += v.throughput * direct;
        }
        if let Some(caustic) = estimate.caustic {
            *radiance.of_path(self.non_delta + 1, true) += v.throughput * caustic;
        }
        self.estimate = Some(estimate);
        self.is_remainder = true;
    }

    /// Next-event estimation: sample a light, and add the light that `v` scatters, unless an estimate covers it.
    #[inline(always)]
    pub fn add_direct(&mut self, v: &EyeVertex<'a>) {
        if v.is_last {
            return;
        }
        let narrow;
        let bsdf = match self.left_for_lights(&v.bsdf) {
            SampledLobes::All => &v.bsdf,
            SampledLobes::Narrow(min_roughness) => {
                narrow = v.bsdf.with_broad(min_roughness, Rgb::BLACK);
                &narrow
            }
            SampledLobes::None => return,
        };
        if !self.wants_direct() || v.remainder.is_black() {
            return self.sampler.skip();
        }
        let at = self.vantage(v);
        let direct = if self.knows_media {
            let place = (&at, &v.surface, self.medium);
            direct_light_through_media(self.scene, place, bsdf, v.wo, &mut self.sampler)
        } else {
            direct_light(self.scene, (&at, &v.surface), bsdf, v.wo, &mut self.sampler)
        };
        *self.sample.radiance.of_path(self.non_delta + 1, false) += v.throughput * direct;
    }

    /// The point of `v` that light is sampled for. It depends on the whole BSDF, so that a technique's estimate does not
    /// change the densities of light samples.
    #[inline(always)]
    pub(super) fn vantage(&self, v: &EyeVertex) -> Vantage<'a> {
        Vantage::on_surface(self.light_tree, v.surface.p, &v.bsdf)
    }

    /// Sample a light for `v`, without visibility. `None` if no light is found, or if the path may not have another segment.
    #[inline]
    pub fn sample_light(&mut self, v: &EyeVertex<'a>) -> Option<LightSample> {
        if v.is_last {
            return None;
        }
        let u = self.sampler.next_2d();
        self.scene.aim_at_light(&self.vantage(v), u)
    }

    /// For walks that do not collect light: skip the random numbers that [`EyeWalk::add_direct`] would draw.
    #[inline]
    pub fn skip_direct(&mut self, v: &EyeVertex<'a>) {
        if !v.is_last && !matches!(self.left_for_lights(&v.bsdf), SampledLobes::None) {
            self.sampler.skip();
        }
    }

    /// Whether the picture needs light that is sampled at the current vertex.
    #[inline]
    pub(super) fn wants_direct(&self) -> bool {
        match self.show {
            Show::All => true,
            Show::Direct => self.non_delta == 0,
            Show::Indirect => self.non_delta > 0,
            Show::Caustic => false,
        }
    }

    /// The part of `bsdf` for which the estimate does not include light straight from light sources.
    #[inline]
    fn left_for_lights(&self, bsdf: &Bsdf) -> SampledLobes {
        match self.estimate {
            Some(Estimate { direct: Some(_), covers, .. }) => match covers {
                Covers::Visible { min_roughness, .. } if bsdf.is_sharp(min_roughness) => {
                    SampledLobes::Narrow(min_roughness)
                }
                _ => SampledLobes::None,
            },
            _ => SampledLobes::All,
        }
    }
}

/// The lobes of a BSDF that light is sampled for.
enum SampledLobes {
    All,
    /// Lobes that are narrower than this roughness.
    Narrow(f32),
    None,
}
