//! No output may overwrite an input, another output, a device or a folder. A symbolic link is written through.

use std::collections::BTreeMap;
use std::os::unix::fs::symlink;
use std::path::Path;

use gi_core::image_io::{ImageFile, Layers, write_file};
use gi_tests::program::{Folder, assert_refused, assert_success, run};

use crate::running::{path_of, start};

/// A folder with a scene that includes a file, and reads a mesh and two pictures.
fn scene_folder() -> Folder {
    let folder = Folder::make();
    let picture = Layers::of_rgb([2, 2], [[0.5; 3]; 4]);
    for (name, format) in [("wood.png", ImageFile::Png), ("sky.exr", ImageFile::Exr)] {
        write_file(Path::new(&folder.at(name)), format, &picture).expect("written");
    }
    let write = |name: &str, text: &str| std::fs::write(folder.at(name), text).expect("written");
    write("mesh.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    write(
        "rest.xml",
        "<scene version='3.0.0'><emitter type='envmap'><string name='filename' value='sky.exr'/></emitter></scene>",
    );
    write(
        "scene.xml",
        "<scene version='3.0.0'><include filename='rest.xml'/><sensor type='perspective'/>\
         <shape type='obj'><string name='filename' value='mesh.obj'/><bsdf type='diffuse'>\
         <texture type='bitmap' name='reflectance'><string name='filename' value='wood.png'/></texture>\
         </bsdf></shape></scene>",
    );
    folder
}

/// The bytes of all files in a folder.
fn contents(folder: &Folder) -> BTreeMap<String, Vec<u8>> {
    let read = |name: String| (name.clone(), std::fs::read(folder.at(&name)).unwrap_or_default());
    folder.files().into_iter().map(read).collect()
}

/// Check that a program refuses these flags before it changes a file. In `flags`, `@` marks names of files in the
/// folder.
#[track_caller]
fn refuses(folder: &Folder, program: &str, flags: &str, says: &[&str]) {
    let before = contents(folder);
    let output = start(folder, program, &format!("--size 8x8 --spp 1 {flags}"));
    assert_refused(&output, 2, says);
    assert!(contents(folder) == before, "{program} {flags:?} changed a file");
}

const PROGRAMS: [&str; 7] =
    ["pathtrace", "irrcache", "radcache", "photonmap", "ppm", "instant-radiosity", "lightcuts"];

#[test]
fn no_program_overwrites_what_its_scene_reads() {
    let folder = scene_folder();
    for program in PROGRAMS {
        // The display image of wood.exr is wood.png.
        refuses(&folder, program, "-o @wood.exr", &["overwrite", "wood.png", "the scene reads"]);
        refuses(&folder, program, "-o @sky.exr", &["overwrite", "sky.exr"]);
        for input in ["scene.xml", "rest.xml", "mesh.obj", "wood.png", "sky.exr"] {
            let flags = format!("-o @out.exr --stats @{input}");
            refuses(&folder, program, &flags, &["overwrite", input]);
        }
        for input in ["scene.xml", "rest.xml", "mesh.obj"] {
            let flags = format!("--export-mitsuba @{input}");
            refuses(&folder, program, &flags, &["overwrite", input]);
        }
    }
    for program in ["pathtrace", "ppm", "lightcuts"] {
        refuses(&folder, program, "-o @out.exr --checkpoint @mesh.obj", &["overwrite", "mesh.obj"]);
    }
}

#[test]
fn inputs_are_recognised_through_links_and_other_paths() {
    let folder = scene_folder();
    symlink("mesh.obj", folder.at("link")).expect("a link");
    symlink("link", folder.at("link-to-link")).expect("a link");
    symlink(".", folder.at("here")).expect("a link");
    for name in ["link", "link-to-link", "here/mesh.obj", "./here/link", "here/here/link"] {
        let flags = format!("-o @out.exr --stats @{name}");
        refuses(&folder, "pathtrace", &flags, &["overwrite", "mesh.obj"]);
    }
}

#[test]
fn technique_files_are_inputs_and_outputs_like_others() {
    let folder = scene_folder();
    let same = |program: &str, flags: &str| refuses(&folder, program, flags, &["overwrite"]);
    for program in ["irrcache", "radcache"] {
        same(program, "-o @out.exr --cache-out @wood.png");
        same(program, "-o @out.exr --cache-out @a.cache --stats @a.cache");
        same(program, "-o @out.exr --cache-in @a.cache --cache-out @a.cache");
        same(program, "-o @out.exr --cache-in @a.cache --stats @a.cache");
        same(program, "-o @out.exr --records-out @a.ply --cache-out @a.ply");
    }
    same("photonmap", "-o @out.exr --map-out @mesh.obj");
    same("photonmap", "-o @out.exr --map-in @a.map --map-out @a.map");
    same("photonmap", "-o @out.exr --photons-out @a.csv --stats @a.csv");
    same("instant-radiosity", "-o @out.exr --vpls-out @a.csv --stats @a.csv");
    same("lightcuts", "-o @out.exr --lights-out @a.csv --stats @a.csv");
    same("ppm", "-o @out.exr --trace-pixel 1,1 --trace-out @a.csv --stats @a.csv");
    same("pathtrace", "-o @out.exr --stats @out.png");
    // Call the program directly, because --merge does not allow --spp.
    std::fs::write(folder.at("kept"), "a checkpoint").expect("written");
    let [scene, out, kept] = ["scene.xml", "out.exr", "kept"].map(|name| folder.at(name));
    let line = [&scene, "-o", &out, "--stats", &kept, "--merge", &kept];
    let output = run(path_of("pathtrace").to_str().expect("UTF-8"), &line);
    assert_refused(&output, 2, &["overwrite", "--merge"]);
}

