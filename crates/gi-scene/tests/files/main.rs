//! Text files, includes, defines, both Mitsuba formats, and error messages.

#[path = "../common/mod.rs"]
mod common;
mod damaged;
mod hostile;

use common::{Folder, assert_same, describe, old_scene, scene};
use gi_core::geometry::Geometry;
use gi_scene::{Options, load};

#[test]
fn old_and_new_format_give_the_same_parts() {
    let new = scene(
        "<sensor type='perspective'><string name='fov_axis' value='y'/><float name='fov' value='30'/>
         <transform name='to_world'><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/></transform></sensor>
         <bsdf type='roughplastic' id='a'><rgb name='diffuse_reflectance' value='.1 .2 .3'/>
         <float name='int_ior' value='1.5'/></bsdf>
         <shape type='sphere'><boolean name='flip_normals' value='true'/><ref id='a'/>
         <transform name='to_world'><translate value='1 2 3'/></transform></shape>",
    );
    let old = old_scene(
        "<sensor type='perspective'><string name='fovAxis' value='y'/><float name='fov' value='30'/>
         <transform name='toWorld'><lookAt origin='0 0 5' target='0 0 0' up='0 1 0'/></transform></sensor>
         <bsdf type='roughplastic' id='a'><rgb name='diffuseReflectance' value='.1, .2, .3'/>
         <float name='intIOR' value='1.5'/></bsdf>
         <shape type='sphere'><boolean name='flipNormals' value='true'/><ref id='a'/>
         <transform name='toWorld'><translate x='1' y='2' z='3'/></transform></shape>",
    );
    assert_same(&describe(&new), &describe(&old));
    assert!(
        new.warnings.is_empty() && old.warnings.is_empty(),
        "{:?} {:?}",
        new.warnings,
        old.warnings
    );
}

#[test]
fn names_are_substituted_and_overridden() {
    let folder = Folder::new();
    let body = "<scene version='3.0.0'><default name='r' value='2'/><default name='rad' value='7'/>
        <default name='gi.ppm.alpha' value='0.7'/><default name='gi.seen' value='$r'/>
        <integrator type='path'><integer name='max_depth' value='$rad'/></integrator>
        <shape type='sphere'><float name='radius' value='${r}'/></shape></scene>";
    let path = folder.write("a.xml", body.replace("${r}", "$r"));
    let define = |n: &str, v: &str| (n.to_owned(), v.to_owned());
    let plain = load(&path, &Options::default()).unwrap();
    let defines = vec![
        define("r", "3"),
        define("gi.ppm.alpha", "0.5"),
        define("gi.new", "1"),
        define("radd", "1"),
    ];
    let changed = load(&path, &Options { defines, ..Options::default() }).unwrap();
    let radius = |l: &gi_scene::Loaded| match l.parts.shapes[0].geometry {
        Geometry::Sphere { radius, .. } => radius,
        _ => panic!(),
    };
    assert_eq!([radius(&plain), radius(&changed)], [2.0, 3.0]);
    assert_eq!(plain.integrator_max_depth, Some(7), "the longest known name wins");
    assert_eq!(plain.presets["gi.ppm.alpha"], "0.7");
    assert_eq!(plain.presets["gi.seen"], "2");
    assert_eq!(changed.presets["gi.ppm.alpha"], "0.5");
    assert_eq!(changed.presets["gi.new"], "1");
    let notes: Vec<_> = changed.warnings.iter().filter(|w| w.contains("-D")).collect();
    assert_eq!(notes, ["-D radd: the scene does not use this name, did you mean `rad`?"]);
    assert_ne!(plain.hash, changed.hash);
    assert_eq!(plain.hash, load(&path, &Options::default()).unwrap().hash);
}

#[test]
fn includes_are_read_in_place_and_may_not_loop() {
    let folder = Folder::new();
    folder.write("parts/b.xml", "<scene version='3.0.0'><bsdf type='diffuse' id='b'/></scene>");
    let loaded = folder.scene(
        "3.0.0",
        "<include filename='parts/b.xml'/><shape type='cube'><ref id='b'/></shape>",
    );
    assert_eq!(loaded.unwrap().parts.materials.len(), 1);
    folder.write(
        "parts/loop.xml",
        "<scene version='3.0.0'>\n<include filename='../scene.xml'/>\n</scene>",
    );
    let shown = folder.problems("<include filename='parts/loop.xml'/>");
    assert!(shown.contains("`../scene.xml` includes itself"), "{shown}");
    folder.write(
        "parts/two.xml",
        "<scene version='3.0.0'><include filename='one.xml'/><include filename='one.xml'/></scene>",
    );
    folder.write("parts/one.xml", "<scene version='3.0.0'><include filename='two.xml'/></scene>");
    assert!(folder.problems("<include filename='parts/one.xml'/>").contains("includes itself"));
}

