//! The light over the hemisphere of a point: one ray in each of M x N strata.

use std::f32::consts::PI;

use gi_core::math::{Rgb, safe_sqrt};
use glam::Vec3;

/// A hemisphere divided into M rings and N sectors of equal cosine-weighted solid angle. Directions are local, with z
/// along the normal; ring 0 surrounds the normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strata {
    /// M: number of rings, from the normal to the horizon.
    pub rings: usize,
    /// N: number of sectors around the normal.
    pub sectors: usize,
}

impl Strata {
    /// About `rays` strata with M : N near 1 : pi, which makes them about as wide as high \[Ward92\].
    pub fn of(rays: u32) -> Self {
        let rings = (rays as f32 / PI).sqrt().round().max(2.0);
        let sectors = (rays as f32 / rings).round().max(4.0);
        Strata { rings: rings as usize, sectors: sectors as usize }
    }

    /// Number of strata.
    pub fn count(self) -> usize {
        self.rings * self.sectors
    }

    /// Squared sine of the angle where ring `j` begins; ring `j - 1` ends there.
    pub fn sin_sq(self, j: usize) -> f32 {
        j as f32 / self.rings as f32
    }

    /// Angle at which sector `k` begins.
    pub fn phi(self, k: usize) -> f32 {
        2.0 * PI * k as f32 / self.sectors as f32
    }

    /// Direction in stratum (`j`, `k`), sampled in proportion to the cosine [slide 7].
    pub fn direction(self, j: usize, k: usize, [u, v]: [f32; 2]) -> Vec3 {
        let sin_sq = (j as f32 + u) / self.rings as f32;
        let phi = 2.0 * PI * (k as f32 + v) / self.sectors as f32;
        let (sin, (sin_phi, cos_phi)) = (sin_sq.sqrt(), phi.sin_cos());
        Vec3::new(sin * cos_phi, sin * sin_phi, safe_sqrt(1.0 - sin_sq))
    }
}

/// The result of one ray.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Its direction, local.
    pub direction: Vec3,
    /// Incoming radiance.
    pub radiance: Rgb,
    /// Distance of the first surface, world; infinite if there is none.
    pub distance: f32,
    /// Unit normal of that surface, local; it may point to either side.
    pub normal: Vec3,
}

/// The results of all rays of a hemisphere, ring by ring.
#[derive(Clone, Debug)]
pub struct Hemisphere {
    /// How it is divided.
    pub strata: Strata,
    seen: Vec<Seen>,
}

/// Fraction and smallest number of rays that [`Hemisphere::without_sparks`] treats as outliers.
const SPARKS: f32 = 0.01;
const FEWEST_SPARKS: usize = 2;

impl Hemisphere {
    /// Trace one ray per stratum: `jitter` gives its position in the stratum, `look` its result.
    pub fn gather(
        strata: Strata,
        mut jitter: impl FnMut(usize) -> [f32; 2],
        mut look: impl FnMut(usize, Vec3) -> Seen,
    ) -> Self {
        let seen = (0..strata.count())
            .map(|i| {
                let d = strata.direction(i / strata.sectors, i % strata.sectors, jitter(i));
                look(i, d)
            })
            .collect();
        Hemisphere { strata, seen }
    }

    /// The result of the ray in ring `j` and sector `k`.
    #[inline]
    pub fn at(&self, j: usize, k: usize) -> &Seen {
        &self.seen[j * self.strata.sectors + k]
    }

    /// The results of all rays, ring by ring.
    pub fn all(&self) -> &[Seen] {
        &self.seen
    }

    /// The same hemisphere with its few brightest rays limited to the next brightest one. The region of validity must
    /// not depend on such outliers: records with a bright outlier would get small radii and records without one large
    /// radii, so that the light between records would be too dark.
    pub fn without_sparks(&self) -> Self {
        let few = ((SPARKS * self.seen.len() as f32) as usize).max(FEWEST_SPARKS);
        let mut means: Vec<f32> = self.seen.iter().map(|s| s.radiance.mean()).collect();
        let next = means.len() - 1 - few.min(means.len() - 1);
        let most = *means.select_nth_unstable_by(next, f32::total_cmp).1;
        let calm = |s: &Seen| {
            let mean = s.radiance.mean();
            let factor = if mean > most { most / mean } else { 1.0 };
            Seen { radiance: s.radiance * factor, ..*s }
        };
        Hemisphere { strata: self.strata, seen: self.seen.iter().map(calm).collect() }
    }

    /// E = pi / N sum_j L_i(x, w_j) [slide 7].
    pub fn irradiance(&self) -> Rgb {
        let sum: Rgb = self.seen.iter().map(|s| s.radiance).sum();
        sum * (PI / self.seen.len() as f32)
    }

