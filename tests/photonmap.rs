//! Compares photon mapping with the path tracer, and with itself for different options.

use gi_core::camera::CameraSpec;
use gi_core::eye::PathLimits;
use gi_core::film::{Film, Show};
use gi_core::geometry::Shape;
use gi_core::image_io::Layers;
use gi_core::light::LightSource;
use gi_core::material::{Distribution, Material, Roughness};
use gi_core::math::Rgb;
use gi_core::scene::SceneParts;
use gi_core::texture::Texture;
use gi_stats::Running;
use gi_tests::{World, furnace, grey, mean_and_variance, sphere};
use glam::Vec3;
use pathtrace::{Mode, PathTracer};
use photonmap::{Gather, Params, PhotonMapping, Subsurface};

fn reference(world: &World, passes: u32, max_depth: Option<u32>, show: Show) -> Film {
    let limits = PathLimits { max_depth, ..PathLimits::default() };
    let params = pathtrace::Params { limits, ..Default::default() };
    world.render::<PathTracer>(&params, passes, 11, show)
}

fn photons(world: &World, params: &Params, passes: u32, show: Show) -> Film {
    world.render::<PhotonMapping>(params, passes, 3, show)
}

/// The defaults, but with enough gather rays that few passes suffice.
fn sixteen_rays() -> Params {
    Params { gather_rays: 16, ..Params::default() }
}

/// Check that the means of two pictures differ by less than `bound`, relative to the second, and that the noise is
/// small enough for this test.
fn assert_ratio(name: &str, ours: &Film, truth: &Film, bound: f64) {
    let ((a, va), (b, vb)) = (mean_and_variance(ours), mean_and_variance(truth));
    let noise = (va / (a * a) + vb / (b * b)).sqrt();
    assert!(noise < 0.4 * bound, "{name}: the noise of the ratio is {noise:.2e}");
    assert!((a / b - 1.0).abs() < bound, "{name}: {a:.5} is not {b:.5} (noise {noise:.1e})");
}

#[test]
fn final_gather_agrees_with_the_path_tracer_within_one_percent() {
    for (scene, show, passes) in
        [("cornell-box.xml", Show::Indirect, 512), ("cornell-spheres.xml", Show::Indirect, 2048)]
    {
        let world = World::load(scene, [48, 48], &[]);
        let truth = reference(&world, passes, None, show);
        let ours = photons(&world, &sixteen_rays(), 32, show);
        assert_ratio(&format!("{scene}, {show:?}"), &ours, &truth, 0.01);
    }
}

#[test]
fn the_caustic_map_agrees_with_paths_from_the_lights_within_one_percent() {
    let world = World::load("cornell-spheres.xml", [48, 48], &[]);
    let params = pathtrace::Params { mode: Mode::Light, ..Default::default() };
    let truth = world.render::<PathTracer>(&params, 6144, 12, Show::Caustic);
    // Over seeds, the sum of so many passes varies by 0.3 %; that of 16 passes varied by 1.5 %.
    let params = Params { gather_rays: 1, ..Params::default() };
    let ours = photons(&world, &params, 160, Show::Caustic);
    // Paths from the lights find no light behind mirrors and glass: skip pixels that are as white as these.
    let (a, b) = (ours.layers(), truth.layers());
    let albedo = a.channel("Albedo.G").expect("a layer");
    let sum = |layers: &Layers, name: &str| -> f64 {
        let values = layers.channel(name).expect("a layer").iter().zip(albedo);
        values.filter(|(_, albedo)| **albedo < 0.72).map(|(v, _)| f64::from(*v)).sum()
    };
    for c in ["R", "G", "B"] {
        let (x, y) = (sum(&a, &format!("Caustic.{c}")), sum(&b, &format!("Caustic.{c}")));
        let noise = sum(&b, &format!("Variance.{c}")).sqrt() / y;
        assert!(noise < 0.002, "{c}: the noise of the truth is {noise:.1e}");
        assert!((x / y - 1.0).abs() < 0.01, "{c}: {x} is not {y} (noise {noise:.1e})");
    }
}

#[test]
fn paths_of_bounded_length_agree_too() {
    let world = World::load("cornell-spheres.xml", [40, 40], &[]);
    for depth in [3, 4] {
        let limits = PathLimits { max_depth: Some(depth), ..PathLimits::default() };
        let truth = reference(&world, 512, limits.max_depth, Show::Indirect);
        let params = Params { limits, ..sixteen_rays() };
        let ours = photons(&world, &params, 32, Show::Indirect);
        assert_ratio(&format!("{depth} segments"), &ours, &truth, 0.015);
    }
}

