//! Photons in participating media [slide 34] \[Jensen98\].
//!
//! A photon is stored where a medium scatters it. Along a ray from the eye, each whose disc the ray pierces adds
//!
//! L += T(t) p(wo, wi) power K(d^2) / (pi r^2)   [Jarosz08, beam radiance estimate]
//!
//! where t is the distance along the ray to the photon's nearest point, d the photon's distance from it, and r the photon's own
//! radius: that of the sphere round it which holds its k nearest. Light that comes straight from a light
//! and is scattered once (single scattering) is not in the maps: it is sampled, the distance half of the time in proportion
//! to one over the squared distance from a point of a light, else in proportion to transmittance. There is a map for each
//! medium: what a photon of another medium adds, across a boundary, would be wrong.
//!
//! Bias: light is blurred over r, and fades toward boundaries over that length.

mod hierarchy;
mod shoot;

use gi_core::eye::{Beam, EyeVertex, Supplied, Supplier};
use gi_core::film::{Components, Show};
use gi_core::math::Rgb;
use gi_core::medium::{Medium, equiangular, equiangular_pdf};
use gi_core::nee::all_direct_light_within;
use gi_core::sampler::Sampler;

use crate::photon::{Kind, Photon};
use crate::shoot::Source;
use crate::{Params, PhotonMapping};
use hierarchy::Hierarchy;

/// Share of the beams behind a rough scattering that are looked along: their light is a small part, and costs as much.
const GATHERED: f32 = 0.25;

/// A photon in a medium: [`Photon`] without a normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumePhoton {
    /// Where, what power is scattered there, and where it came from; already divided by the number of emitted paths.
    pub photon: Photon,
    /// Segments from the light to here, 255 standing for more.
    pub depth: u8,
}

/// The photons of all media.
pub struct VolumeMaps {
    /// One a medium that differs from those before it.
    maps: Vec<Hierarchy>,
    /// For each of the scene's media its map.
    map_of: Vec<usize>,
    /// Paths begun.
    pub emitted: u64,
    /// Share of scatterings that was stored.
    pub kept: f32,
    gave_up: bool,
}

impl VolumeMaps {
    /// Shoot photons until as many are stored as the parameters say.
    pub fn shoot(source: &Source, params: &Params) -> Self {
        let media = source.scene.media();
        // Equal media are one.
        let first = |m: &Medium| media.iter().position(|other| other == m).unwrap_or_default();
        let map_of: Vec<usize> = media.iter().map(first).collect();
        let shot = shoot::shoot(source, params.volume_photons, &map_of);
        let maps = shot.photons.into_iter();
        let maps = maps.map(|photons| Hierarchy::build(photons, params.volume_lookup)).collect();
        VolumeMaps { maps, map_of, emitted: shot.emitted, kept: shot.kept, gave_up: shot.gave_up }
    }

    /// How many photons there are.
    pub fn len(&self) -> usize {
        self.maps.iter().map(Hierarchy::len).sum()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What is worth knowing.
    pub(crate) fn statistics(&self) -> Vec<(String, f64)> {
        let bytes: usize = self.maps.iter().map(Hierarchy::bytes).sum();
        [
            ("volume_photons", self.len() as f64),
            ("volume_paths", self.emitted as f64),
            ("volume_kept_share", f64::from(self.kept)),
            ("volume_bytes", bytes as f64),
            ("volume_gave_up", f64::from(u8::from(self.gave_up))),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .to_vec()
    }

    /// The beam radiance estimate: what photons of at most `depth` segments send back along a beam.
    pub fn radiance(&self, beam: &Beam, medium: &Medium, depth: u8) -> Components {
        let mut out = Components::default();
        let wi = -beam.ray.d;
        self.maps[self.map_of[beam.medium]].pierced(beam.ray, beam.reach, |stored, t, density| {
            if stored.depth > depth {
                return;
            }
            let payload = stored.photon.payload;
            let phase = medium.phase.eval(payload.direction(), wi);
            let found = medium.transmittance(t) * payload.power.to_rgb() * (phase * density);
            match payload.kind() {
                Kind::Caustic => out.caustic += found,
                _ => out.indirect += found,
            }
        });
        out
    }
}

/// Photon mapping with media: `F` answers on surfaces, the maps in between.
pub(crate) struct InMedia<'s, 'a, F> {
    technique: &'s PhotonMapping<'a>,
    maps: &'s VolumeMaps,
    vertex: F,
}

impl<'s, 'a, F: FnMut(&EyeVertex<'_, 'a>, &mut Sampler) -> Option<Supplied>> InMedia<'s, 'a, F> {
    pub(crate) fn new(technique: &'s PhotonMapping<'a>, maps: &'s VolumeMaps, vertex: F) -> Self {
        InMedia { technique, maps, vertex }
    }
}

impl<'a, F: FnMut(&EyeVertex<'_, 'a>, &mut Sampler) -> Option<Supplied>> Supplier<'a>
    for InMedia<'_, 'a, F>
{
    const MEDIA: bool = true;

    fn vertex(&mut self, v: &EyeVertex<'_, 'a>, sampler: &mut Sampler) -> Option<Supplied> {
        (self.vertex)(v, sampler)
    }

    fn beam(&mut self, beam: &Beam, sampler: &mut Sampler) -> Option<Components> {
        let Some(depth) = self.technique.photon_depth(beam.segments) else {
            return Some(Components::default());
        };
        // Of the many rays of a gather point, or behind a glossy surface, a few are asked for all.
        let mut share = 1.0;
        if beam.rough > 0 {
            if sampler.next_1d() >= GATHERED {
                return Some(Components::default());
            }
            share = GATHERED;
        }
        let setting = &self.technique.setting;
        let medium = setting.scene.medium(beam.medium);
        let mut found = match (setting.show, beam.rough) {
            (Show::Direct, _) => Components::default(),
            _ => self.maps.radiance(beam, medium, depth),
        };
        found.direct = self.technique.single_scattering(beam, medium, sampler);
        found.direct = found.direct / share;
        found.indirect = found.indirect / share;
        found.caustic = found.caustic / share;
        Some(found)
    }
}

impl PhotonMapping<'_> {
    /// Light that comes straight from a light and is scattered once, back along a beam; one distance sampled.
    fn single_scattering(&self, beam: &Beam, medium: &Medium, sampler: &mut Sampler) -> Rgb {
        let scene = self.setting.scene;
        let (u_light, [u_way, u]) = (sampler.next_2d(), sampler.next_2d());
        let sigma = medium.sigma_t.mean();
        let by_transmittance = Exponential { sigma, reach: beam.reach };
        // A point of a light to be near to, as it is drawn from the beam's middle, or one free path away.
        let middle = beam.ray.at((0.5 * beam.reach).min(1.0 / sigma));
        let near = scene.sample_light(middle, u_light).and_then(|light| {
            let to = light.p? - beam.ray.o;
            let along = to.dot(beam.ray.d);
            let across = (to - beam.ray.d * along).length();
            (across > 1e-6 * to.length()).then_some((along, across))
        });
        // One sample of both ways, weighted by the balance heuristic.
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
