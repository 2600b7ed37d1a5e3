//! Materials and textures.

use gi_core::material::{Distribution, Material, Roughness};
use gi_core::math::Rgb;
use gi_core::texture::Texture;
use glam::Vec2;

use super::*;

/// The number of a constant texture.
#[track_caller]
fn number(texture: &Texture) -> f32 {
    match texture {
        Texture::Constant(c) if c.r == c.g && c.g == c.b => c.r,
        other => panic!("{other:?}"),
    }
}

#[track_caller]
fn alphas(roughness: &Option<Roughness>) -> [f32; 2] {
    let r = roughness.as_ref().expect("a rough surface");
    assert_eq!(r.distribution, Distribution::Ggx);
    [number(&r.alpha_u), number(&r.alpha_v)]
}

#[test]
fn all_materials_are_read() {
    let loaded = scene("materials.pbrt");
    let is = |n: usize| inner(&loaded, n);
    let Material::Diffuse { reflectance } = is(0) else { panic!() };
    assert_eq!(reflectance.mean().to_array(), [0.6, 0.3, 0.1]);
    let Material::Plastic { eta, nonlinear, roughness, .. } = is(1) else { panic!() };
    assert_eq!((*eta, *nonlinear), (1.6, true));
    assert!((alphas(roughness)[0] - 0.2).abs() < 1e-6, "pbrt takes the square root");
    assert!(matches!(is(2), Material::Plastic { roughness: None, .. }));
    let Material::Conductor { eta, k, roughness, .. } = is(3) else { panic!() };
    assert!(eta.r < 0.3 && eta.b > 1.0 && k.r > 3.0, "gold: {eta:?} {k:?}");
    let [u, v] = alphas(roughness);
    assert!((u - 0.2).abs() < 1e-6 && (v - 0.4).abs() < 1e-6, "{u} {v}");
    let Material::Conductor { eta, k, roughness: None, .. } = is(4) else { panic!() };
    // The reflectance at normal incidence of eta = 1.
    let at_normal = k.map(|k| k * k / (4.0 + k * k));
    assert_eq!(*eta, Rgb::WHITE);
    assert!((at_normal.g - 0.5).abs() < 1e-5 && (at_normal.r - 0.9).abs() < 1e-5);
    let Material::Dielectric { eta, roughness: None, .. } = is(5) else { panic!() };
    assert!((eta - 1.5168).abs() < 1e-4);
    let Material::Dielectric { roughness, .. } = is(6) else { panic!() };
    assert_eq!(alphas(roughness), [0.3, 0.3], "not remapped");
    assert!(matches!(is(7), Material::ThinDielectric { eta: 1.7, .. }));
    let Material::PrincipledThin(sheet) = is(8) else { panic!() };
    assert_eq!([number(&sheet.diff_trans), sheet.base_color.mean().g], [1.0, 0.8]);
    let Material::Blend { weight, first, second } = is(9) else { panic!() };
    assert_eq!(number(weight), 0.25);
    let of = |side: usize| match &loaded.parts.materials[side] {
        Material::TwoSided { front, .. } => &loaded.parts.materials[*front],
        other => other,
    };
    assert!(matches!(of(*first), Material::Diffuse { .. }));
    assert!(matches!(of(*second), Material::Conductor { .. }));
    let Material::Conductor { eta, k, reflectance: Texture::Constant(r), roughness: Some(_) } =
        is(10)
    else {
        panic!()
    };
    // The coat reflects 0.04 of the light along the normal, and copper most of the rest.
    let own = ((eta.r - 1.0).powi(2) + k.r * k.r) / ((eta.r + 1.0).powi(2) + k.r * k.r);
    assert!((r.r * own - (0.04 + 0.96 * 0.96 * own)).abs() < 1e-5, "{r:?}");
    assert!(matches!(is(11), Material::Plastic { .. }));
}

#[test]
fn opaque_materials_have_two_sides() {
    let loaded =
        world("Material \"diffuse\" Shape \"sphere\" Material \"dielectric\" Shape \"sphere\"");
    let of = |n: usize| &loaded.parts.materials[loaded.parts.shapes[n].material];
    assert!(matches!(of(0), Material::TwoSided { .. }));
    assert!(matches!(of(1), Material::Dielectric { .. }));
}

