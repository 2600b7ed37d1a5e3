//! The pavilion: a house with a pool in a garden.

use glam::{Vec2, Vec3};

use super::{block, plate};
use crate::SceneFile;
use crate::mesh::Mesh;
use crate::xml::{
    self, Camera, bsdf, comment, default, diffuse, mesh, metal, rough_plastic, sun_and_sky,
    two_sided,
};

/// Slabs, glass, a pool and a wall of onyx [slide 33, after Mies van der Rohe's houses].
pub(crate) fn pavilion() -> SceneFile {
    let camera = Camera {
        origin: Vec3::new(-7.4, 1.75, 8.6),
        target: Vec3::new(-0.6, 1.25, 0.0),
        fov: 58.0,
        size: [640, 360],
    };
    let xml = xml::scene(
        "A pavilion of slabs and glass with a pool and a wall of onyx, under sun and sky.",
        &camera,
        &body(),
    );
    SceneFile { name: "pavilion", xml, meshes: meshes() }
}

/// The scene file after the camera.
fn body() -> Vec<String> {
    let water = "<bsdf type=\"dielectric\">\n    <float name=\"int_ior\" value=\"1.33\"/>\n    <float name=\"ext_ior\" value=\"1\"/>\n</bsdf>\n";
    let pane = "<bsdf type=\"thindielectric\">\n    <float name=\"int_ior\" value=\"1.5\"/>\n    <float name=\"ext_ior\" value=\"1\"/>\n</bsdf>\n";
    vec![
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
    ]
}

/// All meshes, with the names of their files.
fn meshes() -> Vec<(String, Mesh)> {
    vec![
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
    ]
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
