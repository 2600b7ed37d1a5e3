//! The scenes of the matrix, with the programs that can reach their light.

use super::Program::*;
use super::{ALL, Program, Row, Truth};

fn camera(place: &str) -> String {
    format!(
        r#"<sensor type="perspective"><float name="fov" value="80"/><transform name="to_world"><lookat origin="0,0,1.9" target="0,-0.5,0" up="0,1,0"/>{place}</transform>
        <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/><rfilter type="box"/></film></sensor>"#
    )
}

/// A rectangle with half side `half` that faces up or down at height `y`.
fn sheet(half: f32, y: f32, up: bool, place: &str, inner: &str) -> String {
    let angle = if up { -90 } else { 90 };
    format!(
        r#"<shape type="rectangle"><transform name="to_world"><scale value="{half}"/><rotate x="1" angle="{angle}"/><translate y="{y}"/>{place}</transform>{inner}</shape>"#
    )
}

const GREY: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf>"#;

/// A closed room with a lamp under the ceiling, and `rest` inside; `place` transforms everything.
fn room_at(place: &str, rest: &str) -> String {
    let lamp = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf><emitter type="area"><rgb name="radiance" value="5"/></emitter>"#;
    format!(
        r#"{}<shape type="cube"><boolean name="flip_normals" value="true"/><transform name="to_world"><scale value="2"/>{place}</transform>{GREY}</shape>{}{rest}"#,
        camera(place),
        sheet(0.8, 1.9, false, place, lamp)
    )
}

fn room(rest: &str) -> String {
    room_at("", rest)
}

/// A floor under the lamp with a normal map or bump map.
fn bent(map: &str, inner: &str) -> String {
    let bsdf = match map {
        "height" => format!(
            r#"<bsdf type="bumpmap"><float name="scale" value="0.4"/><texture type="bitmap"><boolean name="raw" value="true"/><string name="filename" value="height.pfm"/></texture>{inner}</bsdf>"#
        ),
        _ => format!(
            r#"<bsdf type="normalmap"><texture name="normalmap" type="bitmap"><boolean name="raw" value="true"/><string name="filename" value="{map}.pfm"/></texture>{inner}</bsdf>"#
        ),
    };
    sheet(1.9, -1.2, true, "", &bsdf)
}

/// A row without light tracing, because only few of its paths reach the eye.
fn but_light(mut row: Row) -> Row {
    row.programs.retain(|(program, _)| *program != Light);
    row
}

