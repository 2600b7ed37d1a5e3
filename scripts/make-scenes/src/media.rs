//! Scenes with light inside media: mist, a translucent solid, a glass of milk [slide 34].

use glam::{Quat, Vec2, Vec3};

use crate::SceneFile;
use crate::mesh::Mesh;
use crate::table::{lamp, smooth};
use crate::xml::{
    self, Camera, bsdf, color, comment, default, diffuse, glass, mesh, parting, sphere,
};

const SEGMENTS: u32 = 96;

/// A named medium; sigma_t is per world unit.
fn medium(id: &str, sigma_t: [f32; 3], albedo: [f32; 3], g: f32) -> String {
    let phase = if g == 0.0 {
        "<phase type=\"isotropic\"/>".to_string()
    } else {
        format!("<phase type=\"hg\">\n    <float name=\"g\" value=\"{g}\"/>\n</phase>")
    };
    let inner = format!("{}\n{}\n{phase}\n", color("sigma_t", sigma_t), color("albedo", albedo));
    let text =
        format!("<medium type=\"homogeneous\" id=\"{id}\">\n{}</medium>\n", xml::indent(&inner));
    xml::indent(&text)
}

fn dielectric(int: f32, ext: f32) -> String {
    format!(
        "<bsdf type=\"dielectric\">\n    <float name=\"int_ior\" value=\"{int}\"/>\n    \
         <float name=\"ext_ior\" value=\"{ext}\"/>\n</bsdf>\n"
    )
}

/// A shaded lamp shines on a glass ball in mist: the ball focuses the light, and the mist makes it visible.
pub(crate) fn fog() -> SceneFile {
    let at = Vec3::new(-1.25, 2.75, 0.35);
    let ball = Vec3::new(0.15, 1.15, 0.0);
    let body = [
        default("lamp", 0.07),
        comment("The mist"),
        medium("mist", [0.35; 3], [0.96, 0.97, 0.98], 0.3),
        comment("Materials"),
        bsdf("floor", &diffuse([0.3, 0.28, 0.26])),
        bsdf("shade", &diffuse([0.12, 0.12, 0.13])),
        bsdf("glass", &glass()),
        bsdf("edge", "<bsdf type=\"null\"/>\n"),
        bsdf("black", &diffuse([0.0; 3])),
        comment("The mist's edge; the ball, round which it is"),
        parting(&mesh("fog-edge", "edge", None), Some("mist"), None),
        parting(&sphere(ball, 0.42, "glass", None), None, Some("mist")),
        comment("The lamp in its shade; -D lamp=0.14 makes it one that path tracing finds"),
        sphere(at, 0.0, "black", Some([2600.0, 2500.0, 2250.0])).replace("value=\"0\"", "value=\"$lamp\""),
        mesh("fog-shade", "shade", None),
        "    <emitter type=\"constant\">\n        <rgb name=\"radiance\" value=\"0.03, 0.035, 0.045\"/>\n    </emitter>\n".into(),
        comment("Floor and wall"),
        mesh("fog-floor", "floor", None),
        mesh("fog-wall", "floor", None),
    ];
    // A tube around the lamp, open toward the ball.
    let shade = [[0.0, -0.2], [0.2, -0.2], [0.2, 0.42], [0.19, 0.42], [0.19, -0.19], [0.0, -0.19]];
    let turn = Quat::from_rotation_arc(Vec3::Y, (ball - at).normalize());
    let shade = Mesh::lathe(&shade.map(Vec2::from_array), SEGMENTS).turned(turn).moved(at);
    let quad = |c: [[f32; 3]; 4]| Mesh::quad(c.map(Vec3::from_array));
    let camera = Camera {
        origin: Vec3::new(0.2, 1.5, 6.2),
        target: Vec3::new(-0.05, 1.3, 0.0),
        fov: 36.0,
        size: [512, 512],
    };
    let meshes = vec![
        ("fog-edge".into(), Mesh::cuboid(Vec3::new(-1.9, -0.1, -1.4), Vec3::new(1.9, 3.2, 1.4))),
        ("fog-shade".into(), shade),
        (
            "fog-floor".into(),
            quad([[-5.0, 0.0, -2.0], [-5.0, 0.0, 8.0], [5.0, 0.0, 8.0], [5.0, 0.0, -2.0]]),
        ),
        (
            "fog-wall".into(),
            quad([[-5.0, 0.0, -2.0], [5.0, 0.0, -2.0], [5.0, 6.0, -2.0], [-5.0, 6.0, -2.0]]),
        ),
    ];
    let xml = xml::scene("A ball of glass in mist: a caustic in the air.", &camera, &body);
    SceneFile { name: "fog", xml, meshes }
}

/// The profile of a chessman, from the centre of its foot to the top of its head, as (radius, height).
const CHESSMAN: [[f32; 2]; 14] = [
    [0.48, 0.0],
    [0.5, 0.07],
    [0.45, 0.15],
    [0.34, 0.22],
    [0.25, 0.36],
    [0.2, 0.56],
    [0.18, 0.8],
    [0.3, 0.88],
    [0.2, 0.97],
    [0.26, 1.08],
    [0.3, 1.22],
    [0.26, 1.36],
    [0.15, 1.45],
    [0.0, 1.49],
];

