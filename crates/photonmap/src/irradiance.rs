//! Irradiance computed ahead at photons \[Christensen99\]: a gather ray then looks up one number instead of k photons.

use gi_core::math::Frame;
use gi_core::math::Rgb;
use gi_core::ray::Ray;
use gi_core::rng::{bits_to_unit, hash_words};
use gi_core::scene::Scene;
use gi_core::technique::Setting;
use gi_core::warp;
use glam::Vec3;
use rayon::prelude::*;

use crate::Params;
use crate::estimate::Estimator;
use crate::kernel::Kernel;
use crate::map::{Layout, Order, PhotonMap};
use crate::photon::{Payload, Photon, Rgbe};
use crate::shoot::Stored;

/// One photon in so many gets the irradiance.
const EVERY: usize = 4;
/// Nearness of normals up to which a neighbour's irradiance is taken.
const SAME_SIDE: f32 = 0.8;
/// Rays that probe how much of an estimate's disc there is.
const PROBES: u32 = 16;
/// How far a surface may lie off the disc, in radii, to belong to it.
const FLATNESS: f32 = 0.25;

/// Irradiance at photons.
pub(crate) struct IrradianceMap {
    map: PhotonMap,
    radius_sq: f32,
}

impl IrradianceMap {
    /// Estimate the irradiance at every fourth photon, of light that took at most `depth` segments.
    pub(crate) fn new(scene: &Scene, from: &Estimator, depth: u8, seed: u32) -> Self {
        // At a photon, one photon lies in the very middle; to make up for it, the photon that a point looks up has fewer
        // neighbours on the point's side, one on average. The two cancel where all places of the disc count the same:
        // a kernel that is high in the middle would be too bright by about 1 / 2k.
        let kernel = if from.kernel == Kernel::Lecture { Kernel::Lecture } else { Kernel::Box };
        let n = from.map.len().div_ceil(EVERY);
        let points: Vec<Stored> = (0..n)
            .into_par_iter()
            .map(|k| {
                let photon = from.map.stored(k * EVERY).photon;
                let (p, normal) = (photon.p(), photon.payload.normal());
                let e = from.irradiance_by(kernel, p, normal, depth);
                let share = share_of_disc(scene, p, normal, e.found.radius_sq, k as u32);
                let dither = [0, 1, 2].map(|c| bits_to_unit(hash_words(&[seed, k as u32, c, 7])));
                let power = Rgbe::dithered(e.all() / share, dither);
                let [phi, theta] = half(e.found.radius_sq.sqrt()).to_le_bytes();
                let payload = Payload { power, phi, theta, ..photon.payload };
                Stored { photon: Photon { payload, ..photon }, depth: 0 }
            })
            .collect();
        let map = PhotonMap::build(points, from.map.emitted, Layout::Fast, Order::Any, false);
        IrradianceMap { map, radius_sq: from.max_radius_sq }
    }

    /// Irradiance and the radius of its estimate at the nearest photon on this side; `None` where there is none near.
    #[inline]
    pub(crate) fn lookup(&self, p: Vec3, n: Vec3) -> Option<(Rgb, f32)> {
        let accept = |payload: &Payload| payload.normal().dot(n) > SAME_SIDE;
        let payload = self.map.near_one(p, self.radius_sq, accept)?;
        let radius = from_half(u16::from_le_bytes([payload.phi, payload.theta]));
        Some((payload.power.to_rgb(), radius))
    }

    /// Bytes in memory.
    pub(crate) fn bytes(&self) -> usize {
        self.map.bytes()
    }
}

/// How much of the disc of an estimate is surface: an estimate at the edge of a wall divides by a disc of which
/// a part hangs over, where no photon can be. Probed by short rays from above.
fn share_of_disc(scene: &Scene, p: Vec3, n: Vec3, radius_sq: f32, stream: u32) -> f32 {
    let radius = radius_sq.sqrt();
    if !(radius > 0.0 && radius.is_finite()) {
        return 1.0;
    }
    let frame = Frame::from_normal(n);
    let height = FLATNESS * radius;
    let mut sampler = gi_core::sampler::Sampler::new(0x6469_7363, stream, 0);
    let offset = sampler.next_2d();
    let there = (0..PROBES).filter(|&i| {
        // A lattice of the golden ratio, shifted for each photon.
        let u = [(i as f32 + 0.5) / PROBES as f32 + offset[0], i as f32 * 0.618_034 + offset[1]];
        let q = warp::disk(u.map(f32::fract)) * radius;
        let o = p + frame.s * q.x + frame.t * q.y + n * height;
        let ray = Ray { o, tmin: 0.0, d: -n, tmax: 2.0 * height };
        scene.intersect(&ray).is_some_and(|(s, _)| s.ng.dot(n).abs() > SAME_SIDE)
    });
    (there.count().max(1) as f32 / PROBES as f32).max(0.2)
}

/// The upper half of a float, rounded up: three digits are enough for a radius.
fn half(x: f32) -> u16 {
    ((x.to_bits() >> 16) + 1) as u16
}

fn from_half(x: u16) -> f32 {
    f32::from_bits(u32::from(x) << 16)
}

/// Irradiance for every depth that a gather ray can ask for: deeper than the deepest photon there is nothing new.
pub(crate) fn irradiance_maps(
    setting: &Setting,
    params: &Params,
    global: &Estimator,
) -> Vec<IrradianceMap> {
    let depths = match params.max_depth {
        None => vec![u8::MAX],
        Some(most) => {
            let deepest = global.map.photons().map(|s| u32::from(s.depth)).max().unwrap_or(1);
            (1..=most.saturating_sub(2).clamp(1, deepest.max(1)) as u8).collect()
        }
    };
    depths
        .into_iter()
        .map(|depth| IrradianceMap::new(setting.scene, global, depth, setting.seed))
        .collect()
}
