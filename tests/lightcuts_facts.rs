//! Compares lightcuts with brute force, with instant radiosity, with the path tracer, and with themselves.

use gi_core::camera::{CameraSpec, Projection};
use gi_core::eye::PathLimits;
use gi_core::film::{Film, Show};
use gi_core::filter::Filter;
use gi_core::options::Caustics;
use gi_core::scene::SceneParts;
use gi_core::technique::Technique;
use gi_stats::{Running, sidak, welch_t_test};
use gi_tests::{World, furnace, mean_and_variance};
use instant_radiosity::InstantRadiosity;
use lightcuts::cut::{Limits, Rule};
use lightcuts::{Lightcuts, Method, Params, Reconstruction};
use pathtrace::PathTracer;
use vpl::{BoundOptions, Compensation, Direct};

use crate::agreement::blocks;

fn render(world: &World, params: &Params, passes: u32, seed: u32, show: Show) -> Film {
    world.render::<Lightcuts>(params, passes, seed, show)
}

fn few_lights() -> Params {
    let mut params = Params { vpls: 300, ..Params::default() };
    params.lights.total = 200;
    params
}

/// The error of each pixel relative to the other picture, as luminance, sorted.
fn relative_errors(a: &Film, b: &Film) -> Vec<f32> {
    let pairs = a.radiance().into_iter().zip(b.radiance());
    let lit = pairs.filter(|(_, b)| b.luminance() > 0.0);
    let mut errors: Vec<f32> =
        lit.map(|(a, b)| ((a - b).luminance() / b.luminance()).abs()).collect();
    errors.sort_unstable_by(f32::total_cmp);
    errors
}

#[test]
fn with_error_zero_it_is_brute_force_and_instant_radiosity() {
    for (scene, size) in
        [("cornell-box.xml", [24, 24]), ("gallery.xml", [24, 18]), ("patio.xml", [24, 18])]
    {
        let world = World::load(scene, size, &[]);
        let cut = Limits { error: 0.0, rule: Rule::Whole, max_cut: Some(u32::MAX) };
        let exact = Params { cut, ..few_lights() };
        let by_cuts = render(&world, &exact, 2, 5, Show::All);
        let all = Params { method: Method::All, ..exact.clone() };
        let brute = render(&world, &all, 2, 5, Show::All);
        // The sums of some hundred terms are in a different order. The compensating paths are the same.
        let errors = relative_errors(&by_cuts, &brute);
        assert!(errors[errors.len() - 1] < 1e-4, "{scene}: {:?}", errors.last());

        // The same lights on surfaces; direct light is sampled with the same random numbers.
        let bound = BoundOptions::compensated(4.0);
        let indirect = Params { direct: Direct::Sample, bound, ..exact };
        let by_cuts = render(&world, &indirect, 2, 5, Show::All);
        let params = instant_radiosity::Params {
            vpls: indirect.vpls,
            bound,
            ..instant_radiosity::Params::default()
        };
        let instant = world.render::<InstantRadiosity>(&params, 2, 5, Show::All);
        let errors = relative_errors(&by_cuts, &instant);
        assert!(errors[errors.len() - 1] < 1e-4, "{scene}: {:?}", errors.last());
    }
}

#[test]
fn errors_stay_below_the_threshold_and_cuts_shrink_as_it_rises() {
    for (scene, defines) in [("gallery.xml", &[("lights", "1024")][..]), ("patio.xml", &[])] {
        let world = World::load(scene, [40, 30], defines);
        let mut params = Params { vpls: 3000, ..Params::default() };
        params.bound.compensation = Compensation::None;
        params.lights.total = 1024;
        let all = Params { method: Method::All, ..params.clone() };
        let brute = render(&world, &all, 1, 5, Show::All);
        let mut last = f64::INFINITY;
        for error in [0.01, 0.02, 0.08] {
            let cut = Limits { error, rule: Rule::Whole, max_cut: Some(3000) };
            let with = Params { cut, ..params.clone() };
            let (technique, film) = world.run::<Lightcuts>(&with, 1, 5, Show::All);
            let errors = relative_errors(&film, &brute);
            let of = |share: f32| errors[(share * errors.len() as f32) as usize];
            assert!(of(0.99) < error, "{scene}: {} for {error}", of(0.99));
            let size = statistic(&technique, "mean_cut");
            assert!(size < 0.9 * last, "{scene}: cuts of {size} for {error}, {last} before");
            last = size;
        }
    }
}