    /// Harmonic mean N / sum_i 1 / d_i of the distances [slide 9]; infinite if no ray hits a surface.
    pub fn harmonic_mean(&self) -> f32 {
        let sum: f64 = self.seen.iter().map(|s| 1.0 / f64::from(s.distance)).sum();
        (self.seen.len() as f64 / sum) as f32
    }

    /// Smallest distance; infinite if no ray hits a surface.
    pub fn nearest(&self) -> f32 {
        self.seen.iter().map(|s| s.distance).fold(f32::INFINITY, f32::min)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use gi_core::rng::Pcg;

    /// A hemisphere whose rays return what `look` gives for a direction: radiance, distance, normal.
    pub(crate) fn hemisphere(
        strata: Strata,
        seed: u64,
        look: impl Fn(Vec3) -> (Rgb, f32, Vec3),
    ) -> Hemisphere {
        let mut rng = Pcg::new(seed, 11);
        Hemisphere::gather(
            strata,
            |_| rng.next_2d(),
            |_, direction| {
                let (radiance, distance, normal) = look(direction);
                Seen { direction, radiance, distance, normal }
            },
        )
    }

    #[test]
    fn from_the_middle_of_a_sphere_the_harmonic_mean_is_its_radius() {
        for rays in [12, 100, 1000] {
            let h = hemisphere(Strata::of(rays), 1, |w| (Rgb::WHITE, 2.5, -w));
            assert!((h.harmonic_mean() - 2.5).abs() < 1e-6, "{}", h.harmonic_mean());
            assert_eq!(h.nearest(), 2.5);
        }
    }

    #[test]
    fn a_constant_sky_of_radiance_l_gives_pi_l() {
        let l = Rgb::new(0.5, 1.0, 2.0);
        let h = hemisphere(Strata::of(500), 2, |w| (l, f32::INFINITY, -w));
        let e = h.irradiance();
        assert!((e.r - 0.5 * PI).abs() < 1e-5 && (e.b - 2.0 * PI).abs() < 1e-5, "{e:?}");
        assert_eq!(h.harmonic_mean(), f32::INFINITY);
    }

    #[test]
    fn strata_are_near_one_to_pi_and_contain_their_directions() {
        for rays in [10, 100, 1000, 5000] {
            let s = Strata::of(rays);
            let off = s.count() as f32 / rays as f32 - 1.0;
            assert!(off.abs() < 0.21, "{rays} rays: {s:?}");
            let ratio = s.sectors as f32 / s.rings as f32;
            assert!(rays < 100 || (ratio - PI).abs() < 0.35, "{rays} rays: {s:?}");
            let mut rng = Pcg::new(3, 0);
            for (j, k) in [(0, 0), (s.rings - 1, s.sectors - 1), (s.rings / 2, 1)] {
                let d = s.direction(j, k, rng.next_2d());
                assert!((d.length() - 1.0).abs() < 1e-5);
                let sin_sq = 1.0 - d.z * d.z;
                assert!(sin_sq >= s.sin_sq(j) - 1e-4 && sin_sq <= s.sin_sq(j + 1) + 1e-4);
                let phi = d.y.atan2(d.x).rem_euclid(2.0 * PI);
                assert!(phi >= s.phi(k) - 1e-4 && phi <= s.phi(k + 1) + 1e-4);
            }
        }
    }

    #[test]
    fn a_single_bright_ray_hardly_changes_the_reach_of_a_record() {
        use crate::control::{Control, ErrorControl, SphereRadius};
        use crate::gradients::translational;
        let room = |spark: f32| {
            let mut rng = Pcg::new(5, 11);
            let look = |i: usize, w: Vec3| {
                let emitted = 1.0 + w.x + if i == 40 { spark } else { 0.0 };
                Seen { direction: w, radiance: Rgb::grey(emitted), distance: 1.0, normal: -w }
            };
            Hemisphere::gather(Strata::of(200), |_| rng.next_2d(), look)
        };
        let (dark, bright) = (room(0.0), room(1e4));
        assert!(
            bright.irradiance().g > 10.0 * dark.irradiance().g,
            "the irradiance includes the bright rays"
        );
        for error in
            [ErrorControl::Bounded, ErrorControl::HessianGeometric, ErrorControl::HessianOcclusion]
        {
            let control = Control { error, radius: SphereRadius::Harmonic, accuracy: 0.1 };
            let radius = |h: &Hemisphere| {
                let h = h.without_sparks();
                control.validity(&h, h.irradiance(), &translational(&h), 1.0).radii[0]
            };
            // One ray in 200 is as bright as the brightest others. Without a limit, that ray alone would determine E /
            // |H| and E / |gradient|.
            let ratio = radius(&bright) / radius(&dark);
            assert!((ratio - 1.0).abs() < 0.35, "{error:?}: {ratio}");
        }
    }
}
