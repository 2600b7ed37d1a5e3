//! The meaning of each plugin, and its defaults.

#[path = "../common/mod.rs"]
mod common;
mod lights;
mod media;
mod sensors;
mod shapes;
mod spectra;
mod textures;

use common::{material, of_only_shape, old_scene, scene};
use gi_core::camera::Projection;
use gi_core::filter::Filter;
use gi_core::geometry::Geometry;
use gi_core::light::{LightSource, Window};
use gi_core::material::{Distribution, Material};
use gi_core::math::Rgb;
use gi_core::medium::{Medium, MediumId, Phase};
use gi_core::texture::Texture;
use glam::{Vec2, Vec3};

fn constant(t: &Texture) -> Rgb {
    match t {
        Texture::Constant(c) => *c,
        other => panic!("{other:?}"),
    }
}

/// Index of bk7 in air, the default of dielectrics.
const GLASS: f32 = 1.5046 / 1.000_277;
/// Index of polypropylene in air, the default of plastics.
const PLASTIC: f32 = 1.49 / 1.000_277;

#[test]
fn a_shape_without_a_bsdf_is_grey_and_a_light_without_one_black() {
    let loaded = scene("<shape type='sphere'/><shape type='sphere'><emitter type='area'/></shape>");
    let albedo = |i: usize| match &loaded.parts.materials[loaded.parts.shapes[i].material] {
        Material::Diffuse { reflectance } => constant(reflectance),
        other => panic!("{other:?}"),
    };
    assert_eq!([albedo(0), albedo(1)], [Rgb::grey(0.5), Rgb::BLACK]);
    assert_eq!(constant(loaded.parts.shapes[1].emission.as_ref().unwrap()), Rgb::WHITE);
}

#[test]
fn dielectrics_are_bk7_in_air_by_default() {
    let eta = |inner: &str| match material(&format!("<bsdf type='dielectric'>{inner}</bsdf>")) {
        Material::Dielectric { eta, roughness: None, .. } => eta,
        other => panic!("{other:?}"),
    };
    assert!((eta("") - GLASS).abs() < 1e-6);
    assert_eq!(eta("<float name='int_ior' value='1.5'/><float name='extIOR' value='1'/>"), 1.5);
    let named = "<string name='int_ior' value='water'/><string name='ext_ior' value='vacuum'/>";
    assert_eq!(eta(named), 1.333);
    let Material::ThinDielectric { eta, .. } = material("<bsdf type='thindielectric'/>") else {
        panic!()
    };
    assert!((eta - GLASS).abs() < 1e-6);
    let Material::Dielectric { roughness: Some(r), .. } =
        material("<bsdf type='roughdielectric'/>")
    else {
        panic!()
    };
    assert_eq!((r.distribution, constant(&r.alpha_u)), (Distribution::Beckmann, Rgb::grey(0.1)));
}

#[test]
fn a_conductor_without_a_material_is_a_mirror_or_copper_in_the_old_format() {
    let body = "<shape type='sphere'><bsdf type='conductor'/></shape>";
    let Material::Conductor { eta, k, .. } = of_only_shape(&scene(body)) else { panic!() };
    assert_eq!((eta, k), (Rgb::BLACK, Rgb::WHITE));
    let Material::Conductor { eta, .. } = of_only_shape(&old_scene(body)) else { panic!() };
    assert_eq!(eta, Rgb::new(0.20101, 0.92375, 1.1022));
    let gold = "<bsdf type='roughconductor'><string name='material' value='Au'/>
        <float name='ext_eta' value='2'/><float name='alpha_v' value='0.3'/></bsdf>";
    let Material::Conductor { eta, roughness: Some(r), .. } = material(gold) else { panic!() };
    assert_eq!(eta, Rgb::new(0.14304, 0.37531, 1.442) / 2.0);
    assert_eq!([constant(&r.alpha_u), constant(&r.alpha_v)], [Rgb::grey(0.1), Rgb::grey(0.3)]);
}

