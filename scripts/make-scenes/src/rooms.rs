//! Rooms with a lamp whose light is focused: scenes of caustics.

use glam::{Vec2, Vec3};

use crate::SceneFile;
use crate::mesh::Mesh;
use crate::xml::{
    self, Camera, bsdf, comment, diffuse, glass, mesh, metal, rough_plastic, sphere, two_sided,
};

/// A glowing ball in a glass shell: all light reaches the room through glass [slides 35, 38].
pub(crate) fn bulb() -> SceneFile {
    let center = Vec3::new(0.0, 1.0, 0.0);
    // Two spheres with glass between them: inside the inner sphere, the index is that of air.
    let shell = "<bsdf type=\"dielectric\">\n    <float name=\"int_ior\" value=\"1\"/>\n    <float name=\"ext_ior\" value=\"1.5\"/>\n</bsdf>\n";
    let body = [
        comment("Materials"),
        bsdf("wall", &diffuse([0.7, 0.7, 0.68])),
        bsdf("socket", &two_sided(&metal("Al", 0.2))),
        bsdf("glass", &glass()),
        bsdf("hollow", shell),
        bsdf("black", &diffuse([0.0; 3])),
        comment("The lamp"),
        sphere(center, 0.08, "black", Some([60.0, 48.0, 30.0])),
        sphere(center, 0.42, "hollow", None),
        sphere(center, 0.5, "glass", None),
        mesh("bulb-socket", "socket", None),
        comment("The room"),
        mesh("bulb-room", "wall", None),
    ];
    let socket =
        [[0.3, 0.0], [0.3, 0.06], [0.16, 0.12], [0.14, 0.45], [0.12, 0.502]].map(Vec2::from_array);
    let camera = Camera {
        origin: Vec3::new(2.6, 1.9, 3.4),
        target: Vec3::new(-0.1, 0.75, -0.2),
        fov: 42.0,
        size: [512, 512],
    };
    let xml =
        xml::scene("A glowing ball in a glass shell in the corner of a room.", &camera, &body);
    let meshes = vec![
        ("bulb-room".into(), Mesh::corner(2.0)),
        ("bulb-socket".into(), Mesh::lathe(&socket, 64)),
    ];
    SceneFile { name: "bulb", xml, meshes }
}

/// A wall lamp: a glowing ball in a glass bulb in a polished shade. All light that leaves it was reflected or
/// refracted, and so was most of what the eye sees of the shade [slides 43 to 46].
pub(crate) fn lamp() -> SceneFile {
    let center = Vec3::new(0.0, 1.35, 0.45);
    let body = [
        comment("Materials"),
        bsdf("wall", &diffuse([0.72, 0.69, 0.62])),
        bsdf("shade", &two_sided(&metal("Cu", 0.0))),
        bsdf("arm", &two_sided(&metal("Al", 0.2))),
        bsdf("glass", &glass()),
        bsdf("vase", &two_sided(&rough_plastic([0.12, 0.2, 0.4], 0.1))),
        bsdf("black", &diffuse([0.0; 3])),
        comment("The lamp: a glowing ball inside solid glass, in a shade open above and below"),
        sphere(center, 0.045, "black", Some([420.0, 350.0, 240.0])),
        sphere(center, 0.13, "glass", None),
        mesh("lamp-shade", "shade", None),
        mesh("lamp-arm", "arm", None),
        comment("The corner of a room, and a vase"),
        mesh("lamp-room", "wall", None),
        mesh("lamp-vase", "vase", None),
    ];
    let shade = [[0.34, -0.28], [0.2, 0.18], [0.19, 0.18], [0.33, -0.28], [0.34, -0.28]];
    let vase = [[0.12, 0.0], [0.24, 0.14], [0.27, 0.3], [0.2, 0.48], [0.09, 0.62], [0.14, 0.72]];
    let corner = Mesh::corner(2.0).moved(Vec3::new(0.9, 0.0, 2.0));
    let arm = Mesh::cuboid(Vec3::new(-0.02, 1.5, 0.0), Vec3::new(0.02, 1.53, 0.26));
    let camera = Camera {
        origin: Vec3::new(1.5, 1.5, 3.5),
        target: Vec3::new(0.05, 0.95, 0.3),
        fov: 40.0,
        size: [512, 512],
    };
    let xml = xml::scene("A wall lamp of glass and polished copper.", &camera, &body);
    let meshes = vec![
        ("lamp-shade".into(), Mesh::lathe(&shade.map(Vec2::from_array), 96).moved(center)),
        ("lamp-arm".into(), arm),
        ("lamp-room".into(), corner),
        (
            "lamp-vase".into(),
            Mesh::lathe(&vase.map(Vec2::from_array), 64).moved(Vec3::new(0.35, 0.0, 0.75)),
        ),
    ];
    SceneFile { name: "lamp", xml, meshes }
}

/// A metal ring on a table: the cardioid.
pub(crate) fn ring() -> SceneFile {
    let profile =
        [[0.96, 0.0], [1.0, 0.0], [1.0, 0.4], [0.96, 0.4], [0.96, 0.0]].map(Vec2::from_array);
    let table = Mesh::quad(
        [[-4.0, -4.0], [-4.0, 4.0], [4.0, 4.0], [4.0, -4.0]].map(|[x, z]| Vec3::new(x, 0.0, z)),
    );
    let lamp = Mesh::quad([
        Vec3::new(3.0, 2.6, 0.1),
        Vec3::new(2.8, 2.8, 0.1),
        Vec3::new(2.8, 2.8, -0.1),
        Vec3::new(3.0, 2.6, -0.1),
    ]);
    let body = [
        comment("Materials"),
        bsdf("table", &diffuse([0.6, 0.58, 0.55])),
        bsdf("gold", &metal("Au", 0.0)),
        bsdf("black", &diffuse([0.0; 3])),
        comment("The ring, the table, a small lamp, and a faint sky"),
        mesh("ring", "gold", None),
        mesh("ring-table", "table", None),
        mesh("ring-lamp", "black", Some([900.0, 820.0, 700.0])),
        "    <emitter type=\"constant\">\n        <rgb name=\"radiance\" value=\"0.02, 0.025, 0.03\"/>\n    </emitter>\n".into(),
    ];
    let camera = Camera {
        origin: Vec3::new(-1.2, 3.2, 2.6),
        target: Vec3::new(0.0, 0.05, 0.05),
        fov: 38.0,
        size: [512, 512],
    };
    let xml = xml::scene("A gold ring on a table: the cardioid caustic.", &camera, &body);
    let meshes = vec![
        ("ring".into(), Mesh::lathe(&profile, 256)),
        ("ring-table".into(), table),
        ("ring-lamp".into(), lamp),
    ];
    SceneFile { name: "ring", xml, meshes }
}
