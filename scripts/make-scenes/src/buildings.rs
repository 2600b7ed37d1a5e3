//! Buildings under sun and sky: light comes in from outside and is scattered further.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::{Quat, Vec2, Vec3};

use crate::SceneFile;
use crate::mesh::Mesh;
use crate::xml::{
    self, Camera, bsdf, color, comment, default, diffuse, mesh, metal, rough_plastic, sun_and_sky,
    two_sided,
};

/// A cuboid on the ground: its centre, half width and half depth, and the heights of bottom and top.
fn block(x: f32, z: f32, half: [f32; 2], from: f32, to: f32) -> Mesh {
    Mesh::cuboid(Vec3::new(x - half[0], from, z - half[1]), Vec3::new(x + half[0], to, z + half[1]))
}

/// A horizontal rectangle that faces up.
fn plate(x: [f32; 2], z: [f32; 2], y: f32) -> Mesh {
    let corners = [[x[0], z[0]], [x[0], z[1]], [x[1], z[1]], [x[1], z[0]]];
    Mesh::quad(corners.map(|[x, z]| Vec3::new(x, y, z)))
}

/// Slabs, glass, a pool and a wall of onyx [slide 33, after Mies van der Rohe's houses].
pub(crate) fn pavilion() -> SceneFile {
    let water = "<bsdf type=\"dielectric\">\n    <float name=\"int_ior\" value=\"1.33\"/>\n    <float name=\"ext_ior\" value=\"1\"/>\n</bsdf>\n";
    let pane = "<bsdf type=\"thindielectric\">\n    <float name=\"int_ior\" value=\"1.5\"/>\n    <float name=\"ext_ior\" value=\"1\"/>\n</bsdf>\n";
    let body = [
        default("sun", 2),
        default("sky", 2),
        comment("Materials"),
        bsdf("ground", &diffuse([0.19, 0.24, 0.1])),
        bsdf("travertine", &diffuse([0.68, 0.6, 0.48])),
        bsdf("plaster", &diffuse([0.78, 0.77, 0.74])),
        bsdf("onyx", &two_sided(&rough_plastic([0.55, 0.26, 0.09], 0.1))),
        bsdf("marble", &two_sided(&rough_plastic([0.12, 0.27, 0.2], 0.1))),
        bsdf("chrome", &two_sided(&metal("Cr", 0.08))),
        bsdf("leather", &diffuse([0.75, 0.72, 0.66])),
        bsdf("pebbles", &diffuse([0.1, 0.12, 0.12])),
        bsdf("water", water),
        bsdf("pane", pane),
        comment("The house"),
        mesh("pavilion-ground", "ground", None),
        mesh("pavilion-hedge", "ground", None),
        mesh("pavilion-plinth", "travertine", None),
        mesh("pavilion-roof", "plaster", None),
        mesh("pavilion-columns", "chrome", None),
        mesh("pavilion-onyx", "onyx", None),
        mesh("pavilion-walls", "marble", None),
        mesh("pavilion-panes", "pane", None),
        mesh("pavilion-stools", "leather", None),
        comment("The pool"),
        mesh("pavilion-basin", "pebbles", None),
        mesh("pavilion-water", "water", None),
        comment("Sun and sky; Mitsuba's sky has its zenith along z"),
        sun_and_sky(Vec3::new(0.45, 0.5, 0.62)),
    ];
    let meshes = vec![
        ("pavilion-ground".into(), ground()),
        ("pavilion-hedge".into(), hedge()),
        ("pavilion-plinth".into(), plinth()),
        ("pavilion-roof".into(), block(0.0, 0.0, [6.0, 3.6], 3.1, 3.4)),
        ("pavilion-columns".into(), columns()),
        ("pavilion-onyx".into(), block(0.4, -0.4, [2.2, 0.09], 0.0, 3.1)),
        (
            "pavilion-walls".into(),
            block(-1.0, -3.2, [6.5, 0.1], 0.0, 3.1).with(&block(-5.6, -0.6, [0.1, 2.5], 0.0, 3.1)),
        ),
        (
            "pavilion-panes".into(),
            Mesh::quad(upright([-1.6, 2.4], [4.6, 2.4]))
                .with(&Mesh::quad(upright([4.6, 2.4], [4.6, -3.1]))),
        ),
        ("pavilion-stools".into(), stools()),
        ("pavilion-basin".into(), basin()),
        ("pavilion-water".into(), plate(POOL[0], POOL[1], -0.12)),
    ];
    let camera = Camera {
        origin: Vec3::new(-7.4, 1.75, 8.6),
        target: Vec3::new(-0.6, 1.25, 0.0),
        fov: 58.0,
        size: [640, 360],
    };
    let xml = xml::scene(
        "A pavilion of slabs and glass with a pool and a wall of onyx, under sun and sky.",
        &camera,
        &body,
    );
    SceneFile { name: "pavilion", xml, meshes }
}

/// Ranges of the pool along x and along z.
const POOL: [[f32; 2]; 2] = [[-7.0, -2.6], [2.8, 7.2]];
/// Ranges of the plinth along x and along z.
const PLINTH: [[f32; 2]; 2] = [[-9.0, 8.0], [-4.6, 8.0]];