#[test]
fn plastics_are_polypropylene_and_linear_by_default() {
    let Material::Plastic { eta, diffuse, specular, nonlinear, roughness: None } =
        material("<bsdf type='plastic'/>")
    else {
        panic!()
    };
    assert!((eta - PLASTIC).abs() < 1e-6 && !nonlinear);
    assert_eq!([constant(&diffuse), constant(&specular)], [Rgb::grey(0.5), Rgb::WHITE]);
    let ggx = "<bsdf type='roughplastic'><string name='distribution' value='ggx'/>
        <boolean name='nonlinear' value='true'/><float name='alpha' value='0.3'/></bsdf>";
    let Material::Plastic { nonlinear: true, roughness: Some(r), .. } = material(ggx) else {
        panic!()
    };
    assert_eq!((r.distribution, constant(&r.alpha_v)), (Distribution::Ggx, Rgb::grey(0.3)));
}

#[test]
fn wrappers_hold_their_children() {
    let loaded = scene(
        "<bsdf type='twosided' id='both'><bsdf type='diffuse'/></bsdf>
         <bsdf type='twosided' id='two'><bsdf type='diffuse'/><bsdf type='plastic'/></bsdf>
         <bsdf type='mask' id='mask'><ref id='both'/></bsdf>
         <bsdf type='blendbsdf' id='blend'><ref id='both'/><ref id='two'/></bsdf>
         <shape type='cube'><ref id='mask'/></shape><shape type='cube'><ref id='blend'/></shape>
         <shape type='cube'><ref id='two'/></shape>",
    );
    let of = |i: usize| loaded.parts.materials[loaded.parts.shapes[i].material].clone();
    let Material::Mask { opacity, inner } = of(0) else { panic!() };
    assert_eq!(constant(&opacity), Rgb::grey(0.5));
    let Material::TwoSided { front, back } = loaded.parts.materials[inner] else { panic!() };
    assert_eq!(front, back);
    let Material::Blend { first, second, .. } = of(1) else { panic!() };
    assert_eq!(first, inner, "a named material is made once");
    let Material::TwoSided { front, back } = of(2) else { panic!() };
    assert_ne!(front, back);
    for (i, material) in loaded.parts.materials.iter().enumerate() {
        if let Material::Blend { first, second, .. } = material {
            assert!(*first < i && *second < i, "children come before their parents");
        }
    }
    assert!(matches!(loaded.parts.materials[second], Material::TwoSided { .. }));
}

#[test]
fn a_coat_over_a_diffuse_base_is_plastic_without_light_between_the_two() {
    let coat = |inner: &str| {
        format!(
            "<bsdf type='coating'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/>{inner}</bsdf>"
        )
    };
    let base = "<bsdf type='diffuse'><rgb name='reflectance' value='0.8'/></bsdf>";
    let Material::Plastic { eta, diffuse, nonlinear: false, roughness: None, .. } =
        material(&coat(base))
    else {
        panic!()
    };
    // `plastic` divides its base by 1 - 0.5963, the part that the coat lets out \[Egan73\].
    let albedo = constant(&diffuse).r / (1.0 - 0.5963);
    assert!(eta == 1.5 && (albedo - 0.8).abs() < 1e-3, "{albedo}");
    let tinted =
        format!("{base}<rgb name='sigma_a' value='0 1 1'/><float name='thickness' value='0.5'/>");
    let Material::Plastic { diffuse: tinted, .. } = material(&coat(&tinted)) else { panic!() };
    let ratio = constant(&tinted).g / constant(&diffuse).g;
    // Along the normal, exp(-1) passes; slanted light is absorbed more.
    assert!((0.8 * (-1.0f32).exp()..(-1.0f32).exp()).contains(&ratio), "{ratio}");
    let ball = format!("<shape type='cube'>{}</shape>", coat("<bsdf type='phong'/>"));
    let shown = common::Folder::new().problems(&ball);
    assert!(shown.contains("`coating` around `phong` is not supported"), "{shown}");
    assert!(shown.contains("clearcoat"), "{shown}");
}