#[test]
fn views_of_techniques_overwrite_no_input() {
    let folder = scene_folder();
    std::fs::rename(folder.at("wood.png"), folder.at("out.records.png")).expect("renamed");
    let text = std::fs::read_to_string(folder.at("scene.xml")).expect("the scene");
    std::fs::write(folder.at("scene.xml"), text.replace("wood.png", "out.records.png"))
        .expect("written");
    let says = ["overwrite", "out.records.png"];
    refuses(&folder, "irrcache", "-o @out.exr --show records", &says);
    refuses(&folder, "radcache", "-o @out.exr --show records", &says);
    refuses(
        &folder,
        "irrcache",
        "-o @out.exr --show records --stats @out.octree.png",
        &["overwrite"],
    );
}

#[test]
fn devices_folders_and_pipes_are_refused() {
    let folder = scene_folder();
    std::fs::create_dir(folder.at("folder.exr")).expect("a folder");
    symlink("/dev/null", folder.at("null.exr")).expect("a link");
    for program in PROGRAMS {
        for device in ["/dev/null", "/dev/full", "/dev/stdout"] {
            let flags = format!("-o @out.exr --stats {device}");
            refuses(&folder, program, &flags, &["not a regular file"]);
        }
        refuses(&folder, program, "-o @folder.exr", &["folder"]);
        refuses(&folder, program, "-o @null.exr", &["not a regular file"]);
        refuses(&folder, program, "--export-mitsuba /dev/null", &["not a regular file"]);
    }
}

#[test]
fn a_symbolic_link_is_written_through() {
    let folder = scene_folder();
    std::fs::create_dir(folder.at("far")).expect("a folder");
    for (link, target) in [("a.exr", "far/a.exr"), ("a.png", "far/b.png"), ("a.json", "far/c.json")]
    {
        symlink(target, folder.at(link)).expect("a link");
    }
    let (out, stats) = (folder.at("a.exr"), folder.at("a.json"));
    let scene = folder.at("scene.xml");
    let flags = ["-o", &out, "--stats", &stats, "--size", "8x8", "--spp", "1"];
    for _ in 0..2 {
        let line = [&[scene.as_str()], &flags[..]].concat();
        assert_success(&run(path_of("pathtrace").to_str().expect("UTF-8"), &line));
        assert!(["a.exr", "a.png", "a.json"].iter().all(|n| Path::new(&folder.at(n)).is_symlink()));
        let far = gi_tests::program::files(Path::new(&folder.at("far")));
        assert_eq!(far, ["a.exr", "b.png", "c.json"]);
    }
}

#[test]
fn inspect_describes_the_scene_and_writes_nothing() {
    let folder = scene_folder();
    let before = contents(&folder);
    for program in PROGRAMS {
        let program = path_of(program);
        let output = run(program.to_str().expect("UTF-8"), &[&folder.at("scene.xml"), "--inspect"]);
        assert_success(&output);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        for part in [
            "scene.xml: 5 files",
            "shapes     1: 1 mesh; 1 triangles",
            "lights     1: 1 environment",
            "Approximated or ignored",
            "Suspicious",
            "Suggestion",
        ] {
            assert!(text.contains(part), "no {part}: {text}");
        }
    }
    assert!(contents(&folder) == before, "--inspect changed a file");
    let pathtrace = path_of("pathtrace");
    let pathtrace = pathtrace.to_str().expect("UTF-8");
    let missing = run(pathtrace, &[&folder.at("none.xml"), "--inspect"]);
    assert_refused(&missing, 2, &["none.xml"]);
    let dark = run(pathtrace, &[&folder.at("mesh.obj"), "--inspect"]);
    assert!(String::from_utf8_lossy(&dark.stdout).contains("--light sky"));
}

#[test]
fn a_file_without_light_is_black_with_advice_and_lit_with_an_added_light() {
    let folder = scene_folder();
    let (mesh, out) = (folder.at("mesh.obj"), folder.at("out.pfm"));
    let render = |light: &[&str]| {
        let mut line = vec![mesh.as_str(), "-o", out.as_str(), "--size", "8x8", "--spp", "4"];
        line.extend(light);
        let output = run(path_of("pathtrace").to_str().expect("UTF-8"), &line);
        assert_success(&output);
        let picture = std::fs::read(&out).expect("a picture");
        let brightest = picture[picture.len() - 8 * 8 * 12..].chunks_exact(4);
        let numbers = brightest.map(|b| f32::from_le_bytes(b.try_into().expect("four bytes")));
        (gi_tests::program::said(&output), numbers.fold(0.0, f32::max))
    };
    let (said, brightest) = render(&[]);
    assert!(said.contains("--light sky or --light studio or --light headlight"), "{said}");
    assert!(brightest == 0.0);
    for light in ["sky", "studio", "headlight"] {
        let (said, brightest) = render(&["--light", light]);
        assert!(!said.contains("nothing shines"), "{said}");
        assert!((0.05..5.0).contains(&brightest), "{light}: {brightest}");
    }
    let output = run(path_of("pathtrace").to_str().expect("UTF-8"), &[&mesh, "--light", "moon"]);
    assert_refused(&output, 2, &["expected sky, studio, headlight"]);
}
