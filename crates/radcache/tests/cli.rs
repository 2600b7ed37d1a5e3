//! The program run as a user runs it: its own flags and files.

use std::path::Path;
use std::process::{Command, Output};

use gi_core::image_io::read_exr;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/cornell-glossy.xml");

fn run(arguments: &[&str]) -> Output {
    let small = ["--size", "24x24", "--rays", "50", "--glossy-rays", "50", "--spp", "1", "-q"];
    let all = [&[SCENE], &small[..], arguments].concat();
    Command::new(env!("CARGO_BIN_EXE_radcache")).args(all).output().expect("it runs")
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_run_leaves_its_pictures_its_cache_and_its_records() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_string();
    let (out, cache, ply, csv) = (at("a.exr"), at("a.cache"), at("a.ply"), at("a.csv"));
    let show = "records,basis,brdf,samples";
    let output = run(&["-o", &out, "--show", show, "--cache-out", &cache, "--records-out", &ply]);
    assert!(output.status.success(), "{}", text(&output));
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
    assert_eq!(files(folder.path()), expected);
    // The cache serves a second run, which makes no record and the same picture.
    let (second, stats) = (at("b.exr"), at("b.json"));
    let output =
        run(&["-o", &second, "--cache-in", &cache, "--records-out", &csv, "--stats", &stats]);
    assert!(output.status.success(), "{}", text(&output));
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
fn what_cannot_be_used_is_one_clear_error_and_status_2() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_string();
    let (cache, broken, out) = (at("a.cache"), at("b.cache"), at("c.exr"));
    let made = run(&["-o", &at("a.exr"), "--cache-out", &cache]);
    assert!(made.status.success(), "{}", text(&made));
    std::fs::write(&broken, b"gilab-ic and more").expect("written");
    let before = files(folder.path());
    let cases = [
        (run(&["-o", &out, "--cache-in", &broken]), "not a radiance cache"),
        (run(&["-o", &out, "--cache-in", &at("nowhere")]), "nowhere"),
        (run(&["-o", &out, "--cache-in", &cache, "--order", "5"]), "--order 10"),
        (run(&["-o", &out, "--cache-in", &cache, "--basis", "hsh"]), "--basis Sh"),
        (run(&["-o", &out, "--order", "17"]), "0..=16"),
        (run(&["-o", &out, "--glossy-accuracy", "0"]), "above 0"),
        (run(&["-o", &out, "--min-roughness=-1"]), "roughness"),
        (run(&["-o", &out, "--min-spacing", "9", "--max-spacing", "5"]), "--min-spacing"),
        (run(&["-o", &out, "--show", "nothing"]), "brdf"),
    ];
    for (output, says) in cases {
        let text = text(&output);
        assert_eq!(output.status.code(), Some(2), "{says}: {text}");
        assert!(text.contains(says) && !text.contains("panicked"), "\"{says}\" is not in:\n{text}");
    }
    assert_eq!(files(folder.path()), before, "something was left half-written");
}
