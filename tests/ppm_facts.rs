//! Compares progressive photon mapping with the path tracer and with itself.

mod caustic;
mod hard_scenes;

use gi_core::camera::CameraSpec;
use gi_core::eye::PathLimits;
use gi_core::film::{Film, Show};
use gi_core::filter::Filter;
use gi_core::geometry::{Geometry, Shape};
use gi_core::light::LightSource;
use gi_core::material::{Distribution, Material, Roughness};
use gi_core::math::Rgb;
use gi_core::scene::SceneParts;
use gi_core::technique::Technique;
use gi_core::texture::Texture;
use gi_stats::{Running, z_test};
use gi_tests::{ALPHA, World, both_sides, cube_inside, grey, mean_and_variance, sphere, square};
use glam::{Affine3A, Quat, Vec3};
use pathtrace::{Mode, PathTracer};
use ppm::{Method, Params, Ppm};

const METHODS: [Method; 4] = [Method::Ppm, Method::Sppm, Method::Ppa, Method::Adaptive];

fn render(world: &World, params: &Params, passes: u32, seed: u32, show: Show) -> Film {
    world.render::<Ppm>(params, passes, seed, show)
}

fn with(method: Method, photons: u32) -> Params {
    Params { method, photons, ..Params::default() }
}

fn channel(film: &Film, name: &str) -> Vec<f64> {
    film.layers().channel(name).expect("a layer").iter().map(|v| f64::from(*v)).collect()
}

/// Mean squared difference of a layer of two pictures, divided by the mean square of the second, minus the noise of the
/// second, which is known for all light.
fn relative_mse(film: &Film, reference: &Film, layer: &str) -> f64 {
    let (mut difference, mut square, mut noise) = (0.0, 0.0, 0.0);
    for c in ["R", "G", "B"] {
        let name = format!("{layer}{c}");
        for (a, b) in channel(film, &name).into_iter().zip(channel(reference, &name)) {
            difference += (a - b).powi(2);
            square += b * b;
        }
        noise += channel(reference, &format!("Variance.{c}")).iter().sum::<f64>();
    }
    (difference - noise) / square
}

/// The inside of a unit sphere of albedo one half around a point light of intensity pi: each scattering of its light
/// adds half as much as the one before, so indirect radiance is 1 everywhere.
fn sphere_world() -> World {
    let shape = Shape { flip_normals: true, ..Shape::new("sphere", sphere(Vec3::ZERO, 1.0), 0) };
    let intensity = Rgb::grey(std::f32::consts::PI);
    let lights = vec![LightSource::Point { position: Vec3::ZERO, intensity }];
    let parts = SceneParts {
        shapes: vec![shape],
        materials: vec![grey(0.5)],
        lights,
        ..SceneParts::default()
    };
    let camera = CameraSpec::look_at(Vec3::new(0.3, 0.2, -0.5), Vec3::X, Vec3::Y, 1.2, [12, 12]);
    World::new(parts, &camera)
}

#[test]
fn the_mean_of_a_lit_sphere_is_one_and_follows_the_geometric_series_with_max_depth() {
    // A ball of radius r around a point of a sphere contains a cap of area pi r^2 for any r, so there is no bias at
    // all. Pixels share photons, so the error of a picture's mean is estimated from seeds only.
    let world = sphere_world();
    let depths = [(None, 1.0), (Some(3), 0.75), (Some(2), 0.5)];
    for (k, method) in METHODS.into_iter().chain(METHODS).enumerate() {
        for (max_depth, expected) in depths {
            let limits = PathLimits { max_depth, ..PathLimits::default() };
            let params = Params { limits, direct_by_photons: k > 3, ..with(method, 400) };
            let means: Running = (0..24)
                .map(|seed| mean_and_variance(&render(&world, &params, 6, seed, Show::All)).0)
                .collect();
            let p = z_test(means.mean(), means.variance_of_mean() + 1e-12, expected, 0.0);
            assert!(p > ALPHA / 24.0, "{method:?}, {max_depth:?}: {} p = {p:.1e}", means.mean());
        }
    }
}

