//! The radiance estimate [slide 24]: light from the density of photons round a point.

use gi_core::bsdf::Bsdf;
use gi_core::geometry::Surface;
use gi_core::math::{INV_PI, Rgb};
use glam::Vec3;

use crate::kernel::Kernel;
use crate::map::{Found, PhotonMap};
use crate::photon::{Kind, Payload};

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
const SAME_SIDE: f32 = 0.8;
/// Photons whose neighbourhoods an automatic radius is the median of, and how many times that it is.
const PROBES: usize = 256;
const RADIUS_FACTOR: f32 = 3.0;

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
    /// Light of every kind.
    pub fn all(&self) -> Rgb {
        self.direct + self.caustic + self.indirect
    }
}

impl Estimator {
    /// Read `map` by `k` photons an estimate; a `max_radius` of 0 (world units) is three times what half of the photons need.
    pub fn new(map: PhotonMap, kernel: Kernel, k: usize, max_radius: f32) -> Self {
        let mut estimator = Estimator { map, kernel, k, max_radius_sq: f32::INFINITY };
        estimator.max_radius_sq = if max_radius > 0.0 {
            max_radius * max_radius
        } else {
            RADIUS_FACTOR * RADIUS_FACTOR * estimator.median_radius_sq()
        };
        estimator
    }

    /// The median over some photons of the squared radius that holds k of them.
    fn median_radius_sq(&self) -> f32 {
        let n = self.map.len();
        let k = self.k.min(n);
        let probe = |i: usize| {
            let p = self.map.stored(i * n / PROBES.min(n)).photon.p();
            self.map.nearest(p, k, f32::INFINITY, |_, _| true, |_, _, _| {}).radius_sq
        };
        let mut radii: Vec<f32> = (0..PROBES.min(n)).map(probe).filter(|r| *r > 0.0).collect();
        radii.sort_by(f32::total_cmp);
        radii.get(radii.len() / 2).copied().unwrap_or(0.0)
    }

    /// Sum `f` times power over the photons round `p` that arrived on the side of the unit normal `n` after at most
    /// `depth` segments, per area.
    pub fn estimate(
        &self,
        p: Vec3,
        n: Vec3,
        depth: u8,
        f: impl Fn(&Payload) -> Rgb,
    ) -> Estimate {
        self.estimate_by(self.kernel, p, n, depth, f)
    }

    fn estimate_by(
        &self,
        kernel: Kernel,
        p: Vec3,
        n: Vec3,
        depth: u8,
        f: impl Fn(&Payload) -> Rgb,
    ) -> Estimate {
        let mut sum = Estimate::default();
        let accept = |photon: &Payload, d: u8| d <= depth && photon.normal().dot(n) > SAME_SIDE;
        sum.found = self.map.nearest(p, self.k, self.max_radius_sq, accept, |photon, d2, r2| {
            let light = f(photon) * photon.power.to_rgb() * kernel.weigh(d2, r2);
            match photon.kind() {
                Kind::Direct => sum.direct += light,
                Kind::Caustic => sum.caustic += light,
                Kind::Indirect => sum.indirect += light,
            }
        });
        sum
    }

    /// Irradiance on the side of the unit normal `n`.
    pub fn irradiance(&self, p: Vec3, n: Vec3, depth: u8) -> Estimate {
        self.estimate(p, n, depth, |_| Rgb::WHITE)
    }

    /// The same by another kernel.
    pub(crate) fn irradiance_by(&self, kernel: Kernel, p: Vec3, n: Vec3, depth: u8) -> Estimate {
        self.estimate_by(kernel, p, n, depth, |_| Rgb::WHITE)
    }

    /// Radiance toward `wo` [slide 24]; delta lobes are not in it.
    pub fn radiance(&self, surface: &Surface, wo: Vec3, bsdf: &Bsdf, depth: u8) -> Estimate {
        let n = facing(surface, wo);
        match bsdf.lambertian(wo) {
            Some(albedo) => {
                let f = albedo * INV_PI;
                self.estimate(surface.p, n, depth, |_| f)
            }
            None => self.estimate(surface.p, n, depth, |photon| bsdf.f(wo, photon.direction())),
        }
    }
}

/// The geometric normal on the side of `wo`.
#[inline]
pub(crate) fn facing(surface: &Surface, wo: Vec3) -> Vec3 {
    if wo.dot(surface.ng) < 0.0 { -surface.ng } else { surface.ng }
}