/// The plinth's floor around the pool, and its sides.
fn plinth() -> Mesh {
    let ([x0, x1], [z0, z1]) = (PLINTH[0], PLINTH[1]);
    let [[px0, px1], [pz0, pz1]] = POOL;
    let floor = plate([x0, x1], [z0, pz0], 0.0)
        .with(&plate([x0, px0], [pz0, pz1], 0.0))
        .with(&plate([px1, x1], [pz0, pz1], 0.0))
        .with(&plate([x0, x1], [pz1, z1], 0.0));
    let corners = [[x0, z0], [x1, z0], [x1, z1], [x0, z1]];
    (0..4).fold(floor, |m, k| {
        let ([ax, az], [bx, bz]) = (corners[k], corners[(k + 1) % 4]);
        let side = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
        m.with(&Mesh::quad([
            side(ax, -1.2, az),
            side(bx, -1.2, bz),
            side(bx, 0.0, bz),
            side(ax, 0.0, az),
        ]))
    })
}

/// Half side of the garden.
const GARDEN: f32 = 26.0;

/// The lawn around the plinth.
fn ground() -> Mesh {
    plate([-GARDEN, GARDEN], [-GARDEN, GARDEN], -1.2)
}

/// A hedge around the garden, higher than the eye, so that the ground may end behind it.
fn hedge() -> Mesh {
    let side = |x: f32, z: f32, half: [f32; 2]| block(x, z, half, -1.2, 2.4);
    [-GARDEN, GARDEN].into_iter().fold(Mesh::default(), |m, at| {
        m.with(&side(at, 0.0, [0.4, GARDEN])).with(&side(0.0, at, [GARDEN, 0.4]))
    })
}

/// The pool's bottom and sides, seen from inside.
fn basin() -> Mesh {
    const DEPTH: f32 = -0.7;
    let [[x0, x1], [z0, z1]] = POOL;
    let corners = [[x0, z0], [x0, z1], [x1, z1], [x1, z0]];
    (0..4).fold(plate([x0, x1], [z0, z1], DEPTH), |m, k| {
        let ([ax, az], [bx, bz]) = (corners[k], corners[(k + 1) % 4]);
        let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
        m.with(&Mesh::quad([
            at(ax, 0.0, az),
            at(bx, 0.0, bz),
            at(bx, DEPTH, bz),
            at(ax, DEPTH, az),
        ]))
    })
}

/// Eight slender columns, in two rows.
fn columns() -> Mesh {
    let profile = [[0.09, 0.0], [0.07, 0.03], [0.07, 3.07], [0.09, 3.1]].map(Vec2::from_array);
    let column = Mesh::lathe(&profile, 32);
    let stands = (0..4).flat_map(|k| [-2.2, 2.2].map(|z| Vec3::new(-4.8 + 3.2 * k as f32, 0.0, z)));
    stands.fold(Mesh::default(), |m, p| m.with(&column.clone().moved(p)))
}

/// Stools in front of the onyx.
fn stools() -> Mesh {
    [-0.9, 0.3, 1.5]
        .into_iter()
        .fold(Mesh::default(), |m, x| m.with(&block(x, 1.1, [0.4, 0.35], 0.22, 0.42)))
}

/// A vertical pane between two points of the floor, up to the roof.
fn upright([ax, az]: [f32; 2], [bx, bz]: [f32; 2]) -> [Vec3; 4] {
    [[ax, 0.0, az], [bx, 0.0, bz], [bx, 3.1, bz], [ax, 3.1, az]].map(Vec3::from_array)
}