fn statistic(technique: &Lightcuts, name: &str) -> f64 {
    let all = technique.statistics();
    all.iter().find(|(n, _)| n == name).unwrap_or_else(|| panic!("no {name}")).1
}

/// Means of the blocks of pictures with different seeds. Pixels of one picture share their lights.
fn by_seed(seeds: u32, film: impl Fn(u32) -> Film) -> Vec<Vec<f64>> {
    (0..seeds).map(|seed| blocks(&film(seed), 8).into_iter().map(|b| b.0).collect()).collect()
}

/// One cut for several camera paths, which connects every point with every light.
fn exact_pairs(gather: u32) -> Params {
    let cut = Limits { error: 0.0, rule: Rule::Whole, max_cut: None };
    Params { method: Method::Multidimensional, gather, cut, ..few_lights() }
}

#[test]
fn a_cut_for_one_camera_path_is_the_cut_of_its_points() {
    for scene in ["cornell-glossy.xml", "gallery.xml"] {
        let world = World::load(scene, [24, 18], &[]);
        let pairs = render(&world, &exact_pairs(1), 2, 5, Show::All);
        let cuts = Params { method: Method::Cuts, ..exact_pairs(1) };
        let errors = relative_errors(&pairs, &render(&world, &cuts, 2, 5, Show::All));
        assert!(errors[errors.len() - 1] < 1e-4, "{scene}: {:?}", errors.last());
    }
}

#[test]
fn errors_of_pixels_stay_below_the_threshold_and_cuts_grow_slower_than_their_gather_points() {
    for (scene, defines) in [("gallery.xml", &[("lights", "64")][..]), ("cornell-glossy.xml", &[])]
    {
        let world = World::load(scene, [20, 15], defines);
        let with = |gather: u32| {
            let mut params = Params { vpls: 1000, ..exact_pairs(gather) };
            params.lights.total = 512;
            params
        };
        let exact = render(&world, &with(8), 1, 5, Show::All);
        let mut last = f64::INFINITY;
        for error in [0.01, 0.02, 0.08] {
            let cut = Limits { error, rule: Rule::Whole, max_cut: Some(20_000) };
            let params = Params { cut, ..with(8) };
            let (technique, film) = world.run::<Lightcuts>(&params, 1, 5, Show::All);
            let errors = relative_errors(&film, &exact);
            let of = |share: f32| errors[(share * errors.len() as f32) as usize];
            assert!(of(0.98) < error, "{scene}: {} for {error}", of(0.98));
            let size = statistic(&technique, "mean_cut");
            assert!(size < 0.9 * last, "{scene}: cuts of {size} for {error}, {last} before");
            last = size;
        }
        let cut = Limits { max_cut: Some(20_000), ..Params::default().cut };
        let size = |gather: u32| {
            let params = Params { cut, ..with(gather) };
            statistic(&world.run::<Lightcuts>(&params, 1, 5, Show::All).0, "mean_cut")
        };
        let [few, many] = [size(2), size(32)];
        assert!(many < 4.0 * few, "{scene}: {few} pairs for 2 paths, {many} for 32");
    }
}

