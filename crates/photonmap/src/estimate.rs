//! The radiance estimate [slide 24]: light from the density of photons round a point.

use gi_core::bsdf::Bsdf;
use gi_core::disc::Disc;
use gi_core::geometry::Surface;
use gi_core::math::{Frame, INV_PI, Rgb};
use gi_core::scene::Scene;
use glam::Vec3;

use crate::kernel::Kernel;
use crate::map::{Found, PhotonMap};
use crate::photon::{Payload, PhotonKind};
use crate::seen::Place;

/// A map with how to read it.
pub struct Estimator {
    /// The photons.
    pub map: PhotonMap,
    /// How they count by distance.
    pub kernel: Kernel,
    /// Most photons of an estimate.
    pub k: usize,
    /// Largest radius squared, world units.
    pub max_radius_sq: f32,
}

/// Photons count on surfaces whose normal is within 37 degrees of that where they arrived: not round a corner, not through
/// a wall, but on the next facet of a round thing.
pub(crate) const SAME_SIDE: f32 = 0.8;
/// Photons whose neighbourhoods an automatic radius is the median of.
const PROBES: usize = 256;

/// What an estimate found, parted by what the light has met.
#[derive(Clone, Copy, Debug, Default)]
pub struct Estimate {
    /// L D.
    pub direct: Rgb,
    /// L S+ D.
    pub caustic: Rgb,
    /// Light over rough surfaces.
    pub indirect: Rgb,
    /// The photons.
    pub found: Found,
}

impl Estimate {
    #[inline]
    fn add(&mut self, photon: &Payload, light: Rgb) {
        match photon.kind() {
            PhotonKind::Direct => self.direct += light,
            PhotonKind::Caustic => self.caustic += light,
            PhotonKind::Indirect => self.indirect += light,
        }
    }

    /// Light of every kind.
    pub fn all(&self) -> Rgb {
        self.direct + self.caustic + self.indirect
    }
}

impl Estimator {
    /// Read `map` by `k` photons an estimate; a `max_radius` of 0 (world units) is `factor` times what half of the photons
    /// need.
    pub fn new(map: PhotonMap, kernel: Kernel, k: usize, max_radius: f32, factor: f32) -> Self {
        let mut estimator = Estimator { map, kernel, k, max_radius_sq: f32::INFINITY };
        estimator.max_radius_sq = if max_radius > 0.0 {
            max_radius * max_radius
        } else {
            factor * factor * estimator.median_radius_sq()
        };
        estimator
    }

    /// The median over some photons of the squared radius that holds k of them.
    fn median_radius_sq(&self) -> f32 {
        let n = self.map.len();
        self.median_of(
            (0..PROBES.min(n)).map(|i| self.map.stored(i * n / PROBES.min(n)).photon.p()),
        )
    }

    /// The same over some points.
    fn median_of(&self, points: impl Iterator<Item = Vec3>) -> f32 {
        let k = self.k.min(self.map.len());
        let probe = |p| self.map.nearest(p, k, f32::INFINITY, |_, _| true, |_, _, _| {}).radius_sq;
        let mut radii: Vec<f32> = points.map(probe).filter(|r| *r > 0.0).collect();
        radii.sort_by(f32::total_cmp);
        radii.get(radii.len() / 2).copied().unwrap_or(0.0)
    }

    /// Bound the radius by `factor` times what half of some places need, too.
    pub(crate) fn bound_radius(&mut self, places: &[Place], factor: f32) {
        let count = PROBES.min(places.len());
        let place = |i: usize| places[i * places.len() / count].0;
        let median = self.median_of((0..count).map(place));
        if median > 0.0 {
            self.max_radius_sq = self.max_radius_sq.min(factor * factor * median);
        }
    }

    /// Sum `f` times power over the photons round `p` that arrived on the side of the unit normal `n` after at most
    /// `depth` segments, per area.
    pub fn estimate(&self, p: Vec3, n: Vec3, depth: u8, f: impl Fn(&Payload) -> Rgb) -> Estimate {
        self.sum(p, n, depth, |_| true, f)
    }

    /// Sum over those photons whose place `takes` takes.
    #[inline]
    fn sum(
        &self,
        p: Vec3,
        n: Vec3,
        depth: u8,
        mut takes: impl FnMut(Vec3) -> bool,
        f: impl Fn(&Payload) -> Rgb,
    ) -> Estimate {
        let mut sum = Estimate::default();
        let accept = |photon: &Payload, d: u8| d <= depth && photon.normal().dot(n) > SAME_SIDE;
        let (map, k, most) = (&self.map, self.k, self.max_radius_sq);
        sum.found = map.nearest_places(p, k, most, accept, |q, photon, d2, r2| {
            if takes(q) {
                sum.add(photon, f(photon) * photon.power.to_rgb() * self.kernel.weigh(d2, r2));
            }
        });
        sum
    }