#[test]
fn a_coated_conductor_is_as_bright_as_with_its_coat_along_the_normal() {
    let coated = |inner: &str| {
        let Material::Conductor { reflectance, roughness: Some(_), .. } = material(&format!(
            "<bsdf type='coating'><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/>{inner}
             <bsdf type='roughconductor'><string name='material' value='none'/></bsdf></bsdf>"
        )) else {
            panic!()
        };
        constant(&reflectance)
    };
    // The coat reflects 0.04. A mirror below it reflects the rest, without light that goes back and forth.
    assert!((coated("").r - (0.04 + 0.96 * 0.96)).abs() < 1e-6);
    let tinted = coated("<rgb name='sigma_a' value='0 100 0'/>");
    assert!((tinted.g - 0.04).abs() < 1e-6 && tinted.r > 0.9, "{tinted:?}");
    let bare = coated("<float name='specular_reflectance' value='0'/>");
    assert!((bare.r - 0.96 * 0.96).abs() < 1e-6, "{bare:?}");
}

#[test]
fn plugins_that_are_not_supported_are_refused_with_a_reason_and_advice() {
    let shown = common::Folder::new().problems(
        "<shape type='linearcurve'/><emitter type='directionalarea'/><shape type='cube'><bsdf type='irawan'/></shape>",
    );
    for text in [
        "shape `linearcurve` is not supported",
        "thin tubes",
        "emitter `directionalarea` is not supported",
        "woven cloth",
        "`principled` with sheen",
    ] {
        assert!(shown.contains(text), "{text}: {shown}");
    }
}

#[test]
fn a_grid_texture_has_the_defaults_of_mitsuba_0_6() {
    let grid = "<bsdf type='diffuse'><texture type='gridtexture' name='reflectance'>
        <float name='uscale' value='4'/><float name='line_width' value='0.05'/></texture></bsdf>";
    let Material::Diffuse { reflectance } = material(grid) else { panic!() };
    let at = |x: f32, y: f32| reflectance.eval(Vec2::new(x, y)).r;
    assert_eq!([at(0.251, 0.5), at(0.1, 0.97), at(0.1, 0.5)], [0.4, 0.4, 0.2]);
}

#[test]
fn twosided_around_a_mask_swaps_places_with_it() {
    let inside = "<bsdf type='twosided'><bsdf type='mask'><bsdf type='diffuse'/></bsdf></bsdf>";
    assert!(matches!(material(inside), Material::Mask { .. }));
    let glass = "<bsdf type='twosided'><bsdf type='dielectric'/></bsdf>";
    assert!(matches!(material(glass), Material::Dielectric { .. }));
}

#[test]
fn a_mixture_becomes_nested_blends_with_the_same_weights() {
    let loaded = scene(
        "<shape type='cube'><bsdf type='mixturebsdf'><string name='weights' value='0.2, 0.3, 0.1'/>
         <bsdf type='diffuse'><rgb name='reflectance' value='1 0 0'/></bsdf>
         <bsdf type='diffuse'><rgb name='reflectance' value='0 1 0'/></bsdf>
         <bsdf type='diffuse'><rgb name='reflectance' value='0 0 1'/></bsdf></bsdf></shape>",
    );
    fn albedo(materials: &[Material], i: usize) -> Rgb {
        match &materials[i] {
            Material::Diffuse { reflectance } => constant(reflectance),
            Material::Blend { weight, first, second } => {
                albedo(materials, *first).lerp(albedo(materials, *second), constant(weight).r)
            }
            other => panic!("{other:?}"),
        }
    }
    let got = albedo(&loaded.parts.materials, loaded.parts.shapes[0].material).to_array();
    for (g, want) in got.into_iter().zip([0.2, 0.3, 0.1]) {
        assert!((g - want).abs() < 1e-6, "{got:?}");
    }
    assert!(loaded.warnings.iter().any(|w| w.contains("absorbed")), "{:?}", loaded.warnings);
}

