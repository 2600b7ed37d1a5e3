//! The eye paths of a pass, and the light at their vertices.

use gi_core::bsdf::Bsdf;
use gi_core::eye::{Covers, Estimate, EyeEvent, EyeMediumVertex, EyeVertex, EyeWalk};
use gi_core::film::Sample as PixelSample;
use gi_core::math::Rgb;
use gi_core::sampler::Sampler;
use vpl::{Direct, MIN_ROUGHNESS};

use crate::cut::Lit;
use crate::light::{At, Lights};
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
        self.use_media(&mut walk);
        while let Some(event) = &walk.next_event() {
            let goes_on = match event {
                EyeEvent::Surface(v) => {
                    walk.add_emitted(v);
                    if v.wants_estimate() {
                        let corners = corners(v);
                        let estimate = self.gather(lights, v, corners.as_ref(), &mut walk.sampler);
                        estimate.into_iter().for_each(|e| walk.add_estimate(v, e));
                    }
                    walk.add_direct(v);
                    walk.scatter(v)
                }
                EyeEvent::Medium(v) => self.scatter_within(lights, v, &mut walk),
            };
            if !goes_on {
                break;
            }
        }
        walk.sample()
    }

    /// Let media attenuate and scatter the path if the scene has media and the method simulates them.
    pub(crate) fn use_media(&self, walk: &mut EyeWalk<'a>) {
        if self.view().is_in_media() {
            walk.use_media(self.camera_medium);
        }
    }

    /// A medium scatters the path: the lights on light sources illuminate the point, and the path continues for all other light.
    /// Returns whether it continues.
    fn scatter_within(
        &self,
        lights: &Lights<'_, 'a>,
        v: &EyeMediumVertex,
        walk: &mut EyeWalk<'a>,
    ) -> bool {
        let path = PathState::of(walk, Some(v.medium));
        let Some(at) = self.view().at_medium((v.p, v.wo), v.medium, path) else {
            walk.add_direct_within(v);
            return walk.scatter_within(v);
        };
        let lit = self.light(lights, &at, &mut walk.sampler);
        self.tally.note(&lit, path.non_delta == 0);
        walk.add_estimate_within(v, lit.direct);
        walk.scatter_within_after_estimate(v)
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
        let path = PathState { segments: v.segments, non_delta: v.non_delta, medium: v.medium };
        let at = self.view().at(&v.surface, v.wo, &bsdf, path)?;
        let params = &self.params;
        let lit = match corners {
            Some(corners) if lights.agree_on_the_whole(&at, corners) => {
                self.tally.reconstructed();
                reconstruct(lights, &at, corners, &params.cut, params.reconstruction.agree)
            }
            _ => self.light(lights, &at, sampler),
        };
        self.tally.note(&lit, v.non_delta == 0);
        self.estimate(v, &bsdf, lit.direct, lit.indirect)
    }

    /// The light of a point by the chosen method.
    fn light(&self, lights: &Lights<'_, 'a>, at: &At<'_, '_, 'a>, sampler: &mut Sampler) -> Lit {
        let params = &self.params;
        match params.method {
            Method::Cuts => light_by_cut(lights, at, &params.cut),
            Method::All => lights.light_by_all(at),
            Method::Stochastic => lights.light_stochastically(at, params.samples, sampler),
            Method::One | Method::Learned | Method::Multidimensional => {
                lights.light_by_some(at, params.samples, sampler)
            }
        }
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
