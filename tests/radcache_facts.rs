//! Compares radiance caching with the path tracer, with irradiance caching and with itself.

use gi_core::camera::CameraSpec;
use gi_core::film::{Film, Show};
use gi_core::geometry::{Mesh, Shape};
use gi_core::material::{Distribution, Material, Roughness};
use gi_core::math::Rgb;
use gi_core::scene::SceneParts;
use gi_core::technique::Technique;
use gi_core::texture::Texture;
use gi_tests::program::Folder;
use gi_tests::{World, cube_inside, furnace, mean_and_variance, polygon};
use glam::Vec3;
use irrcache::IrradianceCaching;
use lightcache::options::CacheFiles;
use pathtrace::PathTracer;
use radcache::file::SavedCache;
use radcache::sh::Basis;
use radcache::{Mode, Params, RadianceCaching};

fn render(world: &World, params: &Params, passes: u32, seed: u32, show: Show) -> Film {
    world.render::<RadianceCaching>(params, passes, seed, show)
}

fn statistic(technique: &RadianceCaching, name: &str) -> f64 {
    let all = technique.statistics();
    all.iter().find(|(n, _)| n == name).unwrap_or_else(|| panic!("no {name}")).1
}

/// A rough conductor that reflects all light, except for what is lost between its facets.
fn mirror(alpha: f32, tint: f32) -> Material {
    let alpha = Texture::grey(alpha);
    let roughness =
        Roughness { distribution: Distribution::Ggx, alpha_u: alpha.clone(), alpha_v: alpha };
    Material::Conductor {
        eta: Rgb::BLACK,
        k: Rgb::WHITE,
        reflectance: Texture::grey(tint),
        roughness: Some(roughness),
    }
}

#[test]
fn with_only_lambertian_surfaces_it_is_irradiance_caching_bit_for_bit() {
    let world = World::load("cornell-box.xml", [32, 32], &[]);
    let ours = Params { rays: 200, ..Params::default() };
    let theirs = irrcache::Params { rays: 200, ..irrcache::Params::default() };
    let a = render(&world, &ours, 2, 7, Show::All);
    let b = world.render::<IrradianceCaching>(&theirs, 2, 7, Show::All);
    assert_eq!(a.layers().channels, b.layers().channels);
}

#[test]
fn a_lambertian_surface_that_has_radiance_records_agrees_with_irradiance_caching() {
    // Oren and Nayar's model with zero roughness: its table is empty, and its diffuse part uses the records'
    // irradiance.
    let make = |material: Material| {
        World::load_with("cornell-box.xml", [24, 24], &[], move |parts, _| {
            for m in &mut parts.materials {
                if let Material::Diffuse { .. } = m {
                    *m = material.clone();
                }
            }
        })
    };
    let reflectance = Texture::grey(0.7);
    let smooth = make(Material::RoughDiffuse {
        reflectance: reflectance.clone(),
        alpha: Texture::grey(0.0),
    });
    let lambert = make(Material::Diffuse { reflectance });
    let theirs = irrcache::Params { rays: 500, ..irrcache::Params::default() };
    let theirs = lambert.render::<IrradianceCaching>(&theirs, 4, 1, Show::Indirect);
    let ours = Params { glossy_rays: 500, ..Params::default() };
    let (technique, ours) = smooth.run::<RadianceCaching>(&ours, 4, 1, Show::Indirect);
    assert!(
        statistic(&technique, "glossy_records") > 50.0 && statistic(&technique, "records") == 0.0
    );
    // There are hundreds of records with 500 rays each, so the noise of both means is well below 1 %.
    let ratio = mean_and_variance(&ours).0 / mean_and_variance(&theirs).0;
    assert!((ratio - 1.0).abs() < 0.01, "mean ratio {ratio}");
}

