//! The Cornell box from its published measurements (millimetres), and two relatives.

use glam::Vec3;

use crate::SceneFile;
use crate::mesh::Mesh;
use crate::xml::{
    self, Camera, bsdf, comment, diffuse, glass, mesh, metal, rough_plastic, sphere, two_sided,
};

const WHITE: [f32; 3] = [0.725, 0.71, 0.68];
const RED: [f32; 3] = [0.63, 0.065, 0.05];
const GREEN: [f32; 3] = [0.14, 0.45, 0.091];
/// Radiance of the lamp, as commonly derived from its measured spectrum.
const LAMP: [f32; 3] = [18.387, 10.9873, 2.75357];

fn camera() -> Camera {
    let origin = Vec3::new(278.0, 273.0, -800.0);
    Camera { origin, target: Vec3::new(278.0, 273.0, -799.0), fov: 39.3077, size: [512, 512] }
}

fn quad(c: [[f32; 3]; 4]) -> Mesh {
    Mesh::quad(c.map(Vec3::from_array))
}

/// The walls and the lamp, each with the name of its file.
fn room() -> Vec<(String, Mesh)> {
    let piece = |name: &str, mesh| (format!("cornell-{name}"), mesh);
    vec![
        piece(
            "floor",
            quad([[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]]),
        ),
        piece(
            "ceiling",
            quad([
                [556.0, 548.8, 0.0],
                [556.0, 548.8, 559.2],
                [0.0, 548.8, 559.2],
                [0.0, 548.8, 0.0],
            ]),
        ),
        piece(
            "back",
            quad([
                [549.6, 0.0, 559.2],
                [0.0, 0.0, 559.2],
                [0.0, 548.8, 559.2],
                [556.0, 548.8, 559.2],
            ]),
        ),
        piece(
            "green",
            quad([[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]]),
        ),
        piece(
            "red",
            quad([
                [552.8, 0.0, 0.0],
                [549.6, 0.0, 559.2],
                [556.0, 548.8, 559.2],
                [556.0, 548.8, 0.0],
            ]),
        ),
        piece(
            "lamp",
            quad([
                [343.0, 548.3, 227.0],
                [343.0, 548.3, 332.0],
                [213.0, 548.3, 332.0],
                [213.0, 548.3, 227.0],
            ]),
        ),
    ]
}

fn room_xml() -> Vec<String> {
    vec![
        comment("Materials"),
        bsdf("white", &diffuse(WHITE)),
        bsdf("red", &diffuse(RED)),
        bsdf("green", &diffuse(GREEN)),
        bsdf("black", &diffuse([0.0; 3])),
        comment("The room"),
        mesh("cornell-floor", "white", None),
        mesh("cornell-ceiling", "white", None),
        mesh("cornell-back", "white", None),
        mesh("cornell-green", "green", None),
        mesh("cornell-red", "red", None),
        mesh("cornell-lamp", "black", Some(LAMP)),
    ]
}

/// Five faces of a block that stands on the floor, from the corners of its top.
fn block(top: [[f32; 3]; 4]) -> Mesh {
    let top = top.map(Vec3::from_array);
    let ground = top.map(|p| Vec3::new(p.x, 0.0, p.z));
    (0..4).fold(Mesh::quad(top), |mesh, k| {
        let next = (k + 1) % 4;
        mesh.with(&Mesh::quad([top[k], ground[k], ground[next], top[next]]))
    })
}

fn blocks() -> [(String, Mesh); 2] {
    let short = block([
        [130.0, 165.0, 65.0],
        [82.0, 165.0, 225.0],
        [240.0, 165.0, 272.0],
        [290.0, 165.0, 114.0],
    ]);
    let tall = block([
        [423.0, 330.0, 247.0],
        [265.0, 330.0, 296.0],
        [314.0, 330.0, 456.0],
        [472.0, 330.0, 406.0],
    ]);
    [("cornell-short-block".to_string(), short), ("cornell-tall-block".to_string(), tall)]
}

/// The box itself.
pub(crate) fn cornell_box() -> SceneFile {
    let mut body = room_xml();
    body.extend([
        mesh("cornell-short-block", "white", None),
        mesh("cornell-tall-block", "white", None),
    ]);
    let xml = xml::scene("The Cornell box, from its published measurements.", &camera(), &body);
    SceneFile { name: "cornell-box", xml, meshes: [room(), blocks().to_vec()].concat() }
}

/// A mirror and a glass ball instead of the blocks [slides 3, 4, 22-31].
pub(crate) fn cornell_spheres() -> SceneFile {
    let mut body = room_xml();
    body.extend([
        comment("The balls"),
        bsdf("mirror", &metal("none", 0.0)),
        bsdf("glass", &glass()),
        sphere(Vec3::new(396.0, 90.0, 366.0), 90.0, "mirror", None),
        sphere(Vec3::new(166.0, 90.0, 190.0), 90.0, "glass", None),
    ]);
    let xml = xml::scene("A Cornell box with a mirror ball and a glass ball.", &camera(), &body);
    SceneFile { name: "cornell-spheres", xml, meshes: room() }
}

/// Rough metal and plastic in the box [slides 15-20].
pub(crate) fn cornell_glossy() -> SceneFile {
    let mut body: Vec<String> = room_xml()
        .iter()
        .map(|s| {
            s.replace(
                "cornell-floor.ply\"/>\n        <ref id=\"white\"",
                "cornell-floor.ply\"/>\n        <ref id=\"polished\"",
            )
        })
        .collect();
    let polished = bsdf("polished", &two_sided(&rough_plastic(WHITE, 0.2)));
    body.insert(1, polished);
    body.insert(2, bsdf("copper", &two_sided(&metal("Cu", 0.25))));
    body.insert(3, bsdf("silver", &two_sided(&metal("Ag", 0.1))));
    body.extend([
        mesh("cornell-tall-block", "copper", None),
        sphere(Vec3::new(166.0, 90.0, 190.0), 90.0, "silver", None),
    ]);
    let xml = xml::scene(
        "A Cornell box with a polished floor, rough copper and silver.",
        &camera(),
        &body,
    );
    SceneFile { name: "cornell-glossy", xml, meshes: [room(), blocks()[1..].to_vec()].concat() }
}
