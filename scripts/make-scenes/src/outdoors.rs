//! Scenes under the sky.

use glam::{Vec2, Vec3};

use crate::SceneFile;
use crate::mesh::Mesh;
use crate::xml::{
    self, Camera, bsdf, comment, default, diffuse, glass, mesh, metal, sphere, sun_and_sky,
    two_sided,
};

/// A paved court with columns and a slatted roof, under sun and sky.
pub(crate) fn patio() -> SceneFile {
    let floor = Mesh::quad(
        [[-200.0, -200.0], [-200.0, 200.0], [200.0, 200.0], [200.0, -200.0]]
            .map(|[x, z]| Vec3::new(x, 0.0, z)),
    );
    let slats = (0..14).fold(Mesh::default(), |m, k| {
        let z = 1.9 - 0.47 * k as f32;
        m.with(&Mesh::cuboid(Vec3::new(-2.7, 2.75, z - 0.06), Vec3::new(2.7, 2.95, z + 0.06)))
    });
    let wall = Mesh::cuboid(Vec3::new(-4.0, 0.0, -5.2), Vec3::new(4.0, 2.2, -4.9));
    let meshes = vec![
        ("patio-floor".into(), floor),
        ("patio-columns".into(), columns()),
        ("patio-slats".into(), slats),
        ("patio-wall".into(), wall),
    ];
    let camera = Camera {
        origin: Vec3::new(1.3, 1.6, 5.4),
        target: Vec3::new(-0.1, 1.05, -1.0),
        fov: 55.0,
        size: [512, 384],
    };
    let xml = xml::scene(
        "A paved court with columns and a slatted roof, under sun and sky.",
        &camera,
        &body(),
    );
    SceneFile { name: "patio", xml, meshes }
}

/// The scene file after the camera.
fn body() -> Vec<String> {
    vec![
        default("sun", 1),
        default("sky", 1),
        comment("Materials"),
        bsdf("stone", &diffuse([0.55, 0.5, 0.43])),
        bsdf("paving", &diffuse([0.4, 0.37, 0.34])),
        bsdf("wood", &diffuse([0.3, 0.17, 0.08])),
        bsdf("glass", &glass()),
        bsdf("gold", &two_sided(&metal("Au", 0.15))),
        comment("The court"),
        mesh("patio-floor", "paving", None),
        mesh("patio-columns", "stone", None),
        mesh("patio-wall", "stone", None),
        mesh("patio-slats", "wood", None),
        sphere(Vec3::new(-0.7, 0.45, 0.9), 0.45, "glass", None),
        sphere(Vec3::new(0.9, 0.35, 0.3), 0.35, "gold", None),
        comment("Sun and sky; Mitsuba's sky has its zenith along z"),
        sun_and_sky(Vec3::new(0.5, 0.35, 0.6)),
    ]
}

/// Four columns on either side.
fn columns() -> Mesh {
    let profile = [
        [0.3, 0.0],
        [0.3, 0.12],
        [0.22, 0.18],
        [0.2, 1.2],
        [0.17, 2.5],
        [0.26, 2.62],
        [0.26, 2.75],
    ]
    .map(Vec2::from_array);
    let column = Mesh::lathe(&profile, 48);
    let stands = (0..4).flat_map(|k| [-2.2, 2.2].map(|x| Vec3::new(x, 0.0, 1.5 - 1.8 * k as f32)));
    stands.fold(Mesh::default(), |m, p| m.with(&column.clone().moved(p)))
}
