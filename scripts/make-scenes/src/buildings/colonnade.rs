//! The colonnade: an atrium with galleries on two storeys.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::{Quat, Vec2, Vec3};

use super::{block, plate};
use crate::SceneFile;
use crate::mesh::Mesh;
use crate::xml::{
    self, Camera, bsdf, color, comment, default, diffuse, mesh, metal, rough_plastic, sun_and_sky,
    two_sided,
};

/// An atrium between two storeys of columns, with drapes, open to sun and sky.
pub(crate) fn colonnade() -> SceneFile {
    let camera = Camera {
        origin: Vec3::new(0.7, 2.1, 8.6),
        target: Vec3::new(-0.5, 2.5, 0.0),
        fov: 70.0,
        size: [640, 360],
    };
    let xml = xml::scene(
        "An atrium between two storeys of columns with drapes, open to sun and sky.",
        &camera,
        &body(),
    );
    SceneFile { name: "colonnade", xml, meshes: meshes() }
}

/// The scene file after the camera.
fn body() -> Vec<String> {
    vec![
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
    ]
}

/// All meshes, with the names of their files.
fn meshes() -> Vec<(String, Mesh)> {
    vec![
        ("colonnade-floor".into(), plate([-OUT, OUT], [-LONG, LONG], 0.0)),
        ("colonnade-walls".into(), walls()),
        ("colonnade-slabs".into(), slabs()),
        ("colonnade-columns".into(), storeys()),
        ("colonnade-bowl".into(), bowl()),
        ("colonnade-drapes-red".into(), drapes(0)),
        ("colonnade-drapes-green".into(), drapes(1)),
        ("colonnade-drapes-blue".into(), drapes(2)),
    ]
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

/// A bowl on a foot.
fn bowl() -> Mesh {
    let profile = [
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
    Mesh::lathe(&profile.map(Vec2::from_array), 64)
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

/// Every third drape, beginning with number `first`.
fn drapes(first: usize) -> Mesh {
    let places = (first..2 * BAYS).step_by(3);
    places.fold(Mesh::default(), |m, k| m.with(&drape(k)))
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
