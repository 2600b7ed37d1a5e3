//! Compares instant radiosity with the path tracer and with itself.

use gi_core::eye::PathLimits;
use gi_core::film::{Film, Show};
use gi_core::math::Rgb;
use gi_stats::{Running, sidak, welch_t_test};
use gi_tests::{World, furnace, mean_and_variance};
use instant_radiosity::{InstantRadiosity, Params};
use pathtrace::PathTracer;
use vpl::{BoundOptions, Direct, Termination};

use crate::agreement::blocks;

fn render(world: &World, params: &Params, passes: u32, seed: u32, show: Show) -> Film {
    world.render::<InstantRadiosity>(params, passes, seed, show)
}

/// Means of the blocks of pictures with different seeds. Pixels of one picture share their lights, so only pictures are
/// independent.
fn by_seed(seeds: u32, side: usize, film: impl Fn(u32) -> Film) -> Vec<Vec<f64>> {
    (0..seeds).map(|seed| blocks(&film(seed), side).into_iter().map(|b| b.0).collect()).collect()
}

/// Check that two sets of independent pictures have the same means, block by block.
fn assert_same_means(name: &str, a: &[Vec<f64>], b: &[Vec<f64>]) {
    let blocks = a[0].len();
    let level = sidak(1e-3, blocks);
    for k in 0..blocks {
        let column = |pictures: &[Vec<f64>]| pictures.iter().map(|p| p[k]).collect::<Running>();
        let (a, b) = (column(a), column(b));
        let p = welch_t_test(&a, &b);
        assert!(p > level, "{name}, block {k}: {} against {}, p = {p:.1e}", a.mean(), b.mean());
    }
}

fn path_traced(world: &World, show: Show) -> Vec<Vec<f64>> {
    by_seed(16, 8, |seed| world.render::<PathTracer>(&pathtrace::Params::default(), 64, seed, show))
}

#[test]
fn with_compensation_the_mean_picture_is_that_of_the_path_tracer() {
    for scene in ["cornell-box.xml", "cornell-glossy.xml", "cornell-spheres.xml"] {
        let world = World::load(scene, [16, 16], &[]);
        let path = path_traced(&world, Show::Indirect);
        for termination in [Termination::Fractional, Termination::Roulette] {
            // A low bound, so that the compensating paths carry much light.
            let bound = BoundOptions::compensated(4.0);
            let params = Params { termination, bound, vpls: 64, ..Params::default() };
            let vpl = by_seed(24, 8, |seed| render(&world, &params, 8, 100 + seed, Show::Indirect));
            assert_same_means(&format!("{scene}, {termination:?}"), &vpl, &path);
        }
    }
}

#[test]
fn direct_light_from_points_on_lights_is_that_of_sampling_them() {
    // An area light, and the sun with the sky.
    for (scene, size) in [("cornell-box.xml", [16, 16]), ("patio.xml", [16, 12])] {
        let world = World::load(scene, size, &[]);
        let path = path_traced(&world, Show::Direct);
        let bound = BoundOptions::compensated(f32::INFINITY);
        let params = Params { direct: Direct::Vpl, bound, vpls: 256, ..Params::default() };
        let vpl = by_seed(24, 8, |seed| render(&world, &params, 8, 100 + seed, Show::Direct));
        assert_same_means(scene, &vpl, &path);
    }
}

#[test]
fn a_bound_only_removes_light_from_pixels() {
    let world = World::load("cornell-box.xml", [24, 24], &[]);
    let film = |clamp: f32| {
        let bound = BoundOptions::biased(clamp);
        let params = Params { bound, vpls: 64, ..Params::default() };
        world.run::<InstantRadiosity>(&params, 2, 5, Show::Indirect)
    };
    let (_, open) = film(f32::INFINITY);
    let mut last = 0.0;
    for clamp in [100.0, 10.0, 1.0] {
        let (technique, bounded) = film(clamp);
        for (a, b) in bounded.radiance().iter().zip(open.radiance()) {
            assert!(a.r <= b.r && a.g <= b.g && a.b <= b.b, "{a:?} above {b:?}");
        }
        // The light that is reported as cut off must be the light that is missing.
        let (a, b) = (mean(&bounded), mean(&open));
        let said = statistic(&technique, "energy_cut");
        assert!((said - (1.0 - a / b)).abs() < 0.02, "{said} said, {} missing", 1.0 - a / b);
        assert!(said > last);
        last = said;
    }
    // No bound is the same as a bound above all geometry terms.
    let (_, huge) = film(1e30);
    assert_eq!(huge.layers().channels, open.layers().channels);
}

