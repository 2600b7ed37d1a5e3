//! Runs the program as a user would: messages, exit status, files.

use std::path::Path;
use std::process::Output;

use gi_core::image_io::read_exr;
use gi_tests::program::{self, Folder, assert_refused, assert_success, said, scene};

/// Run the program.
fn run(arguments: &[&str]) -> Output {
    program::run(env!("CARGO_BIN_EXE_pathtrace"), arguments)
}

/// Expect one clear error, the given exit status, and no new files in the folder.
fn assert_nothing_made(
    output: &Output,
    status: i32,
    says: &[&str],
    folder: &Folder,
    files_before: usize,
) {
    assert_refused(output, status, says);
    assert_eq!(folder.files().len(), files_before, "a file was left half-written");
}

#[test]
fn a_run_writes_a_picture_its_view_and_its_statistics() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let (out, stats) = (at("a.exr"), at("a.json"));
    let output = run(&[
        &scene("cornell-box"),
        "-o",
        &out,
        "--spp",
        "2",
        "--size",
        "24x16",
        "--stats",
        &stats,
        "-t",
        "1",
    ]);
    assert_success(&output);
    let layers = read_exr(Path::new(&out)).expect("an EXR");
    assert_eq!((layers.width, layers.height), (24, 16));
    for name in ["R", "Variance.G", "Direct.B", "Indirect.R", "Caustic.R", "Albedo.R", "N.X", "Z"] {
        assert!(layers.channel(name).is_some(), "no layer {name}");
    }
    assert!(
        layers.metadata.iter().any(|(n, v)| n == "gi.passes" && v == "2"),
        "{:?}",
        layers.metadata
    );
    assert!(Path::new(&at("a.png")).exists());
    let stats = std::fs::read_to_string(stats).expect("statistics");
    assert!(stats.contains("\"passes\": 2") && stats.contains("mean_radiance"), "{stats}");
    assert_eq!(folder.files().len(), 3);
}

#[test]
fn damaged_input_gives_one_clear_error_and_status_2() {
    let folder = Folder::make();
    let out = &folder.at("a.exr");
    let write = |name: &str, text: &str| {
        let path = folder.at(name);
        std::fs::write(&path, text).expect("written");
        path
    };
    let camera = "<sensor type=\"perspective\"/>";
    let shape =
        |body: &str| format!("<scene version=\"3.0.0\">{camera}<shape {body}</shape></scene>");
    let cut = write("cut.xml", "<scene version=\"3.0.0\"><shape type=\"sphere\">");
    let missing = write(
        "missing.xml",
        &shape("type=\"obj\"><string name=\"filename\" value=\"nowhere.obj\"/>"),
    );
    let nan = "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n";
    write("nan.obj", nan);
    let nan =
        write("nan.xml", &shape("type=\"obj\"><string name=\"filename\" value=\"nan.obj\"/>"));
    let unknown = write("unknown.xml", &shape("type=\"sphere\"><bsdf type=\"difuse\"/>"));
    let before = folder.files().len();
    let cases: [(&str, &[&str]); 5] = [
        (&cut, &["cut.xml"]),
        (&missing, &["nowhere.obj"]),
        (&nan, &["nan.obj"]),
        (&unknown, &["difuse", "diffuse", "unknown.xml:1"]),
        ("there-is-no-such.xml", &["there-is-no-such.xml"]),
    ];
    for (scene, says) in cases {
        assert_nothing_made(&run(&[scene, "-o", out]), 2, says, &folder, before);
    }
    let usage: [&[&str]; 10] = [
        &["--size", "32768x32768"],
        &["-t", "60000"],
        &["-D", "gi.pathtrace.size=8x8"],
        &["-D", "gi.pathtrace.mode=sideways"],
        &["--spp", "0"],
        &["--size", "12"],
        &["--max-depth", "0"],
        &["--nonsense"],
        &["--time", "1s", "--spp", "2"],
        &["-D", "x"],
    ];
    for flags in usage {
        let cornell = scene("cornell-box");
        let arguments = [&[cornell.as_str(), "-o", out], flags].concat();
        assert_nothing_made(&run(&arguments), 2, &["error"], &folder, before);
    }
    let arguments = [&scene("cornell-box"), "-o", &folder.at("a.txt")];
    assert_nothing_made(&run(&arguments), 2, &[".exr"], &folder, before);
}

