//! Compares irradiance caching with the path tracer and with itself.

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
    let path = world.render::<PathTracer>(&pathtrace::Params::default(), 512, 3, Show::All);
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

/// A closed box, divided by a wall without thickness, with a lamp in one half. The camera looks in through the ceiling.
fn divided_box() -> World {
    let wall =
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(y, z)| Vec3::new(0.0, y, z));
    let lamp =
        [(-0.8, -0.3), (-0.2, -0.3), (-0.2, 0.3), (-0.8, 0.3)].map(|(x, z)| Vec3::new(x, 0.9, z));
    let emission = Some(Texture::Constant(Rgb::WHITE));
    let shapes = vec![
        Shape::new("box", cube_inside(), 0),
        Shape::new("wall", polygon(&wall), 1),
        Shape { emission, ..Shape::new("lamp", polygon(&lamp), 0) },
    ];
    let materials = vec![grey(0.7), Material::TwoSided { front: 0, back: 0 }];
    let parts = SceneParts { shapes, materials, ..SceneParts::default() };
    let mut camera =
        CameraSpec::look_at(Vec3::new(0.0, 4.0, 0.0), Vec3::ZERO, Vec3::Z, 0.42, [64, 64]);
    camera.near = 3.2; // inside the box, whose ceiling is 3 away
    World::new(parts, &camera)
}

#[test]
fn light_leaks_under_a_thin_wall_only_without_the_guard() {
    let world = divided_box();
    for error in CONTROLS {
        let leak = |leak_guard: bool| {
            let reach = ReachOptions { leak_guard, ..defaults() };
            let params = Params { error, reach, rays: 300, accuracy: 0.8, ..Params::default() };
            let film = render(&world, &params, 4, 1, Show::Indirect);
            let radiance = film.radiance();
            let of = |dark: bool| {
                let pixels = (0..64 * 64).filter(|i| ((i % 64) < 32) == dark);
                pixels.map(|i| f64::from(radiance[i].g)).sum::<f64>()
            };
            // Which half is dark depends on the orientation of the camera.
            let (a, b) = (of(true), of(false));
            a.min(b) / a.max(b)
        };
        let (guarded, open) = (leak(true), leak(false));
        assert_eq!(guarded, 0.0, "{error:?}: fraction of light that leaks with the guard");
        assert!(open > 0.0, "{error:?}: nothing leaks even without the guard");
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
fn a_saved_cache_gives_the_same_picture_and_helps_another_view() {
    for bounces in [None, Some(2)] {
        let world = World::load("cornell-box.xml", [40, 40], &[]);
        let params = Params { bounces, rays: 100, ..Params::default() };
        let (fresh, film) = world.run::<IrradianceCaching>(&params, 2, 7, Show::All);
        let folder = Folder::make();
        let again = Params { files: saved(&folder, &fresh.saved()), ..params.clone() };
        let (read, second) = world.run::<IrradianceCaching>(&again, 2, 7, Show::All);
        assert_eq!(film.layers().channels, second.layers().channels);
        assert_eq!(statistic(&read, "records_made"), 0.0);
        // A view from the side: records of the first view are reused.
        let camera = CameraSpec::look_at(
            Vec3::new(200.0, 273.0, -750.0),
            Vec3::new(278.0, 273.0, 0.0),
            Vec3::Y,
            0.65,
            [40, 40],
        );
        let side = World { camera: gi_core::camera::Camera::new(&camera), ..world };
        let (alone, _) = side.run::<IrradianceCaching>(&params, 1, 7, Show::All);
        let (helped, _) = side.run::<IrradianceCaching>(&again, 1, 7, Show::All);
        let (alone, helped) =
            (statistic(&alone, "records_made"), statistic(&helped, "records_made"));
        assert!(
            helped < 0.5 * alone,
            "{helped} new records with the saved cache, {alone} without it"
        );
    }
}

/// Save a cache to a file, and return options that read it.
fn saved(folder: &Folder, cache: &SavedCache) -> CacheFiles {
    let path = folder.path().join("a.cache");
    std::fs::write(&path, cache.to_bytes()).expect("written");
    CacheFiles { cache_in: Some(path), ..CacheFiles::default() }
}

fn statistic(technique: &IrradianceCaching, name: &str) -> f64 {
    let all = technique.statistics();
    all.iter().find(|(n, _)| n == name).unwrap_or_else(|| panic!("no {name}")).1
}

#[test]
fn a_cache_of_another_world_or_of_other_settings_is_refused() {
    let world = World::load("cornell-box.xml", [8, 8], &[]);
    let params = Params { rays: 20, ..Params::default() };
    let (made, _) = world.run::<IrradianceCaching>(&params, 1, 7, Show::All);
    let folder = Folder::make();
    let refusal = |cache: SavedCache, params: Params| {
        let setting = world.setting(1, Show::All);
        let params = Params { files: saved(&folder, &cache), ..params };
        IrradianceCaching::prepare(setting, &params).err().expect("a refusal")
    };
    let other = SavedCache { world: 99, ..made.saved() };
    assert!(refusal(other, params.clone()).contains("another scene"));
    let finer = Params { accuracy: 0.05, ..params };
    let text = refusal(made.saved(), finer);
    assert!(text.contains("--accuracy 0.1") && text.contains("--accuracy 0.05"), "{text}");
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
        triangles: vec![[0, 2, 1]],
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

#[test]
fn records_of_open_ground_are_not_used_in_the_court() {
    // The ground extends 400 m around a court of 8 m. Records far outside hit almost no surfaces, so their harmonic
    // mean distance is huge, and they could be used everywhere. The test checks that they do not replace the court's
    // own records.
    let world = World::load("patio.xml", [24, 18], &[("sun", "0")]);
    let truth = world.render::<PathTracer>(&pathtrace::Params::default(), 1024, 9, Show::Indirect);
    let (truth, noise) = mean_and_variance(&truth);
    let reach = ReachOptions { min_spacing: 0.5, ..defaults() };
    let params = Params { reach, ..Params::default() };
    let of = |seed| mean_and_variance(&render(&world, &params, 64, seed, Show::Indirect)).0;
    let (mean, error) = mean_and_error(&[1, 2, 3, 4].map(of));
    // The bound includes half a per cent for interpolation in corners, where light changes faster than records can
    // follow.
    let off = (mean / truth - 1.0).abs();
    let noise = (noise.sqrt() / truth).hypot(error / truth);
    assert!(
        off < 0.005 + 4.0 * noise,
        "{mean} against {truth}: relative difference {off:.4} +- {noise:.4}"
    );
}
