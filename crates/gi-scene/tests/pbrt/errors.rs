//! Error messages, and files that are damaged on purpose.

use super::*;

/// The errors of a text.
fn problems(text: &str) -> String {
    let folder = common::Folder::new();
    let path = folder.write("scene.pbrt", text);
    let shown = load(&path, &Options::default()).expect_err("a scene with problems").to_string();
    folder.strip(&shown)
}

#[test]
fn all_errors_are_shown_at_once_with_carets_and_suggestions() {
    let text = "\
WorldBegin
Shape \"sfere\" \"float radius\" 1
Material \"difuse\"
Shape \"sphere\" \"float radius\" wide
Trnslate 1 2 3
NamedMaterial \"grey\"
Shape \"sphere\" \"float radius\" \"1\"
";
    let expected = "\
error: unknown shape `sfere`
 --> scene.pbrt:2:7
  |
2 | Shape \"sfere\" \"float radius\" 1
  |       ^^^^^^^ expected a shape
  |
help: did you mean `sphere`?

error: unknown material `difuse`
 --> scene.pbrt:3:10
  |
3 | Material \"difuse\"
  |          ^^^^^^^^ expected a material
  |
help: did you mean `diffuse`?

error: `wide` is not a number
 --> scene.pbrt:4:31
  |
4 | Shape \"sphere\" \"float radius\" wide
  |                               ^^^^ expected a number

error: unknown directive `Trnslate`
 --> scene.pbrt:5:1
  |
5 | Trnslate 1 2 3
  | ^^^^^^^^ expected a directive
  |
help: did you mean `Translate`?

error: no material is named `grey`
 --> scene.pbrt:6:15
  |
6 | NamedMaterial \"grey\"
  |               ^^^^^^ referred to here

error: `radius` is a string
 --> scene.pbrt:7:16
  |
7 | Shape \"sphere\" \"float radius\" \"1\"
  |                ^^^^^^^^^^^^^^ expected numbers";
    assert_eq!(problems(text), expected);
}

#[test]
fn each_mistake_has_its_message() {
    let mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]";
    let grid = "MakeNamedMedium \"a\" \"string type\" \"uniformgrid\" \"integer nx\" 2";
    let cases = [
        ("AttributeEnd", "there is no open `AttributeBegin`"),
        ("AttributeBegin", "`AttributeBegin` is never closed"),
        ("AttributeBegin ObjectEnd AttributeEnd", "`AttributeBegin` at scene.pbrt:1 is open"),
        ("ObjectBegin \"a\" ObjectBegin \"b\" ObjectEnd ObjectEnd", "inside another one"),
        ("ObjectInstance \"a\"", "no object is named `a`"),
        ("Translate 1 2", "the file ends early"),
        ("Translate 1 2 Shape", "`Shape` is not a number"),
        ("Scale 1e30 1 1", "`1e30` is too large"),
        ("Rotate 30 0 0 0", "this rotation has no axis"),
        ("LookAt 0 0 0 0 0 0 0 1 0", "the same"),
        ("Transform [1 2 3]", "unexpected `]`"),
        ("Transform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 0]", "last number of this matrix is zero"),
        ("CoordSysTransform \"a\"", "no coordinate system is named `a`"),
        ("ColorSpace \"rgb\"", "unknown colour space `rgb`"),
        ("Shape \"sphere\" \"flot radius\" 1", "did you mean `float`?"),
        ("Shape \"sphere\" \"radius\" 1", "`radius` is not a parameter"),
        ("Shape \"sphere\" \"float radius\" [1 2]", "`radius` has 2 values"),
        ("Shape \"sphere\" \"float radius\" [1 \"a\"]", "values of different kinds"),
        ("Shape \"sphere\" \"float radius\" -1", "radius -1"),
        ("Shape \"sphere\" \"float radius\" [1", "the file ends early"),
        ("Shape \"sphere\n", "this string has no closing quote"),
        ("Shape \"plymesh\"", "`plymesh` without a `filename`"),
        ("Shape \"plymesh\" \"string filename\" \"a.ply\"", "cannot find `a.ply`"),
        ("Shape \"trianglemesh\"", "`trianglemesh` without `point3 P`"),
        (&format!("{mesh} \"integer indices\" [0 1 3]"), "the index 3 of 3 points"),
        (&format!("{mesh} \"integer indices\" [0 1 -1]"), "the index -1 of 3 points"),
        (&format!("{mesh} \"integer indices\" [0 1]"), "`indices` has 2 numbers"),
        ("Material \"diffuse\" \"texture reflectance\" \"a\"", "no texture is named `a`"),
        ("Material \"diffuse\" \"spectrum reflectance\" \"a\"", "cannot find `a`"),
        ("Material \"diffuse\" \"rgb reflectance\" [1 2]", "2 numbers are not a colour"),
        ("Material \"dielectric\" \"float eta\" 100", "index of refraction"),
        ("Material \"mix\"", "`mix` without `string materials`"),
        ("MakeNamedMaterial \"a\"", "a material without a `string type`"),
        ("MakeNamedMedium \"a\" \"string type\" \"homogenous\"", "did you mean `homogeneous`?"),
        ("MakeNamedMedium \"a\" \"string type\" \"cloud\"", "sample it into a `uniformgrid`"),
        ("MakeNamedMedium \"a\" \"string type\" \"nanovdb\"", "the NanoVDB format is not read"),
        (&format!("{grid} \"float density\" [1 2 3]"), "3 values for 2 x 1 x 1 cells"),
        (&format!("{grid} \"float density\" [1 -2]"), "a density of -2"),
        (&format!("{grid} \"integer ny\" -1 \"float density\" []"), "density"),
        ("MediumInterface \"a\" \"b\"", "no medium is named `a`"),
        ("Texture \"a\" \"colour\" \"constant\"", "a texture of `colour`"),
        ("Texture \"a\" \"float\" \"imagemap\"", "`imagemap` without a `filename`"),
        ("LightSource \"pont\"", "did you mean `point`?"),
        ("LightSource \"distant\" \"point3 to\" [0 0 0]", "the same point"),
        ("LightSource \"point\" \"rgb I\" [-1 0 0]", "light cannot be negative"),
        ("AreaLightSource \"diffus\"", "did you mean `diffuse`?"),
        ("Include \"a.pbrt\"", "cannot find `a.pbrt`"),
        ("Include \"scene.pbrt\"", "`scene.pbrt` includes itself"),
        ("WorldBegin", "a second `WorldBegin`"),
    ];
    for (text, expected) in cases {
        let shown = problems(&format!("WorldBegin {text}"));
        assert!(shown.contains(expected), "{text}:\n{shown}");
        assert!(shown.contains("scene.pbrt:1:"), "{text}: without its place\n{shown}");
    }
    let camera = problems("Camera \"perspective\" \"float fov\" 200\nWorldBegin Shape \"sphere\"");
    assert!(camera.contains("fov 200"), "{camera}");
    assert!(problems("Shape \"sphere\"").contains("before `WorldBegin`"));
    assert!(problems("").contains("has no `WorldBegin`"));
}

