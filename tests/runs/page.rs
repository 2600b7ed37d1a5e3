//! The live page in a real browser: what it shows while the run goes on, and what it keeps when the run has ended. Where no browser is
//! installed, the test says that it was skipped.

use gi_core::image_io::Layers;
use gi_tests::browser::{Browser, find_or_skip};
use gi_tests::program::Folder;
use serde_json::{Value, json};

use crate::running::{PROGRAMS, picture, says};
use crate::served::Served;

/// What the page's scripts share.
const CHECKS: &str = include_str!("page.js");

/// Run one of the functions of the checks in the page.
fn evaluate(browser: &mut Browser, call: &str) -> Value {
    browser.evaluate(&format!("(async () => {{ {CHECKS}\n return await {call}; }})()"))
}

/// The three numbers of a pixel in a file.
fn pixel(file: &Layers, layer: &str, [x, y]: [usize; 2]) -> [f64; 3] {
    let value = |c: &str| {
        let name = if layer == "Picture" { c.to_string() } else { format!("{layer}.{c}") };
        f64::from(file.channel(&name).expect("a channel")[y * file.width + x])
    };
    ["R", "G", "B"].map(value)
}

/// Check a row of the pixel table: three digits of a half float.
fn assert_row(layer: &str, row: &Value, right: [f64; 3]) {
    for (k, right) in right.into_iter().enumerate() {
        let shown: f64 = row[k].as_str().and_then(|t| t.parse().ok()).expect("a number");
        let tolerance = (0.005 + 1.0 / 2048.0) * right.abs() + 1e-6;
        assert!((shown - right).abs() <= tolerance, "{layer}: {shown} is not {right}");
    }
}

#[test]
fn the_page_shows_the_run_and_keeps_its_last_picture() {
    let Some(program) = find_or_skip() else { return };
    for (width, name) in [(1400, "pathtrace"), (390, "ppm")] {
        let technique = PROGRAMS.iter().find(|p| p.name == name).expect("it is there");
        let folder = Folder::make();
        let served = Served::start(technique, &folder, &["--spp", "100000000"]);
        let url = served.url();
        let mut browser = Browser::start(&program, folder.path());
        browser.open(&url, [width, 900]);
        let seen = evaluate(&mut browser, "checkRun()");
        assert_eq!(seen["problems"], json!([]), "{name}");
        assert_eq!(seen["unlabelled"], json!([]), "{name}");
        assert!(seen["overflow"].as_i64().is_some_and(|v| v <= 0), "{name}: the page is too wide");
        assert_eq!(seen["title"], format!("{name} {}", gi_tests::program::scene("cornell-box")));
        for layer in ["Picture", "Standard error", "Normal", "Depth"] {
            let labels = seen["labels"].as_array().expect("labels");
            assert!(labels.iter().any(|l| l.as_str().is_some_and(|l| l.ends_with(layer))));
        }
        // Nothing was downloaded that was not shown.
        let downloads = seen["downloads"].as_array().expect("addresses");
        assert!(downloads.iter().all(|d| d.as_str().is_some_and(|d| d.ends_with("/Picture"))));
        if name == "ppm" {
            let numbers = seen["numbers"].as_array().expect("names");
            assert!(numbers.iter().any(|n| n == "radius mean"), "{numbers:?}");
        }
        assert_eq!(browser.complaints(&url), [""; 0], "{name}");
        served.run.signal("TERM");
        let end = evaluate(&mut browser, "checkEnd()");
        assert_eq!(served.run.end().0, Some(143));
        assert_eq!(end["problems"], json!([]), "{name}");
        let file = picture(&folder, "out.exr");
        let facts = end["facts"].as_object().expect("facts");
        let passes = says(&file, "gi.passes").expect("passes");
        assert!(
            facts["picture after"].as_str().is_some_and(|t| t.starts_with(passes)),
            "{facts:?}"
        );
        let at = [0, 1].map(|k| end["at"][k].as_u64().expect("a number") as usize);
        for layer in ["Picture", "Direct", "Albedo"] {
            assert_row(layer, &end["rows"][layer], pixel(&file, layer, at));
        }
    }
}