#[test]
fn in_the_glossy_box_it_agrees_with_the_path_tracer_and_more_rays_reduce_the_error() {
    let world = World::load("cornell-glossy.xml", [48, 48], &[]);
    let reference =
        world.render::<PathTracer>(&pathtrace::Params::default(), 2048, 3, Show::Indirect);
    let (truth, variance) = mean_and_variance(&reference);
    assert!(variance.sqrt() < 3e-3 * truth, "the reference is too noisy for the bound below");
    let error_of = |params: &Params| {
        let film = render(&world, params, 16, 1, Show::Indirect);
        (mean_and_variance(&film).0 / truth, rel_mse(&film, &reference))
    };
    let (ratio, usual) = error_of(&Params::default());
    assert!((ratio - 1.0).abs() < 0.02, "mean ratio {ratio}");
    let (hsh_ratio, _) = error_of(&Params { basis: Basis::Hsh, ..Params::default() });
    assert!((hsh_ratio - 1.0).abs() < 0.02, "hemispherical: mean ratio {hsh_ratio}");
    let (_, few) = error_of(&Params { rays: 50, glossy_rays: 50, ..Params::default() });
    let (_, naive) = error_of(&Params { mode: Mode::RhoE, ..Params::default() });
    let (_, low) = error_of(&Params { order: 2, ..Params::default() });
    assert!(usual < few, "{usual} with many rays, {few} with few");
    assert!(usual < 0.5 * naive, "{usual} in the basis, {naive} by the naive product");
    assert!(usual < 0.5 * low, "{usual} at order 10, {low} at order 2");
}

/// Mean squared difference of two pictures relative to the second, minus the second's own noise.
fn rel_mse(film: &Film, reference: &Film) -> f64 {
    let (a, b) = (film.layers(), reference.layers());
    let of = |l: &gi_core::image_io::Layers, name: &str| l.channel(name).expect("one").to_vec();
    let mut sum = 0.0;
    for c in ["R", "G", "B"] {
        let variance = of(&b, &format!("Variance.{c}"));
        for ((a, b), v) in of(&a, c).into_iter().zip(of(&b, c)).zip(variance) {
            sum += f64::from((a - b).powi(2) - v) / f64::from(b * b + 1e-3);
        }
    }
    sum / (3 * a.width * a.height) as f64
}

#[test]
fn a_glossy_furnace_reads_what_the_path_tracer_reads() {
    // The walls emit 1. At each bounce, the rough mirror loses the same fraction between its facets as in path tracing.
    let (mut parts, camera) = furnace(0.0);
    parts.materials = vec![mirror(0.3, 0.5)];
    let world = World::new(parts, &camera);
    let truth = world.render::<PathTracer>(&pathtrace::Params::default(), 256, 3, Show::All);
    let (truth, _) = mean_and_variance(&truth);
    for basis in [Basis::Sh, Basis::Hsh] {
        let params = Params { basis, glossy_rays: 500, ..Params::default() };
        let film = render(&world, &params, 16, 1, Show::All);
        let ratio = mean_and_variance(&film).0 / truth;
        // In spherical harmonics, a lobe at grazing angles extends below the horizon: this affects 1 % of the indirect
        // light.
        assert!((ratio - 1.0).abs() < 0.01, "{basis:?}: {ratio}");
    }
}

/// A rough mirror as floor in a black room, whose far walls emit smoothly varying light without edges.
fn soft_world() -> World {
    let ceiling = [
        Vec3::new(-1.0, -1.0, 1.0),
        Vec3::new(-1.0, 1.0, 1.0),
        Vec3::new(1.0, 1.0, 1.0),
        Vec3::new(1.0, -1.0, 1.0),
    ];
    let floor = ceiling.map(|p| Vec3::new(p.y, p.x, -1.0) * Vec3::new(0.3, 0.3, 0.5));
    let lamp = [
        Vec3::new(-0.3, -0.3, -0.99),
        Vec3::new(0.3, -0.3, -0.99),
        Vec3::new(0.3, 0.3, -0.99),
        Vec3::new(-0.3, 0.3, -0.99),
    ];
    let white = Material::Diffuse { reflectance: Texture::grey(0.8) };
    let black = Material::Diffuse { reflectance: Texture::grey(0.0) };
    let shapes = vec![
        Shape::new("walls", cube_inside(), 1),
        Shape::new("floor", polygon(&floor), 0),
        Shape {
            emission: Some(Texture::Constant(Rgb::grey(5.0))),
            ..Shape::new("lamp", polygon(&lamp), 2)
        },
    ];
    let materials = vec![mirror(0.4, 1.0), white, black];
    let camera = CameraSpec::look_at(
        Vec3::new(0.0, -0.6, 0.1),
        Vec3::new(0.0, 0.0, -0.5),
        Vec3::Z,
        0.5,
        [16, 16],
    );
    World::new(SceneParts { shapes, materials, ..SceneParts::default() }, &camera)
}

