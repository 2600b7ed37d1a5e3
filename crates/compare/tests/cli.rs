//! Runs the program as a user would: runs and finished pictures, tables and JSON, and the input that it refuses.

// No test file uses all shared functions.
#[allow(dead_code)]
mod common;

use std::path::Path;

use common::{build_programs, run, save, save_rgb};
use gi_core::image_io::read_exr;
use gi_tests::program::{Folder, assert_refused, assert_success, scene};
use serde_json::Value;

fn json(path: &str) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("a file")).expect("JSON")
}

/// The radiance in a file.
fn rgb(path: &str) -> Vec<f32> {
    let layers = read_exr(Path::new(path)).expect("an EXR");
    layers.interleaved(["R", "G", "B"]).expect("its channels")
}

/// Check that the numbers are those of the pictures that the runs wrote to the folder `out`.
fn assert_errors_are_those_of_the_pictures(entries: &[Value], out: &str) {
    let hash = entries[0]["command"].as_str().map(|_| json(&format!("{out}/pathtrace.json")));
    let hash = hash.expect("a command")["scene_hash"].as_str().expect("a hash").to_string();
    let halves = ["a", "b"].map(|half| rgb(&format!("{out}/reference-{hash}-16x12.{half}.exr")));
    let truth: Vec<f32> = halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (a + b)).collect();
    for (entry, file) in entries.iter().zip(["pathtrace", "photonmap", "photonmap-none"]) {
        let metrics = gi_stats::metrics::compare(&rgb(&format!("{out}/{file}.exr")), &truth)
            .expect("comparable");
        let mse = entry["errors"]["mse"].as_f64().expect("a number");
        assert!((mse / metrics.mse - 1.0).abs() < 1e-6, "{file}: {mse} is not {}", metrics.mse);
        assert_eq!(entry["run"]["passes"], 4);
        assert_eq!(entry["ladder"].as_array().map(Vec::len), Some(3));
        assert!(entry["split"]["variance"].as_f64().is_some_and(|v| v > 0.0));
    }
}

#[test]
fn runs_at_equal_passes_are_measured_against_a_reference_that_is_kept() {
    build_programs();
    let folder = Folder::make();
    let (out, numbers) = (folder.at("out"), folder.at("numbers.json"));
    let scene = scene("cornell-box");
    let flags = [
        &scene,
        "--size",
        "16x12",
        "--spp",
        "4",
        "--techniques",
        "pathtrace,photonmap",
        "--with",
        "photonmap: --photons 2000 --gather-rays 2",
        "--with",
        "photonmap/none: --gather none",
        "--seeds",
        "3",
        "--ladder",
        "3",
        "--reference-spp",
        "16",
        "-o",
        &out,
        "--json",
        &numbers,
    ];
    let first = run(&flags);
    assert_success(&first);
    let found = json(&numbers);
    let entries = found["entries"].as_array().expect("entries");
    let labels: Vec<&str> = entries.iter().filter_map(|e| e["label"].as_str()).collect();
    assert_eq!(labels, ["pathtrace", "photonmap", "photonmap/none"]);

    assert_errors_are_those_of_the_pictures(entries, &out);
    assert!(
        entries[1]["command"]
            .as_str()
            .is_some_and(|c| c.contains("--gather-rays 2 --spp 4 --seed 0"))
    );
    let page = std::fs::read_to_string(format!("{out}/index.html")).expect("a page");
    assert!(page.contains("photonmap/none") && !page.contains("{{"));

    // The second time, the reference is reused; with more passes it is made again.
    let noted = |numbers: &str| json(numbers)["reference"]["notes"].to_string();
    assert!(!noted(&numbers).contains("kept"));
    assert_success(&run(&flags));
    assert!(noted(&numbers).contains("kept"));
    let more: Vec<&str> = flags.iter().map(|f| if *f == "16" { "32" } else { *f }).collect();
    assert_success(&run(&more));
    assert!(!noted(&numbers).contains("kept"));
}

#[test]
fn finished_pictures_of_any_program_are_compared_and_broken_pixels_counted() {
    let folder = Folder::make();
    let path = |name: &str| folder.at(name);
    let truth = |i: usize| [0.1 + i as f32 * 0.01, 0.5, 0.2];
    save_rgb(&path("truth.exr"), [8, 6], &truth);
    let off = |i: usize, k: usize| if i == 7 && k == 1 { f32::NAN } else { truth(i)[k] + 0.5 };
    save_rgb(&path("broken.exr"), [8, 6], &|i| [off(i, 0), off(i, 1), off(i, 2)]);
    save(
        &path("other.exr"),
        [8, 6],
        &[("View.R", &|i| truth(i)[0]), ("View.G", &|i| truth(i)[1]), ("View.B", &|i| truth(i)[2])],
    );
    let output = run(&[
        &path("broken.exr"),
        &path("other.exr"),
        "--reference",
        &path("truth.exr"),
        "-o",
        &path("out"),
        "--json",
        &path("n.json"),
    ]);
    assert_success(&output);
    let entries = json(&path("n.json"))["entries"].clone();
    let mse = entries[0]["errors"]["mse"].as_f64().expect("a number");
    assert!((mse - 0.25).abs() < 1e-6, "{mse}");
    assert_eq!(entries[0]["errors"]["pixels_left_out"], 1);
    assert!(entries[0]["notes"].to_string().contains("no error counts: 1"));
    assert_eq!(entries[1]["errors"]["mse"], 0.0);
    assert!(entries[1]["notes"].to_string().contains("layer View is used"));
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(table.contains("relMSE") && table.contains("broken  "), "{table}");
    assert!(table.contains("not finite"), "{table}");
}