#[test]
fn an_output_that_cannot_be_written_gives_status_1_before_any_work() {
    let folder = Folder::make();
    let out = folder.at("no/such/folder/a.exr");
    let arguments = [&scene("cornell-box"), "-o", &out, "--spp", "100000"];
    assert_nothing_made(&run(&arguments), 1, &["cannot write", "a.exr"], &folder, 0);
}

#[test]
fn presets_of_a_scene_are_defaults_that_flags_override() {
    let folder = Folder::make();
    let path = folder.at("preset.xml");
    let xml = std::fs::read_to_string(scene("cornell-box")).expect("the scene");
    let preset = "<default name=\"gi.pathtrace.rr_depth\" value=\"3\"/><default name=\"gi.pathtrace.mode\" value=\"light\"/>";
    let meshes = format!("{}/../../scenes/meshes/", env!("CARGO_MANIFEST_DIR"));
    let xml =
        xml.replacen("<integrator", &format!("{preset}<integrator"), 1).replace("meshes/", &meshes);
    std::fs::write(&path, xml).expect("written");
    let stats_of = |extra: &[&str]| {
        let (stats, out) = (folder.at("s.json"), folder.at("p.exr"));
        let small = [&path, "-o", &out, "--spp", "1", "--size", "8x8", "--stats", &stats];
        let arguments = [&small, extra].concat();
        let output = run(&arguments);
        assert_success(&output);
        std::fs::read_to_string(stats).expect("statistics")
    };
    assert!(stats_of(&[]).contains("light_paths"), "the preset chooses the mode");
    assert!(
        !stats_of(&["--mode", "path"]).contains("light_paths"),
        "the flag overrides the preset"
    );
    assert!(stats_of(&["-D", "gi.pathtrace.spp=3"]).contains("\"passes\": 1"), "--spp 1 was typed");
    assert!(
        !stats_of(&["-D", "gi.pathtrace.mode=path"]).contains("light_paths"),
        "-D overrides the preset"
    );
}

#[test]
fn a_preset_number_of_passes_gives_way_to_a_typed_time() {
    let folder = Folder::make();
    let out = &folder.at("p.exr");
    let cornell = scene("cornell-box");
    let budget = ["--time", "50ms", "-D", "gi.pathtrace.spp=1000000", "--size", "8x8"];
    let output = run(&[&[cornell.as_str(), "-o", out], &budget[..]].concat());
    assert_success(&output);
}

#[test]
fn checkpoints_of_a_scene_with_its_own_number_of_passes_can_be_merged() {
    let folder = Folder::make();
    let (out, kept, cornell) = (folder.at("p.exr"), folder.at("kept"), scene("cornell-box"));
    let with = |size: &str, more: &[&str]| {
        let flags = ["-o", &out, "-D", "gi.pathtrace.spp=2", "--size", size];
        run(&[&[cornell.as_str()], &flags[..], more].concat())
    };
    assert_success(&with("8x8", &["--checkpoint", &kept]));
    assert_success(&with("8x8", &["--merge", &kept]));
    let output = with("8x16", &["--merge", &kept]);
    assert_refused(&output, 2, &["another picture size: 8 x 8, not 8 x 16"]);
    assert!(!said(&output).contains("Camera {"), "{}", said(&output));
}

#[cfg(unix)]
#[test]
fn an_export_overwrites_no_file_of_the_scene_through_a_link() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let texture = gi_core::image_io::Layers::of_rgb([1, 1], [[0.5; 3]]);
    let picture = at("texture.pfm");
    gi_core::image_io::write_file(Path::new(&picture), gi_core::image_io::ImageFile::Pfm, &texture)
        .expect("written");
    let before = std::fs::read(&picture).expect("a picture");
    std::fs::write(
        at("o.obj"),
        "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n",
    )
    .expect("written");
    std::fs::write(at("m.mtl"), "newmtl a\nKd 0.5 0.5 0.5\nmap_Kd texture.pfm\n").expect("written");
    let export = || run(&[&at("o.obj"), "--export-mitsuba", &at("out.xml")]);
    assert_success(&export());
    // Every file of the export becomes a link to the texture.
    for name in program::files(Path::new(&at("out-files"))) {
        let path = at(&format!("out-files/{name}"));
        std::fs::remove_file(&path).expect("removed");
        std::os::unix::fs::symlink("../texture.pfm", &path).expect("a link");
    }
    let output = export();
    assert!(!output.status.success());
    assert!(said(&output).contains("part of the scene"), "{}", said(&output));
    assert_eq!(std::fs::read(&picture).expect("a picture"), before);
}

