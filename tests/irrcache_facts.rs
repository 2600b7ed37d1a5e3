//! Compares irradiance caching with the path tracer and with itself.

mod leaks;
mod saved;

use gi_core::camera::CameraSpec;
use gi_core::eye::PathLimits;
use gi_core::film::{Film, Show};
use gi_core::geometry::{Geometry, Mesh, Shape};
use gi_core::material::Material;
use gi_core::math::Rgb;
use gi_core::options::{Caustics, defaults};
use gi_core::scene::SceneParts;
use gi_core::technique::Technique;
use gi_core::texture::Texture;
use gi_tests::program::Folder;
use gi_tests::{World, cube_inside, furnace, grey, mean_and_variance, polygon};
use glam::Vec3;
use irrcache::file::SavedCache;
use irrcache::{IrradianceCaching, Params};
use lightcache::control::ErrorControl;
use lightcache::options::{CacheFiles, Gradients, ReachOptions};
use pathtrace::PathTracer;

const CONTROLS: [ErrorControl; 4] = [
    ErrorControl::SplitSphere,
    ErrorControl::Bounded,
    ErrorControl::HessianGeometric,
    ErrorControl::HessianOcclusion,
];

fn render(world: &World, params: &Params, passes: u32, seed: u32, show: Show) -> Film {
    world.render::<IrradianceCaching>(params, passes, seed, show)
}

fn records(world: &World, params: &Params) -> usize {
    let (technique, _) = world.run::<IrradianceCaching>(params, 1, 1, Show::Indirect);
    technique.cache().records().len()
}

/// Mean of several values and the standard error of that mean.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// Mean squared difference of two pictures relative to the second, minus the second's own noise.
fn rel_mse(film: &Film, reference: &Film) -> f64 {
    let (a, b) = (film.layers(), reference.layers());
    let mut sum = 0.0;
    for c in ["R", "G", "B"] {
        let of =
            |l: &gi_core::image_io::Layers, name: &str| l.channel(name).expect("a layer").to_vec();
        let variance = of(&b, &format!("Variance.{c}"));
        for ((a, b), v) in of(&a, c).into_iter().zip(of(&b, c)).zip(variance) {
            sum += f64::from((a - b).powi(2) - v) / f64::from(b * b + 1e-2);
        }
    }
    sum / (3 * a.width * a.height) as f64
}

#[test]
fn a_furnace_reads_one_over_one_minus_a_with_every_error_control() {
    // The film's variance does not include the noise of gather rays, so several seeds are used to estimate it.
    let (parts, camera) = furnace(0.5);
    let world = World::new(parts, &camera);
    for error in CONTROLS {
        let params = Params { error, rays: 100, ..Params::default() };
        let means: Vec<f64> = (0..8)
            .map(|seed| mean_and_variance(&render(&world, &params, 1, seed, Show::All)).0)
            .collect();
        let (mean, error_of_mean) = mean_and_error(&means);
        // t with 7 degrees of freedom exceeds 5.4 once in a thousand cases.
        assert!(
            (mean - 2.0).abs() < 5.4 * error_of_mean,
            "{error:?}: {mean} +- {error_of_mean} is not 2"
        );
    }
}

#[test]
fn cache_levels_and_max_depth_count_bounces() {
    // In a furnace, b bounces after the first give (1 - a^(b+2)) / (1 - a): emission, direct light, and b more.
    let a = 0.5f64;
    let (parts, camera) = furnace(a as f32);
    let world = World::new(parts, &camera);
    for b in 1..4u32 {
        let expected = (1.0 - a.powi(b as i32 + 2)) / (1.0 - a);
        let by_levels = Params { bounces: Some(b), rays: 100, ..Params::default() };
        let limits = PathLimits { max_depth: Some(b + 2), ..PathLimits::default() };
        let by_depth = Params { limits, rays: 100, ..Params::default() };
        for (name, params) in [("levels", by_levels), ("depth", by_depth)] {
            let means: Vec<f64> = (0..8)
                .map(|seed| mean_and_variance(&render(&world, &params, 1, seed, Show::All)).0)
                .collect();
            let (mean, error) = mean_and_error(&means);
            assert!(
                (mean - expected).abs() < 5.4 * error,
                "{b} {name}: {mean} +- {error} is not {expected}"
            );
        }
    }
}

