//! Scenes where light goes through glass onto surfaces that are seen through glass. Path tracing fails there [slides 35
//! to 46].

use std::f32::consts::TAU;

use glam::{Quat, Vec3};

use crate::SceneFile;
use crate::mesh::Mesh;
use crate::xml::{self, Camera, bsdf, comment, default, diffuse, glass, mesh, sphere};

/// A lamp with a radius parameter. Path tracing finds only a large lamp.
fn lamp(center: Vec3, radiance: [f32; 3]) -> String {
    sphere(center, 0.0, "black", Some(radiance)).replace("value=\"0\"", "value=\"$lamp\"")
}

/// A matte ring in a block of glass.
pub(crate) fn torus_in_glass() -> SceneFile {
    let body = [
        default("lamp", 0.1),
        comment("Materials"),
        bsdf("wall", &diffuse([0.65, 0.65, 0.63])),
        bsdf("ring", &diffuse([0.75, 0.3, 0.12])),
        bsdf("glass", &glass()),
        bsdf("black", &diffuse([0.0; 3])),
        comment("The lamp; -D lamp=0.5 makes it one that path tracing finds"),
        lamp(Vec3::new(1.4, 3.4, 1.7), [900.0, 840.0, 750.0]),
        comment("The block, the ring in it, and the corner of a room"),
        mesh("torus-block", "glass", None),
        mesh("torus-ring", "ring", None),
        mesh("torus-room", "wall", None),
    ];
    let tilt = Quat::from_rotation_x(0.5) * Quat::from_rotation_z(0.35);
    let ring = Mesh::torus(0.52, 0.2, [64, 32]).turned(tilt).moved(Vec3::new(0.0, 0.85, 0.0));
    let block = Mesh::cuboid(Vec3::new(-0.85, 0.02, -0.85), Vec3::new(0.85, 1.68, 0.85));
    let block = block.turned(Quat::from_rotation_y(0.35));
    let camera = Camera {
        origin: Vec3::new(1.1, 2.3, 4.6),
        target: Vec3::new(-0.1, 0.75, 0.0),
        fov: 40.0,
        size: [512, 512],
    };
    let xml = xml::scene("A matte ring in a block of glass, lit by a small lamp.", &camera, &body);
    let meshes = vec![
        ("torus-block".into(), block),
        ("torus-ring".into(), ring),
        ("torus-room".into(), Mesh::corner(2.4)),
    ];
    SceneFile { name: "torus-in-glass", xml, meshes }
}

/// Height of the water surface over its mean in metres: waves of several lengths and directions.
fn wave(x: f32, z: f32) -> f32 {
    let waves = [(0.011, 1.9, 0.4, 0.3), (0.009, 3.1, 2.1, 1.7), (0.006, 5.3, 3.9, 4.2)];
    let height = |(amplitude, k, angle, phase): (f32, f32, f32, f32)| {
        amplitude * (k * TAU / 2.0 * (x * angle.cos() + z * angle.sin()) + phase).sin()
    };
    waves.into_iter().map(height).sum()
}

/// A basin of water under a small lamp.
pub(crate) fn pool() -> SceneFile {
    /// Half width of the basin, its depth, and half width of the deck.
    const HALF: f32 = 1.2;
    const DEPTH: f32 = 1.0;
    const DECK: f32 = 3.0;
    let water = "<bsdf type=\"dielectric\">\n    <float name=\"int_ior\" value=\"1.33\"/>\n    <float name=\"ext_ior\" value=\"1\"/>\n</bsdf>\n";
    let body = [
        default("lamp", 0.06),
        comment("Materials"),
        bsdf("tiles", &diffuse([0.55, 0.72, 0.75])),
        bsdf("deck", &diffuse([0.6, 0.5, 0.4])),
        bsdf("ball", &diffuse([0.75, 0.2, 0.15])),
        bsdf("water", water),
        bsdf("black", &diffuse([0.0; 3])),
        comment("The lamp; -D lamp=0.5 makes it one that path tracing finds"),
        lamp(Vec3::new(0.5, 3.2, -0.6), [3000.0, 2850.0, 2640.0]),
        comment("The basin with its water, and a ball at the bottom"),
        mesh("pool-basin", "tiles", None),
        mesh("pool-deck", "deck", None),
        mesh("pool-water", "water", None),
        sphere(Vec3::new(-0.35, 0.26 - DEPTH, -0.2), 0.25, "ball", None),
    ];
    let at = |x: f32, y: f32, z: f32| Vec3::new(x * HALF, y, z * HALF);
    let c = [(-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)];
    let rim = 0.06;
    let floor = Mesh::quad(c.map(|(x, z)| at(x, -DEPTH, z)));
    let basin = (0..4).fold(floor, |m, k| {
        let ((x0, z0), (x1, z1)) = (c[k], c[(k + 1) % 4]);
        let wall = [at(x0, -DEPTH, z0), at(x1, -DEPTH, z1), at(x1, rim, z1), at(x0, rim, z0)];
        m.with(&Mesh::quad(wall))
    });
    let deck = (0..4).fold(Mesh::default(), |m, k| {
        let ((x0, z0), (x1, z1)) = (c[k], c[(k + 1) % 4]);
        let outer = |x: f32, z: f32| Vec3::new(x * DECK, rim, z * DECK);
        m.with(&Mesh::quad([at(x0, rim, z0), at(x1, rim, z1), outer(x1, z1), outer(x0, z0)]))
    });
    let camera = Camera {
        origin: Vec3::new(0.4, 2.6, 3.6),
        target: Vec3::new(0.0, -0.45, 0.0),
        fov: 34.0,
        size: [512, 384],
    };
    let xml = xml::scene("A basin of water under a small lamp.", &camera, &body);
    let meshes = vec![
        ("pool-basin".into(), basin),
        ("pool-deck".into(), deck),
        ("pool-water".into(), Mesh::height_field(HALF, 48, wave)),
    ];
    SceneFile { name: "pool", xml, meshes }
}
