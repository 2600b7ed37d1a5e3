//! Runs the program as a user would: its own flags and files.

use std::path::Path;
use std::process::Output;

use gi_core::image_io::read_exr;
use gi_tests::program::{self, Folder, assert_refused, assert_success, scene};

fn run(arguments: &[&str]) -> Output {
    let scene = scene("cornell-glossy");
    let small =
        [&scene, "--size", "24x24", "--rays", "50", "--glossy-rays", "50", "--spp", "1", "-q"];
    program::run(env!("CARGO_BIN_EXE_radcache"), &[&small, arguments].concat())
}

#[test]
fn a_run_writes_its_pictures_its_cache_and_its_records() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let (out, cache, ply, csv) = (at("a.exr"), at("a.cache"), at("a.ply"), at("a.csv"));
    let show = "records,basis,brdf,samples";
    let output = run(&["-o", &out, "--show", show, "--cache-out", &cache, "--records-out", &ply]);
    assert_success(&output);
    let expected = [
        "a.basis.png",
        "a.brdf.png",
        "a.cache",
        "a.exr",
        "a.glossy-records.png",
        "a.ply",
        "a.png",
        "a.records.png",
        "a.samples.png",
    ];
    assert_eq!(folder.files(), expected);
    // A second run with this cache makes no record, and the same picture.
    let (second, stats) = (at("b.exr"), at("b.json"));
    let output =
        run(&["-o", &second, "--cache-in", &cache, "--records-out", &csv, "--stats", &stats]);
    assert_success(&output);
    let stats = std::fs::read_to_string(stats).expect("statistics");
    assert!(stats.contains("\"records_made\": 0.0"), "{stats}");
    assert!(stats.contains("rough conductor, 0.10): path"), "the rule is printed: {stats}");
    let layers = read_exr(Path::new(&out)).expect("an EXR");
    let again = read_exr(Path::new(&second)).expect("an EXR");
    assert_eq!(layers.channel("G"), again.channel("G"));
    assert!(layers.channel("Glossy-records.radius").is_some());
    assert!(std::fs::read_to_string(csv).expect("a table").lines().count() > 10);
}

#[test]
fn unusable_files_and_flags_give_one_clear_error_and_status_2() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let (cache, broken, out) = (at("a.cache"), at("b.cache"), at("c.exr"));
    let made = run(&["-o", &at("a.exr"), "--cache-out", &cache]);
    assert_success(&made);
    std::fs::write(&broken, b"gilab-ic and more").expect("written");
    let before = folder.files();
    let cases = [
        (run(&["-o", &out, "--cache-in", &broken]), "not a radiance cache"),
        (run(&["-o", &out, "--cache-in", &at("nowhere")]), "nowhere"),
        (run(&["-o", &out, "--cache-in", &cache, "--order", "5"]), "--order 10"),
        (run(&["-o", &out, "--cache-in", &cache, "--basis", "hsh"]), "--basis Sh"),
        (run(&["-o", &out, "--order", "17"]), "0..=16"),
        (run(&["-o", &out, "--glossy-accuracy", "0"]), "above 0"),
        (run(&["-o", &out, "--min-roughness=-1"]), "roughness"),
        (run(&["-o", &out, "--min-spacing", "9", "--max-spacing", "5"]), "--min-spacing"),
        (run(&["-o", &out, "--records-out", &at("r.txt")]), ".ply"),
        (run(&["-o", &out, "--show", "nothing"]), "brdf"),
    ];
    for (output, says) in cases {
        assert_refused(&output, 2, &[says]);
    }
    assert_eq!(folder.files(), before, "a file was left half-written");
}