fn mean(film: &Film) -> f64 {
    film.radiance().iter().map(|c| f64::from(c.luminance())).sum()
}

fn statistic(technique: &InstantRadiosity, name: &str) -> f64 {
    use gi_core::technique::Technique;
    let all = technique.statistics();
    all.iter().find(|(n, _)| n == name).unwrap_or_else(|| panic!("no {name}")).1
}

#[test]
fn a_growing_bound_loses_less() {
    let world = World::load("cornell-box.xml", [16, 16], &[]);
    let cut = |relaxation: f32| {
        let bound = BoundOptions::biased(2.0);
        let params = Params { relaxation, bound, vpls: 64, ..Params::default() };
        let (technique, _) = world.run::<InstantRadiosity>(&params, 8, 5, Show::Indirect);
        statistic(&technique, "energy_cut")
    };
    let (still, growing) = (cut(0.0), cut(1.0));
    assert!(growing < 0.6 * still, "{growing} of {still}");
}

#[test]
fn a_furnace_cut_at_k_bounces_reads_the_geometric_sum() {
    let a = 0.6f64;
    let (parts, camera) = furnace(a as f32);
    let world = World::new(parts, &camera);
    for depth in [2u32, 3, 4, 6] {
        let limits = PathLimits { max_depth: Some(depth), ..PathLimits::default() };
        for termination in [Termination::Fractional, Termination::Roulette] {
            let bound = BoundOptions::compensated(3.0);
            let params = Params { limits, termination, bound, vpls: 64, ..Params::default() };
            let means: Vec<f64> = (0..16)
                .map(|seed| mean_and_variance(&render(&world, &params, 4, seed, Show::All)).0)
                .collect();
            let n = means.len() as f64;
            let mean = means.iter().sum::<f64>() / n;
            let error =
                (means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
            let expected = (1.0 - a.powi(depth as i32)) / (1.0 - a);
            // t with 15 degrees of freedom exceeds 4.1 once in a thousand cases; floats have seven digits.
            assert!(
                (mean - expected).abs() < 4.1 * error + 1e-5,
                "{depth} segments, {termination:?}: {mean} +- {error} is not {expected}"
            );
        }
    }
}

#[test]
fn spheres_have_no_bright_spots_and_their_blur_shrinks_with_the_number_of_lights() {
    let world = World::load("cornell-glossy.xml", [32, 32], &[]);
    let reference =
        world.render::<PathTracer>(&pathtrace::Params::default(), 1024, 3, Show::Indirect);
    let film = |vsl: bool, vpls: u32| {
        let bound = BoundOptions::biased(f32::INFINITY);
        let params = Params { vsl, bound, vpls, ..Params::default() };
        render(&world, &params, 2, 5, Show::Indirect)
    };
    let error = |film: &Film| {
        let pairs = film.radiance().into_iter().zip(reference.radiance());
        let relative = |(a, b): (Rgb, Rgb)| {
            f64::from((a - b).luminance().powi(2) / (b.luminance().powi(2) + 1e-2))
        };
        pairs.map(relative).sum::<f64>()
    };
    // The same lights as points and as spheres: points have no bias, spheres blur light over edges.
    let pairs = [256, 4096].map(|vpls| [film(false, vpls), film(true, vpls)]);
    let lost = |[points, spheres]: &[Film; 2]| 1.0 - mean(spheres) / mean(points);
    for [points, spheres] in &pairs {
        let (a, b) = (error(spheres), error(points));
        assert!(a < 0.5 * b, "error of spheres {a}, of points {b}");
    }
    let (few, many) = (lost(&pairs[0]), lost(&pairs[1]));
    assert!(few > 2.0 * many && many < 0.04, "light lost: {few} with few lights, {many} with many");
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let bits = |threads: usize, params: &Params| -> Vec<u32> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let world = World::load("cornell-glossy.xml", [40, 30], &[]);
            let layers = render(&world, params, 2, 7, Show::All).layers();
            layers.channels.into_iter().flat_map(|(_, v)| v.into_iter().map(f32::to_bits)).collect()
        })
    };
    let spheres = Params { vsl: true, vpls: 64, ..Params::default() };
    for params in [Params { direct: Direct::Vpl, vpls: 64, ..Params::default() }, spheres] {
        let one = bits(1, &params);
        assert!([2, 4].into_iter().all(|threads| bits(threads, &params) == one), "{params:?}");
    }
}