#[test]
fn camera_paths_of_a_pixel_follow_the_filter() {
    let world = World::load("gallery.xml", [12, 9], &[]);
    let film = |filter: Filter, params: &Params, seed: u32| {
        let mut film = Film::new([12, 9], filter, Show::Direct);
        let setting = world.setting(seed, Show::Direct);
        let mut technique = Lightcuts::prepare(setting, params).expect("valid parameters");
        (0..4).for_each(|k| technique.pass(k, &mut film));
        film
    };
    for filter in [Filter::Gaussian { stddev: 0.5 }, Filter::Lanczos { lobes: 3 }] {
        let mut pairs = exact_pairs(8);
        pairs.lights.total = 32;
        let cuts = Params { method: Method::All, ..pairs.clone() };
        // Pixels one by one: a filter that is too wide blurs edges, and changes no mean.
        let of = |params: &Params| -> Vec<Vec<f64>> {
            let pixels = |seed| {
                let film = film(filter, params, seed);
                film.radiance().into_iter().map(|c| f64::from(c.luminance())).collect()
            };
            (0..16).map(pixels).collect()
        };
        let (a, b) = (of(&pairs), of(&cuts));
        let level = sidak(1e-3, a[0].len());
        for k in 0..a[0].len() {
            let column = |p: &[Vec<f64>]| p.iter().map(|p| p[k]).collect::<Running>();
            let (a, b) = (column(&a), column(&b));
            let p = welch_t_test(&a, &b);
            assert!(
                p > level,
                "{filter:?}, pixel {k}: {} against {}, p = {p:.1e}",
                a.mean(),
                b.mean()
            );
        }
    }
}

#[test]
fn with_sampled_lights_the_mean_picture_is_that_of_the_path_tracer() {
    let scenes = [
        ("cornell-glossy.xml", [16, 16], &[][..]),
        ("patio.xml", [16, 16], &[]),
        ("gallery.xml", [16, 12], &[("lights", "64")]),
    ];
    for (scene, size, defines) in scenes {
        let world = World::load(scene, size, defines);
        let path = by_seed(16, |seed| {
            world.render::<PathTracer>(&pathtrace::Params::default(), 64, seed, Show::All)
        });
        for (method, samples) in [
            (Method::One, 4),
            (Method::Stochastic, 8),
            (Method::Learned, 1),
            (Method::Multidimensional, 1),
        ] {
            // The path tracer hardly ever finds the sun through glass, but photons would.
            let (bound, caustics) = (BoundOptions::compensated(4.0), Caustics::Path.into());
            // The multidimensional method is unbiased only if its cut consists of all pairs.
            let params = Params { method, samples, bound, caustics, ..exact_pairs(2) };
            // The choices change after each pass, so learned lights get more passes.
            let passes = match method {
                Method::Learned => 40,
                Method::Multidimensional => 2,
                _ => 8,
            };
            let drawn = by_seed(24, |seed| render(&world, &params, passes, 100 + seed, Show::All));
            let level = sidak(1e-3, path[0].len());
            for k in 0..path[0].len() {
                let column = |p: &[Vec<f64>]| p.iter().map(|p| p[k]).collect::<Running>();
                let (a, b) = (column(&drawn), column(&path));
                let p = welch_t_test(&a, &b);
                assert!(
                    p > level,
                    "{scene}, {method:?}, block {k}: {} against {}, p = {p:.1e}",
                    a.mean(),
                    b.mean()
                );
            }
        }
    }
}

#[test]
fn cuts_and_reconstruction_cuts_give_nearly_the_path_tracers_picture() {
    let world = World::load("gallery.xml", [32, 24], &[]);
    let path = world.render::<PathTracer>(&pathtrace::Params::default(), 512, 3, Show::All);
    let params = Params { vpls: 4000, ..Params::default() };
    let with = Params { reconstruction: Reconstruction::on(), ..params.clone() };
    for params in [params, with] {
        let film = render(&world, &params, 4, 5, Show::All);
        for layer in ["Direct.G", "Indirect.G"] {
            let sum = |film: &Film| -> f64 {
                let layers = film.layers();
                layers.channel(layer).expect("a layer").iter().map(|v| f64::from(*v)).sum()
            };
            let ratio = sum(&film) / sum(&path);
            // Four sets of 4096 points and 4000 lights: about one per cent of noise, and bias up to the threshold.
            assert!((ratio - 1.0).abs() < 0.03, "{layer}: {ratio}, {:?}", params.reconstruction);
        }
    }
}