    /// As [`Estimator::estimate`], of the photons that are seen from just above `p` (see [`Disc`]), per area of the part of
    /// the disc that is seen. `share` finds one over that part, as it does for [`Disc::inverse_share`]. Also whether all of
    /// the disc is seen, as far as was looked.
    ///
    /// The slide's kernel sums as the slide does, over all photons and the whole disc.
    pub(crate) fn estimate_seen(
        &self,
        scene: &Scene,
        (p, n, depth): (Vec3, Vec3, u8),
        share: impl FnOnce(&Disc) -> f32,
        f: impl Fn(&Payload) -> Rgb,
    ) -> (Estimate, bool) {
        // The farthest photon in each quarter of the disc: what a wall hides is far.
        let frame = Frame::from_normal(n);
        let mut farthest = [(Vec3::ZERO, 0.0f32); 4];
        let note = |q: Vec3| {
            let d = q - p;
            let quarter = usize::from(d.dot(frame.s) < 0.0) + 2 * usize::from(d.dot(frame.t) < 0.0);
            if d.length_squared() > farthest[quarter].1 {
                farthest[quarter] = (q, d.length_squared());
            }
            true
        };
        let all = self.sum(p, n, depth, note, &f);
        let radius = all.found.radius_sq.sqrt();
        if self.kernel == Kernel::Lecture || all.found.count == 0 || !radius.is_finite() {
            return (all, false);
        }
        let disc = Disc::new(scene, p, n, radius, SAME_SIDE);
        let inverse_share = share(&disc);
        let is_seen = |(q, d): &(Vec3, f32)| *d == 0.0 || disc.sees(*q);
        let is_clear = inverse_share == 1.0 && farthest.iter().all(is_seen);
        let mut seen = all;
        if !is_clear {
            let disc = disc.lowered();
            seen = self.sum(p, n, depth, |q| disc.sees(q), f);
        }
        for light in [&mut seen.direct, &mut seen.indirect, &mut seen.caustic] {
            *light *= inverse_share;
        }
        (seen, is_clear)
    }

    /// Irradiance by `k` photons, however far they are.
    pub(crate) fn irradiance_of(&self, k: usize, p: Vec3, n: Vec3) -> Estimate {
        let mut sum = Estimate::default();
        let accept = |photon: &Payload, _: u8| photon.normal().dot(n) > SAME_SIDE;
        sum.found = self.map.nearest(p, k, f32::INFINITY, accept, |photon, d2, r2| {
            sum.add(photon, photon.power.to_rgb() * self.kernel.weigh(d2, r2));
        });
        sum
    }

    /// Visit the photons of an estimate.
    pub(crate) fn visit(&self, p: Vec3, n: Vec3, depth: u8, mut visit: impl FnMut(&Payload)) {
        let accept = |photon: &Payload, d: u8| d <= depth && photon.normal().dot(n) > SAME_SIDE;
        self.map.nearest(p, self.k, self.max_radius_sq, accept, |photon, _, _| visit(photon));
    }

    /// Irradiance on the side of the unit normal `n`.
    pub fn irradiance(&self, p: Vec3, n: Vec3, depth: u8) -> Estimate {
        self.estimate(p, n, depth, |_| Rgb::WHITE)
    }

    /// Irradiance on the seen part of the disc, see [`Estimator::estimate_seen`].
    pub(crate) fn irradiance_seen(
        &self,
        scene: &Scene,
        place: (Vec3, Vec3, u8),
        mut u: impl FnMut() -> [f32; 2],
    ) -> Estimate {
        self.estimate_seen(scene, place, |disc| disc.inverse_share(&mut u), |_| Rgb::WHITE).0
    }

    /// Radiance toward `wo` [slide 24]; delta lobes are not in it. `u` gives uniform points to probe the disc at.
    pub fn radiance(
        &self,
        scene: &Scene,
        (surface, wo, bsdf): (&Surface, Vec3, &Bsdf),
        depth: u8,
        mut u: impl FnMut() -> [f32; 2],
    ) -> Estimate {
        let place = (surface.p, facing(surface, wo), depth);
        let share = |disc: &Disc| disc.inverse_share(&mut u);
        match bsdf.lambertian(wo) {
            Some(albedo) => {
                let f = albedo * INV_PI;
                self.estimate_seen(scene, place, share, |_| f).0
            }
            None => self.estimate_seen(scene, place, share, |p| bsdf.f(wo, p.direction())).0,
        }
    }
}

/// The geometric normal on the side of `wo`.
#[inline]
pub(crate) fn facing(surface: &Surface, wo: Vec3) -> Vec3 {
    if wo.dot(surface.ng) < 0.0 { -surface.ng } else { surface.ng }
}

#[cfg(test)]
mod tests;
