//! A scene on a table that photon maps render well.

use glam::{Vec2, Vec3};

use crate::SceneFile;
use crate::mesh::Mesh;
use crate::xml::{self, Camera, bsdf, comment, default, diffuse, glass, mesh, parting};

/// Height of the cognac in the glass.
const LEVEL: f32 = 0.8;
/// Thickness of the bowl.
const WALL: f32 = 0.02;
const SEGMENTS: u32 = 192;

/// Outside of the bowl, from the stem to the rim, as (radius, height).
const BOWL: [[f32; 2]; 7] = [
    [0.04, 0.40],
    [0.18, 0.44],
    [0.36, 0.58],
    [0.45, 0.80],
    [0.42, 1.04],
    [0.33, 1.24],
    [0.27, 1.38],
];
/// The profile from the centre of the foot to the bowl.
const FOOT: [[f32; 2]; 7] = [
    [0.0, 0.0],
    [0.36, 0.0],
    [0.36, 0.015],
    [0.2, 0.045],
    [0.06, 0.1],
    [0.035, 0.22],
    [0.04, 0.40],
];

/// A snifter of cognac on a table under a small lamp [slide 32].
pub(crate) fn cognac() -> SceneFile {
    let foot = FOOT.map(Vec2::from_array);
    let outside = smooth(&BOWL.map(Vec2::from_array));
    let inside = moved_in(&outside);
    let (dry, wet) = cut(&inside);
    let rim = [outside[outside.len() - 1], inside[inside.len() - 1]];
    // The glass where it touches air: up the outside, over the rim, down the inside to the cognac.
    let round: Vec<Vec2> =
        outside.iter().chain(&rim[1..]).copied().chain(dry.iter().rev().skip(1).copied()).collect();
    let stem = smooth(&foot[2..]);
    let glass_mesh = Mesh::lathe(&foot[..3], SEGMENTS)
        .with(&Mesh::lathe(&stem, SEGMENTS))
        .with(&Mesh::lathe(&round, SEGMENTS));
    let down: Vec<Vec2> = wet.iter().rev().copied().collect();
    let top = [wet[wet.len() - 1], Vec2::new(0.0, LEVEL)];
    let table = Mesh::quad(
        [[-6.0, -4.0], [-6.0, 6.0], [6.0, 6.0], [6.0, -4.0]].map(|[x, z]| Vec3::new(x, 0.0, z)),
    );
    let wall = Mesh::quad(
        [[-6.0, 0.0], [6.0, 0.0], [6.0, 6.0], [-6.0, 6.0]].map(|[x, y]| Vec3::new(x, y, -4.0)),
    );
    let camera = Camera {
        origin: Vec3::new(0.9, 2.1, 3.9),
        target: Vec3::new(0.28, 0.52, 0.0),
        fov: 32.0,
        size: [512, 512],
    };
    let meshes = vec![
        ("cognac-glass".into(), glass_mesh),
        ("cognac-inside".into(), Mesh::lathe(&down, SEGMENTS)),
        ("cognac-surface".into(), Mesh::lathe(&top, SEGMENTS)),
        ("cognac-table".into(), table),
        ("cognac-wall".into(), wall),
        ("cognac-lamp".into(), lamp(Vec3::new(-2.4, 2.9, -0.9), Vec3::new(0.0, 0.7, 0.0), 0.12)),
    ];
    let xml = xml::scene("A snifter of cognac on a table: the caustic.", &camera, &body());
    SceneFile { name: "cognac", xml, meshes }
}

