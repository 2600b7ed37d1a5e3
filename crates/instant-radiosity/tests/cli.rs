//! Runs the program as a user would: its own flags and files.

use std::path::Path;
use std::process::Output;

use gi_core::image_io::read_exr;
use gi_tests::program::{self, Folder, assert_refused, assert_success, scene};

fn run(arguments: &[&str]) -> Output {
    let small = [&scene("cornell-box"), "--size", "24x24", "--spp", "2", "-q"];
    program::run(env!("CARGO_BIN_EXE_instant-radiosity"), &[&small, arguments].concat())
}

#[test]
fn a_run_writes_its_pictures_and_its_lights() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let (out, csv, ply) = (at("a.exr"), at("a.csv"), at("b.ply"));
    let flags =
        ["--vpls", "50", "--direct", "vpl", "--show", "vpls,connections", "--pixel", "12,20"];
    let output = run(&[&["-o", &out, "--vpls-out", &csv][..], &flags].concat());
    assert_success(&output);
    let layers = read_exr(Path::new(&out)).expect("an EXR");
    assert!(layers.channel("Vpls.R").is_some() && layers.channel("Connections.G").is_some());
    assert!(Path::new(&at("a.vpls.png")).exists() && Path::new(&at("a.connections.png")).exists());
    let table = std::fs::read_to_string(csv).expect("a table");
    let of_depth =
        |d: &str| table.lines().filter(|l| l.ends_with(&format!(",{d},oriented"))).count();
    assert!(of_depth("0") > 5 && of_depth("1") > 5, "points of lights and of surfaces:\n{table}");
    let output =
        run(&["-o", &at("b.exr"), "--vpls-out", &ply, "--vsl", "--termination", "fractional"]);
    assert_success(&output);
    assert!(std::fs::read(ply).expect("a point cloud").starts_with(b"ply\n"));
}

#[test]
fn a_picture_without_the_light_of_virtual_lights_creates_none() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let stats = at("run.json");
    let run_with = |out: &str, flags: &[&str]| {
        assert_success(&run(&[&["-o", out, "--stats", &stats][..], flags].concat()));
        std::fs::read_to_string(&stats).expect("statistics").contains("\"vpls\": 0.0")
    };
    let (all, alone) = (at("all.exr"), at("alone.exr"));
    assert!(
        !run_with(&all, &[])
            && !run_with(&at("vpl.exr"), &["--direct", "vpl", "--component", "direct"])
    );
    for (component, layer) in [("direct", "Direct.R"), ("caustic", "Caustic.R")] {
        assert!(run_with(&alone, &["--component", component]), "{component}");
        let channel = |path: &str| {
            let layers = read_exr(Path::new(path)).expect("an EXR");
            layers.channel(layer).expect("a layer").to_vec()
        };
        assert_eq!(channel(&all), channel(&alone), "{component}");
        assert!(run_with(&alone, &["--component", component, "--vsl"]), "{component}");
    }
}

#[test]
fn wrong_flags_are_one_clear_error_and_status_2() {
    let folder = Folder::make();
    let (out, csv) = (&folder.at("a.exr"), &folder.at("a.csv"));
    let cases: [(&[&str], &str); 7] = [
        (&["--clamp", "0"], "above 0"),
        (&["--clamp", "nan"], "above 0"),
        (&["--vpls", "0"], "1.."),
        (&["--relaxation=-1"], "from 0 to 2"),
        (&["--pixel", "3"], "X,Y"),
        (&["--stats", csv, "--vpls-out", csv], "overwrite"),
        (&["--vpls-out", "lights.txt"], ".ply or .csv"),
    ];
    for (flags, says) in cases {
        assert_refused(&run(&[&["-o", out], flags].concat()), 2, &[says]);
    }
    assert_eq!(folder.files().len(), 0);
}