#[test]
fn without_bias_the_error_falls_with_the_kept_photons() {
    // In the sphere, the error is only noise. It depends on N^alpha photons [slide 39], so MSE ~ passes^(-alpha).
    let world = sphere_world();
    for alpha in [0.5, 0.8] {
        let params = Params { alpha, initial_radius: 0.15, ..with(Method::Sppm, 300) };
        let mse = |passes: u32| -> f64 {
            let of = |seed| {
                let indirect =
                    channel(&render(&world, &params, passes, seed, Show::All), "Indirect.R");
                indirect.iter().map(|v| (v - 0.5).powi(2)).sum::<f64>() / indirect.len() as f64
            };
            (0..6).map(of).sum::<f64>() / 6.0
        };
        let slope = (mse(128) / mse(8)).ln() / 16f64.ln();
        assert!((slope + alpha).abs() < 0.12, "alpha {alpha}: slope {slope}");
    }
}

#[test]
fn all_methods_agree_with_the_path_tracer_in_each_layer_and_more_passes_reduce_the_error() {
    let world = World::load("cornell-spheres.xml", [32, 32], &[]);
    let reference = world.render::<PathTracer>(&Default::default(), 2048, 5, Show::All);
    for method in METHODS {
        // If hit points are found once, the noise in mirrors and glass is fixed, so use many hit points.
        let params = Params { hit_points: 64, ..with(method, 8192) };
        let error =
            |passes| relative_mse(&render(&world, &params, passes, 1, Show::All), &reference, "");
        let errors = [4, 16, 64].map(error);
        assert!(errors.is_sorted_by(|a, b| a > b), "{method:?}: {errors:?}");
        let film = render(&world, &params, 64, 1, Show::All);
        for layer in ["Direct", "Indirect", "Caustic"] {
            let sum = |film: &Film| -> f64 {
                ["R", "G", "B"].iter().flat_map(|c| channel(film, &format!("{layer}.{c}"))).sum()
            };
            let ratio = sum(&film) / sum(&reference);
            assert!((ratio - 1.0).abs() < 0.05, "{method:?}, {layer}: {ratio}");
        }
    }
}

#[test]
fn every_layer_has_the_same_bits_at_1_2_and_4_threads() {
    let world = World::load("cornell-glossy.xml", [36, 20], &[]);
    for method in METHODS {
        let bits = |threads: usize, seed: u32| -> Vec<(String, Vec<u32>)> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            // Use more photons than a single task traces.
            let film = pool
                .expect("threads")
                .install(|| render(&world, &with(method, 9000), 3, seed, Show::All));
            let channels = film.layers().channels.into_iter();
            channels.map(|(n, v)| (n, v.iter().map(|x| x.to_bits()).collect())).collect()
        };
        let one = bits(1, 7);
        assert!(bits(2, 7) == one && bits(4, 7) == one, "{method:?}");
        assert!(bits(2, 8) != one, "{method:?}: another seed gives the same picture");
    }
}

#[test]
fn a_scene_ten_times_as_large_gives_the_same_picture() {
    let read = |scale: f32| {
        World::load_with("cornell-spheres.xml", [20, 20], &[], |parts, camera| {
            let map = Affine3A::from_scale(Vec3::splat(scale));
            for shape in &mut parts.shapes {
                match &mut shape.geometry {
                    Geometry::Mesh(mesh) => mesh.transform(&map),
                    Geometry::Sphere { center, radius, .. } => {
                        *center *= scale;
                        *radius *= scale;
                    }
                    other => panic!("no {other:?} in this scene"),
                }
            }
            camera.to_world.translation *= scale;
        })
    };
    for method in METHODS {
        let picture =
            |scale| channel(&render(&read(scale), &with(method, 2000), 4, 3, Show::All), "G");
        let (one, other) = (picture(1.0), picture(10.0));
        // The random numbers are the same, so only rounding differs. A path that rounding diverts becomes a different
        // path.
        let far =
            one.iter().zip(&other).filter(|(a, b)| (*a - *b).abs() > 1e-3 * a.abs().max(0.01));
        let far = far.count();
        assert!(far < 8, "{method:?}: {far} of {} pixels differ", one.len());
    }
}

#[test]
fn the_film_agrees_with_the_statistics() {
    // With fixed hit points and a box filter, the film's light from photons is tau / (pi R^2 n) [slides 41, 42].
    let world = sphere_world();
    let params = Params { trace_pixels: vec![[5, 6]], ..with(Method::Ppm, 900) };
    let (technique, film) = world.run::<Ppm>(&params, 9, 1, Show::All);
    let csv = String::from_utf8(technique.traces_csv()).expect("a text");
    let last: Vec<f64> = csv
        .lines()
        .last()
        .expect("a line")
        .split(',')
        .map(|v| v.parse().expect("a number"))
        .collect();
    let of_film = channel(&film, "Indirect.R")[6 * 12 + 5];
    assert!((last[6] / of_film - 1.0).abs() < 1e-5, "{} against {of_film}", last[6]);
    assert!(csv.starts_with("x,y,pass,radius,N,M,"));
    assert_eq!(csv.lines().count(), 10);
}

