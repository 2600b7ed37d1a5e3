//! Neighbouring pixels that use each other's paths.

use gi_core::camera::Projection;
use gi_core::film::{Film, Show};
use gi_core::options::{Parameters, PathLimits};
use gi_stats::{Running, sidak, welch_t_test};
use gi_tests::World;
use pathtrace::{LightSelection, Mode, Params, PathTracer};

use crate::agreement::{block_means, means_of_parts};

fn groups_of(reuse: u32) -> Params {
    Params { reuse, ..Params::default() }
}

/// Compare indirect light, averaged over parts of pictures, with and without reuse.
fn assert_same_means(
    name: &str,
    world: &World,
    (params, passes): (&Params, u32),
    parts: impl Fn(&Film) -> Vec<f64>,
) {
    let render =
        |params: &Params, seed| world.render::<PathTracer>(params, passes, seed, Show::Indirect);
    let one = Params { reuse: 1, ..params.clone() };
    let alone = means_of_parts(100..124, |seed| render(&one, seed), &parts);
    let reused = means_of_parts(200..224, |seed| render(params, seed), &parts);
    let level = sidak(1e-3, alone.len());
    for (k, (a, b)) in alone.iter().zip(&reused).enumerate() {
        let p = welch_t_test(a, b);
        let error = |r: &Running| r.variance_of_mean().sqrt();
        assert!(
            p > level,
            "{name}, part {k}: {:.5} +- {:.1e} alone, {:.5} +- {:.1e} with reuse, p = {p:.1e}",
            a.mean(),
            error(a),
            b.mean(),
            error(b)
        );
    }
}

#[test]
fn reuse_changes_no_mean() {
    // Diffuse and glossy walls; mirrors and glass in view; plastic, masks and the sky; many lamps, chosen by a tree.
    for (scene, aperture_radius, reuse) in [
        ("cornell-box.xml", 0.0, 8),
        ("cornell-glossy.xml", 0.0, 16),
        ("cornell-spheres.xml", 0.0, 5),
        ("patio.xml", 0.0, 8),
        ("pavilion.xml", 0.0, 2),
        ("gallery.xml", 0.2, 8),
    ] {
        let world = World::load_with(scene, [24, 24], &[], |_, camera| {
            if let Projection::Perspective { aperture_radius: radius, focus_distance, .. } =
                &mut camera.projection
            {
                (*radius, *focus_distance) = (aperture_radius, 4.0);
            }
        });
        let light_selection = match scene {
            "gallery.xml" => LightSelection::Tree,
            _ => LightSelection::Auto,
        };
        // Long paths through glass find light rarely, and are then bright. Means of few pictures would not be normally distributed.
        let limits = PathLimits { max_depth: Some(6), ..PathLimits::default() };
        let params = Params { light_selection, limits, ..groups_of(reuse) };
        assert_same_means(scene, &world, (&params, 32), |film| block_means(film, 6));
    }
}

/// Means over the columns of a picture.
fn columns(film: &Film) -> Vec<f64> {
    let layers = film.layers();
    let green = layers.channel("G").expect("a layer");
    let column = |x| green.iter().skip(x).step_by(layers.width).map(|v| f64::from(*v)).sum::<f64>();
    (0..layers.width).map(|x| column(x) / layers.height as f64).collect()
}

/// A blind whose slats are turned to the left and to the right alternately. Neighbouring pixels see slats, and walls that see the slats from
/// behind. What reaches one of these points is often hidden from the next.
fn blind(slats: [&str; 2]) -> String {
    let slat = |k: usize| {
        let (x, angle) = (-1.5 + 0.2 * k as f32, [55, -55][k % 2]);
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale x="0.13" y="1.6" z="1"/><rotate y="1" angle="{angle}"/><translate x="{x}" y="0" z="0.5"/></transform>{}</shape>"#,
            slats[k % 2]
        )
    };
    (0..16).map(slat).collect()
}

/// A thin wall that the camera sees from its edge: pixels to the left and to the right of the middle use different sides of it.
fn thin_wall(bsdf: &str) -> String {
    format!(
        r#"<shape type="rectangle"><transform name="to_world"><scale x="1" y="1.6" z="1"/><rotate y="1" angle="90"/><translate z="-1"/></transform>{bsdf}</shape>"#
    )
}

/// A room with things, lit from a lamp that is as wide as the ceiling.
fn room(walls: &str, things: &str) -> World {
    World::of_xml(&format!(
        r#"<sensor type="perspective"><float name="fov" value="75"/><transform name="to_world"><lookat origin="0,0,1.9" target="0,0,0" up="0,1,0"/></transform><film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="24"/><rfilter type="box"/></film></sensor>
        <shape type="cube"><transform name="to_world"><scale value="2"/></transform><bsdf type="twosided">{walls}</bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><translate y="1.9" z="-0.8"/></transform><bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="5"/></emitter></shape>{things}"#
    ))
}

const GREY: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.7"/></bsdf>"#;
const DARK: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.2"/></bsdf>"#;
const MIRROR: &str = r#"<bsdf type="twosided"><bsdf type="conductor"/></bsdf>"#;
const MASK: &str = r#"<bsdf type="mask"><float name="opacity" value="0.4"/><bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf>"#;
const BUMPS: &str = r#"<bsdf type="bumpmap"><float name="scale" value="1"/><texture type="bitmap"><boolean name="raw" value="true"/><string name="filename" value="height.pfm"/></texture><bsdf type="roughplastic"><float name="alpha" value="0.3"/></bsdf></bsdf>"#;