#[test]
fn textures_are_read() {
    let loaded = scene("textures.pbrt");
    let reflectance = |n: usize| match inner(&loaded, n) {
        Material::Diffuse { reflectance } => reflectance,
        other => panic!("{other:?}"),
    };
    let near = |a: Rgb, b: [f32; 3]| {
        assert!(a.to_array().iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-5), "{a:?} {b:?}");
    };
    near(reflectance(0).mean(), [0.05, 0.1, 0.4]);
    near(reflectance(1).mean(), [0.46, 0.52, 0.88]);
    let board = reflectance(2);
    // Four squares across and two upward; the one at the origin has the first colour.
    for (uv, blue) in [([0.1, 0.1], 0.8), ([0.3, 0.1], 0.9), ([0.3, 0.6], 0.8), ([0.6, 0.1], 0.8)] {
        assert!((board.eval(Vec2::from(uv)).b - blue).abs() < 1e-6, "{uv:?}");
    }
    let Texture::Bitmap { bitmap, scale, to_uv } = reflectance(3) else { panic!() };
    near(*scale, [0.5; 3]);
    assert_eq!(to_uv.transform_point2(Vec2::new(0.25, 0.25)), Vec2::new(0.5, 0.5));
    assert_eq!(bitmap.width(), 4);
    // pbrt's v runs upward: the bottom left corner of a picture is at its origin.
    let plain = world_with_picture(
        "Texture \"p\" \"spectrum\" \"imagemap\" \"string filename\" \"picture.pfm\"",
    );
    near(plain.eval(Vec2::new(0.125, 0.125)), [0.0, 0.75, 0.5]);
    let inverted = world_with_picture(
        "Texture \"p\" \"spectrum\" \"imagemap\" \"string filename\" \"picture.pfm\" \"bool invert\" true",
    );
    near(inverted.eval(Vec2::new(0.125, 0.125)), [1.0, 0.25, 0.5]);
    let scaled_first = world_with_picture(
        "Texture \"p\" \"spectrum\" \"imagemap\" \"string filename\" \"picture.pfm\" \"bool invert\" true
         \"float scale\" 0.5",
    );
    near(scaled_first.eval(Vec2::new(0.125, 0.125)), [1.0, 0.625, 0.75]);
    let Material::NormalMap { inner: metal, .. } = inner(&loaded, 4) else { panic!() };
    let Material::Conductor { roughness: Some(r), .. } = &loaded.parts.materials[*metal] else {
        panic!()
    };
    let Texture::Bitmap { bitmap, .. } = &r.alpha_u else { panic!() };
    near(bitmap.texel(1, 3), [0.5, 0.75f32.sqrt(), 0.5f32.sqrt()]);
    assert!(matches!(inner(&loaded, 5), Material::Bump { .. }));
}

