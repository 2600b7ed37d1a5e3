//! Tests of the principled model: with each of its lobes, and against Mitsuba's values.

use gi_core::bsdf::Transport;
use gi_core::material::{Material, Principled, PrincipledThin};
use gi_core::math::Rgb;
use gi_core::texture::Texture;
use glam::Vec3;

use crate::bsdfs::floor;

/// A dull principled surface, modified by `change`.
pub(crate) fn principled(change: impl FnOnce(&mut Principled)) -> Material {
    let zero = || Texture::grey(0.0);
    let mut p = Principled {
        base_color: Texture::Constant(Rgb::new(0.6, 0.4, 0.2)),
        roughness: Texture::grey(0.5),
        anisotropic: zero(),
        metallic: zero(),
        spec_trans: zero(),
        eta: 1.5,
        spec_tint: zero(),
        sheen: zero(),
        sheen_tint: zero(),
        flatness: zero(),
        clearcoat: zero(),
        clearcoat_gloss: zero(),
    };
    change(&mut p);
    Material::Principled(Box::new(p))
}

/// A principled sheet, modified by `change`.
pub(crate) fn sheet(change: impl FnOnce(&mut PrincipledThin)) -> Material {
    let zero = || Texture::grey(0.0);
    let mut p = PrincipledThin {
        base_color: Texture::Constant(Rgb::new(0.6, 0.4, 0.2)),
        roughness: Texture::grey(0.5),
        anisotropic: zero(),
        spec_trans: zero(),
        diff_trans: zero(),
        eta: Texture::grey(1.5),
        spec_tint: zero(),
        sheen: zero(),
        sheen_tint: zero(),
        flatness: zero(),
    };
    change(&mut p);
    Material::PrincipledThin(Box::new(p))
}

/// The principled model with each of its lobes.
pub(crate) fn materials() -> Vec<(&'static str, Vec<Material>, bool)> {
    let grey = Texture::grey;
    vec![
        ("principled", vec![principled(|_| {})], false),
        ("principled, rough", vec![principled(|p| p.roughness = grey(1.0))], false),
        (
            "principled, flat with sheen",
            vec![principled(|p| {
                p.flatness = grey(0.7);
                (p.sheen, p.sheen_tint) = (grey(0.5), grey(0.5));
            })],
            false,
        ),
        (
            "principled metal, anisotropic",
            vec![principled(|p| (p.metallic, p.anisotropic) = (grey(1.0), grey(0.8)))],
            false,
        ),
        (
            "principled, tinted with clearcoat",
            vec![principled(|p| {
                (p.clearcoat, p.clearcoat_gloss) = (grey(1.0), grey(0.3));
                (p.spec_tint, p.metallic) = (grey(0.8), grey(0.3));
            })],
            false,
        ),
        (
            "principled glass",
            vec![principled(|p| (p.spec_trans, p.roughness) = (grey(1.0), grey(0.6)))],
            false,
        ),
        (
            "principled, some of all",
            vec![principled(|p| {
                (p.spec_trans, p.metallic, p.eta) = (grey(0.6), grey(0.2), 1.33);
                (p.anisotropic, p.clearcoat, p.sheen) = (grey(0.5), grey(0.5), grey(0.3));
                (p.spec_tint, p.flatness) = (grey(0.4), grey(0.3));
            })],
            false,
        ),
        (
            "principled, thinner than outside",
            vec![principled(|p| {
                (p.spec_trans, p.eta, p.clearcoat) = (grey(0.7), 0.8, grey(0.5));
                (p.spec_tint, p.metallic) = (grey(0.5), grey(0.2));
            })],
            false,
        ),
        ("principled sheet", vec![sheet(|p| p.diff_trans = grey(0.8))], false),
        (
            "principled sheet, some of all",
            vec![sheet(|p| {
                (p.spec_trans, p.diff_trans, p.eta) = (grey(0.6), grey(1.2), grey(1.33));
                (p.anisotropic, p.spec_tint, p.sheen) = (grey(0.5), grey(0.5), grey(0.4));
                (p.flatness, p.sheen_tint) = (grey(0.5), grey(0.5));
            })],
            false,
        ),
    ]
}

