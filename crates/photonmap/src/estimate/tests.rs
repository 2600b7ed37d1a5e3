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
    Estimator::new(map, kernel, k, max_radius, 3.0)
}

/// The same plane, strewn with photons that know nothing of each other: those of a light lie more evenly.
fn strewn(kernel: Kernel, k: usize) -> Estimator {
    let mut rng = Pcg::new(6, 0);
    let n = 100_000u32;
    let power = Rgbe::nearest(Rgb::grey(3.0 * 4.0 / n as f32));
    let photons = (0..n).map(|_| {
        let [x, z] = rng.next_2d().map(|u| 2.0 * u - 1.0);
        let photon = Photon::new(Vec3::new(x, 0.0, z), power, Vec3::Y, Vec3::Y, PhotonKind::Direct);
        Stored { photon, depth: 1 }
    });
    let photons = photons.collect();
    let map = PhotonMap::build(photons, n.into(), Layout::Fast, Order::Any, false);
    Estimator::new(map, kernel, k, 0.0, 3.0)
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
    assert!((mean - expected).abs() < 4.0 * error, "{name}: {mean} is not {expected} +- {error}");
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
    let estimator = Estimator::new(map, Kernel::Box, 200, 0.0, 3.0);
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
