//! Precomputed irradiance \[Christensen99\]: a gather ray looks up one number instead of k photons.

use gi_core::disc::Disc;
use gi_core::math::Rgb;
use gi_core::progress;
use gi_core::rng::{bits_to_unit, hash_words};
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use gi_core::technique::Setting;
use glam::Vec3;
use rayon::prelude::*;

use crate::estimate::{Estimator, Place, SAME_SIDE};
use crate::map::{Layout, Order, PhotonMap};
use crate::params::Params;
use crate::photon::{Payload, Photon, PhotonKind, Rgbe};
use crate::shoot::Stored;

/// Number of photons per place.
const EVERY: usize = 4;
/// Largest distance to the place that is looked up, in largest radii of an estimate.
const REACH: f32 = 2.0;
/// Number of rays that probe the visible fraction of a disc, and of additional rays if it is not fully visible.
const PROBES: u32 = 16;
const MORE_PROBES: u32 = 64;
/// Smallest visible fraction of a disc. If less is visible, the estimate is too dark.
const LEAST_SHARE: f32 = 0.05;

/// Number of places for a map of `photons` photons.
pub(crate) fn count(photons: usize) -> usize {
    photons.div_ceil(EVERY)
}

/// Irradiance at the ends of gather rays.
pub(crate) struct IrradianceMap {
    /// Places as photons: their power is the irradiance, their direction encodes the radius of the estimate, and their kind is
    /// [`PhotonKind::Direct`] if the whole disc of the estimate is visible.
    map: PhotonMap,
    radius_sq: f32,
}

impl IrradianceMap {
    /// Estimate the irradiance at places where gather rays end, for light of at most `depth` segments.
    ///
    /// The places do not depend on the photons. If photons were the places \[Christensen99\], most would lie in bright regions: a
    /// lookup near an edge between bright and dark would find the bright side, and where photons are few, an estimate would
    /// include the photon at its own place. Both make the picture too bright.
    pub(crate) fn new(setting: &Setting, from: &Estimator, depth: u8, places: &[Place]) -> Self {
        let point = |(index, place): (usize, &Place)| {
            progress::advance(1);
            at(setting, from, *place, depth, index as u32)
        };
        progress::begin("irradiance estimates", places.len() as u64);
        let points = places.par_iter().enumerate().map(point).collect();
        let map = PhotonMap::build(points, from.map.emitted, Layout::Fast, Order::Any, false);
        IrradianceMap { map, radius_sq: REACH * REACH * from.max_radius_sq }
    }

    /// Irradiance, and the radius of its estimate, at the nearest visible place on this side; `None` if there is none nearby.
    #[inline]
    pub(crate) fn lookup(&self, scene: &Scene, p: Vec3, n: Vec3) -> Option<(Rgb, f32)> {
        let accept = |payload: &Payload| payload.normal().dot(n) > SAME_SIDE;
        let (q, payload) = self.map.near_one(p, self.radius_sq, accept)?;
        let radius = from_half(u16::from_le_bytes([payload.phi, payload.theta]));
        let distance = p.distance(q);
        // There is no wall within half the radius of a fully visible disc.
        let is_clear = payload.kind() == PhotonKind::Direct && 2.0 * distance < radius;
        let is_seen = is_clear || Disc::new(scene, p, n, distance, SAME_SIDE).sees(q);
        is_seen.then(|| (payload.power.to_rgb(), radius))
    }

    /// Bytes in memory.
    pub(crate) fn bytes(&self) -> usize {
        self.map.bytes()
    }
}

/// The irradiance at a place.
fn at(setting: &Setting, from: &Estimator, (p, n): Place, depth: u8, index: u32) -> Stored {
    let mut sampler = Sampler::new(0x6469_7363, index, 0);
    let offset = sampler.next_2d();
    let share = |disc: &Disc| {
        let share = disc.share(PROBES, offset);
        if share == 1.0 {
            return 1.0;
        }
        1.0 / disc.lowered().share(MORE_PROBES, offset).max(LEAST_SHARE)
    };
    let (e, is_clear) = from.density_seen_by(setting.scene, (p, n, depth), share, |q, per_area| {
        q.power.to_rgb() * per_area
    });
    let dither = [0, 1, 2].map(|c| bits_to_unit(hash_words(&[setting.seed, index, c, 7])));
    let kind = if is_clear { PhotonKind::Direct } else { PhotonKind::Indirect };
    let photon = Photon::new(p, Rgbe::dithered(e.all(), dither), n, n, kind);
    let [phi, theta] = half(e.found.radius_sq.sqrt()).to_le_bytes();
    Stored {
        photon: Photon { payload: Payload { phi, theta, ..photon.payload }, ..photon },
        depth: 0,
    }
}

/// The upper half of a float, rounded up: three digits are enough for a radius.
fn half(x: f32) -> u16 {
    ((x.to_bits() >> 16) + 1) as u16
}

fn from_half(x: u16) -> f32 {
    f32::from_bits(u32::from(x) << 16)
}

/// Maps for every depth that a gather ray can ask for, up to that of the deepest photon.
pub(crate) fn irradiance_maps(
    setting: &Setting,
    params: &Params,
    global: &Estimator,
    places: &[Place],
) -> Vec<IrradianceMap> {
    let depths = match params.limits.max_depth {
        None => vec![u8::MAX],
        Some(most) => {
            let deepest = global.map.photons().map(|s| u32::from(s.depth)).max().unwrap_or(1);
            (1..=most.saturating_sub(2).clamp(1, deepest.max(1)) as u8).collect()
        }
    };
    let new = |depth| IrradianceMap::new(setting, global, depth, places);
    depths.into_iter().map(new).collect()
}