/// A chessman and a ring of polished marble in front of a lamp.
pub(crate) fn marble() -> SceneFile {
    let body = [
        comment("Marble: most light that enters leaves again, some way off"),
        medium("marble", [11.0, 12.5, 14.0], [0.997, 0.994, 0.986], 0.0),
        comment("Materials"),
        bsdf("table", &diffuse([0.33, 0.27, 0.22])),
        bsdf("polish", &dielectric(1.5, 1.0)),
        bsdf("black", &diffuse([0.0; 3])),
        comment("The chessman and the ring"),
        parting(&mesh("marble-chessman", "polish", None), Some("marble"), None),
        parting(&mesh("marble-ring", "polish", None), Some("marble"), None),
        comment("The lamp behind, a dim sky, the table"),
        mesh("marble-lamp", "black", Some([11.0, 10.0, 8.8])),
        "    <emitter type=\"constant\">\n        <rgb name=\"radiance\" value=\"0.2, 0.22, 0.26\"/>\n    </emitter>\n".into(),
        mesh("marble-table", "table", None),
    ];
    let side = smooth(&CHESSMAN.map(Vec2::from_array));
    let profile: Vec<Vec2> = std::iter::once(Vec2::ZERO).chain(side).collect();
    let chessman = Mesh::lathe(&profile, SEGMENTS).moved(Vec3::new(-0.42, 0.002, 0.0));
    let turn = Quat::from_rotation_y(0.5) * Quat::from_rotation_x(1.25);
    let ring = Mesh::torus(0.42, 0.16, [96, 48]).turned(turn).moved(Vec3::new(0.62, 0.56, 0.05));
    let camera = Camera {
        origin: Vec3::new(0.35, 1.35, 3.9),
        target: Vec3::new(0.08, 0.66, 0.0),
        fov: 33.0,
        size: [512, 512],
    };
    let table = [[-4.0, -3.0], [-4.0, 5.0], [4.0, 5.0], [4.0, -3.0]];
    let meshes = vec![
        ("marble-chessman".into(), chessman),
        ("marble-ring".into(), ring),
        ("marble-lamp".into(), lamp(Vec3::new(0.5, 2.4, -2.4), Vec3::new(0.1, 0.6, 0.0), 1.0)),
        ("marble-table".into(), Mesh::quad(table.map(|[x, z]| Vec3::new(x, 0.0, z)))),
    ];
    let xml = xml::scene("Polished marble, lit from behind.", &camera, &body);
    SceneFile { name: "marble", xml, meshes }
}

/// A tumbler of milk on a table under a lamp.
pub(crate) fn milk() -> SceneFile {
    /// Outer radius, height, thickness of wall and bottom, and height of the milk.
    const R: f32 = 0.42;
    const H: f32 = 1.2;
    const WALL: f32 = 0.03;
    const BOTTOM: f32 = 0.09;
    const LEVEL: f32 = 0.86;
    let body = [
        comment("Milk, thinned with water"),
        medium("milk", [14.0, 16.0, 19.0], [0.9985, 0.998, 0.992], 0.0),
        comment("Materials; the milk's index is 1.35"),
        bsdf("table", &diffuse([0.45, 0.3, 0.2])),
        bsdf("wall", &diffuse([0.35, 0.42, 0.5])),
        bsdf("glass", &glass()),
        bsdf("glass-milk", &dielectric(1.5, 1.35)),
        bsdf("milk-air", &dielectric(1.35, 1.0)),
        bsdf("black", &diffuse([0.0; 3])),
        comment("The glass where air is round it, its inside where milk is, and the milk's surface"),
        mesh("milk-glass", "glass", None),
        parting(&mesh("milk-inside", "glass-milk", None), None, Some("milk")),
        parting(&mesh("milk-surface", "milk-air", None), Some("milk"), None),
        comment("The room and the lamp"),
        mesh("milk-table", "table", None),
        mesh("milk-wall", "wall", None),
        mesh("milk-lamp", "black", Some([20.0, 18.2, 16.0])),
        "    <emitter type=\"constant\">\n        <rgb name=\"radiance\" value=\"0.3, 0.32, 0.36\"/>\n    </emitter>\n".into(),
    ];
    let lift = 0.002;
    let at = |r: f32, y: f32| Vec2::new(r, y + lift);
    let inner = R - WALL;
    let dry = [at(0.0, 0.0), at(R, 0.0), at(R, H), at(inner, H), at(inner, LEVEL)];
    let wet = [at(inner, LEVEL), at(inner, BOTTOM), at(0.0, BOTTOM)];
    let top = [at(inner, LEVEL), at(0.0, LEVEL)];
    let quad = |c: [[f32; 3]; 4]| Mesh::quad(c.map(Vec3::from_array));
    let camera = Camera {
        origin: Vec3::new(0.9, 1.9, 3.6),
        target: Vec3::new(0.0, 0.55, 0.0),
        fov: 32.0,
        size: [512, 512],
    };
    let meshes = vec![
        ("milk-glass".into(), Mesh::lathe(&dry, SEGMENTS)),
        ("milk-inside".into(), Mesh::lathe(&wet, SEGMENTS)),
        ("milk-surface".into(), Mesh::lathe(&top, SEGMENTS)),
        (
            "milk-table".into(),
            quad([[-5.0, 0.0, -3.0], [-5.0, 0.0, 5.0], [5.0, 0.0, 5.0], [5.0, 0.0, -3.0]]),
        ),
        (
            "milk-wall".into(),
            quad([[-5.0, 0.0, -3.0], [5.0, 0.0, -3.0], [5.0, 5.0, -3.0], [-5.0, 5.0, -3.0]]),
        ),
        ("milk-lamp".into(), lamp(Vec3::new(-2.0, 2.6, 0.6), Vec3::new(0.0, 0.6, 0.0), 0.7)),
    ];
    let xml = xml::scene("A glass of milk.", &camera, &body);
    SceneFile { name: "milk", xml, meshes }
}