/// A texture of the picture, as a reflectance.
fn world_with_picture(texture: &str) -> Texture {
    let folder = common::Folder::new();
    folder.write("picture.pfm", std::fs::read(path("picture.pfm")).unwrap());
    let text = format!(
        "WorldBegin {texture} Material \"diffuse\" \"texture reflectance\" \"p\" Shape \"disk\""
    );
    let loaded = load(&folder.write("scene.pbrt", text), &Options::default()).unwrap();
    match inner(&loaded, 0) {
        Material::Diffuse { reflectance } => {
            let Texture::Bitmap { bitmap, .. } = reflectance else { panic!() };
            assert_eq!(bitmap.width(), 4);
            reflectance.clone()
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn alpha_becomes_a_mask() {
    let loaded = scene("alpha.pbrt");
    let of = |n: usize| &loaded.parts.materials[loaded.parts.shapes[n].material];
    let Material::Mask { opacity: Texture::Checkerboard { .. }, inner } = of(0) else { panic!() };
    assert!(matches!(loaded.parts.materials[*inner], Material::TwoSided { .. }));
    assert_eq!(
        loaded.parts.shapes[0].material, loaded.parts.shapes[1].material,
        "one mask for both"
    );
    let Material::Mask { opacity, .. } = of(2) else { panic!() };
    assert_eq!(number(opacity), 0.5);
    assert!(matches!(of(3), Material::TwoSided { .. }), "an alpha of one is no mask");
}

#[test]
fn the_old_format_is_read() {
    let loaded = scene("old.pbrt");
    assert_eq!(loaded.integrator_max_depth, Some(8));
    let gi_core::filter::Filter::Gaussian { stddev } = loaded.filter else { panic!() };
    assert!((stddev - 0.5).abs() < 1e-6);
    let is = |n: usize| inner(&loaded, n);
    let Material::RoughDiffuse { reflectance: Texture::Checkerboard { .. }, .. } = is(0) else {
        panic!("{:?}", is(0))
    };
    // `TransformBegin` keeps the transform only.
    assert!(matches!(is(1), Material::RoughDiffuse { .. }));
    assert_eq!(loaded.parts.shapes[1].geometry.bounds().center().x, 0.0);
    let Material::Plastic { diffuse, specular, roughness, .. } = is(2) else { panic!() };
    assert_eq!(diffuse.mean().to_array(), [0.1, 0.2, 0.3]);
    assert_eq!(number(specular), 0.2);
    // pbrt-v3's map from roughness to alpha: 1.62142 + 0.819955 x + 0.1734 x^2 + ..., x = ln 0.1.
    assert!((alphas(roughness)[0] - 0.461_76).abs() < 1e-4, "{:?}", alphas(roughness));
    let Material::Conductor { eta, .. } = is(3) else { panic!() };
    assert!(eta.b > 1.0, "gold, without the file: {eta:?}");
    let Material::Blend { weight, first, .. } = is(4) else { panic!() };
    assert_eq!(number(weight), 0.75);
    assert!(
        matches!(loaded.parts.materials[*first], Material::Dielectric { .. }),
        "the second one"
    );
    let outer = &loaded.parts.materials[loaded.parts.shapes[5].material];
    assert!(matches!(outer, Material::Mask { .. }));
    let gi_core::light::LightSource::Environment { scale, image, .. } = &loaded.parts.lights[1]
    else {
        panic!()
    };
    assert_eq!((*scale, image.width()), (2.0, 8), "latitude and longitude already");
}

#[test]
fn the_texture_uv_is_approximated_by_its_mean() {
    let loaded = world(
        "Texture \"t\" \"spectrum\" \"uv\"
Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\"",
    );
    let Material::Diffuse { reflectance } = inner(&loaded, 0) else { panic!() };
    assert_eq!(reflectance.mean(), Rgb::new(0.5, 0.5, 0.0));
    assert_eq!(warnings(&loaded), ["3: texture `uv` is approximated by its mean"]);
}

#[test]
fn uber_of_pbrt_v3_that_transmits_most_light_is_glass() {
    let loaded = world(
        "Material \"uber\" \"rgb Kd\" [0 0 0] \"rgb Ks\" [0 0 0] \"rgb Kr\" [1 1 1] \"rgb Kt\" [.9 .9 .9] \"float index\" 1.25
Shape \"sphere\"
Material \"uber\" \"rgb Kr\" [0 0 0] \"rgb Kt\" [0 0 0] \"rgb opacity\" [1 1 1] Shape \"sphere\"
Material \"uber\" \"rgb Kt\" [.1 .1 .1] Shape \"sphere\" WorldEnd",
    );
    let Material::Dielectric { eta, transmittance, .. } = inner(&loaded, 0) else { panic!() };
    assert_eq!((*eta, transmittance.mean()), (1.25, Rgb::grey(0.9)));
    assert!(matches!(inner(&loaded, 1), Material::Plastic { .. }));
    assert_eq!(
        warnings(&loaded),
        [
            "5: material `uber` is approximated by `roughplastic`",
            "6: material `uber` is approximated by `roughplastic`",
            "6: `Kt` is ignored: the surface is opaque",
        ]
    );
}

#[test]
fn a_gamma_encoding_of_a_picture_is_said_to_be_read_as_srgb() {
    let folder = common::Folder::new();
    folder.write("a.pfm", [b"PF\n1 1\n-1.0\n".as_slice(), &[0; 12]].concat());
    let text = "WorldBegin
Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.pfm\" \"string encoding\" \"gamma 2.2\"
Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\"";
    let loaded = load(&folder.write("scene.pbrt", text), &Options::default()).unwrap();
    assert!(warnings(&loaded).contains(&"2: encoding `gamma 2.2` is read as sRGB"));
}
