//! Invalid numbers: each one is refused, or corrected with a warning.

mod camera;
#[path = "../common/mod.rs"]
mod common;
mod far;
mod meshes;

use common::{Folder, scene};
use gi_core::texture::Texture;
use gi_scene::{CameraOverride, Options, load};
use glam::{Affine3A, Vec3};

/// The errors of a scene with this body.
fn problems(body: &str) -> String {
    Folder::new().problems(body)
}

/// Check that loading fails with `message` and `expected`.
fn refused(body: &str, message: &str, expected: &str) {
    let shown = problems(body);
    assert!(shown.contains(message) && shown.contains(expected), "{body}\n{shown}");
    assert!(shown.contains("scene.xml:2:"), "{shown}");
}

fn bsdf(kind: &str, inner: &str) -> String {
    format!("<shape type='rectangle'><bsdf type='{kind}'>{inner}</bsdf></shape>")
}

fn float(name: &str, value: &str) -> String {
    format!("<float name='{name}' value='{value}'/>")
}

/// A PFM of one row.
fn pfm(texels: &[[f32; 3]]) -> Vec<u8> {
    let mut out = format!("PF\n{} 1\n-1.0\n", texels.len()).into_bytes();
    out.extend(texels.iter().flatten().flat_map(|v| v.to_le_bytes()));
    out
}

const SENSOR: &str = "<sensor type='perspective'/>";
const NAN: [f32; 3] = [1.0, f32::NAN, 1.0];

#[test]
fn a_texel_that_is_not_finite_is_named_with_its_file() {
    let picture = "<string name='filename' value='bad.pfm'/>";
    let bodies = [
        bsdf("diffuse", &format!("<texture name='reflectance' type='bitmap'>{picture}</texture>")),
        format!("<emitter type='envmap'>{picture}</emitter>"),
        format!(
            "<shape type='sphere'><emitter type='area'>\
             <texture name='radiance' type='bitmap'>{picture}</texture></emitter></shape>"
        ),
    ];
    for body in bodies {
        let folder = Folder::new();
        folder.write("bad.pfm", pfm(&[[0.5; 3], NAN]));
        let shown = folder.problems(&body);
        assert!(
            shown.contains("cannot read `bad.pfm`: texel (1, 0) is not finite: 1 NaN 1"),
            "{shown}"
        );
    }
}

#[test]
fn negative_texels_of_light_become_zero_with_a_warning() {
    let folder = Folder::new();
    folder.write("neg.pfm", pfm(&[[0.5; 3], [1.0, -1.0, 2.0]]));
    let picture = "<string name='filename' value='neg.pfm'/>";
    let body = format!(
        "<shape type='sphere'><emitter type='area'>\
         <texture name='radiance' type='bitmap'>{picture}</texture></emitter></shape>\
         <emitter type='envmap'>{picture}</emitter>"
    );
    let loaded = folder.scene("3.0.0", &body).unwrap();
    let noted = loaded.warnings.iter().filter(|w| w.contains("texel (1, 0)")).count();
    assert!(noted > 0, "{:?}", loaded.warnings);
    let Some(Texture::Bitmap { bitmap, .. }) = &loaded.parts.shapes[0].emission else { panic!() };
    assert_eq!(bitmap.texel(1, 0).to_array(), [1.0, 0.0, 2.0]);
    let gi_core::light::LightSource::Environment { image, .. } = &loaded.parts.lights[0] else {
        panic!()
    };
    assert_eq!(image.texel(1, 0).to_array(), [1.0, 0.0, 2.0]);
}

#[test]
fn a_reflectance_picture_above_one_gives_one_warning() {
    let folder = Folder::new();
    folder.write("two.pfm", pfm(&[[0.5; 3], [1.0, 2.0, 2.0]]));
    let body = bsdf(
        "diffuse",
        "<texture name='reflectance' type='bitmap'><string name='filename' value='two.pfm'/></texture>",
    );
    let loaded = folder.scene("3.0.0", &format!("{SENSOR}{body}")).unwrap();
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    assert!(loaded.warnings[0].contains("outside [0, 1]: 0.5 to 2"), "{:?}", loaded.warnings);
}