#[test]
fn guided_gather_rays_change_the_noise_only() {
    let world = World::load("cornell-box.xml", [24, 24], &[]);
    let render = |guided| photons(&world, &Params { guided, ..sixteen_rays() }, 48, Show::Indirect);
    let ((a, va), (b, vb)) = (mean_and_variance(&render(0.0)), mean_and_variance(&render(0.8)));
    let p = gi_stats::z_test(a, va, b, vb);
    assert!(p > 1e-3 && (va + vb).sqrt() < 0.006 * a, "{a} is not {b}: p = {p:.1e}");
}

/// Mean over pixels and channels of the squared error, divided by the squared reference plus 0.01.
fn rel_mse(film: &Film, truth: &Film) -> f64 {
    let (a, b) = (film.radiance(), truth.radiance());
    let error = |x: f32, y: f32| f64::from((x - y) * (x - y) / (y * y + 0.01));
    let pixels = a.iter().zip(&b);
    let sum: f64 = pixels
        .flat_map(|(a, b)| {
            (0..3).map(|k| error(a.to_array()[k], b.to_array()[k])).collect::<Vec<_>>()
        })
        .sum();
    sum / (3 * a.len()) as f64
}

#[test]
fn more_photons_in_total_and_per_estimate_lower_the_error() {
    let world = World::load("cornell-box.xml", [32, 32], &[]);
    let truth = reference(&world, 1024, None, Show::Indirect);
    let errors: Vec<f64> = [(1_000, 10), (10_000, 30), (100_000, 90), (1_000_000, 270)]
        .into_iter()
        .map(|(n, lookup)| {
            let params = Params { photons: n, lookup, gather: Gather::Direct, ..sixteen_rays() };
            rel_mse(&photons(&world, &params, 16, Show::Indirect), &truth)
        })
        .collect();
    // Variance falls like 1 / k, and the squared blur like (k / N)^2: both by a factor of three or more at each step.
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.6 * pair[0], "{errors:?}");
    }
}

#[test]
fn a_furnace_reads_one_over_one_minus_a_through_the_map() {
    let (parts, camera) = furnace(0.6);
    let world = World::new(parts, &camera);
    let (mean, variance) = mean_and_variance(&photons(&world, &sixteen_rays(), 16, Show::All));
    // 100,000 photons of equal power: their number on the walls has a relative error of 1 / sqrt(100000) = 0.3 %.
    let bound = 2.5 * (4.0 * variance.sqrt() + 3.0 * 0.0032 * 0.6);
    assert!((mean - 2.5).abs() < bound, "{mean} is not 2.5 +- {bound}");
}

#[test]
fn a_scene_ten_times_as_large_gives_the_same_picture() {
    let read = |scale: f32| World::load_scaled("cornell-spheres.xml", [24, 24], scale);
    let params = Params { photons: 20_000, caustic_photons: 20_000, ..sixteen_rays() };
    let render = |scale| photons(&read(scale), &params, 8, Show::All);
    let (one, other) = (render(1.0), render(10.0));
    // The photons and paths are the same. Only rounding differs, mainly that of powers to eight bits.
    let error = rel_mse(&one, &other);
    assert!(error < 2e-4, "{error}");
}

#[test]
fn every_layer_has_the_same_bits_at_1_2_and_4_threads() {
    let params = Params { photons: 20_000, caustic_photons: 20_000, ..sixteen_rays() };
    let params = Params { volume_photons: 20_000, ..params };
    let bits =
        |scene: &str, threads: usize, params: &Params, seed: u32| -> Vec<(String, Vec<u32>)> {
            let pool =
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| {
                let world = World::load(scene, [40, 30], &[]);
                let film = world.render::<PhotonMapping>(params, 2, seed, Show::All);
                let channels = film.layers().channels.into_iter();
                channels.map(|(name, v)| (name, v.iter().map(|x| x.to_bits()).collect())).collect()
            })
        };
    const PHOTONS: Subsurface = Subsurface::Photons;
    for (scene, gather, subsurface) in [
        ("cornell-spheres.xml", Gather::Final, PHOTONS),
        ("cornell-spheres.xml", Gather::None, PHOTONS),
        ("marble.xml", Gather::Final, PHOTONS),
        ("marble.xml", Gather::Final, Subsurface::Dipole),
        ("fog.xml", Gather::Direct, PHOTONS),
    ] {
        let params = Params { gather, subsurface, ..params.clone() };
        let one = bits(scene, 1, &params, 7);
        let same = [2, 4].into_iter().all(|threads| bits(scene, threads, &params, 7) == one);
        let name = format!("{scene}, {gather:?}, {subsurface:?}");
        assert!(same, "{name}");
        assert!(bits(scene, 2, &params, 8) != one, "{name}: another seed gives the same picture");
    }
}