#[test]
fn all_errors_are_shown_at_once_with_carets_and_suggestions() {
    let folder = Folder::new();
    let shown = folder.problems(
        "  <bsdf type=\"difuse\" id=\"grey\"/>\n  <shape type=\"cube\"><ref id=\"gray\"/></shape>\n  <shape type=\"sphere\">\n    <float name=\"radius\" value=\"wide\"/>\n  </shape>",
    );
    let expected = "\
error: unknown bsdf `difuse`
 --> scene.xml:2:15
  |
2 |   <bsdf type=\"difuse\" id=\"grey\"/>
  |               ^^^^^^ expected a bsdf plugin
  |
help: did you mean `diffuse`?

error: nothing has the id `gray`
 --> scene.xml:3:31
  |
3 |   <shape type=\"cube\"><ref id=\"gray\"/></shape>
  |                               ^^^^ referred to here
  |
help: did you mean `grey`?

error: `wide` is not a number
 --> scene.xml:5:33
  |
5 |     <float name=\"radius\" value=\"wide\"/>
  |                                 ^^^^ expected a number";
    assert_eq!(shown, expected);
}

#[test]
fn missing_files_are_listed_together() {
    let folder = Folder::new();
    let mesh =
        |n: u32| format!("<shape type='obj'><string name='filename' value='m{n}.obj'/></shape>\n");
    let shown = folder.problems(
        &(mesh(1)
            + &mesh(2)
            + "<emitter type='envmap'><string name='filename' value='sky.exr'/></emitter>"),
    );
    assert_eq!(shown.matches("error").count(), 1, "{shown}");
    for part in [
        "cannot find 3 files",
        "scene.xml:2: m1.obj",
        "scene.xml:3: m2.obj",
        "scene.xml:4: sky.exr",
    ] {
        assert!(shown.contains(part), "{shown}");
    }
}

#[test]
fn unknown_tags_and_parameters_are_ignored_with_a_warning() {
    let loaded = scene(
        "<shape type='sphere'>\n<float name='radus' value='3'/>\n<wibble name='a'/></shape>
         <integrator type='bdpt'/><sampler type='sobol'/>",
    );
    let notes: Vec<&str> = loaded
        .warnings
        .iter()
        .map(|w| w.rsplit_once("scene.xml:").map_or(w.as_str(), |p| p.1))
        .collect();
    assert!(
        notes.contains(
            &"3: shape `sphere` has no parameter `radus`: ignored, did you mean `radius`?"
        ),
        "{notes:?}"
    );
    assert!(notes.iter().any(|n| n.contains("unknown tag `wibble`")), "{notes:?}");
}

