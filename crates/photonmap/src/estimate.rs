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
    #[inline]
    fn add(&mut self, photon: &Payload, light: Rgb) {
        match photon.kind() {
            Kind::Direct => self.direct += light,
            Kind::Caustic => self.caustic += light,
            Kind::Indirect => self.indirect += light,
        }
    }

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
    pub fn estimate(&self, p: Vec3, n: Vec3, depth: u8, f: impl Fn(&Payload) -> Rgb) -> Estimate {
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
            sum.add(photon, f(photon) * photon.power.to_rgb() * kernel.weigh(d2, r2));
        });
        sum
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Layout, Order};
    use crate::photon::{Photon, Rgbe};
    use crate::shoot::{Source, Stored, Wanted};
    use crate::test_scenes::lit_plane;
    use gi_core::rng::Pcg;
    use gi_stats::Running;

    fn estimator(kernel: Kernel, k: usize, max_radius: f32) -> Estimator {
        let scene = lit_plane();
        let source = Source { scene: &scene, seed: 5, max_segments: None, media: false };
        let shot = source.shoot(Wanted::Global, 100_000);
        let map = PhotonMap::build(shot.photons, shot.emitted, Layout::Fast, Order::Any, false);
        Estimator::new(map, kernel, k, max_radius)
    }

    /// The same plane, strewn with photons that know nothing of each other: those of a light lie more evenly.
    fn strewn(kernel: Kernel, k: usize) -> Estimator {
        let mut rng = Pcg::new(6, 0);
        let n = 100_000u32;
        let power = Rgbe::nearest(Rgb::grey(3.0 * 4.0 / n as f32));
        let photons = (0..n).map(|_| {
            let [x, z] = rng.next_2d().map(|u| 2.0 * u - 1.0);
            let photon = Photon::new(Vec3::new(x, 0.0, z), power, Vec3::Y, Vec3::Y, Kind::Direct);
            Stored { photon, depth: 1 }
        });
        let photons = photons.collect();
        let map = PhotonMap::build(photons, n.into(), Layout::Fast, Order::Any, false);
        Estimator::new(map, kernel, k, 0.0)
    }

    /// Check the mean of estimates all over the plane.
    fn assert_reads(name: &str, estimator: &Estimator, expected: f64) {
        // Discs have a radius of at most 0.03: 17 by 17 of them do not overlap.
        let mut e = Running::default();
        for i in 0..17 * 17 {
            let at = |j: usize| (j as f32 - 8.0) * 0.11;
            let p = Vec3::new(at(i % 17), 0.0, at(i / 17));
            e.push(f64::from(estimator.irradiance(p, Vec3::Y, 255).all().g));
        }
        // Powers have eight bits.
        let error = e.variance_of_mean().sqrt() + expected * 0.001;
        let mean = e.mean();
        assert!(
            (mean - expected).abs() < 4.0 * error,
            "{name}: {mean} is not {expected} +- {error}"
        );
        assert!(error < 0.04, "{name}: {error}");
    }

    #[test]
    fn a_uniformly_lit_plane_reads_its_irradiance_whatever_the_kernel() {
        for kernel in Kernel::ALL {
            // All photons within a radius, and the nearest fifty: only there the slide's formula is too bright.
            assert_reads(&format!("{kernel:?}, radius"), &estimator(kernel, 2000, 0.03), 3.0);
            let factor = if kernel == Kernel::Lecture { 50.0 / 49.0 } else { 1.0 };
            assert_reads(&format!("{kernel:?}, nearest"), &strewn(kernel, 50), 3.0 * factor);
        }
    }

    #[test]
    fn photons_of_the_other_side_of_a_thin_wall_neither_shine_through_nor_count() {
        let estimator = estimator(Kernel::Box, 50, 0.0);
        let e = estimator.irradiance(Vec3::new(0.1, -1e-3, 0.2), -Vec3::Y, 255);
        assert_eq!((e.found.count, e.all()), (0, Rgb::BLACK));
        // Round a corner neither.
        let e = estimator.irradiance(Vec3::ZERO, Vec3::X, 255);
        assert_eq!((e.found.count, e.all()), (0, Rgb::BLACK));
    }

    #[test]
    fn photons_that_went_further_than_is_asked_for_do_not_count() {
        let scene = crate::test_scenes::lit_sphere();
        let source = Source { scene: &scene, seed: 5, max_segments: None, media: false };
        let shot = source.shoot(Wanted::Global, 50_000);
        let map = PhotonMap::build(shot.photons, shot.emitted, Layout::Fast, Order::Any, true);
        let estimator = Estimator::new(map, Kernel::Box, 200, 0.0);
        // Irradiance 1 from the light, and half of the last from each scattering.
        for (depth, expected) in [(1u8, 1.0), (2, 1.5), (3, 1.75), (255, 2.0)] {
            let mut e = Running::default();
            for i in 0..100u32 {
                let p = gi_core::warp::sphere([(i as f32 + 0.5) / 100.0, i as f32 * 0.618_034]);
                e.push(f64::from(estimator.irradiance(p, -p, depth).all().g));
            }
            let error = e.variance_of_mean().sqrt();
            assert!((e.mean() - expected).abs() < 4.0 * error, "{depth}: {} +- {error}", e.mean());
        }
    }
}