#[test]
fn in_the_cornell_box_it_agrees_with_the_path_tracer_and_better_settings_reduce_the_error() {
    let world = World::load("cornell-box.xml", [48, 48], &[]);
    let reference =
        world.render::<PathTracer>(&pathtrace::Params::default(), 1024, 3, Show::Indirect);
    let (truth, variance) = mean_and_variance(&reference);
    assert!(variance.sqrt() < 2e-3 * truth, "the reference is too noisy for the bound below");
    let error_of = |params: &Params| {
        let film = render(&world, params, 8, 1, Show::Indirect);
        let (mean, _) = mean_and_variance(&film);
        (mean / truth, rel_mse(&film, &reference))
    };
    // Bounds: the mean within 1 %; for comparison, path tracing at 1024 samples has a relMSE of 2e-4 here.
    for error in
        [ErrorControl::Bounded, ErrorControl::HessianGeometric, ErrorControl::HessianOcclusion]
    {
        let (ratio, rel_mse) = error_of(&Params { error, ..Params::default() });
        assert!((ratio - 1.0).abs() < 0.01, "{error:?}: mean ratio {ratio}");
        assert!(rel_mse < 2e-4, "{error:?}: relMSE {rel_mse}");
    }
    let with = |rays, accuracy| error_of(&Params { rays, accuracy, ..Params::default() }).1;
    let rays: Vec<f64> = [30, 200, 2000].map(|n| with(n, 0.1)).to_vec();
    assert!(rays[0] > rays[1] && rays[1] > rays[2], "error against rays {rays:?}");
    let coarse = Params { error: ErrorControl::SplitSphere, rays: 2000, ..Params::default() };
    let accuracy: Vec<f64> =
        [0.8, 0.4, 0.1].map(|a| error_of(&Params { accuracy: a, ..coarse.clone() }).1).to_vec();
    assert!(
        accuracy[0] > accuracy[1] && accuracy[1] > accuracy[2],
        "error against accuracy {accuracy:?}"
    );
    // Gradients help where there are few records.
    let few = Params {
        accuracy: 0.4,
        error: ErrorControl::Bounded,
        reach: ReachOptions { max_spacing: 0.0, ..defaults() },
        ..Params::default()
    };
    let without = error_of(&Params { gradients: Gradients::Off, ..few.clone() }).1;
    let both = error_of(&few).1;
    assert!(both < 0.7 * without, "with gradients {both}, without {without}");
}

#[test]
fn coats_glass_and_mirrors_are_path_traced() {
    // All other components have the same mean as with the path tracer.
    let world = World::load("cornell-spheres.xml", [32, 32], &[]);
    let path = world.render::<PathTracer>(&pathtrace::Params::default(), 2048, 3, Show::All);
    // Photons would find more of the caustics than paths.
    let params = Params { caustics: Caustics::Path.into(), ..Params::default() };
    let cached = render(&world, &params, 256, 1, Show::All);
    let component = |film: &Film, name: &str| {
        let layers = film.layers();
        ["R", "G", "B"]
            .iter()
            .flat_map(|c| layers.channel(&format!("{name}.{c}")).expect("a layer").to_vec())
            .map(f64::from)
            .sum::<f64>()
    };
    for (name, bound) in [("Direct", 0.01), ("Indirect", 0.015), ("Caustic", 0.15)] {
        let ratio = component(&cached, name) / component(&path, name);
        assert!((ratio - 1.0).abs() < bound, "{name}: {ratio}");
    }
}

#[test]
fn scaling_the_scene_changes_neither_picture_nor_number_of_records() {
    let scaled = |s: f32| {
        World::load_with("cornell-box.xml", [24, 24], &[], |parts, camera| {
            camera.to_world.translation *= s;
            for shape in &mut parts.shapes {
                if let Geometry::Mesh(mesh) = &mut shape.geometry {
                    mesh.positions.iter_mut().for_each(|p| *p *= s);
                }
            }
        })
    };
    let world = scaled(1.0);
    let big = scaled(8.0);
    for error in CONTROLS {
        let params = Params { error, rays: 200, ..Params::default() };
        assert_eq!(records(&world, &params), records(&big, &params), "{error:?}");
        let [a, b] =
            [&world, &big].map(|w| mean_and_variance(&render(w, &params, 2, 1, Show::All)).0);
        assert!((a / b - 1.0).abs() < 1e-4, "{error:?}: {a} and {b}");
    }
}

#[test]
fn picture_and_cache_have_the_same_bits_for_any_number_of_threads() {
    let bits = |threads: usize, bounces: Option<u32>| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let world = World::load("cornell-glossy.xml", [40, 30], &[]);
            let params = Params { bounces, rays: 100, ..Params::default() };
            let (technique, film) = world.run::<IrradianceCaching>(&params, 2, 7, Show::All);
            let layers = film.layers().channels.into_iter();
            let pixels: Vec<u32> =
                layers.flat_map(|(_, v)| v.into_iter().map(f32::to_bits)).collect();
            (pixels, technique.saved().to_bytes())
        })
    };
    for bounces in [None, Some(2)] {
        let one = bits(1, bounces);
        for threads in [2, 4] {
            assert!(bits(threads, bounces) == one, "{threads} threads, bounces {bounces:?}");
        }
    }
}

#[test]
fn an_empty_world_and_one_without_light_are_black() {
    let camera = CameraSpec::look_at(Vec3::ZERO, Vec3::Z, Vec3::Y, 0.7, [8, 8]);
    let triangle = Mesh {
        positions: vec![
            Vec3::new(-1.0, -1.0, 2.0),
            Vec3::new(1.0, -1.0, 2.0),
            Vec3::new(0.0, 1.0, 2.0),
        ],
        triangles: vec![[0, 2, 1]].into(),
        ..Mesh::default()
    };
    let dark = SceneParts {
        shapes: vec![Shape::new("triangle", Geometry::Mesh(triangle), 0)],
        materials: vec![grey(0.5)],
        ..SceneParts::default()
    };
    for parts in [SceneParts::default(), dark] {
        let world = World::new(parts, &camera);
        for error in CONTROLS {
            let film = render(&world, &Params { error, ..Params::default() }, 1, 1, Show::All);
            assert!(film.radiance().iter().all(|c| c.is_black()), "{error:?}");
        }
    }
}
