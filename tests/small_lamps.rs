//! Rooms with a small lamp: bare and close to a surface, in a corner, in a glass bulb, behind a pane. Compares virtual
//! lights and caches with light tracing.

use gi_core::film::{Film, Show};
use gi_core::math::Rgb;
use gi_stats::{Running, welch_t_test};
use gi_tests::{World, mean_and_variance};

const GREY: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.6"/></bsdf>"#;
const GLASS: &str = r#"<bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf>"#;
const HOLLOW: &str = r#"<bsdf type="dielectric"><float name="int_ior" value="1"/><float name="ext_ior" value="1.5"/></bsdf>"#;

fn ball(center: [f32; 3], radius: f32, inner: &str) -> String {
    let [x, y, z] = center;
    format!(
        r#"<shape type="sphere"><point name="center" x="{x}" y="{y}" z="{z}"/><float name="radius" value="{radius}"/>{inner}</shape>"#
    )
}

fn lamp(center: [f32; 3], radius: f32) -> String {
    let emitter = format!(
        r#"<bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf><emitter type="area"><rgb name="radiance" value="{}"/></emitter>"#,
        1.0 / radius.powi(2)
    );
    ball(center, radius, &emitter)
}

/// A lamp in a hollow glass ball.
fn bulb(center: [f32; 3], radius: f32) -> String {
    [lamp(center, 0.2 * radius), ball(center, 0.9 * radius, HOLLOW), ball(center, radius, GLASS)]
        .concat()
}

/// The lower half of a room, seen from its centre; the lamps are above.
fn room(rest: &str) -> World {
    World::of_xml(&format!(
        r#"<sensor type="perspective"><float name="fov" value="70"/><transform name="to_world"><lookat origin="0,0.5,1.9" target="0,-1.2,-0.6" up="0,1,0"/></transform>
        <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/><rfilter type="box"/></film></sensor>
        <shape type="cube"><boolean name="flip_normals" value="true"/><transform name="to_world"><scale value="2"/></transform>{GREY}</shape>
        <shape type="cube"><transform name="to_world"><scale value="0.4"/><translate x="-0.6" y="-1.6" z="-0.5"/></transform>{GREY}</shape>{rest}"#
    ))
}

fn kinds() -> [(&'static str, World); 5] {
    let pane = r#"<shape type="cube"><transform name="to_world"><scale x="0.5" y="0.02" z="0.5"/><translate y="1.7"/></transform>"#;
    // This lamp faces down.
    let lamp_above = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.05"/><rotate x="1" angle="90"/><translate x="0.1" y="1.95"/></transform><emitter type="area"><rgb name="radiance" value="400"/></emitter></shape>"#;
    let pane = format!("{lamp_above}{pane}{GLASS}</shape>");
    [
        ("close to the ceiling", room(&lamp([0.5, 1.93, -0.5], 0.03))),
        ("in a corner", room(&lamp([1.92, 1.92, -1.92], 0.03))),
        ("in a bulb", room(&bulb([0.0, 1.4, -0.5], 0.2))),
        ("in a bulb close to a wall", room(&bulb([0.0, 1.3, -1.88], 0.1))),
        ("behind a pane", room(&pane)),
    ]
}

type Render = fn(&World, u32) -> Film;

/// Largest relMSE of a picture by virtual lights. With some ten photons per pixel and pass and six passes, photons give
/// 1/60; other noise gives about as much. Paths that search for the lamp give errors above 1.
const ERROR: f32 = 0.05;
/// The same for caches, whose rays find the light around a bare lamp near a surface only by chance.
const CACHE_ERROR: f32 = 0.2;

const PROGRAMS: [(&str, f32, Render); 4] = [
    ("instant radiosity", ERROR, |world, seed| {
        let params = instant_radiosity::Params { vpls: 128, ..Default::default() };
        world.render::<instant_radiosity::InstantRadiosity>(&params, 6, seed, Show::All)
    }),
    ("lightcuts", ERROR, |world, seed| {
        let mut params = lightcuts::Params { vpls: 1024, ..Default::default() };
        params.lights.total = 256;
        params.cut.max_cut = Some(200);
        world.render::<lightcuts::Lightcuts>(&params, 6, seed, Show::All)
    }),
    ("irradiance caching", CACHE_ERROR, |world, seed| {
        let params = irrcache::Params::default();
        world.render::<irrcache::IrradianceCaching>(&params, 6, seed, Show::All)
    }),
    ("radiance caching", CACHE_ERROR, |world, seed| {
        let params = radcache::Params::default();
        world.render::<radcache::RadianceCaching>(&params, 6, seed, Show::All)
    }),
];

/// Allowed relative error of the mean, from the blur of photons in the first passes and from the accuracy of a cache.
const BLUR: f64 = 0.025;
const SEEDS: u32 = 4;

#[test]
fn a_small_lamp_near_surfaces_or_behind_glass_causes_no_bright_pixels() {
    let params = pathtrace::Params { mode: pathtrace::Mode::Light, ..Default::default() };
    for (kind, world) in kinds() {
        let truth = |seed| world.render::<pathtrace::PathTracer>(&params, 600, seed, Show::All);
        let truth: Vec<Film> = (0..SEEDS).map(truth).collect();
        let mean = |film: &Film| mean_and_variance(film).0;
        let expected: Running = truth.iter().map(mean).collect();
        let pixels = picture(&truth);
        for (program, limit, render) in PROGRAMS {
            let films: Vec<Film> = (0..SEEDS).map(|seed| render(&world, 40 + seed)).collect();
            let found: Running = films.iter().map(mean).collect();
            let ratio = found.mean() / expected.mean();
            let by = (BLUR * expected.mean()).min((found.mean() - expected.mean()).abs());
            let by = by.copysign(1.0 - ratio);
            let moved: Running = films.iter().map(|f| mean(f) + by).collect();
            let p = welch_t_test(&moved, &expected);
            for film in &films {
                let pairs = || film.radiance().into_iter().zip(&pixels);
                let error = pairs().map(|(a, &b)| rel_mse(a, b)).sum::<f32>() / pixels.len() as f32;
                let most = pairs().map(|(a, b)| a.luminance() / b.luminance()).fold(0.0, f32::max);
                println!(
                    "{kind}, {program}: ratio {ratio:.3}, p {p:.1e}, relMSE {error:.4}, most {most:.2}"
                );
                assert!(
                    error < limit && most < 5.0,
                    "{kind}, {program}: relMSE {error}, pixel {most}"
                );
            }
            assert!(p > 1e-5, "{kind}, {program}: {ratio} of the light, p = {p:.1e}");
        }
    }
}

/// The mean of several pictures.
fn picture(films: &[Film]) -> Vec<Rgb> {
    let mut sum = films[0].radiance();
    for film in &films[1..] {
        sum.iter_mut().zip(film.radiance()).for_each(|(s, c)| *s += c);
    }
    sum.into_iter().map(|c| c / films.len() as f32).collect()
}

fn rel_mse(a: Rgb, b: Rgb) -> f32 {
    (a.luminance() - b.luminance()).powi(2) / (b.luminance().powi(2) + 1e-2)
}
