//! Media whose density varies.

use gi_core::medium::{Between, Cells, Domain, Grid, Medium, Outside, Volume};
use gi_scene::{Options, export_mitsuba, load};

use super::*;
use crate::common::Folder;

/// A file of 2 x 3 x 4 cells.
fn file(channels: usize) -> Vec<u8> {
    let mut out = b"VOL\x03".to_vec();
    out.extend([1, 2, 3, 4, channels as i32].map(i32::to_le_bytes).concat());
    out.extend([1.0, 2.0, 3.0, 3.0, 5.0, 4.0f32].map(f32::to_le_bytes).concat());
    out.extend((0..24 * channels).flat_map(|k| (k as f32 / 128.0).to_le_bytes()));
    out
}

fn body(medium: &str) -> String {
    format!(
        "<medium type='heterogeneous' id='m'>{medium}</medium>
         <shape type='cube'><bsdf type='null'/><ref name='interior' id='m'/></shape>"
    )
}

fn volume(name: &str, file: &str, inner: &str) -> String {
    format!(
        "<volume type='gridvolume' name='{name}'><string name='filename' value='{file}'/>{inner}</volume>"
    )
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("grey.vol", file(1));
    folder.write("colour.vol", file(3));
    folder
}

fn medium_of(version: &str, medium: &str) -> Medium {
    let loaded = folder().scene(version, &body(medium)).unwrap_or_else(|e| panic!("{e}"));
    loaded.parts.media[0].clone()
}

fn grid(volume: &Volume) -> (&Grid, Vec3) {
    match volume {
        Volume::Grid { grid, to_local, .. } => (grid, to_local.transform_point3(Vec3::splat(2.0))),
        other @ Volume::Constant(_) => panic!("{other:?}"),
    }
}

#[test]
fn grids_have_the_filter_the_wrap_mode_and_the_place_of_their_parameters() {
    let medium = medium_of(
        "3.0.0",
        &(volume("sigma_t", "grey.vol", "<string name='filter_type' value='nearest'/>")
            + "<float name='scale' value='8'/>"
            + &volume(
                "albedo",
                "colour.vol",
                "<string name='wrap_mode' value='mirror'/><boolean name='use_grid_bbox' value='true'/>
                 <transform name='to_world'><scale value='2'/></transform>",
            )),
    );
    let varying = medium.varying.expect("a density that varies");
    let (density, at) = grid(varying.sigma_t());
    assert_eq!(density.size(), [2, 3, 4]);
    assert_eq!((density.between(), density.outside()), (Between::Nearest, Outside::Clamp));
    assert!(matches!(density.cells(), Cells::Grey(v) if v[23] == 23.0 / 128.0));
    assert_eq!(at, Vec3::splat(2.0), "the unit cube");
    assert_eq!(varying.sigma_t().at(Vec3::new(0.9, 0.1, 0.1)), Rgb::grey(1.0 / 16.0));
    assert!(
        matches!(varying.domain(), Domain::BoxAround(_)),
        "Mitsuba clips to a box in world space"
    );
    let (albedo, at) = grid(varying.albedo());
    assert_eq!((albedo.between(), albedo.outside()), (Between::Trilinear, Outside::Mirror));
    // The file's box is (1, 2, 3) to (3, 5, 4), and twice that in the world.
    let expected = Vec3::new(0.0, -1.0 / 3.0, -2.0);
    assert!((at - expected).length() < 1e-6, "{at}");
    assert_eq!(medium.sigma_t, Rgb::grey(8.0 * 23.0 / 128.0));
    assert_eq!(medium.albedo, Rgb::new(69.0, 70.0, 71.0) * (1.0 / 128.0));
}

#[test]
fn volumes_are_constant_by_default_and_fill_the_unit_cube() {
    let medium = medium_of("3.0.0", "<rgb name='sigma_t' value='1 2 3'/>");
    let varying = medium.varying.expect("a box");
    assert_eq!(varying.sigma_t(), &Volume::Constant(Rgb::new(1.0, 2.0, 3.0)));
    assert_eq!(varying.albedo(), &Volume::Constant(Rgb::grey(0.75)));
    assert_eq!(varying.domain().bounds().max, Vec3::ONE);
    let moved = "<volume type='constvolume' name='sigma_t'><float name='value' value='2'/>
        <transform name='to_world'><translate x='1'/></transform></volume>";
    let varying = medium_of("3.0.0", moved).varying.expect("a box");
    assert_eq!(varying.domain().bounds().min, Vec3::X);
}

#[test]
fn grids_of_mitsuba_0_6_have_their_outer_centres_on_the_files_box() {
    let medium = medium_of("0.6.0", &volume("density", "grey.vol", ""));
    let varying = medium.varying.expect("a density that varies");
    let sigma_t = varying.sigma_t();
    assert!(sigma_t.at(Vec3::new(1.0, 2.0, 3.0)).r < 1e-6);
    assert!((sigma_t.at(Vec3::new(3.0, 5.0, 4.0)).r - 23.0 / 128.0).abs() < 1e-6);
    assert!((varying.domain().bounds().max - Vec3::new(3.0, 5.0, 4.0)).length() < 1e-5);
}

