//! Photons in participating media [slide 34] \[Jensen98\].
//!
//! A photon is stored where a medium scatters it. Each photon whose disc a ray from the eye pierces adds
//!
//! L += T(t) p(wo, wi) power K(d^2) / (pi r^2)   [Jarosz08, beam radiance estimate]
//!
//! where t is the distance along the ray to the point nearest to the photon, d the photon's distance from it, and r the photon's
//! radius: that of the sphere that contains its k nearest neighbours. Single scattering is not in the maps: it is sampled. Each
//! medium has its own map, because photons must not contribute across a boundary.
//!
//! Bias: light is blurred over r. Discs that reach beyond a flat boundary are reflected at it; curved boundaries and thin parts still
//! lose light.

mod hierarchy;
mod shoot;

use gi_core::eye::Beam;
use gi_core::film::Components;
use gi_core::medium::{Medium, MediumId, first_equal};

use crate::order::Order;
use crate::params::Params;
use crate::photon::PhotonKind;
use crate::shoot::Source;
use hierarchy::Hierarchy;
pub use hierarchy::VolumePhoton;
pub(crate) use shoot::VolumeShot;

/// The photons of all media.
pub struct VolumeMaps {
    /// One map per distinct medium.
    maps: Vec<Hierarchy>,
    /// For each of the scene's media its map.
    map_of: Vec<usize>,
    /// Paths begun.
    pub emitted: u64,
    /// Fraction of the scatterings that was stored.
    pub kept: f32,
    gave_up: bool,
}

impl VolumeMaps {
    /// Trace photons until the wanted number is stored, in the media that `is_wanted` accepts.
    pub(crate) fn shoot(
        source: &Source,
        params: &Params,
        is_wanted: impl Fn(MediumId) -> bool + Sync,
    ) -> Self {
        let media = source.scene.media();
        // No photon is stored where nothing is scattered, however many are shot.
        let is_wanted = |m: MediumId| !media[m.index()].only_absorbs() && is_wanted(m);
        let count = if (0..media.len()).map(MediumId::new).any(is_wanted) {
            params.volume_photons
        } else {
            0
        };
        let shot = shoot::shoot(source, count, &maps_of(media), &is_wanted);
        Self::build(shot, media, params.volume_lookup, Order::Any)
    }

    /// The maps over photons of a scene's media, the radius of each reaching to its `k` nearest.
    pub(crate) fn build(shot: VolumeShot, media: &[Medium], k: usize, order: Order) -> Self {
        let VolumeShot { photons, emitted, kept, gave_up } = shot;
        let maps = photons.into_iter().map(|photons| Hierarchy::build(photons, k, order)).collect();
        VolumeMaps { maps, map_of: maps_of(media), emitted, kept, gave_up }
    }

    /// For each medium its photons in the order of their tree; those of equal media stand at the first.
    pub(crate) fn photons(&self) -> impl Iterator<Item = &[VolumePhoton]> {
        self.maps.iter().map(Hierarchy::photons)
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

    /// The beam radiance estimate: radiance along a beam from photons of at most `depth` segments.
    pub fn radiance(&self, beam: &Beam, medium: &Medium, depth: u8) -> Components {
        let mut out = Components::default();
        let wi = -beam.ray.d;
        let map = &self.maps[self.map_of[beam.medium.index()]];
        // Only the beam from a camera inside the medium does not begin at a surface.
        let from_surface = beam.entered.is_some() || beam.segments > 1;
        map.pierced(&beam.ray, beam.reach, from_surface, |stored, t, density| {
            if stored.depth > depth {
                return;
            }
            let payload = stored.photon.payload;
            let phase = medium.phase.eval(payload.direction(), wi);
            let found = medium.transmittance(t) * payload.power.to_rgb() * (phase * density);
            match payload.kind() {
                PhotonKind::Caustic => out.caustic += found,
                _ => out.indirect += found,
            }
        });
        out
    }
}

/// For each medium its map.
fn maps_of(media: &[Medium]) -> Vec<usize> {
    (0..media.len()).map(|m| first_equal(media, MediumId::new(m)).index()).collect()
}