#[test]
fn invalid_input_is_refused_and_nothing_is_written() {
    build_programs();
    let folder = Folder::make();
    let path = |name: &str| folder.at(name);
    save_rgb(&path("a.exr"), [8, 6], &|_| [1.0; 3]);
    save_rgb(&path("small.exr"), [4, 6], &|_| [1.0; 3]);
    save(&path("depth.exr"), [8, 6], &[("Z", &|_| 1.0)]);
    save_rgb(&path("nan.exr"), [8, 6], &|_| [f32::NAN; 3]);
    std::fs::write(path("no.exr"), "no picture").expect("it is written");
    let (a, small, depth, nan, no) =
        (path("a.exr"), path("small.exr"), path("depth.exr"), path("nan.exr"), path("no.exr"));
    let scene = scene("cornell-box");
    let layer = format!("{a}#Caustic");
    let page = path("out/index.html");
    let nowhere = path("nowhere");
    let view = path("a.png");
    let cases: [(&[&str], &[&str]); 19] = [
        (&[&view, "--reference", &a], &["a.png is a display image", ".exr"]),
        (&[&a, "--reference", &a, "--json", &page], &["--json", "would overwrite"]),
        (&[&a, "--reference", &small, "--json", &small], &["small.exr would overwrite"]),
        (&[&scene, "--reference", &a, "--json", &scene], &["cornell-box.xml would overwrite"]),
        (&[&scene, "--programs", &nowhere], &["no technique's program", "nowhere", "--programs"]),
        (&[&small, "--reference", &a], &["4 x 6", "8 x 6", "--size"]),
        (&[&a, "--reference", &depth], &["depth.exr", "no channels R, G, B", "Z"]),
        (&[&layer, "--reference", &a], &["no layer Caustic"]),
        (&[&nan, "--reference", &a], &["nan", "no pixel is finite"]),
        (&[&no, "--reference", &a], &["cannot use", "no.exr"]),
        (&[&a], &["need --reference"]),
        (&[&a, "--reference", &path("none.exr")], &["none.exr"]),
        (&[&a, "--reference", &a, "--seeds", "2"], &["--seeds", "finished pictures"]),
        (&[&a, &scene], &["one scene, or only finished pictures"]),
        (&["nowhere.xml"], &["nowhere.xml", "no such file"]),
        (
            &[&scene, "--techniques", "pathtrase"],
            &["no program pathtrase", "cargo build --release", "pathtrace"],
        ),
        (
            &[&scene, "--techniques", "pathtrace", "--with", "pathtrace/b: --bogus 1"],
            &["pathtrace/b", "--bogus"],
        ),
        (&[&scene, "--techniques", "pathtrace", "--size", "0x3"], &["pathtrace", "--size"]),
        (&[&scene, "--techniques", "pathtrace", "--seed", "2119655149"], &["--seed", "reference"]),
    ];
    let before = folder.files().len();
    for (flags, says) in cases {
        let out = path("out");
        let output = run(&[flags, &["-o", &out]].concat());
        assert_refused(&output, 2, says);
        assert!(!Path::new(&out).exists(), "{flags:?}");
        assert_eq!(folder.files().len(), before, "{flags:?}");
    }
}

#[test]
fn a_run_that_shares_the_references_noise_is_reported() {
    build_programs();
    let folder = Folder::make();
    let (out, truth) = (folder.at("out"), folder.at("out/pathtrace.exr"));
    let scene = scene("cornell-box");
    let flags = [&scene, "--size", "8x8", "--spp", "2", "--techniques", "pathtrace", "-o", &out];
    assert_success(&run(&[&flags[..], &["--reference-spp", "2"]].concat()));
    for subject in [&flags[..], &[&truth, "-o", &out]] {
        let output = run(&[subject, &["--reference", &truth]].concat());
        let table = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(table.contains("share their noise"), "{table}");
        // Finished pictures from our programs contain their number of passes.
        let row: Vec<&str> = table.lines().nth(1).expect("a row").split_whitespace().collect();
        assert_eq!(row[..2], ["pathtrace", "2"], "{table}");
    }
}