/// The scene file after the camera.
fn body() -> Vec<String> {
    // Either a tint at the boundary of the cognac, for programs that do not support media, or absorption along the way.
    let tint = "<rgb name=\"specular_transmittance\" value=\"$tint\"/>";
    let amber = "    <medium type=\"homogeneous\" id=\"amber\">\n        <rgb name=\"sigma_t\" value=\"$absorption\"/>\n        \
                 <rgb name=\"albedo\" value=\"0, 0, 0\"/>\n    </medium>\n";
    let between = |int: f32, ext: f32| {
        format!(
            "<bsdf type=\"dielectric\">\n    <float name=\"int_ior\" value=\"{int}\"/>\n    \
             <float name=\"ext_ior\" value=\"{ext}\"/>\n    {tint}\n</bsdf>\n"
        )
    };
    vec![
        // Two of these tints have the effect of this absorption over a length of 0.4.
        comment("The cognac's colour: a tint at its boundary, which all programs know, or with -D tint=1,1,1 -D absorption=0.36,2.08,6.37 by the length of the way"),
        default("tint", "0.93, 0.66, 0.28"),
        default("absorption", "0, 0, 0"),
        amber.into(),
        comment("Materials; the cognac's index is 1.36"),
        bsdf("table", &diffuse([0.62, 0.52, 0.42])),
        bsdf("wall", &diffuse([0.45, 0.47, 0.5])),
        bsdf("black", &diffuse([0.0; 3])),
        bsdf("glass", &glass()),
        bsdf("glass-cognac", &between(1.5, 1.36)),
        bsdf("cognac", &between(1.36, 1.0)),
        comment("The glass where air is round it, its inside where cognac is, and the cognac's surface"),
        mesh("cognac-glass", "glass", None),
        parting(&mesh("cognac-inside", "glass-cognac", None), None, Some("amber")),
        parting(&mesh("cognac-surface", "cognac", None), Some("amber"), None),
        comment("The room and the lamp"),
        mesh("cognac-table", "table", None),
        mesh("cognac-wall", "wall", None),
        mesh("cognac-lamp", "black", Some([640.0, 580.0, 490.0])),
        "    <emitter type=\"constant\">\n        <rgb name=\"radiance\" value=\"0.12, 0.13, 0.15\"/>\n    </emitter>\n".into(),
    ]
}

/// A square lamp with half side `half` at `p` that faces `target`.
pub(crate) fn lamp(p: Vec3, target: Vec3, half: f32) -> Mesh {
    let n = (target - p).normalize();
    let s = n.cross(Vec3::Y).normalize() * half;
    let t = s.cross(n);
    Mesh::quad([p - s - t, p + s - t, p + s + t, p - s + t]).facing(n)
}

/// A smooth curve through the points \[Catmull74\], with eight segments between two points.
pub(crate) fn smooth(points: &[Vec2]) -> Vec<Vec2> {
    const PIECES: usize = 8;
    let last = points.len() - 1;
    let mut out = Vec::new();
    for k in 0..last {
        let [a, b, c, d] = [k.max(1) - 1, k, k + 1, (k + 2).min(last)].map(|i| points[i]);
        for piece in 0..PIECES {
            let t = piece as f32 / PIECES as f32;
            let (t2, t3) = (t * t, t * t * t);
            out.push(
                0.5 * (2.0 * b
                    + (c - a) * t
                    + (2.0 * a - 5.0 * b + 4.0 * c - d) * t2
                    + (3.0 * b - a - 3.0 * c + d) * t3),
            );
        }
    }
    out.push(points[last]);
    out
}

/// The inside of the bowl: its outside offset inward by the thickness, closed at the axis.
fn moved_in(outside: &[Vec2]) -> Vec<Vec2> {
    let n = outside.len();
    let mut inside = vec![];
    for k in 0..n {
        let along = (outside[(k + 1).min(n - 1)] - outside[k.max(1) - 1]).normalize();
        let p = outside[k] + Vec2::new(-along.y, along.x) * WALL;
        if p.x > 0.06 {
            inside.push(p);
        }
    }
    let lowest = inside[0].y - 0.004;
    inside.insert(0, Vec2::new(0.0, lowest));
    inside
}

/// Split the inside at the level of the cognac, into the parts above and below, both from bottom to top.
fn cut(inside: &[Vec2]) -> (Vec<Vec2>, Vec<Vec2>) {
    let k = inside.iter().position(|p| p.y > LEVEL).unwrap_or(inside.len() - 1);
    let (a, b) = (inside[k - 1], inside[k]);
    let edge = a.lerp(b, (LEVEL - a.y) / (b.y - a.y));
    let dry = [&[edge], &inside[k..]].concat();
    let wet = [&inside[..k], &[edge]].concat();
    (dry, wet)
}