#[test]
fn a_furnace_cut_at_k_bounces_reads_the_geometric_sum() {
    let a = 0.6f64;
    let (parts, camera) = furnace(a as f32);
    let world = World::new(parts, &camera);
    for depth in [2u32, 3, 4] {
        let limits = PathLimits { max_depth: Some(depth), ..PathLimits::default() };
        let cut = Limits { error: 0.001, rule: Rule::Whole, max_cut: Some(10_000) };
        let bound = BoundOptions::compensated(3.0);
        let mut params = Params { limits, cut, bound, vpls: 300, ..Params::default() };
        params.lights.total = 300;
        // The lights lie on the walls that they illuminate. There, direct light from points is unbiased but noisy, so
        // sample it instead.
        params.direct = Direct::Sample;
        let means: Running = (0..16)
            .map(|seed| mean_and_variance(&render(&world, &params, 4, seed, Show::All)).0)
            .collect();
        let error = (means.variance() / 16.0).sqrt();
        let expected = (1.0 - a.powi(depth as i32)) / (1.0 - a);
        // t with 15 degrees of freedom exceeds 4.1 once in a thousand cases; cuts may differ by a thousandth.
        assert!(
            (means.mean() - expected).abs() < 4.1 * error + 1e-3 * expected,
            "{depth} segments: {} +- {error} is not {expected}",
            means.mean()
        );
    }
}

#[test]
fn a_scene_ten_times_as_large_makes_the_same_picture() {
    let film = |scale: f32| {
        let world = World::load_scaled("cornell-box.xml", [16, 16], scale);
        render(&world, &few_lights(), 2, 5, Show::Indirect)
    };
    let mean = |film: &Film| mean_and_variance(film).0;
    let (one, ten) = (mean(&film(1.0)), mean(&film(8.0)));
    // A power of two scales everything exactly; only the order of equal values could differ.
    assert!((one / ten - 1.0).abs() < 1e-3, "{one} and {ten}");
}

#[test]
fn reconstruction_saves_rays_and_does_not_darken_corners() {
    // A part of the picture, so that blocks are as small as in typical pictures: wall, floor, and the corner between
    // them.
    let near = |_: &mut SceneParts, camera: &mut CameraSpec| {
        if let Projection::Perspective { fov_x, .. } = &mut camera.projection {
            *fov_x = 0.35;
        }
    };
    let world = World::load_with("gallery.xml", [48, 36], &[("lights", "1024")], near);
    let cut = Limits { rule: Rule::Whole, max_cut: Some(5000), ..Params::default().cut };
    let mut params = Params { vpls: 3000, cut, ..Params::default() };
    params.bound.compensation = Compensation::None;
    params.lights.total = 1024;
    let run = |params: &Params| {
        let (technique, film) = world.run::<Lightcuts>(params, 1, 5, Show::All);
        (statistic(&technique, "seen_rays_a_point"), film)
    };
    let (_, brute) = run(&Params { method: Method::All, ..params.clone() });
    let (plain, _) = run(&params);
    let reconstruction = Reconstruction::on();
    let (shared, film) = run(&Params { reconstruction, ..params.clone() });
    assert!(shared < 0.7 * plain, "{shared} rays, {plain} without");
    let errors = relative_errors(&film, &brute);
    let of = |share: f32| errors[(share * errors.len() as f32) as usize];
    assert!(of(0.5) < 0.01 && of(0.95) < 0.04, "{} {}", of(0.5), of(0.95));
    println!("{shared} {plain} {} {} {}", of(0.5), of(0.95), of(0.99));
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
    let variants = [
        few_lights(),
        Params { reconstruction: Reconstruction::on(), ..few_lights() },
        Params { method: Method::Stochastic, samples: 8, ..few_lights() },
        Params { method: Method::One, samples: 4, ..few_lights() },
        Params { method: Method::Learned, ..few_lights() },
        Params { method: Method::Multidimensional, gather: 5, ..few_lights() },
    ];
    for params in variants {
        let one = bits(1, &params);
        assert!([2, 4].into_iter().all(|threads| bits(threads, &params) == one), "{params:?}");
    }
}
