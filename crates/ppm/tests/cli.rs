//! Runs the program as a user would: checkpoints, traces, messages, exit status.

use std::path::Path;
use std::process::Output;

use gi_core::image_io::{Layers, read_exr};
use gi_tests::program::{self, Folder, assert_refused, assert_success, said, scene};

/// Run the program on a small picture of the scene with balls.
fn run(folder: &Folder, name: &str, flags: &[&str]) -> Output {
    let (scene, out) = (scene("cornell-spheres"), folder.at(name));
    let small = [&scene, "-o", &out, "--size", "24x20", "-q"];
    program::run(env!("CARGO_BIN_EXE_ppm"), &[&small, flags].concat())
}

/// The layers of the picture that a run writes.
fn picture(folder: &Folder, name: &str, flags: &[&str]) -> Layers {
    assert_success(&run(folder, name, flags));
    read_exr(Path::new(&folder.at(name))).expect("an EXR")
}

/// Expect a run to be refused as bad input, with these words, and to write no file.
fn refuse(folder: &Folder, flags: &[&str], says: &[&str]) {
    let before = folder.files();
    assert_refused(&run(folder, "refused.exr", flags), 2, says);
    assert_eq!(folder.files(), before, "{flags:?} left a file");
}

fn bits(layers: &Layers) -> Vec<(String, Vec<u32>)> {
    let channels = layers.channels.iter();
    channels.map(|(n, v)| (n.clone(), v.iter().map(|x| x.to_bits()).collect())).collect()
}

#[test]
fn a_resumed_run_equals_an_uninterrupted_one_bit_for_bit() {
    for method in ["ppm", "sppm", "ppa", "adaptive"] {
        let folder = Folder::make();
        let (kept, csv, whole_csv) =
            (folder.at("kept"), folder.at("t.csv"), folder.at("whole.csv"));
        let common = ["--method", method, "--photons", "700", "--trace-pixel", "9,12"];
        let render = |name: &str, csv: &str, flags: &[&str]| {
            let maps = ["--show", "radius", "--show", "photons", "--trace-out", csv];
            picture(&folder, name, &[&common, &maps[..], flags].concat())
        };
        let whole = render("whole.exr", &whole_csv, &["-t", "1", "--passes", "7"]);
        let keep = ["--checkpoint", kept.as_str(), "-t", "2", "--passes"];
        render("half.exr", &csv, &[&keep[..], &["3"]].concat());
        let resumed = render("resumed.exr", &csv, &[&keep[..], &["7", "--resume"]].concat());
        assert!(bits(&whole) == bits(&resumed), "{method}");
        let read = |path: &str| std::fs::read_to_string(path).expect("a trace");
        assert_eq!(read(&csv), read(&whole_csv), "{method}");
        assert_eq!(read(&csv).lines().count(), 1 + 7);
        // All passes are done already, so the picture must be the same.
        let again = render("again.exr", &csv, &[&keep[..], &["7", "--resume"]].concat());
        assert!(bits(&again) == bits(&whole), "{method}");
    }
}

#[test]
fn ranges_of_probabilistic_passes_merge_to_the_picture_of_one_run() {
    let folder = Folder::make();
    let ppa = ["--method", "ppa", "--photons", "700"];
    let whole = picture(&folder, "whole.exr", &[&ppa[..], &["--passes", "5"]].concat());
    let [a, b] = ["a", "b"].map(|name| folder.at(name));
    for (first, passes, file) in [("0", "2", &a), ("2", "3", &b)] {
        let flags = ["--first-pass", first, "--passes", passes, "--checkpoint", file];
        picture(&folder, "part.exr", &[&ppa[..], &flags].concat());
    }
    let merged = picture(&folder, "m.exr", &[&ppa[..], &["--merge", &a, "--merge", &b]].concat());
    assert!(bits(&merged) == bits(&whole));
    refuse(&folder, &[&ppa[..], &["--merge", &a, "--merge", &a]].concat(), &["0 to 1", "another"]);
    refuse(&folder, &["--first-pass", "3"], &["build on each other"]);
}

#[test]
fn checkpoints_of_another_run_are_refused_with_the_cause() {
    let folder = Folder::make();
    let kept = folder.at("kept");
    let keep = ["--passes", "1", "--checkpoint", kept.as_str()];
    let resume = [&keep[..], &["--resume"]].concat();
    refuse(&folder, &resume, &["cannot read", "kept"]);
    refuse(&folder, &["--resume"], &["--checkpoint"]);
    picture(&folder, "p.exr", &keep);
    let refuses = |flags: &[&str], says: &[&str]| {
        refuse(&folder, &[&resume[..], flags].concat(), says);
    };
    refuses(&["--seed", "5"], &["seed", "5"]);
    refuses(&["--alpha", "0.5"], &["another --alpha: 0.7, not 0.5"]);
    refuses(&["--method", "ppa"], &["another --method: sppm, not ppa"]);
    refuses(&["--size", "25x20"], &["another picture size: 24 x 20, not 25 x 20"]);
    refuses(&["--component", "caustic"], &["component"]);
    refuses(&["--stop-at-error", "0.1"], &["estimates its error", "--stop-at-error"]);
    let bytes = std::fs::read(&kept).expect("the checkpoint");
    for n in [0, 10, 100, bytes.len() / 2, bytes.len() - 1] {
        std::fs::write(&kept, &bytes[..n]).expect("written");
        refuses(&[], &["cannot use", "kept"]);
    }
    // Whichever byte is wrong, even in a length, there must be no panic and no huge allocation.
    for k in (0..2500).step_by(41) {
        let mut damaged = bytes.clone();
        damaged[k] ^= 0xff;
        std::fs::write(&kept, damaged).expect("written");
        let output = run(&folder, "damaged.exr", &resume);
        let text = said(&output);
        assert!(matches!(output.status.code(), Some(0 | 2)), "byte {k}: {text}");
        assert!(!text.contains("panicked"), "byte {k}: {text}");
    }
}

#[test]
fn options_that_make_no_sense_are_refused() {
    let folder = Folder::make();
    refuse(&folder, &["--alpha", "0"], &["--alpha"]);
    refuse(&folder, &["--alpha", "nan"], &["--alpha"]);
    refuse(&folder, &["--initial-radius=-0.1"], &["--initial-radius"]);
    refuse(&folder, &["--initial-photons", "0"], &["initial-photons"]);
    refuse(&folder, &["--method", "sspm"], &["sppm"]);
    refuse(&folder, &["--trace-pixel", "3,4"], &["--trace-out"]);
    let csv = folder.at("t.csv");
    refuse(&folder, &["--trace-pixel", "24,0", "--trace-out", &csv], &["24 x 20"]);
    refuse(&folder, &["--trace-pixel", "x", "--trace-out", &csv], &["X,Y"]);
}

#[test]
fn a_run_ends_when_its_estimated_error_is_small_enough() {
    let folder = Folder::make();
    let stats = folder.at("s.json");
    let stop = ["--stop-at-error", "0.2", "--passes", "2000", "--show", "error"];
    let layers = picture(&folder, "p.exr", &[&stop[..], &["--stats", &stats]].concat());
    assert!(layers.channel("Error.Noise").is_some() && layers.channel("Error.Bias").is_some());
    let passes = layers.metadata.iter().find(|(n, _)| n == "gi.passes").expect("passes");
    let passes: u32 = passes.1.parse().expect("a number");
    assert!((3..2000).contains(&passes), "{passes} passes");
    assert!(Path::new(&folder.at("p.error.png")).exists());
    assert!(std::fs::read_to_string(stats).expect("statistics").contains("error_estimate"));
}
