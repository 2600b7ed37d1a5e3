//! The page in a real browser: every control used, every number and colour that it shows checked. Where no browser is
//! installed, the test says that it was skipped.

// Not all of what tests share is used by each.
mod browser;
#[allow(dead_code)]
#[path = "../common/mod.rs"]
mod common;

use std::io::Write;
use std::path::Path;

use browser::Browser;
use common::{at, build_programs, run, said, scene};
use gi_core::image_io::read_exr;
use serde_json::Value;

/// The numbers that the page shows of a pixel are those of the picture's file.
fn assert_shows(rows: &Value, index: usize, file: &str, [x, y]: [usize; 2]) {
    let layers = read_exr(Path::new(file)).expect("an EXR");
    for (k, channel) in ["R", "G", "B"].into_iter().enumerate() {
        let right = f64::from(layers.channel(channel).expect("a channel")[y * layers.width + x]);
        let shown: f64 = rows[index][k].as_str().and_then(|t| t.parse().ok()).expect("a number");
        // Eleven bits, then three digits.
        assert!(
            (shown - right).abs() <= 0.006 * right.abs() + 1e-6,
            "{file} {channel} at {x}, {y}: {shown} is not {right}"
        );
    }
}

#[test]
fn every_control_works_on_wide_and_narrow_windows_without_errors_or_network() {
    let Some(program) = browser::find() else {
        // Not by eprintln, which the test runner keeps to itself.
        let names = browser::NAMES.join(", ");
        let _ = writeln!(
            std::io::stderr(),
            "SKIPPED, the page was not tested: no browser is installed ({names})"
        );
        return;
    };
    build_programs();
    let folder = tempfile::tempdir().expect("a folder");
    let out = at(folder.path(), "out");
    let output = run(&[
        &scene("cornell-box"),
        "--size",
        "30x20",
        "--spp",
        "4",
        "--techniques",
        "pathtrace,photonmap",
        "--with",
        "photonmap: --photons 2000 --gather none",
        "--seeds",
        "2",
        "--ladder",
        "2",
        "-o",
        &out,
    ]);
    assert!(output.status.success(), "{}", said(&output));
    let url = format!("file://{out}/index.html");
    let mut browser = Browser::start(&program, folder.path());
    for width in [1400, 390] {
        browser.open(&url, [width, 900]);
        let seen = browser.evaluate(include_str!("checks.js"));
        assert_eq!(browser.complaints(&url), [""; 0], "{width}");
        for nothing in ["problems", "resources", "unlabelled"] {
            assert_eq!(seen[nothing], serde_json::json!([]), "{width}: {nothing}");
        }
        assert_eq!(seen["finished"], true, "{width}");
        assert_eq!(seen["state"], true, "{width}: pictures were unpacked");
        assert!(
            seen["overflow"].as_i64().is_some_and(|v| v <= 0),
            "{width}: the page is too wide: {seen}"
        );
        assert_eq!(
            seen["pictures"],
            serde_json::json!(["1 reference", "2 pathtrace", "3 photonmap"])
        );
        assert_eq!(seen["quantities"].as_array().map(Vec::len), Some(7));
        for inspected in seen["inspected"].as_array().expect("two pixels") {
            let at = [0, 1].map(|k| inspected["at"][k].as_u64().expect("a number") as usize);
            assert_eq!(inspected["shown"], format!("{}, {}", at[0], at[1]));
            for (index, name) in [(1, "pathtrace"), (2, "photonmap")] {
                assert_shows(&inspected["rows"], index, &format!("{out}/{name}.exr"), at);
            }
        }
    }
}