#[test]
fn memory_does_not_grow_with_the_passes() {
    let world = sphere_world();
    for method in METHODS {
        let kept = |passes| {
            let (technique, _) = world.run::<Ppm>(&with(method, 200), passes, 1, Show::All);
            technique.save_state().len()
        };
        assert_eq!(kept(10), kept(1000), "{method:?}");
    }
}

#[test]
fn hit_points_that_are_found_once_miss_most_glossy_reflections() {
    // Rays follow the silver ball's reflection: in each pass anew with sppm, but only once, to one point, with ppm.
    let world = World::load("cornell-glossy.xml", [32, 32], &[]);
    let reference = world.render::<PathTracer>(&Default::default(), 1024, 5, Show::All);
    let error = |method| {
        let params = Params { min_roughness: 0.3, ..with(method, 8192) };
        relative_mse(&render(&world, &params, 48, 1, Show::All), &reference, "Indirect.")
    };
    let (once, anew) = (error(Method::Ppm), error(Method::Sppm));
    assert!(once > 3.0 * anew, "{once} against {anew}");
}

#[test]
fn rays_follow_coats_too_sharp_for_photons_and_no_light_is_lost_or_counted_twice() {
    let roughness = |alpha| Roughness {
        distribution: Distribution::Ggx,
        alpha_u: Texture::grey(alpha),
        alpha_v: Texture::grey(alpha),
    };
    for alpha in [None, Some(0.05), Some(0.3), Some(0.5)] {
        let world = World::load_with("cornell-spheres.xml", [20, 20], &[], |parts, _| {
            for material in &mut parts.materials {
                if let Material::Diffuse { reflectance } = material.clone() {
                    *material = Material::Plastic {
                        eta: 1.5,
                        diffuse: reflectance,
                        specular: Texture::grey(1.0),
                        nonlinear: false,
                        roughness: alpha.map(roughness),
                    };
                }
            }
        });
        let mean = |film: &Film| channel(film, "R").iter().sum::<f64>();
        let reference = world.render::<PathTracer>(&Default::default(), 1024, 5, Show::Indirect);
        let film = render(&world, &with(Method::Sppm, 16384), 64, 2, Show::Indirect);
        let ratio = mean(&film) / mean(&reference);
        assert!((ratio - 1.0).abs() < 0.02, "{alpha:?}: {ratio}");
    }
}

#[test]
fn light_through_glass_onto_surfaces_seen_through_glass_is_found() {
    // A large lamp, so that the path tracer finds it too.
    let world = World::load("torus-in-glass.xml", [24, 24], &[("lamp", "0.9")]);
    let reference = world.render::<PathTracer>(&Default::default(), 1024, 5, Show::Caustic);
    let (truth, variance) = mean_and_variance(&reference);
    let params = Params { initial_radius: 0.004, ..with(Method::Sppm, 16384) };
    let means: Running = (0..8)
        .map(|seed| mean_and_variance(&render(&world, &params, 32, seed, Show::Caustic)).0)
        .collect();
    let p = z_test(truth, variance, means.mean(), means.variance_of_mean());
    assert!(p > ALPHA, "{truth} against {}: p = {p:.1e}", means.mean());
    // The uncertainty is small enough to detect a factor of the squared index, or light that is counted twice.
    assert!(variance + means.variance_of_mean() < (0.05 * truth).powi(2));
}

#[test]
fn a_pass_of_ppa_has_the_same_bits_after_other_passes_and_in_a_shard_of_its_own() {
    let world = World::load("cornell-spheres.xml", [48, 40], &[]);
    let params = with(Method::Ppa, 2000);
    let film = |passes: std::ops::Range<u32>, counts: u32| {
        let mut ppm = Ppm::prepare(world.setting(0, Show::All), &params).expect("no file is read");
        let new = || Film::new([48, 40], Filter::Box, Show::All);
        let (mut before, mut film) = (new(), new());
        for pass in passes {
            ppm.pass(pass, if pass < counts { &mut before } else { &mut film });
        }
        film.layers()
    };
    assert!(film(0..7, 6) == film(6..7, 6));
}
