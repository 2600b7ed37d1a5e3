//! The light that a medium scatters back along a ray: photons, the dipole, and samples of lights.

use gi_core::eye::{Beam, EyeWalk};
use gi_core::film::{Components, Show};
use gi_core::math::Rgb;
use gi_core::medium::{Medium, equiangular, equiangular_pdf};
use gi_core::nee::all_direct_light_within;
use gi_core::sampler::Sampler;

use crate::gather::Gatherer;
use crate::media::MediaMaps;

/// Fraction of the beams that are sampled once a path has scattered by other than a delta lobe.
const GATHERED: f32 = 0.25;

impl<'a> Gatherer<'_, 'a> {
    /// Add the light that a medium scatters back along the next segment of a path.
    pub(crate) fn add_medium(&self, walk: &mut EyeWalk<'a>) {
        let Some(maps) = &self.maps.media else { return };
        let Some(beam) = walk.beam_ahead() else { return };
        let Some(depth) = self.photon_depth(beam.segments) else { return };
        // After a scattering by other than a delta lobe, this light is a small part and costs as much: sample few beams.
        let mut share = 1.0;
        if beam.non_delta > 0 {
            if walk.sampler.next_1d() >= GATHERED {
                return;
            }
            share = GATHERED;
        }
        let Components { direct, indirect, caustic } =
            self.scattered(maps, &beam, depth, &mut walk.sampler);
        let (direct, indirect, caustic) = (direct / share, indirect / share, caustic / share);
        walk.add_beam(&beam, Components { direct, indirect, caustic });
    }

    /// All light of at most `depth` segments that a medium scatters back along a beam.
    fn scattered(
        &self,
        maps: &MediaMaps,
        beam: &Beam,
        depth: u8,
        sampler: &mut Sampler,
    ) -> Components {
        let (scene, show) = (self.setting.scene, self.setting.show);
        let medium = scene.medium(beam.medium);
        let (mut direct, mut indirect, mut caustic) = (Rgb::BLACK, Rgb::BLACK, Rgb::BLACK);
        if let Some(dipoles) = &maps.dipoles
            && maps.solids.is_dark(beam.medium)
        {
            if matches!(show, Show::All | Show::Indirect) {
                indirect = dipoles.radiance(scene, beam, depth);
            }
            return Components { direct, indirect, caustic };
        }
        if show != Show::Direct {
            Components { indirect, caustic, .. } = maps.volume.radiance(beam, medium, depth);
        }
        if !maps.solids.is_dark(beam.medium) {
            direct = self.single_scattering(beam, medium, sampler);
        }
        Components { direct, indirect, caustic }
    }

    /// Single scattering: light straight from a light source that is scattered once, back along a beam. One distance is sampled,
    /// half of the time in proportion to one over the squared distance from a point of a light, else in proportion to
    /// transmittance.
    fn single_scattering(&self, beam: &Beam, medium: &Medium, sampler: &mut Sampler) -> Rgb {
        let scene = self.setting.scene;
        let (u_light, [u_way, u]) = (sampler.next_2d(), sampler.next_2d());
        let sigma = medium.sigma_t.mean();
        let by_transmittance = Exponential { sigma, reach: beam.reach };
        // Sample a point of a light from the middle of the beam, or from one mean free path away.
        let middle = beam.ray.at((0.5 * beam.reach).min(1.0 / sigma));
        let near = scene.sample_light(middle, u_light).and_then(|light| {
            let to = light.p? - beam.ray.o;
            let along = to.dot(beam.ray.d);
            let across = (to - beam.ray.d * along).length();
            (across > 1e-6 * to.length()).then_some((along, across))
        });
        // One sample, weighted by the balance heuristic.
        let (t, pdf) = match near {
            None => by_transmittance.sample(u),
            Some((along, across)) if u_way < 0.5 => {
                let (t, pdf) = equiangular(along, across, beam.reach, u);
                (t, 0.5 * (pdf + by_transmittance.pdf(t)))
            }
            Some((along, across)) => {
                let (t, pdf) = by_transmittance.sample(u);
                (t, 0.5 * (pdf + equiangular_pdf(along, across, beam.reach, t)))
            }
        };
        if !(pdf > 0.0 && pdf.is_finite() && t < beam.reach) {
            return Rgb::BLACK;
        }
        let (p, wo) = (beam.ray.at(t), -beam.ray.d);
        let scattered = all_direct_light_within(scene, beam.medium, p, wo, sampler);
        medium.transmittance(t) * medium.sigma_s() * scattered / pdf
    }
}

/// Distances up to `reach` in proportion to exp(-sigma t).
struct Exponential {
    sigma: f32,
    reach: f32,
}

impl Exponential {
    /// 1 - exp(-sigma reach).
    fn whole(&self) -> f32 {
        -(-self.sigma * self.reach).exp_m1()
    }

    fn sample(&self, u: f32) -> (f32, f32) {
        let t = -(-u * self.whole()).ln_1p() / self.sigma;
        (t, self.pdf(t))
    }

    fn pdf(&self, t: f32) -> f32 {
        self.sigma * (-self.sigma * t).exp() / self.whole()
    }
}
