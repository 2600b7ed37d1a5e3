//! Runs the program as a user would: its own flags and files.

use std::path::Path;
use std::process::Output;

use gi_core::image_io::read_exr;
use gi_tests::program::{self, Folder, assert_refused, assert_success, scene};

const PROGRAM: &str = env!("CARGO_BIN_EXE_irrcache");

fn run(arguments: &[&str]) -> Output {
    let small = [&scene("cornell-box"), "--size", "24x24", "--rays", "50", "--spp", "1", "-q"];
    program::run(PROGRAM, &[&small, arguments].concat())
}

#[test]
fn a_run_writes_its_pictures_its_cache_and_its_records() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let show = "records,validity,octree,octree-slice,weights";
    let (out, cache, ply, csv) = (at("a.exr"), at("a.cache"), at("a.ply"), at("a.csv"));
    let output = run(&[
        "-o",
        &out,
        "--show",
        show,
        "--cache-out",
        &cache,
        "--records-out",
        &ply,
        "--error",
        "bounded",
    ]);
    assert_success(&output);
    let mut expected = [
        "a.cache",
        "a.exr",
        "a.octree-slice.png",
        "a.octree.png",
        "a.ply",
        "a.png",
        "a.records.png",
        "a.validity.png",
        "a.weights.png",
    ];
    expected.sort_unstable();
    assert_eq!(folder.files(), expected);
    let layers = read_exr(Path::new(&out)).expect("an EXR");
    for name in ["Records.radius", "Weights.w", "Octree.G", "Octree-slice.records", "Validity.B"] {
        assert!(layers.channel(name).is_some(), "no layer {name}");
    }
    // A second run with this cache makes no record, and the same picture.
    let (second, stats) = (at("b.exr"), at("b.json"));
    let output = run(&[
        "-o",
        &second,
        "--cache-in",
        &cache,
        "--records-out",
        &csv,
        "--stats",
        &stats,
        "--error",
        "bounded",
    ]);
    assert_success(&output);
    assert!(std::fs::read_to_string(stats).expect("statistics").contains("\"records_made\": 0.0"));
    let again = read_exr(Path::new(&second)).expect("an EXR");
    assert_eq!(layers.channel("G"), again.channel("G"));
    let rows = std::fs::read_to_string(csv).expect("a table").lines().count();
    assert!(
        rows > 10 && layers.channel("Records.radius").expect("a layer").len() == 24 * 24,
        "{rows}"
    );
}

#[test]
fn caches_that_cannot_be_used_give_one_clear_error_and_status_2() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let (cache, broken, out) = (at("a.cache"), at("b.cache"), at("c.exr"));
    let made = run(&["-o", &at("a.exr"), "--cache-out", &cache]);
    assert_success(&made);
    let mut bytes = std::fs::read(&cache).expect("a cache");
    bytes[8] = 99;
    std::fs::write(&broken, bytes).expect("written");
    let before = folder.files();
    let glossy = scene("cornell-glossy");
    let other = program::run(PROGRAM, &[&glossy, "-o", &out, "--cache-in", &cache, "-q"]);
    let cases = [
        (other, "another scene"),
        (run(&["-o", &out, "--cache-in", &broken]), "version 99"),
        (run(&["-o", &out, "--cache-in", &at("nowhere")]), "nowhere"),
        (run(&["-o", &out, "--cache-in", &cache, "--accuracy", "0.3"]), "--accuracy 0.1"),
        (run(&["-o", &out, "--cache-in", &cache, "--bounces", "2"]), "--bounces path"),
        (run(&["-o", &out, "--accuracy", "0"]), "above 0"),
        (run(&["-o", &out, "--rays", "3"]), "8.."),
        (run(&["-o", &out, "--min-spacing", "9", "--max-spacing", "5"]), "--min-spacing"),
        (run(&["-o", &out, "--records-out", &at("r.txt")]), ".ply"),
        (run(&["-o", &out, "--cache-out", &out]), "overwrite"),
        (run(&["-o", &out, "-D", "gi.irrcache.cache_out=x"]), "cannot set"),
        (run(&["-o", &out, "--show", "nothing"]), "octree-slice"),
    ];
    for (output, says) in cases {
        assert_refused(&output, 2, &[says]);
    }
    assert_eq!(folder.files(), before, "a file was left half-written");
}

#[test]
fn presets_of_the_scene_are_defaults() {
    let folder = Folder::make();
    let (stats, out) = (folder.at("s.json"), folder.at("p.exr"));
    let records = |preset: &str| {
        let output = run(&["-o", &out, "-D", preset, "--stats", &stats, "--error", "bounded"]);
        assert_success(&output);
        let text = std::fs::read_to_string(&stats).expect("statistics");
        let (_, rest) = text.split_once("\"records\": ").expect("a number of records");
        rest.split(',').next().expect("a number").trim().parse::<f64>().expect("a number")
    };
    assert!(records("gi.irrcache.accuracy=0.1") > 1.2 * records("gi.irrcache.accuracy=0.5"));
}
