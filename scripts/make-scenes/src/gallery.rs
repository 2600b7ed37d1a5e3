//! The gallery: a hall under many lamps.

use glam::{Vec2, Vec3};

use crate::SceneFile;
use crate::mesh::Mesh;
use crate::xml::{
    self, Camera, bsdf, comment, default, diffuse, mesh, metal, point, rough_plastic, shape,
    sphere, two_sided,
};

/// Numbers of lights whose lamps are stored in the repository.
const GALLERY_LIGHTS: [u32; 4] = [4, 64, 1024, 16_384];
/// The hall's half width, height and half length.
const HALL: Vec3 = Vec3::new(4.0, 3.5, 8.0);

/// Positions of the plinths.
const STANDS: [Vec3; 4] = [
    Vec3::new(-1.6, 0.0, -2.0),
    Vec3::new(1.6, 0.0, -5.0),
    Vec3::new(-1.6, 0.0, -5.0),
    Vec3::new(1.6, 0.0, -2.0),
];

/// A hall under any number of lamps with the same total power: `-D lights=1024`.
pub(crate) fn gallery() -> SceneFile {
    let mut meshes = vec![
        ("gallery-floor".into(), floor()),
        ("gallery-walls".into(), walls()),
        ("gallery-plinths".into(), plinths()),
        ("gallery-vases".into(), vases()),
    ];
    meshes.extend(GALLERY_LIGHTS.map(gallery_lights));
    let camera = Camera {
        origin: Vec3::new(0.3, 1.7, 5.5),
        target: Vec3::new(0.0, 1.35, -3.0),
        fov: 60.0,
        size: [512, 384],
    };
    let xml = xml::scene(
        "A hall under many lamps; their number is a parameter (4, 64, 1024, 16384, or what make-scenes was asked for).",
        &camera,
        &body(),
    );
    SceneFile { name: "gallery", xml, meshes }
}

/// The scene file after the camera.
fn body() -> Vec<String> {
    vec![
        default("lights", GALLERY_LIGHTS[1]),
        comment("Materials"),
        bsdf("wall", &diffuse([0.72, 0.7, 0.66])),
        bsdf("floor", &two_sided(&rough_plastic([0.35, 0.2, 0.12], 0.2))),
        bsdf("plinth", &diffuse([0.5, 0.5, 0.5])),
        bsdf("bronze", &two_sided(&metal("Cu", 0.3))),
        bsdf("clay", &two_sided(&rough_plastic([0.6, 0.25, 0.15], 0.3))),
        bsdf("black", &diffuse([0.0; 3])),
        comment("The hall and its lamps"),
        mesh("gallery-walls", "wall", None),
        mesh("gallery-floor", "floor", None),
        mesh("gallery-lights-$lights", "black", Some([60.0, 54.0, 45.0])),
        comment("What is shown"),
        mesh("gallery-plinths", "plinth", None),
        mesh("gallery-vases", "clay", None),
        sphere(Vec3::new(-1.6, 1.4, -2.0), 0.4, "bronze", None),
        shape(
            "cylinder",
            &format!(
                "{}\n{}\n<float name=\"radius\" value=\"0.3\"/>\n",
                point("p0", Vec3::new(1.6, 1.0, -5.0)),
                point("p1", Vec3::new(1.6, 1.9, -5.0))
            ),
            "bronze",
            None,
        ),
    ]
}

/// The floor of the hall.
fn floor() -> Mesh {
    let h = HALL;
    Mesh::quad([
        Vec3::new(-h.x, 0.0, -h.z),
        Vec3::new(-h.x, 0.0, h.z),
        Vec3::new(h.x, 0.0, h.z),
        Vec3::new(h.x, 0.0, -h.z),
    ])
}

/// The walls and the ceiling of the hall.
fn walls() -> Mesh {
    let h = HALL;
    // The inside of a box, without the floor: its outside with normals flipped.
    let wall =
        |a: Vec3, b: Vec3| Mesh::quad([a, b, Vec3::new(b.x, h.y, b.z), Vec3::new(a.x, h.y, a.z)]);
    let c = [
        Vec3::new(-h.x, 0.0, h.z),
        Vec3::new(-h.x, 0.0, -h.z),
        Vec3::new(h.x, 0.0, -h.z),
        Vec3::new(h.x, 0.0, h.z),
    ];
    let ceiling = Mesh::quad([
        Vec3::new(-h.x, h.y, -h.z),
        Vec3::new(h.x, h.y, -h.z),
        Vec3::new(h.x, h.y, h.z),
        Vec3::new(-h.x, h.y, h.z),
    ]);
    (0..4).fold(ceiling, |m, k| m.with(&wall(c[k], c[(k + 1) % 4])))
}

/// One plinth at each of the positions.
fn plinths() -> Mesh {
    let half = Vec3::new(0.45, 0.0, 0.45);
    STANDS
        .iter()
        .fold(Mesh::default(), |m, p| m.with(&Mesh::cuboid(*p - half, *p + half + Vec3::Y)))
}

/// Two vases, on the third and the fourth plinth.
fn vases() -> Mesh {
    let vase = [[0.15, 0.0], [0.32, 0.2], [0.36, 0.4], [0.25, 0.65], [0.12, 0.8], [0.2, 0.95]]
        .map(Vec2::from_array);
    let vase = Mesh::lathe(&vase, 48);
    [STANDS[2], STANDS[3]]
        .iter()
        .fold(Mesh::default(), |m, p| m.with(&vase.clone().moved(*p + Vec3::Y)))
}

/// `n` square lamps spread evenly under the ceiling; their total area is always the same.
pub(crate) fn gallery_lights(n: u32) -> (String, Mesh) {
    /// Area of all lamps, square metres.
    const AREA: f32 = 1.0;
    let (wide, long) = (2.0 * HALL.x, 2.0 * HALL.z);
    let columns = ((n as f32 * wide / long).sqrt().round() as u32).max(1);
    let rows = n.div_ceil(columns);
    let half = 0.5 * (AREA / n as f32).sqrt();
    let mut mesh = Mesh::default();
    for k in 0..n {
        let (row, column) = (k / columns, k % columns);
        // The last row may have fewer lamps than the others: spread these.
        let in_row = columns.min(n - row * columns);
        let x = wide * ((column as f32 + 0.5) / in_row as f32 - 0.5);
        let z = long * ((row as f32 + 0.5) / rows as f32 - 0.5);
        let at = |dx: f32, dz: f32| Vec3::new(x + dx * half, HALL.y - 0.05, z + dz * half);
        mesh = mesh.with(&Mesh::quad([at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]));
    }
    (format!("gallery-lights-{n}"), mesh)
}