/// An atrium between two storeys of columns, with drapes, open to sun and sky.
pub(crate) fn colonnade() -> SceneFile {
    let body = [
        default("sun", 3),
        default("sky", 3),
        comment("Materials"),
        bsdf("stone", &diffuse([0.6, 0.54, 0.45])),
        bsdf("wall", &diffuse([0.55, 0.42, 0.33])),
        bsdf("floor", &two_sided(&rough_plastic([0.42, 0.38, 0.34], 0.2))),
        bsdf("red", &cloth([0.5, 0.05, 0.04])),
        bsdf("green", &cloth([0.06, 0.28, 0.07])),
        bsdf("blue", &cloth([0.04, 0.12, 0.42])),
        bsdf("bronze", &two_sided(&metal("Cu", 0.25))),
        comment("The building"),
        mesh("colonnade-floor", "floor", None),
        mesh("colonnade-walls", "wall", None),
        mesh("colonnade-slabs", "stone", None),
        mesh("colonnade-columns", "stone", None),
        mesh("colonnade-bowl", "bronze", None),
        comment("Drapes"),
        mesh("colonnade-drapes-red", "red", None),
        mesh("colonnade-drapes-green", "green", None),
        mesh("colonnade-drapes-blue", "blue", None),
        comment("Sun and sky; Mitsuba's sky has its zenith along z"),
        sun_and_sky(Vec3::new(0.42, 0.85, 0.2)),
    ];
    let drapes = |first: usize| {
        let places = (first..2 * BAYS).step_by(3);
        places.fold(Mesh::default(), |m, k| m.with(&drape(k)))
    };
    let bowl = [
        [0.35, 0.0],
        [0.3, 0.08],
        [0.12, 0.2],
        [0.12, 0.7],
        [0.55, 0.95],
        [0.62, 1.1],
        [0.56, 1.1],
        [0.5, 1.0],
        [0.0, 0.85],
    ];
    let meshes = vec![
        ("colonnade-floor".into(), plate([-OUT, OUT], [-LONG, LONG], 0.0)),
        ("colonnade-walls".into(), walls()),
        ("colonnade-slabs".into(), slabs()),
        ("colonnade-columns".into(), storeys()),
        ("colonnade-bowl".into(), Mesh::lathe(&bowl.map(Vec2::from_array), 64)),
        ("colonnade-drapes-red".into(), drapes(0)),
        ("colonnade-drapes-green".into(), drapes(1)),
        ("colonnade-drapes-blue".into(), drapes(2)),
    ];
    let camera = Camera {
        origin: Vec3::new(0.7, 2.1, 8.6),
        target: Vec3::new(-0.5, 2.5, 0.0),
        fov: 70.0,
        size: [640, 360],
    };
    let xml = xml::scene(
        "An atrium between two storeys of columns with drapes, open to sun and sky.",
        &camera,
        &body,
    );
    SceneFile { name: "colonnade", xml, meshes }
}

/// Half width of the atrium and of the building, and half length.
const IN: f32 = 2.6;
const OUT: f32 = 5.2;
const LONG: f32 = 9.6;
/// Height of a storey, and number of bays per side.
const STOREY: f32 = 3.6;
const BAYS: usize = 6;

/// Matte cloth on both sides.
fn cloth(rgb: [f32; 3]) -> String {
    two_sided(&format!("<bsdf type=\"diffuse\">\n    {}\n</bsdf>\n", color("reflectance", rgb)))
}

/// Positions of a side's columns along z.
fn bay(k: usize) -> f32 {
    2.0 * LONG * (k as f32 / BAYS as f32 - 0.5)
}

/// Walls behind the galleries, and at both ends.
fn walls() -> Mesh {
    let high = 2.0 * STOREY + 0.4;
    let sides = block(-OUT - 0.1, 0.0, [0.1, LONG], 0.0, high).with(&block(
        OUT + 0.1,
        0.0,
        [0.1, LONG],
        0.0,
        high,
    ));
    let ends = block(0.0, -LONG - 0.1, [OUT, 0.1], 0.0, high).with(&block(
        0.0,
        LONG + 0.1,
        [OUT, 0.1],
        0.0,
        high,
    ));
    sides.with(&ends)
}

/// Floors of the upper gallery, the roof over it, and a rail.
fn slabs() -> Mesh {
    let (middle, half) = (0.5 * (IN - 0.3 + OUT), [0.5 * (OUT - IN + 0.3), LONG]);
    [-1.0, 1.0].into_iter().fold(Mesh::default(), |m, side| {
        m.with(&block(side * middle, 0.0, half, STOREY - 0.3, STOREY))
            .with(&block(side * middle, 0.0, half, 2.0 * STOREY - 0.3, 2.0 * STOREY))
            .with(&block(side * (IN - 0.25), 0.0, [0.05, LONG], STOREY + 0.85, STOREY + 0.95))
    })
}

/// Two storeys of columns on both sides.
fn storeys() -> Mesh {
    let profile = [
        [0.32, 0.0],
        [0.32, 0.14],
        [0.24, 0.22],
        [0.22, 1.4],
        [0.19, 2.8],
        [0.3, 3.05],
        [0.34, 3.15],
        [0.34, 3.3],
    ];
    let column = Mesh::lathe(&profile.map(Vec2::from_array), 40);
    let all = (0..=BAYS).flat_map(|k| {
        [-IN, IN].into_iter().flat_map(move |x| [0.0, STOREY].map(|y| Vec3::new(x, y, bay(k))))
    });
    all.fold(Mesh::default(), |m, p| m.with(&column.clone().moved(p)))
}

/// A drape in bay `k % BAYS` of one side, hanging from the upper floor.
fn drape(k: usize) -> Mesh {
    const HALF: f32 = 1.2;
    let (side, bay_k) = (if k < BAYS { -1.0 } else { 1.0 }, k % BAYS);
    // Folds grow toward the hem.
    let fold = |x: f32, y: f32| {
        let phase = 1.3 * k as f32;
        0.09 * (0.6 + 0.4 * y / HALF) * (TAU * 2.6 * x / HALF + phase + 0.5 * y).sin()
    };
    let sheet = Mesh::height_field(HALF, 72, fold)
        .turned(Quat::from_rotation_x(FRAC_PI_2))
        .turned(Quat::from_rotation_y(FRAC_PI_2));
    let z = 0.5 * (bay(bay_k) + bay(bay_k + 1));
    sheet.moved(Vec3::new(side * IN, STOREY - 0.3 - HALF, z))
}