#[test]
fn a_filter_of_zero_or_huge_width_is_refused() {
    let film = |filter: &str| {
        format!(
            "<sensor type='perspective'><film type='hdrfilm'>{filter}</film></sensor>\
             <shape type='sphere'/>"
        )
    };
    for stddev in ["0", "1e-40", "-1", "4.5", "1e10"] {
        let filter = format!("<rfilter type='gaussian'>{}</rfilter>", float("stddev", stddev));
        refused(&film(&filter), "stddev", "expected more than 0 and at most 4");
    }
    for name in ["b", "c", "B"] {
        let filter = format!("<rfilter type='mitchell'>{}</rfilter>", float(name, "11"));
        refused(&film(&filter), &format!("{} 11", name.to_lowercase()), "expected -10 to 10");
    }
    for lobes in ["0", "-1", "9"] {
        let filter =
            format!("<rfilter type='lanczos'><integer name='lobes' value='{lobes}'/></rfilter>");
        refused(&film(&filter), &format!("lobes {lobes}"), "expected 1 to 8");
    }
}

#[test]
fn negative_light_is_refused() {
    let lights = [
        "<emitter type='point'><rgb name='intensity' value='1 -1 1'/></emitter>",
        "<emitter type='spot'><float name='intensity' value='-1'/></emitter>",
        "<emitter type='constant'><spectrum name='radiance' value='-1'/></emitter>",
        "<emitter type='constant'><spectrum name='radiance' value='400:-1 600:1'/></emitter>",
        "<emitter type='directional'><rgb name='irradiance' value='-1'/></emitter>",
        "<emitter type='sunsky'><float name='scale' value='-1'/></emitter>",
        "<shape type='sphere'><emitter type='area'><rgb name='radiance' value='-1'/></emitter></shape>",
        "<emitter type='constant'><spectrum type='d65' name='radiance'><float name='scale' value='-2'/></spectrum></emitter>",
    ];
    for light in lights {
        refused(light, "light cannot be negative", "expected 0 or more");
    }
}

#[test]
fn light_of_one_wavelength_is_not_refused_as_negative() {
    for light in ["480:0 490:1 500:0", "690:0 700:1 710:0"] {
        let body = format!(
            "<emitter type='constant'><spectrum name='radiance' value='{light}'/></emitter>"
        );
        scene(&body);
    }
}

#[test]
fn numbers_that_would_overflow_later_are_refused() {
    refused(&bsdf("bumpmap", &float("scale", "2e15")), "too large", "a number");
    let moved = "<transform name='to_world'><scale value='1e10'/><scale value='1e10'/></transform>";
    refused(&format!("<shape type='cube'>{moved}</shape>"), "product is too large", "1e15");
    refused(
        "<emitter type='point'><rgb name='intensity' value='1e16'/></emitter>",
        "too large",
        "number",
    );
}

#[test]
fn parameters_of_materials_outside_their_range_are_refused() {
    for (kind, name, value) in [
        ("dielectric", "int_ior", "1e10"),
        ("plastic", "int_ior", "0.01"),
        ("thindielectric", "ext_ior", "100"),
    ] {
        refused(&bsdf(kind, &float(name, value)), "inside / outside", "expected 0.1 to 10");
    }
    for kind in ["roughconductor", "roughdielectric", "roughplastic"] {
        refused(&bsdf(kind, &float("alpha", "-0.1")), "`alpha` is -0.1", "expected 0 to 10");
        refused(&bsdf(kind, &float("alpha", "11")), "`alpha` is 11", "expected 0 to 10");
        scene(&bsdf(kind, &float("alpha", "2")));
    }
    refused(&bsdf("phong", &float("exponent", "-1")), "`exponent` is -1", "0 or more");
}

