//! The program run as a user runs it: its own flags and files.

use std::path::Path;
use std::process::{Command, Output};

use gi_core::image_io::read_exr;

fn run(arguments: &[&str]) -> Output {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/cornell-box.xml");
    let all = [&[scene, "--size", "24x24", "--spp", "2", "-q"], arguments].concat();
    Command::new(env!("CARGO_BIN_EXE_instant-radiosity")).args(all).output().expect("it runs")
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_run_leaves_its_pictures_and_its_lights() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_string();
    let (out, csv, ply) = (at("a.exr"), at("a.csv"), at("b.ply"));
    let flags =
        ["--vpls", "50", "--direct", "vpl", "--show", "vpls,connections", "--pixel", "12,20"];
    let output = run(&[&["-o", &out, "--vpls-out", &csv][..], &flags].concat());
    assert!(output.status.success(), "{}", text(&output));
    let layers = read_exr(Path::new(&out)).expect("an EXR");
    assert!(layers.channel("Vpls.R").is_some() && layers.channel("Connections.G").is_some());
    assert!(Path::new(&at("a.vpls.png")).exists() && Path::new(&at("a.connections.png")).exists());
    let table = std::fs::read_to_string(csv).expect("a table");
    let of_depth =
        |d: &str| table.lines().filter(|l| l.ends_with(&format!(",{d},oriented"))).count();
    assert!(of_depth("0") > 5 && of_depth("1") > 5, "points of lights and of surfaces:\n{table}");
    let output =
        run(&["-o", &at("b.exr"), "--vpls-out", &ply, "--vsl", "--termination", "fractional"]);
    assert!(output.status.success(), "{}", text(&output));
    assert!(std::fs::read(ply).expect("a point cloud").starts_with(b"ply\n"));
}

#[test]
fn wrong_flags_are_one_clear_error_and_status_2() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("a.exr");
    let out = out.to_str().expect("UTF-8");
    let cases: [(&[&str], &str); 7] = [
        (&["--clamp", "0"], "above 0"),
        (&["--clamp", "nan"], "above 0"),
        (&["--vpls", "0"], "1.."),
        (&["--relaxation=-1"], "from 0 to 2"),
        (&["--pixel", "3"], "X,Y"),
        (&["--vpls-out", out], "overwrite"),
        (&["--vpls-out", "lights.txt"], ".ply or .csv"),
    ];
    for (flags, says) in cases {
        let output = run(&[&["-o", out], flags].concat());
        let text = text(&output);
        assert_eq!(output.status.code(), Some(2), "{says}: {text}");
        assert!(text.contains(says) && !text.contains("panicked"), "\"{says}\" is not in:\n{text}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 0);
}