#[test]
fn files_in_the_wrong_case_are_found_with_a_warning() {
    let folder = Folder::new();
    folder.write("Mesh/A.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let body = "<shape type='obj'><string name='filename' value='mesh\\a.OBJ'/></shape>";
    let loaded = folder.scene("3.0.0", body).unwrap();
    assert!(loaded.warnings.iter().any(|w| w.contains("Mesh/A.obj")), "{:?}", loaded.warnings);
}

#[test]
fn comments_may_hold_two_dashes() {
    let folder = Folder::new();
    let body = "<!-- render with -o x.exr --spp 64 --->\n<!-- \u{e4} -- --><shape type='cuboid'/>";
    let shown = folder.problems(body);
    assert!(
        shown.contains("unknown shape `cuboid`") && shown.contains("scene.xml:3:27"),
        "{shown}"
    );
    assert!(shown.contains("<!-- \u{e4} -- -->"), "the line is shown unchanged: {shown}");
}

#[test]
fn a_scene_may_begin_with_a_byte_order_mark() {
    let folder = Folder::new();
    let text = "\u{feff}<?xml version='1.0' encoding='utf-8'?><scene version='3.0.0'><shape type='cube'/></scene>";
    assert!(load(&folder.write("a.xml", text), &Options::default()).is_ok());
    let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    assert!(load(&folder.write("a.xml", wide), &Options::default()).is_ok());
}

#[test]
fn a_radiance_picture_may_start_with_the_name_of_any_program() {
    let folder = Folder::new();
    let file = "<string name='filename' value='a.hdr'/>";
    let body = format!("<emitter type='envmap'>{file}</emitter>");
    for name in ["RADIANCE", "RGBE", "AUTOPANO"] {
        let head = format!("#?{name}\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n");
        folder.write("a.hdr", [head.as_bytes(), &[128; 16]].concat());
        let loaded = folder.scene("3.0.0", &body).unwrap_or_else(|e| panic!("{name}: {e}"));
        let gi_core::light::LightSource::Environment { image, .. } = &loaded.parts.lights[0] else {
            panic!()
        };
        assert!((image.texel(1, 1).r - 0.5).abs() < 0.01, "{name}");
    }
    folder.write("a.hdr", "#?");
    folder.problems(&body);
}

#[test]
fn ignored_requests_of_an_integrator_give_a_warning() {
    let warnings = |integrator: &str| {
        let sensor = "<sensor type='perspective'/>";
        let loaded = scene(&format!("{integrator}{sensor}<shape type='cube'/>"));
        loaded.warnings.join("\n")
    };
    let strict =
        "<integrator type='path'><boolean name='strict_normals' value='true'/></integrator>";
    assert!(warnings(strict).contains("`strict_normals` is ignored"), "{}", warnings(strict));
    assert_eq!(warnings(&strict.replace("true", "false")), "");
    assert!(warnings("<integrator type='direct'/>").contains("--max-depth 2"));
    let nested =
        "<integrator type='aov'><integrator type='path'><integer name='max_depth' value='5'/>
        <boolean name='hideEmitters' value='true'/></integrator></integrator>";
    let loaded = scene(&format!("{nested}<shape type='cube'/>"));
    assert_eq!(loaded.integrator_max_depth, Some(5));
    assert!(loaded.parts.hides_emitters && !warnings(nested).contains("hide_emitters"));
    let fog = "<medium type='homogeneous' id='m'/>";
    let foggy = scene(&format!("{nested}{fog}<shape type='cube'/>"));
    assert!(!foggy.parts.hides_emitters);
    let shown = foggy.warnings.join("\n");
    assert!(shown.contains("`hide_emitters` is ignored in a scene with media"), "{shown}");
}

#[test]
fn an_undefined_name_is_one_error() {
    let folder = Folder::new();
    let shown = folder.problems(
        "<include filename='$a'/>
         <shape type='sphere'><float name='radius' value='$a'/><rgb name='x' value='$a'/><ref id='$a'/>
         <transform name='to_world'><translate x='$a'/><scale value='$a'/></transform></shape>
         <shape type='obj'><string name='filename' value='$a'/></shape><bsdf type='$a'/>",
    );
    let errors = shown.lines().filter(|l| l.starts_with("error: ")).collect::<Vec<_>>();
    assert!(errors.iter().all(|l| l.contains("`$a` is not defined")), "{errors:#?}");
}

#[test]
fn an_unknown_reference_is_not_counted_as_a_missing_child_too() {
    let shown = Folder::new().problems(
        "<shape type='cube'><bsdf type='twosided'><ref id='nothing'/></bsdf></shape>
         <shape type='cube'><bsdf type='blendbsdf'><bsdf type='diffuse'/><ref id='nothing'/></bsdf></shape>",
    );
    assert!(!shown.contains(" bsdfs"), "{shown}");
}

#[test]
fn elements_after_the_end_of_the_scene_are_ignored_with_a_warning() {
    let folder = Folder::new();
    let text = "<scene version='3.0.0'><shape type='sphere'/></scene>\n<shape type='cube'/>\n";
    let loaded = load(&folder.write("a.xml", text), &Options::default()).unwrap();
    assert_eq!(loaded.parts.shapes.len(), 1);
    let warned = |w: &String| w.ends_with("a.xml:1: what follows `</scene>` is ignored");
    assert!(loaded.warnings.iter().any(warned), "{:?}", loaded.warnings);
}
