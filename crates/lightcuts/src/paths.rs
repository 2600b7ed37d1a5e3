//! The eye paths of a pass, and the light at their vertices.

use gi_core::bsdf::Bsdf;
use gi_core::eye::{Covers, Estimate, EyeVertex, EyeWalk};
use gi_core::film::Sample as PixelSample;
use gi_core::math::Rgb;
use gi_core::sampler::Sampler;
use vpl::{Direct, MIN_ROUGHNESS};

use crate::light::Lights;
use crate::params::Method;
use crate::reconstruct::{Corners, Sample};
use crate::view::PathState;
use crate::{Lightcuts, light_by_cut, reconstruct, record_cut};

impl<'a> Lightcuts<'a> {
    /// One path through a pixel. `corners` finds samples from which the first point can be reconstructed.
    pub(crate) fn sample_pixel<'s>(
        &self,
        lights: &Lights<'_, 'a>,
        pixel: [usize; 2],
        index: u32,
        corners: impl Fn(&EyeVertex) -> Option<Corners<'s>>,
    ) -> PixelSample {
        let mut walk = EyeWalk::through_pixel(&self.setting, self.params.limits, pixel, index);
        while let Some(v) = &walk.next_vertex() {
            walk.add_emitted(v);
            if v.wants_estimate() {
                let corners = corners(v);
                if let Some(estimate) = self.gather(lights, v, corners.as_ref(), &mut walk.sampler)
                {
                    walk.add_estimate(v, estimate);
                }
            }
            walk.add_direct(v);
            if !walk.scatter(v) {
                break;
            }
        }
        walk.sample()
    }

    /// The light of a vertex from all lights, and what it covers: the path continues for the rest.
    fn gather(
        &self,
        lights: &Lights<'_, 'a>,
        v: &EyeVertex<'a>,
        corners: Option<&Corners>,
        sampler: &mut Sampler,
    ) -> Option<Estimate> {
        let bsdf = v.bsdf.broad(v.wo, MIN_ROUGHNESS)?;
        let path = PathState { segments: v.segments, non_delta: v.non_delta };
        let at = self.view().at(&v.surface, v.wo, &bsdf, path)?;
        let params = &self.params;
        let lit = match (params.method, corners) {
            (Method::Cuts, Some(corners)) if lights.agree_on_the_whole(&at, corners) => {
                self.tally.reconstructed();
                reconstruct(lights, &at, corners, &params.cut, params.reconstruction.agree)
            }
            (Method::Cuts, _) => light_by_cut(lights, &at, &params.cut),
            (Method::All, _) => lights.light_by_all(&at),
            (Method::Stochastic, _) => lights.light_stochastically(&at, params.samples, sampler),
            (Method::One | Method::Learned | Method::Multidimensional, _) => {
                lights.light_by_some(&at, params.samples, sampler)
            }
        };
        self.tally.note(&lit, v.non_delta == 0);
        self.estimate(v, &bsdf, lit.direct, lit.indirect)
    }

    /// The light of a vertex, with the light of photons. `bsdf` is without narrow lobes.
    pub(crate) fn estimate(
        &self,
        v: &EyeVertex,
        bsdf: &Bsdf,
        direct: Rgb,
        indirect: Rgb,
    ) -> Option<Estimate> {
        let max_geometry = self.view().compensated_geometry();
        let max_scatterings = self.view().max_scatterings(v.segments)?;
        let scene = self.setting.scene;
        Some(Estimate {
            covers: Covers::Visible { max_geometry, min_roughness: MIN_ROUGHNESS },
            direct: (self.params.direct == Direct::Vpl).then_some(direct),
            indirect,
            caustic: self.focused.radiance(scene, (&v.surface, v.wo, bsdf), max_scatterings),
        })
    }

    /// The recorded cut of the point seen at a film position; `None` if nothing there receives light.
    pub(crate) fn sample_corner(&self, lights: &Lights<'_, 'a>, film: [f32; 2]) -> Option<Sample> {
        let sample = self.view().at_film(film, |at| record_cut(lights, at, &self.params.cut))?;
        self.tally.sampled(sample.rays);
        Some(sample)
    }
}