pub(super) fn stacks() -> Vec<Row> {
    let row = |name, rest: String, programs: &[(Program, f64)]| Row {
        name,
        body: room(&rest),
        truth: Truth::Of(Path),
        programs: programs.to_vec(),
    };
    let stack = |n: u32, bsdf: &str| -> String {
        (0..n).map(|k| sheet(1.9, 1.0 - 0.1 * k as f32, false, "", bsdf)).collect()
    };
    let mask = r#"<bsdf type="mask"><float name="opacity" value="0.1"/><bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf>"#;
    // Half of the squares are holes.
    let lattice = r#"<bsdf type="mask"><texture name="opacity" type="checkerboard"><transform name="to_uv"><scale value="8"/></transform><rgb name="color0" value="0"/><rgb name="color1" value="1"/></texture><bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf>"#;
    let pane = r#"<bsdf type="thindielectric"/>"#;
    vec![
        row("plain room", String::new(), &ALL),
        row("three null sheets before the lamp", stack(3, r#"<bsdf type="null"/>"#), &ALL),
        row("ten masks before the lamp", stack(10, mask), &ALL),
        row("lattice before the lamp", stack(1, lattice), &ALL),
        // Light tracing does not find the light that panes reflect.
        but_light(row("two panes before the lamp", stack(2, pane), &ALL)),
    ]
}

pub(super) fn maps() -> Vec<Row> {
    let metal = r#"<bsdf type="roughconductor"><string name="material" value="none"/><float name="alpha" value="0.3"/></bsdf>"#;
    // Radiance records include only the mean shadowing of a lobe with a normal map; photons blur over the waves of the
    // map.
    let loose = |p: Program, bias: f64| match p {
        Radcache => 0.06,
        Photonmap => 0.05,
        _ => bias,
    };
    let row = |name, map: &str, inner: &str| Row {
        name,
        body: room(&bent(map, inner)),
        truth: Truth::Of(Path),
        programs: ALL.into_iter().map(|(p, bias)| (p, loose(p, bias))).collect(),
    };
    vec![
        row("gentle normal map", "gentle", GREY),
        row("strong normal map", "strong", GREY),
        row("strong normal map on metal", "strong", metal),
        row("bump map", "height", GREY),
    ]
}

pub(super) fn places() -> Vec<Row> {
    let row = |name, place: &str| Row {
        name,
        body: room_at(place, ""),
        truth: Truth::Of(Path),
        programs: ALL.to_vec(),
    };
    vec![
        row("a hundred kilometres out", r#"<translate x="100000" y="-70000" z="40000"/>"#),
        row("a micrometre wide", r#"<scale value="1e-6"/>"#),
        row("a million units wide", r#"<scale value="1e6"/>"#),
    ]
}

/// A ball that scatters light, in constant light of 1: with albedo 1 all light comes out again, so the ball is
/// invisible.
pub(super) fn media() -> Vec<Row> {
    let ball = |shape: &str| {
        format!(
            r#"<sensor type="perspective"><float name="fov" value="30"/><transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
            <film type="hdrfilm"><integer name="width" value="12"/><integer name="height" value="12"/><rfilter type="box"/></film></sensor>
            {shape}<bsdf type="null"/><medium name="interior" type="homogeneous"><rgb name="albedo" value="1"/><rgb name="sigma_t" value="1"/></medium></shape>
            <emitter type="constant"><rgb name="radiance" value="1"/></emitter>"#
        )
    };
    let row = |name, shape: &str| Row {
        name,
        body: ball(shape),
        truth: Truth::Exact(1.0),
        programs: vec![(VolPath, 0.0), (Light, 0.0), (Bdpt, 0.0), (Vcm, 0.0)],
    };
    let cube = r#"<shape type="cube">"#;
    let inward = r#"<shape type="cube"><transform name="to_world"><scale x="-1"/></transform>"#;
    let flipped = r#"<shape type="cube"><boolean name="flip_normals" value="true"/>"#;
    vec![
        row("medium in a cube", cube),
        row("medium in a mirrored cube", inward),
        row("medium in a cube that faces inward", flipped),
    ]
}

/// Two halves of a hall, separated by a wall without thickness. The hall is 2 high, and the wall is `wall` high; the
/// lamp is in the other half.
pub(super) fn hall(wall: f32) -> String {
    let white = r#"<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.7"/></bsdf></bsdf>"#;
    let side = |x: f32, y: f32, turn: &str, place: &str| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale x="{x}" y="{y}"/>{turn}<translate {place}/></transform>{white}</shape>"#
        )
    };
    let turn = |axis: &str, angle: i32| format!(r#"<rotate {axis}="1" angle="{angle}"/>"#);
    let half = 0.5 * wall;
    [
        r#"<sensor type="perspective"><float name="fov" value="70"/><transform name="to_world"><lookat origin="3.5,1.2,0" target="0,0.4,0" up="0,1,0"/></transform>
        <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/><rfilter type="box"/></film></sensor>"#.into(),
        side(4.0, 1.5, &turn("x", -90), r#"y="0""#),
        side(4.0, 1.5, &turn("x", 90), r#"y="2""#),
        side(4.0, 1.0, "", r#"y="1" z="-1.5""#),
        side(4.0, 1.0, &turn("y", 180), r#"y="1" z="1.5""#),
        side(1.5, 1.0, &turn("y", 90), r#"x="-4" y="1""#),
        side(1.5, 1.0, &turn("y", -90), r#"x="4" y="1""#),
        side(1.5, half, &turn("y", 90), &format!(r#"x="0" y="{half}""#)),
        r#"<shape type="rectangle"><transform name="to_world"><scale value="0.5"/><rotate x="1" angle="90"/><translate x="-2" y="1.95"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf><emitter type="area"><rgb name="radiance" value="30"/></emitter></shape>"#.into(),
    ]
    .concat()
}

/// Little light comes around the wall. Photons and records on the other side are near, but they receive different
/// light.
pub(super) fn slits() -> Vec<Row> {
    let programs = vec![
        (Light, 0.0),
        (Bdpt, 0.0),
        (Vcm, 0.01),
        (Irrcache, 0.06),
        (Radcache, 0.06),
        (Photonmap, 0.1),
        (Ppm, 0.1),
        (InstantRadiosity, 0.0),
        (Lightcuts, 0.02),
    ];
    vec![Row { name: "slit above a wall", body: hall(1.9), truth: Truth::Of(Path), programs }]
}

/// A house in the sun, and a small ball on wide ground: edges, and light that misses the visible part.
pub(super) fn outdoors() -> Vec<Row> {
    let sky = r#"<emitter type="constant"><rgb name="radiance" value="0.3"/></emitter>
        <emitter type="directional"><vector name="direction" x="0.4" y="-1" z="-0.3"/><rgb name="irradiance" value="2"/></emitter>"#;
    let scene = |ground: f32, things: &str| {
        format!(
            r#"<sensor type="perspective"><float name="fov" value="50"/><transform name="to_world"><lookat origin="2.5,1.5,3" target="0,0.4,0" up="0,1,0"/></transform>
            <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/><rfilter type="box"/></film></sensor>{sky}{}{things}"#,
            sheet(
                ground,
                0.0,
                true,
                "",
                r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.6"/></bsdf>"#
            )
        )
    };
    let thing = |kind: &str, scale: f32, y: f32| {
        format!(
            r#"<shape type="{kind}"><transform name="to_world"><scale value="{scale}"/><translate y="{y}"/></transform><bsdf type="diffuse"><rgb name="reflectance" value="0.6"/></bsdf></shape>"#
        )
    };
    let row = |name, body| Row { name, body, truth: Truth::Of(Path), programs: ALL.to_vec() };
    vec![
        row("a house in the sun", scene(8.0, &thing("cube", 0.7, 0.7))),
        // Of a hundred light paths from the sky, only one comes near the eye.
        but_light(row("a small ball on wide ground", scene(40.0, &thing("sphere", 0.4, 0.4)))),
    ]
}

/// A lamp in a glass bulb behind the eye. Paths from the eye rarely find it; programs that depend on such paths print a
/// warning.
pub(super) fn bulbs() -> Vec<Row> {
    let bulb = r#"<shape type="sphere"><float name="radius" value="0.3"/><point name="center" x="0" y="1.2" z="1.5"/><bsdf type="dielectric"/></shape>
        <shape type="sphere"><float name="radius" value="0.02"/><point name="center" x="0" y="1.2" z="1.5"/><bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="2000"/></emitter></shape>"#;
    let body = format!(
        r#"{}<shape type="cube"><boolean name="flip_normals" value="true"/><transform name="to_world"><scale value="2"/></transform>{GREY}</shape>{bulb}"#,
        camera("")
    );
    let programs = vec![(Bdpt, 0.0), (Vcm, 0.02), (Photonmap, 0.04), (Ppm, 0.04)];
    vec![Row { name: "lamp in a bulb", body, truth: Truth::Of(Light), programs }]
}