#[test]
fn wrong_volumes_are_named() {
    let folder = folder();
    let mut far = file(1);
    far[48 + 4 * 5..][..4].copy_from_slice(&(-1.0f32).to_le_bytes());
    folder.write("negative.vol", &far);
    folder.write("cut.vol", &far[..60]);
    folder.write("six.vol", [&file(1)[..20], &6i32.to_le_bytes(), &file(1)[24..]].concat());
    folder.write("half.vol", [b"VOL\x03\x02\0\0\0", &file(1)[8..]].concat());
    let of = |file: &str, inner: &str| volume("sigma_t", file, inner);
    for (medium, expected) in [
        (of("negative.vol", ""), "negative.vol`: the value of cell (1, 2, 0) is -1"),
        (of("cut.vol", ""), "cut.vol`: it has 12 bytes of values, and its header says 96"),
        (of("six.vol", ""), "6 channels are not supported"),
        (of("half.vol", ""), "values stored as half precision are not supported"),
        (of("absent.vol", ""), "cannot find `absent.vol`"),
        (of("grey.vol", "<string name='wrap_mode' value='miror'/>"), "did you mean `mirror`?"),
        (
            of("grey.vol", "<string name='filter_type' value='cubic'/>"),
            "expected `trilinear` or `nearest`",
        ),
        (
            of("grey.vol", "<transform name='to_world'><scale x='0'/></transform>"),
            "cannot be inverted",
        ),
        (
            of("grey.vol", "<float name='scale' value='-1'/>")
                + "<float name='scale' value='1e9'/>",
            "too dense",
        ),
        ("<float name='albedo' value='1.5'/>".into(), "amplifies"),
        ("<float name='sigma_t' value='-2'/>".into(), "`sigma_t` is -2"),
        ("<volume type='gridvolum' name='albedo'/>".into(), "did you mean `gridvolume`?"),
    ] {
        let shown = folder.problems(&body(&medium));
        assert!(shown.contains(expected), "{medium}: {shown}");
    }
    let options = Options { max_memory: 1 << 20, ..Options::default() };
    let mut large = file(1)[..48].to_vec();
    large[8..20].copy_from_slice(&[64, 64, 256].map(i32::to_le_bytes).concat());
    large.resize(48 + 4 * 64 * 64 * 256, 0);
    folder.write("large.vol", large);
    let path = folder.write(
        "scene.xml",
        format!("<scene version='3.0.0'>{}</scene>", body(&of("large.vol", ""))),
    );
    let shown = load(&path, &options).expect_err("more memory than allowed").to_string();
    assert!(shown.contains("large.vol") && shown.contains("--max-memory"), "{shown}");
}

#[test]
fn an_exported_medium_is_read_back() {
    let folder = folder();
    let inner = "<string name='wrap_mode' value='repeat'/><transform name='to_world'><rotate y='1' angle='30'/></transform>";
    let medium = volume("sigma_t", "grey.vol", inner)
        + &volume("albedo", "colour.vol", "<string name='filter_type' value='nearest'/>")
        + "<float name='scale' value='3'/>";
    let text = format!("<scene version='3.0.0'>{}</scene>", body(&medium));
    let (a, b) = (folder.write("scene.xml", text), folder.path("export.xml"));
    let warnings = export_mitsuba(&a, &Options::default(), &b).expect("an export");
    assert!(warnings.iter().all(|w| !w.contains("medium")), "{warnings:?}");
    let [a, b] = [a, b].map(|p| load(&p, &Options::default()).expect("a scene").parts.media);
    let [a, b] = [&a[0], &b[0]];
    assert_eq!((a.sigma_t, a.albedo), (b.sigma_t, b.albedo));
    let [a, b] = [a, b].map(|m| m.varying.as_ref().expect("a density that varies"));
    for k in 0..50 {
        let p = Vec3::new(0.31, -0.17, 0.23) * k as f32 - 3.0;
        assert_eq!(a.albedo().at(p), b.albedo().at(p));
        let [x, y] = [a, b].map(|m| m.sigma_t().at(p).r);
        assert!((x - y).abs() < 1e-5, "{p}: {x} and {y}");
    }
}

#[test]
fn a_grid_with_a_value_just_below_zero_is_read() {
    let folder = Folder::new();
    let mut cells = file(1);
    cells[48..52].copy_from_slice(&(-1e-45f32).to_le_bytes());
    folder.write("grey.vol", cells);
    let loaded = folder.scene("3.0.0", &body(&volume("sigma_t", "grey.vol", ""))).unwrap();
    let varying = loaded.parts.media[0].varying.clone().expect("a density that varies");
    let (density, _) = grid(varying.sigma_t());
    assert!(matches!(density.cells(), Cells::Grey(v) if v[0] == 0.0));
}