#[test]
fn the_hash_of_the_world_ignores_the_camera() {
    let world = |camera: &str, radius: f32, preset: &str| {
        let text = format!(
            "<scene version=\"3.0.0\">{preset}<integrator type=\"path\"/><sensor type=\"perspective\">{camera}</sensor>\
             <shape type=\"sphere\"><float name=\"radius\" value=\"{radius}\"/></shape></scene>"
        );
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("scene.xml");
        std::fs::write(&path, text).expect("written");
        let loaded = gi_scene::load(&path, &gi_scene::Options::default());
        let loaded = loaded.unwrap_or_else(|problems| panic!("{problems}"));
        (loaded.world, loaded.hash)
    };
    let (first, hash) = world("", 1.0, "");
    let wider = "<float name=\"fov\" value=\"70\"/><film type=\"hdrfilm\"/>";
    let preset = "<default name=\"gi.irrcache.rays\" value=\"20\"/>";
    for (same, other_hash) in [world(wider, 1.0, ""), world("", 1.0, preset)] {
        assert_eq!(same, first);
        assert_ne!(other_hash, hash);
    }
    assert_ne!(world("", 1.5, "").0, first);
}

#[test]
fn principled_has_the_parameters_of_mitsuba() {
    let of = |kind: &str, inner: &str| material(&format!("<bsdf type='{kind}'>{inner}</bsdf>"));
    let Material::Principled(p) = of("principled", "") else { panic!() };
    assert!((p.eta - 1.5).abs() < 1e-6, "specular 0.5 is an index of 1.5: {}", p.eta);
    assert_eq!([constant(&p.base_color), constant(&p.roughness)], [Rgb::grey(0.5); 2]);
    assert!(p.spec_trans.is_black() && p.clearcoat.is_black());
    let float = |name: &str, v: &str| format!("<float name='{name}' value='{v}'/>");
    let clear = float("spec_trans", "1") + &float("eta", "1");
    let Material::Principled(p) = of("principled", &clear) else { panic!() };
    assert_eq!(p.eta, 1.001, "as in Mitsuba");
    let Material::PrincipledThin(p) = of("principledthin", &float("diff_trans", "1.5")) else {
        panic!()
    };
    assert_eq!([constant(&p.diff_trans), constant(&p.eta)], [Rgb::grey(1.5); 2]);
    let both = scene(&format!(
        "<shape type='cube'><bsdf type='principled'>{}{}</bsdf></shape>",
        float("eta", "1.3"),
        float("specular", "0.2")
    ));
    assert!(both.warnings[0].contains("`specular` is ignored"), "{:?}", both.warnings);
    let odd = of("twosided", "<bsdf type='principled'><float name='metallic' value='1'/></bsdf>");
    assert!(matches!(odd, Material::TwoSided { .. }));
}

#[test]
fn ignored_parameters_that_change_the_picture_give_a_warning() {
    let named = |body: &str, name: &str| {
        let shown = old_scene(body).warnings.join("\n");
        assert!(shown.contains(name), "{name}: {shown}");
    };
    named("<shape type='cube'><subsurface type='dipole'/></shape>", "its subsurface");
    named("<shape type='cube'><bsdf type='roughdiffuse'/></shape>", "qualitative");
    let film = |inner: &str| {
        format!(
            "<sensor type='perspective'><film type='hdrfilm'>{inner}</film></sensor><shape type='cube'/>"
        )
    };
    named(&film("<string name='pixelFormat' value='luminance'/>"), "`pixel_format`");
    let far = "<sensor type='perspective'><float name='farClip' value='1'/>
        <transform name='toWorld'><translate z='-5'/></transform></sensor><shape type='cube'/>";
    named(far, "`far_clip`");
    let lens = "<sensor type='thinlens'><float name='aperture_radius' value='1'/><integer name='blades' value='5'/></sensor>
        <shape type='cube'/>";
    named(lens, "`blades`");
}

#[test]
fn filters_of_polarised_light_transmit_what_they_do_of_unpolarised_light() {
    let transmitted = |bsdf: &str| match material(bsdf) {
        Material::ThinDielectric { eta: 1.0, transmittance, .. } => constant(&transmittance).g,
        other => panic!("{other:?}"),
    };
    let half = "<bsdf type='polarizer'><spectrum name='theta' value='30'/></bsdf>";
    let dark = "<bsdf type='circular'><rgb name='transmittance' value='0.5'/></bsdf>";
    let retarder = "<bsdf type='retarder'><float name='delta' value='90'/></bsdf>";
    assert_eq!([half, dark, retarder].map(transmitted), [0.5, 0.25, 1.0]);
}