#[test]
fn statistics_do_not_overwrite_the_picture() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    for stats in [at("p.exr"), at("p.png")] {
        let output =
            run(&[&scene("cornell-box"), "-o", &at("p.exr"), "--stats", &stats, "--spp", "1"]);
        assert_nothing_made(&output, 2, &["overwrite"], &folder, 0);
    }
}

#[test]
fn an_exported_scene_is_read_again_and_gives_the_same_picture() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let export = run(&[&scene("cornell-glossy"), "--export-mitsuba", &at("clean.xml")]);
    assert_success(&export);
    let render = |scene: &str, out: &str| {
        let output = run(&[scene, "-o", out, "--spp", "4", "--size", "16x16", "-q"]);
        assert_success(&output);
        read_exr(Path::new(out)).expect("an EXR")
    };
    let (first, second) =
        (render(&scene("cornell-glossy"), &at("a.exr")), render(&at("clean.xml"), &at("b.exr")));
    assert_eq!(first.channel("R"), second.channel("R"));
    assert!(!Path::new(&at("clean.exr")).exists(), "an export renders nothing");
}

#[test]
fn a_resumed_run_equals_an_uninterrupted_one_bit_for_bit() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let (scene, kept) = (scene("cornell-spheres"), at("kept"));
    for mode in ["path", "light"] {
        let render = |name: &str, flags: &[&str]| {
            let out = at(name);
            let common = [scene.as_str(), "-o", &out, "--size", "20x12", "-q", "--mode", mode];
            let output = run(&[&common, flags].concat());
            assert_success(&output);
            read_exr(Path::new(&out)).expect("an EXR").channels
        };
        let whole = render("whole.exr", &["--spp", "9"]);
        let keep = ["--checkpoint", kept.as_str(), "--spp"];
        render("half.exr", &[&keep[..], &["4"]].concat());
        let resumed = render("resumed.exr", &[&keep[..], &["9", "--resume"]].concat());
        assert!(whole == resumed, "{mode}");
    }
}

#[test]
fn volpath_renders_media_and_path_says_that_it_ignores_them() {
    let folder = Folder::make();
    let out = &folder.at("a.exr");
    let with = |mode: &str| {
        let run = run(&[&scene("fog"), "-o", out, "--spp=1", "--size=8x8", "--mode", mode]);
        assert_success(&run);
        said(&run)
    };
    assert!(with("path").contains("participating media are left out"));
    assert!(!with("volpath").contains("warning"), "{}", with("volpath"));
}

#[test]
fn the_scenes_max_depth_is_reported_unless_the_flag_was_given() {
    let folder = Folder::make();
    let (path, out) = (folder.at("a.xml"), folder.at("a.exr"));
    let xml = "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='7'/></integrator>\
               <sensor type='perspective'/><emitter type='constant'/></scene>";
    std::fs::write(&path, xml).expect("written");
    let with = |flags: &[&str]| {
        let run = run(&[&[path.as_str(), "-o", &out, "--spp=1", "--size=8x8"], flags].concat());
        assert_success(&run);
        said(&run)
    };
    assert!(with(&[]).contains("`max_depth` 7 is ignored: give `--max-depth 7`"), "{}", with(&[]));
    for typed in [["--max-depth", "7"], ["--max-depth", "-1"], ["--max-depth=3", "-q"]] {
        assert!(!with(&typed).contains("max_depth"), "{typed:?}");
    }
}

#[test]
fn passes_beyond_the_largest_number_are_refused_and_leave_no_black_picture() {
    let folder = Folder::make();
    let (scene, out) = (scene("cornell-box"), folder.at("a.exr"));
    for (first, passes) in [("4294967295", "1"), ("4294967290", "5")] {
        let flags = ["-o", &out, "--size", "8x8", "--first-pass", first, "--spp", passes];
        let output = run(&[&[scene.as_str()], &flags[..]].concat());
        assert_nothing_made(&output, 2, &["--first-pass", "4294967293"], &folder, 0);
    }
    let flags = ["-o", &out, "--size", "8x8", "--first-pass", "4294967290", "--spp", "4"];
    assert_success(&run(&[&[scene.as_str()], &flags[..]].concat()));
}
