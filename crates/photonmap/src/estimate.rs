//! The radiance estimate [slide 24]: light from the density of photons round a point.

use gi_core::disc::Disc;
use gi_core::geometry::Surface;
use gi_core::math::{Frame, Rgb};
use gi_core::scene::Scene;
use glam::Vec3;

use crate::kernel::Kernel;
use crate::map::{Found, PhotonMap};
use crate::photon::{Payload, PhotonKind};

/// A point at which the global map will be read, and the unit normal on the side that is seen.
pub(crate) type Place = (Vec3, Vec3);

/// A photon map, and how it is read.
pub struct Estimator {
    /// The photons.
    pub map: PhotonMap,
    /// How photons are weighted by distance.
    pub kernel: Kernel,
    /// Maximum number of photons of an estimate.
    pub k: usize,
    /// Square of the largest radius, world units.
    pub max_radius_sq: f32,
}

/// A photon lights a point only if the cosine between its surface's normal and the point's is larger: not round a corner
/// and not through a wall, but on the next facet of a curved mesh. The limit is tight, because a photon map keeps
/// normals to 3 degrees only, and because the radius does not shrink.
pub(crate) const SAME_SIDE: f32 = 0.8;
/// An automatic radius is the median over the neighbourhoods of this many photons.
const PROBES: usize = 256;

/// A density estimate, by what the light has met before.
#[derive(Clone, Copy, Debug, Default)]
pub struct Density {
    /// L D.
    pub direct: Rgb,
    /// L S+ D.
    pub caustic: Rgb,
    /// L .* D .* D: light that another surface scattered by other than delta lobes.
    pub indirect: Rgb,
    /// The photons.
    pub found: Found,
}

impl Density {
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
    /// Read `map` with `k` photons per estimate. If `max_radius` (world units) is 0, it becomes `factor` times the radius that
    /// half of the photons need.
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

    /// Also limit the radius to `factor` times the radius that half of some places need.
    pub(crate) fn bound_radius(&mut self, places: &[Place], factor: f32) {
        let count = PROBES.min(places.len());
        let place = |i: usize| places[i * places.len() / count].0;
        let median = self.median_of((0..count).map(place));
        if median > 0.0 {
            self.max_radius_sq = self.max_radius_sq.min(factor * factor * median);
        }
    }

    /// Sum of `light` over the photons near `p` that arrived on the side of the unit normal `n` after at most `depth`
    /// segments, per area.
    pub fn density(&self, p: Vec3, n: Vec3, depth: u8, light: impl Fn(&Payload) -> Rgb) -> Density {
        self.sum(p, n, depth, |_| true, |photon, per_area| light(photon) * per_area)
    }

    /// Sum of `light` over those photons whose position `takes` accepts [slide 24]. `light` gets a photon and its weight per area:
    /// 1 / (pi r^2), changed by the kernel.
    #[inline]
    fn sum(
        &self,
        p: Vec3,
        n: Vec3,
        depth: u8,
        mut takes: impl FnMut(Vec3) -> bool,
        light: impl Fn(&Payload, f32) -> Rgb,
    ) -> Density {
        let mut sum = Density::default();
        let accept = |photon: &Payload, d: u8| d <= depth && photon.normal().dot(n) > SAME_SIDE;
        let (map, k, most) = (&self.map, self.k, self.max_radius_sq);
        sum.found = map.nearest_places(p, k, most, accept, |q, photon, d2, r2| {
            if takes(q) {
                sum.add(photon, light(photon, self.kernel.weigh(d2, r2)));
            }
        });
        sum
    }

    /// Sum of `light` over the photons that are visible from just above `p` (see [`Disc`]), per area of the visible part of the disc.
    /// `light` gets a photon and its weight per area: 1 / (pi r^2), changed by the kernel. `share` estimates the disc's area over that of the visible part, as
    /// [`Disc::inverse_share`] does. Also returns whether the whole disc seems visible.
    ///
    /// The slide's kernel sums as the slide does, over all photons and the whole disc.
    pub(crate) fn density_seen_by(
        &self,
        scene: &Scene,
        (p, n, depth): (Vec3, Vec3, u8),
        share: impl FnOnce(&Disc) -> f32,
        light: impl Fn(&Payload, f32) -> Rgb,
    ) -> (Density, bool) {
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
        let all = self.sum(p, n, depth, note, &light);
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
            seen = self.sum(p, n, depth, |q| disc.sees(q), light);
        }
        for part in [&mut seen.direct, &mut seen.indirect, &mut seen.caustic] {
            *part *= inverse_share;
        }
        (seen, is_clear)
    }

    /// The same, unbiased. `u` gives uniform points at which the disc is probed.
    pub(crate) fn density_seen(
        &self,
        scene: &Scene,
        place: (Vec3, Vec3, u8),
        mut u: impl FnMut() -> [f32; 2],
        light: impl Fn(&Payload, f32) -> Rgb,
    ) -> Density {
        self.density_seen_by(scene, place, |disc| disc.inverse_share(&mut u), light).0
    }

    /// Irradiance from the `k` nearest photons, without a limit on the radius.
    pub(crate) fn irradiance_of(&self, k: usize, p: Vec3, n: Vec3) -> Density {
        let mut sum = Density::default();
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
    pub fn irradiance(&self, p: Vec3, n: Vec3, depth: u8) -> Density {
        self.density(p, n, depth, |photon| photon.power.to_rgb())
    }

    /// Irradiance on the visible part of the disc, see [`Estimator::density_seen`].
    pub(crate) fn irradiance_seen(
        &self,
        scene: &Scene,
        place: (Vec3, Vec3, u8),
        u: impl FnMut() -> [f32; 2],
    ) -> Density {
        self.density_seen(scene, place, u, |photon, per_area| photon.power.to_rgb() * per_area)
    }
}

/// The geometric normal on the side of `wo`.
#[inline]
pub(crate) fn facing(surface: &Surface, wo: Vec3) -> Vec3 {
    if wo.dot(surface.ng) < 0.0 { -surface.ng } else { surface.ng }
}

#[cfg(test)]
mod tests;
