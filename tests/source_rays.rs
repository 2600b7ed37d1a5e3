//! Extra camera rays that look only for light sources.

use gi_core::camera::Projection;
use gi_core::eye::{PathLimits, SourceRays};
use gi_core::film::{Film, Sample, Show};
use gi_core::filter::Filter;
use gi_core::options::Parameters;
use gi_core::technique::{Setting, Technique};
use gi_tests::{World, mean_and_variance};
use lightcuts::{Lightcuts, Method};
use pathtrace::{Mode, Params, PathTracer};

use crate::agreement::assert_agree;

/// Passes of a technique, with rays for the light sources in view.
fn render<'a, T: Technique<'a>>(
    world: &'a World,
    params: &T::Params,
    (source_rays, passes, seed): (u32, u32, u32),
    filter: Filter,
) -> Film
where
    T::Params: Parameters,
{
    let setting = Setting { source_rays, ..world.setting(seed, Show::All) };
    let limits = PathLimits { max_depth: params.max_depth(), ..PathLimits::default() };
    let rays = SourceRays::new(&setting, limits, params.simulates_media());
    assert_eq!(rays.is_some(), source_rays > 0);
    let mut film = Film::new(world.camera.size(), filter, Show::All);
    let mut technique = T::prepare(setting, params).expect("valid parameters");
    for pass in 0..passes {
        if let Some(rays) = &rays {
            rays.add_to_pass(pass, &mut film);
        }
        technique.pass(pass, &mut film);
    }
    film
}

/// Mean radiance of the light sources that the rays of a pass find.
fn sources_alone(world: &World, params: &Params, filter: Filter) -> f64 {
    let setting = Setting { source_rays: 64, ..world.setting(1, Show::All) };
    let rays = SourceRays::new(&setting, params.limits, params.simulates_media()).expect("rays");
    let mut film = Film::new(world.camera.size(), filter, Show::All);
    rays.add_to_pass(0, &mut film);
    film.add_pass(|_| Sample::default());
    mean_and_variance(&film).0
}

fn paths(mode: Mode, max_depth: Option<u32>) -> Params {
    let limits = PathLimits { max_depth, ..PathLimits::default() };
    Params { mode, limits, ..Params::default() }
}

const MITCHELL: Filter = Filter::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 };

#[test]
fn rays_for_light_sources_change_no_mean() {
    // Lamps in the open, through a lens, in glass, in a mirror and in media; the sky in the open and through glass.
    for (scene, aperture_radius, mode, filter) in [
        ("gallery.xml", 0.0, Mode::Path, MITCHELL),
        ("gallery.xml", 0.2, Mode::Path, Filter::Box),
        ("bulb.xml", 0.0, Mode::Path, Filter::Tent),
        ("cornell-spheres.xml", 0.0, Mode::Path, Filter::Tent),
        ("pavilion.xml", 0.0, Mode::Path, Filter::Box),
        ("cognac.xml", 0.0, Mode::VolPath, Filter::Box),
        ("milk.xml", 0.0, Mode::VolPath, Filter::Tent),
        ("bulb.xml", 0.0, Mode::Bdpt, Filter::Tent),
        ("pavilion.xml", 0.0, Mode::Bdpt, Filter::Box),
        ("cornell-spheres.xml", 0.0, Mode::Vcm, Filter::Tent),
        ("milk.xml", 0.0, Mode::Vcm, Filter::Box),
    ] {
        let world = World::load_with(scene, [24, 24], &[], |_, camera| {
            if let Projection::Perspective { aperture_radius: radius, focus_distance, .. } =
                &mut camera.projection
            {
                (*radius, *focus_distance) = (aperture_radius, 4.0);
            }
        });
        let params = paths(mode, Some(4));
        assert!(sources_alone(&world, &params, filter) > 0.0, "{scene} shows no light source");
        let without = render::<PathTracer>(&world, &params, (0, 512, 3), filter);
        let with = render::<PathTracer>(&world, &params, (5, 128, 4), filter);
        assert_agree(&format!("{scene}, {filter:?}"), &without, &with, 8);
    }
}

#[test]
fn rays_for_light_sources_change_no_mean_of_multidimensional_lightcuts() {
    let world = World::load("gallery.xml", [24, 18], &[]);
    let limits = PathLimits { max_depth: Some(1), ..PathLimits::default() };
    let method = Method::Multidimensional;
    let params = lightcuts::Params { method, gather: 4, limits, ..lightcuts::Params::default() };
    for filter in [Filter::Box, MITCHELL] {
        let without = render::<Lightcuts>(&world, &params, (0, 128, 3), filter);
        let with = render::<Lightcuts>(&world, &params, (5, 64, 4), filter);
        assert_agree(&format!("multidimensional, {filter:?}"), &without, &with, 6);
    }
}

#[test]
fn lamps_have_smooth_edges_after_few_passes() {
    let world = World::load("gallery.xml", [48, 36], &[("lights", "1024")]);
    let lamps = paths(Mode::Path, Some(1));
    for filter in [Filter::Box, MITCHELL] {
        let picture = |asked| {
            let film = render::<PathTracer>(&world, &lamps, asked, filter);
            film.layers().channel("G").expect("a layer").to_vec()
        };
        let truth = picture((0, 4096, 1));
        let error = |asked| {
            let errors =
                picture(asked).into_iter().zip(&truth).map(|(a, b)| f64::from(a - b).powi(2));
            errors.sum::<f64>()
        };
        // A sample counts in several pixels if the filter is wide, so the factor is below 64.
        let [few, many] = [error((0, 2, 2)), error((64, 2, 2))];
        assert!(many < few / 16.0, "{filter:?}: {few} without rays, {many} with 64");
    }
}

#[test]
fn rays_for_light_sources_give_the_same_bits_for_any_number_of_threads() {
    let world = World::load("gallery.xml", [40, 33], &[]);
    let params = lightcuts::Params { vpls: 256, ..lightcuts::Params::default() };
    let bits = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let film = pool.install(|| render::<Lightcuts>(&world, &params, (8, 2, 1), Filter::Tent));
        let layers = film.layers();
        layers.channel("R").expect("a layer").iter().map(|v| v.to_bits()).collect::<Vec<_>>()
    };
    assert!(bits(1) == bits(3));
}