/// Pairs of directions: toward the eye, and toward the light.
const DIRECTIONS: [[[f32; 3]; 2]; 5] = [
    [[0.3, 0.2, 0.9], [-0.4, -0.1, 0.8]],
    [[0.8, 0.1, 0.4], [-0.6, 0.3, 0.5]],
    [[0.3, 0.2, 0.9], [-0.2, -0.3, -0.7]],
    [[0.5, -0.4, -0.6], [-0.3, 0.2, 0.8]],
    [[0.5, -0.4, -0.6], [-0.5, 0.3, -0.7]],
];
const BLACK: [f32; 3] = [0.0; 3];

/// Materials, and f times cosine for each of the pairs, from Mitsuba 3.9.1. It is long because it is a table.
fn mitsuba() -> Vec<(Material, [[f32; 3]; 5])> {
    let grey = Texture::grey;
    let specular = |s: f32| 2.0 / (1.0 - (0.08 * s).sqrt()) - 1.0;
    let one_sided = |a, b| [a, b, BLACK, BLACK, BLACK];
    vec![
        (principled(|_| {}), one_sided([0.21363, 0.15704, 0.10045], [0.12542, 0.087775, 0.05013])),
        (
            principled(|p| {
                (p.roughness, p.flatness) = (grey(1.0), grey(0.6));
                (p.sheen, p.sheen_tint) = (grey(0.8), grey(0.5));
            }),
            one_sided([0.14113, 0.09514, 0.049148], [0.14, 0.09629, 0.052582]),
        ),
        (
            principled(|p| {
                (p.metallic, p.anisotropic) = (grey(0.7), grey(0.8));
                (p.roughness, p.spec_tint) = (grey(0.6), grey(0.5));
            }),
            one_sided([0.28807, 0.19315, 0.098239], [0.04761, 0.031961, 0.016312]),
        ),
        (
            principled(|p| {
                (p.clearcoat, p.roughness, p.eta) = (grey(1.0), grey(0.7), specular(0.9));
            }),
            one_sided([0.22719, 0.1706, 0.11401], [0.13958, 0.10161, 0.063644]),
        ),
        (
            principled(|p| (p.spec_trans, p.eta, p.roughness) = (grey(0.8), 1.33, grey(0.7))),
            [
                [0.040724, 0.029406, 0.018088],
                [0.032165, 0.024571, 0.016978],
                [0.45582, 0.37217, 0.26317],
                BLACK,
                [0.030262, 0.030262, 0.030262],
            ],
        ),
        (
            principled(|p| {
                (p.spec_trans, p.eta, p.roughness) = (grey(0.6), 0.8, grey(0.7));
                (p.clearcoat, p.metallic) = (grey(0.5), grey(0.2));
            }),
            [
                [0.11422, 0.08288, 0.05154],
                [0.28307, 0.27093, 0.25878],
                [1.0966, 0.89538, 0.63313],
                [0.16812, 0.13727, 0.097066],
                [0.0033754, 0.0033754, 0.0033754],
            ],
        ),
        (
            sheet(|p| {
                (p.spec_trans, p.diff_trans, p.roughness) = (grey(0.6), grey(1.2), grey(0.7));
                (p.eta, p.anisotropic, p.spec_tint) = (grey(1.33), grey(0.5), grey(0.5));
                (p.sheen, p.flatness) = (grey(0.4), grey(0.5));
            }),
            [
                [0.027683, 0.019123, 0.010564],
                [0.023057, 0.01615, 0.0092428],
                [0.4851, 0.3234, 0.1617],
                [0.21633, 0.14422, 0.072111],
                [0.028324, 0.019964, 0.011604],
            ],
        ),
    ]
}

#[test]
fn principled_agrees_with_mitsubas() {
    for (k, (material, expected)) in mitsuba().into_iter().enumerate() {
        let (scene, surface) = floor(vec![material]);
        for ([wo, wi], want) in DIRECTIONS.into_iter().zip(expected) {
            let [wo, wi] = [wo, wi].map(|d| Vec3::from(d).normalize());
            let f_cos = scene.bsdf(&surface, wo, Transport::Radiance).f_cos(wo, wi).to_array();
            for (a, b) in f_cos.into_iter().zip(want) {
                // The numbers have five digits.
                assert!((a - b).abs() <= 1e-4 * b + 1e-6, "{k} {wo} {wi}: {f_cos:?}, {want:?}");
            }
        }
    }
}
