//! Colours and spectra.

use super::*;

#[test]
fn diffuse_takes_colours_numbers_and_spectra() {
    let albedo = |inner: &str| match material(&format!("<bsdf type='diffuse'>{inner}</bsdf>")) {
        Material::Diffuse { reflectance } => constant(&reflectance),
        other => panic!("{other:?}"),
    };
    assert_eq!(albedo(""), Rgb::grey(0.5));
    assert_eq!(albedo("<rgb name='reflectance' value='.1, .2 .3'/>"), Rgb::new(0.1, 0.2, 0.3));
    assert_eq!(albedo("<rgb name='reflectance' value='0.25'/>"), Rgb::grey(0.25));
    assert_eq!(albedo("<spectrum name='reflectance' value='0.25'/>"), Rgb::grey(0.25));
    assert_eq!(albedo("<srgb name='reflectance' value='#ffffff'/>"), Rgb::WHITE);
    assert_eq!(albedo("<rgb name='reflectance' value='2 0.5 0'/>"), Rgb::new(1.0, 0.5, 0.0));
}

#[test]
fn a_measured_reflectance_has_mitsubas_colour() {
    // Values from Mitsuba 3.9.1: the same pairs under D65.
    let inner = "<spectrum name='reflectance' value='400:0.2, 500:0.5, 600:0.9, 700:0.1'/>";
    let Material::Diffuse { reflectance } =
        material(&format!("<bsdf type='diffuse'>{inner}</bsdf>"))
    else {
        panic!()
    };
    let got = constant(&reflectance).to_array();
    for (g, want) in got.into_iter().zip([0.815_698, 0.686_849, 0.317_002]) {
        assert!((g - want).abs() < 1e-3, "{got:?}");
    }
}

#[test]
fn a_spectrum_may_be_a_bitmap() {
    let folder = common::Folder::new();
    let half = [0.5f32; 3].map(f32::to_le_bytes).concat();
    folder.write("a.pfm", [b"PF\n1 1\n-1.0\n".as_slice(), &half].concat());
    let body = "<shape type='cube'><bsdf type='diffuse'><spectrum type='bitmap' name='reflectance'>
        <string name='filename' value='a.pfm'/></spectrum></bsdf></shape>";
    let loaded = folder.scene("3.0.0", body).unwrap();
    let Material::Diffuse { reflectance } = of_only_shape(&loaded) else { panic!() };
    assert_eq!(reflectance.mean(), Rgb::grey(0.5));
}

#[test]
fn spectra_have_the_spellings_of_mitsuba_2() {
    let albedo = |inner: &str| match material(&format!("<bsdf type='diffuse'>{inner}</bsdf>")) {
        Material::Diffuse { reflectance } => constant(&reflectance),
        other => panic!("{other:?}"),
    };
    let of = |kind: &str, inner: &str| {
        albedo(&format!("<spectrum type='{kind}' name='reflectance'>{inner}</spectrum>"))
    };
    assert_eq!(of("srgb", "<rgb name='color' value='.1 .2 .3'/>"), Rgb::new(0.1, 0.2, 0.3));
    let pairs = albedo("<spectrum name='reflectance' value='400:0.2, 500:0.5, 600:0.9'/>");
    let lists = "<string name='values' value='0.2, 0.5, 0.9'/>";
    let range = |first: &str, last: &str| {
        format!("<float name='{first}' value='400'/><float name='{last}' value='600'/>{lists}")
    };
    assert_eq!(of("regular", &range("wavelength_min", "wavelength_max")), pairs);
    assert_eq!(of("interpolated", &range("lambda_min", "lambda_max")), pairs);
    let nodes = format!("<string name='wavelengths' value='400, 500, 600'/>{lists}");
    assert_eq!(of("irregular", &nodes), pairs);
    let vector = "<texture type='rawconstant' name='reflectance'><vector name='value' value='.1, .2, .3'/></texture>";
    assert_eq!(albedo(vector), Rgb::new(0.1, 0.2, 0.3));
    assert_eq!(of("rawconstant", "<float name='value' value='.25'/>"), Rgb::grey(0.25));
    let light = scene(
        "<emitter type='constant'><spectrum type='srgb_d65' name='radiance'>
         <rgb name='color' value='1 2 3'/><float name='scale' value='2'/></spectrum></emitter>",
    );
    let LightSource::Constant { radiance } = light.parts.lights[0] else { panic!() };
    assert_eq!(radiance, Rgb::new(2.0, 4.0, 6.0));
    let uneven = "<shape type='cube'><bsdf type='diffuse'><spectrum type='irregular' name='reflectance'>
        <string name='wavelengths' value='400, 500'/><string name='values' value='1'/></spectrum></bsdf></shape>";
    let shown = common::Folder::new().problems(uneven);
    assert!(shown.contains("2 wavelengths for 1 values"), "{shown}");
}