#[test]
fn where_photons_are_few_final_gather_is_not_too_bright() {
    // A point light of intensity pi in a unit sphere of albedo 1/2: indirect radiance is 1 everywhere.
    let shape = Shape { flip_normals: true, ..Shape::new("sphere", sphere(Vec3::ZERO, 1.0), 0) };
    let intensity = Rgb::grey(std::f32::consts::PI);
    let parts = SceneParts {
        shapes: vec![shape],
        materials: vec![grey(0.5)],
        lights: vec![LightSource::Point { position: Vec3::ZERO, intensity }],
        ..SceneParts::default()
    };
    let camera = CameraSpec::look_at(Vec3::new(0.3, 0.2, -0.5), Vec3::X, Vec3::Y, 1.2, [12, 12]);
    let world = World::new(parts, &camera);
    // On average, a disc of the largest radius contains five photons.
    let params = Params { photons: 4000, max_radius: 0.04, ..Params::default() };
    let of =
        |seed| mean_and_variance(&world.render::<PhotonMapping>(&params, 8, seed, Show::All)).0;
    let means: Running = (0..16).map(of).collect();
    let error = means.variance_of_mean().sqrt();
    assert!(error < 0.005, "+- {error}");
    assert!((means.mean() - 1.0).abs() < 4.0 * error, "{} +- {error}", means.mean());
}

#[test]
fn a_small_roof_on_wide_ground_gets_its_photons() {
    // A roof of 4 m over 400 m of ground, seen from below: photons that are not aimed hardly ever come near it.
    let world = World::roof_over_wide_ground();
    let (truth, variance) = mean_and_variance(&reference(&world, 256, None, Show::Indirect));
    for gather in [Gather::None, Gather::Direct, Gather::Final] {
        let params = Params { gather, ..Params::default() };
        let of = |seed| {
            let film = world.render::<PhotonMapping>(&params, 8, seed, Show::Indirect);
            mean_and_variance(&film).0
        };
        let means: Running = (0..12).map(of).collect();
        let error = (means.variance_of_mean() + variance).sqrt() / truth;
        let ratio = means.mean() / truth;
        assert!(error < 0.03, "{gather:?}: +- {error}");
        assert!((ratio - 1.0).abs() < 0.02 + 3.0 * error, "{gather:?}: {ratio} +- {error}");
    }
}

#[test]
fn caustics_of_slightly_rough_glass_use_the_caustic_map() {
    let world = World::load_with("cornell-spheres.xml", [24, 24], &[], |parts, _| {
        for material in &mut parts.materials {
            if let Material::Dielectric { roughness, .. } = material {
                let alpha = Texture::grey(0.005);
                let (distribution, alpha_u, alpha_v) = (Distribution::Ggx, alpha.clone(), alpha);
                *roughness = Some(Roughness { distribution, alpha_u, alpha_v });
            }
        }
    });
    let seeds = 4;
    let render = |caustic_photons| {
        let params = Params { caustic_photons, ..Params::default() };
        let of = |seed| {
            let film = world.render::<PhotonMapping>(&params, 64, seed, Show::Indirect);
            mean_and_variance(&film)
        };
        let all: Vec<(f64, f64)> = (0..seeds).map(of).collect();
        let (mean, variance) = all.iter().fold((0.0, 0.0), |(m, v), of| (m + of.0, v + of.1));
        let n = f64::from(seeds);
        (mean / n, variance / (n * n))
    };
    let ((a, va), (b, vb)) = (render(100_000), render(0));
    // For single seeds, the ratio of variances is 0.24 +- 0.06. For four seeds, 0.4 is five standard errors above that.
    assert!(va < 0.4 * vb, "the variance is {va} with the caustic map, {vb} without");
    let noise = (va + vb).sqrt() / a;
    assert!((a / b - 1.0).abs() < 0.01 + 3.0 * noise, "{a} is not {b} (noise {noise:.1e})");
}