#[test]
fn unknown_parameters_give_a_warning_with_a_suggestion() {
    let loaded =
        world("Shape \"sphere\" \"float radus\" 3\nMaterial \"diffuse\" \"float roughness\" 1");
    let notes = warnings(&loaded);
    assert_eq!(
        notes,
        [
            "3: shape `sphere` has no parameter `radus`: ignored, did you mean `radius`?",
            "4: material `diffuse` has no parameter `roughness`: ignored",
        ]
    );
}

#[test]
fn levels_may_cross_in_the_old_format_only() {
    let crossed = "WorldBegin AttributeBegin ObjectBegin \"a\" Shape \"sphere\" AttributeEnd ObjectEnd \
        ObjectInstance \"a\"";
    assert!(problems(crossed).contains("`ObjectBegin` at scene.pbrt:1 is open"));
    let folder = common::Folder::new();
    let path = folder.write("scene.pbrt", format!("{crossed} WorldEnd"));
    assert_eq!(load(&path, &Options::default()).unwrap().parts.groups.len(), 1);
}

#[test]
fn a_million_nested_levels_are_refused() {
    for begin in ["AttributeBegin\n", "ObjectBegin \"a\"\n"] {
        let shown = problems(&format!("WorldBegin\n{}", begin.repeat(1_000_000)));
        assert!(shown.contains("nested too deeply") || shown.contains("inside another"), "{shown}");
    }
}

#[test]
fn included_text_is_limited_counting_repeats() {
    let folder = common::Folder::new();
    folder.write("a.pbrt", "Include \"b.pbrt\"\n".repeat(200));
    folder.write("b.pbrt", "Include \"c.pbrt\"\n".repeat(200));
    folder.write("c.pbrt", "Identity\n");
    let path = folder.write("scene.pbrt", "WorldBegin\nInclude \"a.pbrt\"");
    let shown = load(&path, &Options::default()).unwrap_err().to_string();
    assert!(shown.contains("too many files include each other"), "{shown}");
}

#[test]
fn files_of_pbrt_v2_are_named_as_such() {
    let shown = problems("SurfaceIntegrator \"path\"\nWorldBegin\nWorldEnd");
    assert!(shown.contains("`SurfaceIntegrator` is a directive of pbrt-v2"), "{shown}");
    assert!(shown.contains("the file is read as pbrt-v3"), "{shown}");
}