#[test]
fn the_error_falls_with_the_order_under_soft_light() {
    let world = soft_world();
    let show = Show::Indirect;
    let reference = world.render::<PathTracer>(&pathtrace::Params::default(), 2048, 3, show);
    let error = |order| {
        let params = Params { order, glossy_rays: 20_000, ..Params::default() };
        rel_mse(&render(&world, &params, 8, 1, show), &reference)
    };
    let errors: Vec<f64> = [1, 2, 3, 5].map(error).to_vec();
    assert!(errors.windows(2).all(|w| w[1] < w[0]), "{errors:?}");
}

#[test]
fn lobes_below_the_minimum_roughness_are_path_traced() {
    let world = World::load("cornell-glossy.xml", [16, 16], &[]);
    let none = Params { min_roughness: 2.0, rays: 50, ..Params::default() };
    let (technique, _) = world.run::<RadianceCaching>(&none, 1, 1, Show::All);
    assert_eq!(statistic(&technique, "glossy_records"), 0.0);
    assert!(technique.reach().contains("path"), "{}", technique.reach());
    let (technique, _) = world.run::<RadianceCaching>(
        &Params { glossy_rays: 50, rays: 50, ..Params::default() },
        1,
        1,
        Show::All,
    );
    let reach = technique.reach();
    assert!(statistic(&technique, "glossy_records") > 0.0);
    assert!(reach.contains("0.25): order 10") && reach.contains("0.10): path"), "{reach}");
}

#[test]
fn picture_and_caches_have_the_same_bits_for_any_number_of_threads() {
    let bits = |threads: usize, basis: Basis| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let world = World::load("cornell-glossy.xml", [40, 30], &[]);
            let params = Params { basis, rays: 100, glossy_rays: 100, ..Params::default() };
            let (technique, film) = world.run::<RadianceCaching>(&params, 2, 7, Show::All);
            let layers = film.layers().channels.into_iter();
            let pixels: Vec<u32> =
                layers.flat_map(|(_, v)| v.into_iter().map(f32::to_bits)).collect();
            (pixels, technique.saved().to_bytes())
        })
    };
    for basis in [Basis::Sh, Basis::Hsh] {
        let one = bits(1, basis);
        for threads in [2, 4] {
            assert!(bits(threads, basis) == one, "{threads} threads, {basis:?}");
        }
    }
}

#[test]
fn a_saved_cache_gives_the_same_picture_and_helps_another_view() {
    let world = World::load("cornell-glossy.xml", [40, 40], &[]);
    let params = Params { rays: 100, glossy_rays: 100, ..Params::default() };
    let (fresh, film) = world.run::<RadianceCaching>(&params, 2, 7, Show::All);
    let folder = Folder::make();
    let files = |cache: &SavedCache| {
        let path = folder.path().join("a.cache");
        std::fs::write(&path, cache.to_bytes()).expect("written");
        CacheFiles { cache_in: Some(path), ..CacheFiles::default() }
    };
    let saved = fresh.saved();
    let again = Params { files: files(&saved), ..params.clone() };
    let (read, second) = world.run::<RadianceCaching>(&again, 2, 7, Show::All);
    assert_eq!(film.layers().channels, second.layers().channels);
    assert_eq!(statistic(&read, "records_made"), 0.0);
    // A view from the side: records of the first view are reused.
    let side = world.from_the_side();
    let (alone, _) = side.run::<RadianceCaching>(&params, 1, 7, Show::All);
    let (helped, _) = side.run::<RadianceCaching>(&again, 1, 7, Show::All);
    let (alone, helped) = (statistic(&alone, "records_made"), statistic(&helped, "records_made"));
    assert!(helped < 0.5 * alone, "{helped} new records with the saved cache, {alone} without it");
    let refused = |cache: SavedCache, params: Params| {
        let params = Params { files: files(&cache), ..params };
        RadianceCaching::prepare(side.setting(1, Show::All), &params).err().expect("a refusal")
    };
    let other = SavedCache { world: 9, ..saved.clone() };
    assert!(refused(other, params.clone()).contains("another scene"));
    let text = refused(saved, Params { order: 6, ..params });
    assert!(text.contains("--order 10") && text.contains("--order 6"), "{text}");
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
    let shapes = vec![Shape::new("triangle", gi_core::geometry::Geometry::Mesh(triangle), 0)];
    let dark = SceneParts { shapes, materials: vec![mirror(0.5, 0.9)], ..SceneParts::default() };
    for parts in [SceneParts::default(), dark] {
        let world = World::new(parts, &camera);
        let film = render(&world, &Params::default(), 1, 1, Show::All);
        assert!(film.radiance().iter().all(|c| c.is_black()));
    }
}
