//! Files that are damaged, malicious, or in another format.

use super::*;

#[test]
fn malicious_text_ends_in_an_error() {
    let folder = Folder::new();
    // Entities that multiply.
    let bomb = "<!DOCTYPE s [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;\">]><scene version='3.0.0'>&b;</scene>";
    assert!(load(&folder.write("bomb.xml", bomb), &Options::default()).is_err());
    // Substitution that doubles.
    let mut doubling = String::from("<default name='a0' value='xxxxxxxxxxxxxxxx'/>");
    for i in 1..60 {
        doubling += &format!(
            "<default name='a{i}z' value='$a{0}$a{0}'/>",
            if i == 1 { "0".into() } else { format!("{}z", i - 1) }
        );
    }
    assert!(folder.problems(&doubling).contains("too long"));
    // Nesting, in the text and by reference.
    let deep = "<bsdf type='twosided'>".repeat(5000) + &"</bsdf>".repeat(5000);
    assert!(folder.problems(&deep).contains("too deep"));
    let mut chain = String::new();
    for i in 0..2000 {
        chain += &format!("<bsdf type='mask' id='m{i}'><ref id='m{}'/></bsdf>\n", i + 1);
    }
    chain += "<bsdf type='diffuse' id='m2000'/><shape type='cube'><ref id='m0'/></shape>";
    assert!(folder.problems(&chain).contains("too deep"));
    let ring = "<bsdf type='mask' id='a'><ref id='b'/></bsdf><bsdf type='mask' id='b'><ref id='a'/></bsdf>";
    assert!(folder.problems(ring).contains("contains itself"));
    let cut = "<scene version='3.0.0'><shape type='cube'";
    assert!(load(&folder.write("cut.xml", cut), &Options::default()).is_err());
    assert!(
        load(
            &folder.write("latin.xml", b"<scene version='3.0.0'>\xff</scene>"),
            &Options::default()
        )
        .is_err()
    );
    assert!(load(&folder.path("absent.xml"), &Options::default()).is_err());
    let empty = folder.write("empty.xml", "");
    assert!(load(&empty, &Options::default()).is_err());
}

#[test]
fn a_scene_cut_at_any_byte_never_panics() {
    let folder = Folder::new();
    let text = "<?xml version='1.0'?>\n<scene version='0.6.0'><default name='x' value='1'/><bsdf type='diffuse' id='ä'>
        <spectrum name='reflectance' value='400:0.1, 700:$x'/></bsdf><shape type='sphere'><ref id='ä'/>
        <transform name='toWorld'><rotate y='1' angle='3'/></transform></shape></scene>";
    for end in 0..text.len() {
        let path = folder.write("cut.xml", &text.as_bytes()[..end]);
        if let Err(problems) = load(&path, &Options::default()) {
            assert!(!problems.to_string().is_empty());
        }
    }
}

#[test]
fn a_vertex_that_is_not_finite_is_named() {
    let folder = Folder::new();
    folder.write("bad.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n");
    let shown =
        folder.problems("<shape type='obj'><string name='filename' value='bad.obj'/></shape>");
    assert!(shown.contains("bad.obj") && shown.contains("vertex 1 is not finite"), "{shown}");
}

#[test]
fn a_scene_in_another_format_is_refused() {
    let folder = Folder::new();
    let shown = folder.problems("<sensor type='perspective'/><mesh type='obj'/><mesh type='obj'/>");
    assert!(
        shown.contains("not in Mitsuba's format") && shown.ends_with("Mitsuba has no <mesh>"),
        "{shown}"
    );
    let lit = folder.problems("<emitter type='point'/><mesh type='obj'/>");
    assert!(lit.contains("not in Mitsuba"), "{lit}");
    assert!(load(&folder.write("a.xml", "<world><mesh/></world>"), &Options::default()).is_err());
}

#[test]
fn a_git_lfs_pointer_is_recognised() {
    let folder = Folder::new();
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n";
    let all_say = |shown: String| {
        assert!(shown.contains("Git LFS") && shown.contains("`git lfs pull`"), "{shown}");
    };
    for name in ["a.obj", "a.xml"] {
        all_say(load(&folder.write(name, pointer), &Options::default()).unwrap_err().to_string());
    }
    for (kind, name) in [("obj", "a.obj"), ("ply", "a.ply"), ("serialized", "a.serialized")] {
        folder.write(name, pointer);
        let body = format!("<shape type='{kind}'><string name='filename' value='{name}'/></shape>");
        all_say(folder.problems(&body));
    }
    for name in ["a.exr", "a.png", "a.hdr", "a.pfm", "a.jpg"] {
        folder.write(name, pointer);
        let file = format!("<string name='filename' value='{name}'/>");
        all_say(folder.problems(&format!("<emitter type='envmap'>{file}</emitter>")));
    }
    folder.write("a.mtl", pointer);
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    all_say(load(&folder.write("b.obj", obj), &Options::default()).unwrap_err().to_string());
}
