//! The materials that BSDFs are tested with.

use gi_core::material::{BentNormals, Distribution, Material, Roughness};
use gi_core::math::Rgb;
use gi_core::texture::Texture;

use crate::principled;

/// Name, table of materials (the last is the one to test), and whether its albedo must be one.
type Case = (&'static str, Vec<Material>, bool);

pub(super) fn rough(distribution: Distribution, u: f32, v: f32) -> Option<Roughness> {
    Some(Roughness { distribution, alpha_u: Texture::grey(u), alpha_v: Texture::grey(v) })
}

fn white() -> Texture {
    Texture::grey(1.0)
}

pub(super) fn metal(roughness: Option<Roughness>) -> Material {
    let (eta, k) = (Rgb::new(0.2, 0.9, 1.1), Rgb::new(3.9, 2.4, 2.2));
    Material::Conductor { eta, k, reflectance: white(), roughness }
}

pub(super) fn glass(roughness: Option<Roughness>) -> Material {
    Material::Dielectric { eta: 1.5, reflectance: white(), transmittance: white(), roughness }
}

fn plastic(nonlinear: bool, roughness: Option<Roughness>) -> Material {
    let diffuse = Texture::Constant(Rgb::new(0.7, 0.4, 0.1));
    Material::Plastic { eta: 1.49, diffuse, specular: white(), nonlinear, roughness }
}

fn diffuse() -> Material {
    Material::Diffuse { reflectance: Texture::grey(0.8) }
}

fn mask(inner: usize) -> Material {
    Material::Mask { opacity: Texture::grey(0.7), inner }
}

/// A blend of the first two materials of a table.
fn blend() -> Material {
    Material::Blend { weight: Texture::grey(0.4), first: 0, second: 1 }
}

/// All materials.
pub(super) fn materials() -> Vec<Case> {
    [plain(), bent(), blends(), principled::materials()].concat()
}

/// Materials without children, and a mask.
fn plain() -> Vec<Case> {
    use Distribution::{Beckmann, Ggx};
    let phong = |exponent| Material::Phong {
        diffuse: Texture::grey(0.3),
        specular: Texture::grey(0.5),
        exponent: Texture::grey(exponent),
    };
    vec![
        ("diffuse", vec![diffuse()], false),
        ("diffuse, two-sided", vec![diffuse(), Material::TwoSided { front: 0, back: 0 }], false),
        (
            "Oren-Nayar",
            vec![Material::RoughDiffuse {
                reflectance: Texture::grey(0.8),
                alpha: Texture::grey(0.4),
            }],
            false,
        ),
        ("conductor", vec![metal(None)], false),
        ("GGX conductor 0.1", vec![metal(rough(Ggx, 0.1, 0.1))], false),
        ("GGX conductor 0.5", vec![metal(rough(Ggx, 0.5, 0.5))], false),
        ("GGX conductor 0.4, 0.1", vec![metal(rough(Ggx, 0.4, 0.1))], false),
        ("Beckmann conductor 0.3", vec![metal(rough(Beckmann, 0.3, 0.3))], false),
        ("Beckmann conductor 0.15, 0.5", vec![metal(rough(Beckmann, 0.15, 0.5))], false),
        ("dielectric", vec![glass(None)], true),
        ("GGX dielectric 0.3", vec![glass(rough(Ggx, 0.3, 0.3))], false),
        ("Beckmann dielectric 0.2", vec![glass(rough(Beckmann, 0.2, 0.2))], false),
        (
            "pane",
            vec![Material::ThinDielectric {
                eta: 1.5,
                reflectance: white(),
                transmittance: white(),
            }],
            true,
        ),
        ("plastic", vec![plastic(false, None)], false),
        ("plastic, nonlinear", vec![plastic(true, None)], false),
        ("GGX plastic 0.2", vec![plastic(true, rough(Ggx, 0.2, 0.2))], false),
        ("Beckmann plastic 0.1", vec![plastic(false, rough(Beckmann, 0.1, 0.1))], false),
        ("phong 10", vec![phong(10.0)], false),
        ("phong 200", vec![phong(200.0)], false),
        ("null", vec![Material::Null], true),
        ("mask", vec![diffuse(), mask(0)], false),
    ]
}

/// Materials with a normal map.
fn bent() -> Vec<Case> {
    let bump = Material::NormalMap {
        map: Texture::Constant(Rgb::new(0.6, 0.45, 0.95)),
        inner: 0,
        normals: BentNormals::default(),
    };
    // From half of the directions above the floor, the back of such a normal is visible.
    let steep = |inner, flipped| Material::NormalMap {
        map: Texture::Constant(Rgb::new(0.95, 0.4, 0.6)),
        inner,
        normals: BentNormals { flipped, shadowed: true },
    };
    let metal_2 = metal(rough(Distribution::Ggx, 0.2, 0.2));
    vec![
        ("normal map", vec![diffuse(), bump], false),
        ("normal map, steep", vec![diffuse(), steep(0, true)], false),
        ("normal map, steep, not flipped", vec![diffuse(), steep(0, false)], false),
        (
            "normal map, steep, not flipped, two-sided",
            vec![diffuse(), steep(0, false), Material::TwoSided { front: 1, back: 1 }],
            false,
        ),
        ("normal map, steep, of metal", vec![metal_2.clone(), steep(0, true)], false),
        ("normal map, steep, of a mirror", vec![metal(None), steep(0, true)], false),
        (
            "normal map, steep, of a blend, two-sided",
            vec![
                plastic(true, rough(Distribution::Ggx, 0.3, 0.3)),
                metal_2.clone(),
                blend(),
                steep(2, true),
                Material::TwoSided { front: 3, back: 3 },
            ],
            false,
        ),
    ]
}

/// Blends of two materials.
fn blends() -> Vec<Case> {
    let metal_2 = metal(rough(Distribution::Ggx, 0.2, 0.2));
    vec![
        ("blend", vec![diffuse(), metal_2.clone(), blend()], false),
        (
            "masked blend, two-sided",
            vec![diffuse(), metal_2, blend(), mask(2), Material::TwoSided { front: 3, back: 3 }],
            false,
        ),
    ]
}