#[test]
fn fractions_outside_zero_to_one_and_huge_exponents_are_clamped_with_a_warning() {
    let two = "<bsdf type='diffuse'/><bsdf type='null'/>";
    let bodies = [
        bsdf("mask", &format!("{}<bsdf type='diffuse'/>", float("opacity", "1.5"))),
        bsdf("blendbsdf", &format!("{}{two}", float("weight", "-1"))),
        bsdf("phong", &float("exponent", "1e9")),
    ];
    for body in bodies {
        let loaded = scene(&format!("{SENSOR}{body}"));
        assert_eq!(loaded.warnings.len(), 1, "{body} {:?}", loaded.warnings);
    }
}

#[test]
fn parameters_of_cameras_and_skies_outside_their_range_are_refused() {
    let lens =
        |inner: &str| format!("<sensor type='thinlens'>{inner}</sensor><shape type='sphere'/>");
    refused(&lens(&float("aperture_radius", "-1")), "aperture_radius -1", "0 or more");
    refused(&lens(&float("near_clip", "-1")), "near_clip -1", "0 or more");
    let focus = float("aperture_radius", "1") + &float("focus_distance", "0");
    refused(&lens(&focus), "focus_distance 0", "more than 0");
    let sky = |inner: &str| format!("<emitter type='sunsky'>{inner}</emitter>");
    refused(&sky(&float("albedo", "1.5")), "albedo is 1.5", "0 to 1");
    refused(&sky(&float("sun_radius_scale", "-1")), "sun_radius_scale -1", "0 or more");
}

#[test]
fn unsupported_wrap_modes_give_a_warning() {
    let warnings = |modes: &str| {
        let folder = Folder::new();
        folder.write("a.pfm", pfm(&[[0.5; 3]]));
        let body = format!(
            "{SENSOR}<shape type='sphere'><bsdf type='diffuse'><texture type='bitmap' \
             name='reflectance'><string name='filename' value='a.pfm'/>{modes}</texture></bsdf></shape>"
        );
        folder.scene("3.0.0", &body).unwrap().warnings
    };
    let mode = |name: &str, mode: &str| format!("<string name='{name}' value='{mode}'/>");
    for border in ["zero", "one", "black", "white"] {
        let shown = warnings(&mode("wrap_mode", border));
        assert!(shown[0].contains(&format!("`{border}` is read as `clamp`")), "{shown:?}");
    }
    let two = |u: &str, v: &str| mode("wrap_mode_u", u) + &mode("wrap_mode_v", v);
    assert!(warnings(&two("clamp", "mirror"))[0].contains("along v is ignored"));
    assert!(warnings(&two("clamp", "clamp")).is_empty());
    assert!(warnings(&mode("wrap_mode", "mirror")).is_empty());
}

#[test]
fn a_flat_instance_gives_a_warning() {
    let body = format!(
        "{SENSOR}<shape type='shapegroup' id='g'><shape type='cube'/></shape>\
         <shape type='instance'><ref id='g'/><transform name='to_world'><scale value='1 1 0'/>\
         </transform></shape>"
    );
    let shown = scene(&body).warnings;
    assert!(shown[0].contains("the instance is flat"), "{shown:?}");
}

#[test]
fn an_environment_with_a_huge_scale_is_refused() {
    let folder = Folder::new();
    folder.write("a.pfm", pfm(&[[1e10; 3]]));
    let body = format!(
        "<emitter type='envmap'><string name='filename' value='a.pfm'/>{}</emitter>",
        float("scale", "1e10")
    );
    let shown = folder.problems(&body);
    assert!(shown.contains("`scale` is too large"), "{shown}");
}

#[test]
fn negative_light_and_an_invalid_index_in_a_library_are_ignored_with_a_warning() {
    let folder = Folder::new();
    let obj = "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let path = folder.write("a.obj", obj);
    for (line, shown) in [
        ("Ke 1 -1 1", "material `m`: light `Ke 1 -1 1` is not in 0 to 1e15: ignored"),
        ("illum 4\nNi 100", "material `m`: `Ni 100` is not in 0.1 to 10: 1.5 is used"),
    ] {
        folder.write("a.mtl", format!("newmtl m\n{line}\n"));
        let loaded = load(&path, &Options::default()).unwrap();
        assert!(loaded.warnings[0].contains(shown), "{:?}", loaded.warnings);
        assert!(loaded.parts.shapes[0].emission.is_none());
    }
}