#[test]
fn reuse_changes_no_mean_where_neighbours_see_different_things() {
    // Bright in front and dark behind.
    let sides = format!(
        r#"<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.9"/></bsdf>{DARK}</bsdf>"#
    );
    let dark = format!(r#"<bsdf type="twosided">{DARK}</bsdf>"#);
    let bumps = format!(r#"<bsdf type="twosided">{BUMPS}</bsdf>"#);
    let coated = r#"<bsdf type="twosided"><bsdf type="plastic"/></bsdf>"#;
    let limits = |max_depth, rr_depth| PathLimits { max_depth, rr_depth };
    for (name, walls, things, limits) in [
        ("thin wall", GREY, thin_wall(&sides), limits(Some(4), 2)),
        ("two sides", GREY, blind([&sides, &sides]), limits(Some(4), 2)),
        ("coats", GREY, blind([coated, &dark]), limits(Some(4), 2)),
        ("sheets", GREY, blind([MASK, MASK]), limits(Some(4), 2)),
        ("bumps", BUMPS, thin_wall(&bumps), limits(Some(4), 2)),
        ("mirrors and a limit", GREY, blind([MIRROR, &dark]), limits(Some(3), 2)),
        ("early roulette", DARK, blind([&dark, &dark]), limits(None, 0)),
    ] {
        let params = Params { limits, ..groups_of(16) };
        assert_same_means(name, &room(walls, &things), (&params, 32), |film| {
            [columns(film), block_means(film, 12)].concat()
        });
    }
}

/// Regression: paths that end at a black surface, such as a lamp, had a positive density in the weights. The ceiling near the lamp lost a
/// fifth of its indirect light.
#[test]
fn reuse_loses_no_light_next_to_black_surfaces() {
    let world = World::of_xml(
        r#"<sensor type="perspective"><float name="fov" value="60"/><transform name="to_world"><lookat origin="0,0,1.9" target="0,0,0" up="0,1,0"/></transform><film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="24"/><rfilter type="box"/></film></sensor>
        <shape type="cube"><boolean name="flip_normals" value="true"/><transform name="to_world"><scale value="2"/></transform><bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="0.2"/></transform><bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf></shape>"#,
    );
    assert_same_means("black sheet", &world, (&groups_of(16), 32), |film| block_means(film, 6));
}

/// Regression: a bent normal is flipped if it faces away from the path, and the light tree never chooses lights behind the flipped
/// normal. Pixels that saw the same point with the other normal lost the light of these lamps: 3 % of all indirect light.
#[test]
fn reuse_loses_no_light_where_bent_normals_are_flipped() {
    let steep = r#"<bsdf type="bumpmap"><float name="scale" value="3"/><texture type="bitmap"><boolean name="raw" value="true"/><string name="filename" value="height.pfm"/></texture><bsdf type="diffuse"/></bsdf>"#;
    let lamp = |[x, y, z]: [f32; 3]| {
        format!(
            r#"<emitter type="point"><point name="position" x="{x}" y="{y}" z="{z}"/><rgb name="intensity" value="0.6"/></emitter>"#
        )
    };
    let lamps = [
        [-1.6, -0.6, -1.0],
        [1.6, -0.5, -1.5],
        [0.0, 1.2, -1.5],
        [0.3, -0.7, 1.5],
        [-1.0, 1.2, 1.0],
    ];
    let params = Params { light_selection: LightSelection::Tree, ..groups_of(16) };
    let params =
        Params { limits: PathLimits { max_depth: Some(3), ..PathLimits::default() }, ..params };
    let world = room(steep, &lamps.map(lamp).concat());
    assert_same_means("steep bumps", &world, (&params, 128), |film| block_means(film, 24));
}

/// Mean squared error against a reference.
fn error(film: &Film, reference: &Film) -> f64 {
    let [a, b] =
        [film, reference].map(|film| film.layers().channel("G").expect("a layer").to_vec());
    a.iter().zip(&b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / a.len() as f64
}

#[test]
fn reuse_halves_the_error_of_indirect_light() {
    let world = World::load("cornell-box.xml", [32, 32], &[]);
    let show = Show::Indirect;
    let render = |reuse, passes| world.render::<PathTracer>(&groups_of(reuse), passes, 1, show);
    let truth = world.render::<PathTracer>(&groups_of(8), 2048, 2, show);
    let [alone, reused] = [1, 8].map(|reuse| error(&render(reuse, 16), &truth));
    // Eight paths instead of one would give an eighth, if all eight were independent and as good as the pixel's own.
    assert!(reused < alone / 2.0, "{reused:.2e} with reuse, {alone:.2e} without");
}

#[test]
fn reuse_gives_the_same_bits_for_any_number_of_threads() {
    let world = World::load("cornell-spheres.xml", [37, 21], &[]);
    let bits = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let film = pool.install(|| world.render::<PathTracer>(&groups_of(8), 3, 1, Show::All));
        let layers = film.layers();
        layers.channel("R").expect("a layer").iter().map(|v| v.to_bits()).collect::<Vec<_>>()
    };
    assert!(bits(1) == bits(3));
}

#[test]
fn reuse_is_refused_where_it_has_no_effect() {
    for mode in [Mode::VolPath, Mode::Light, Mode::Bdpt, Mode::Vcm] {
        let refused = Params { mode, ..groups_of(8) }.check().expect_err("refused");
        assert!(refused.contains("--mode path"), "{refused}");
    }
    assert_eq!(groups_of(8).check(), Ok(()));
}
