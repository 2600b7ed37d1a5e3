//! The page in a real browser: every control used, every number and colour that it shows checked. Where no browser is
//! installed, the tests say that they were skipped.

// Not all of what tests share is used by each.
#[allow(dead_code)]
#[path = "../common/mod.rs"]
mod common;

use std::path::Path;

use common::{build_programs, run, save_rgb};
use gi_core::image_io::read_exr;
use gi_tests::browser::{Browser, find_or_skip};
use gi_tests::program::{Folder, assert_success, files, scene};
use serde_json::{Value, json};

/// The radiance of a file at a pixel.
fn pixel(file: &str, [x, y]: [usize; 2]) -> [f64; 3] {
    let layers = read_exr(Path::new(file)).expect("an EXR");
    let value = |c| f64::from(layers.channel(c).expect("a channel")[y * layers.width + x]);
    ["R", "G", "B"].map(value)
}

/// A number as the page shows it.
fn shown(cell: &Value) -> f64 {
    cell.as_str().and_then(|t| t.parse().ok()).expect("a number")
}

/// Half a unit of the third digit, of the smallest leading digit; and half a unit of a half float's last bit.
const DIGITS: f64 = 0.005;
const HALF: f64 = 1.0 / 2048.0;

/// Check a number that the page has computed from half floats of this size.
fn assert_near(name: &str, shown: f64, right: f64, size: f64) {
    let tolerance = DIGITS * right.abs() + (1.0 + DIGITS) * HALF * size + 1e-9;
    assert!((shown - right).abs() <= tolerance, "{name}: {shown} is not {right}");
}

/// Check the maps' numbers at a pixel, of picture 1, against the files of its seeds and of the reference.
fn assert_maps(maps: &Value, seeds: [&str; 2], halves: [String; 2]) {
    for (name, map) in maps.as_object().expect("maps") {
        let (x, y) = map["at"].as_str().and_then(|t| t.split_once(", ")).expect("a pixel");
        let at = [x, y].map(|t| t.parse().expect("a number"));
        let [ra, rb] = halves.each_ref().map(|f| pixel(f, at));
        let [a, b] = seeds.map(|f| pixel(f, at));
        let r: [f64; 3] = std::array::from_fn(|k| 0.5 * (ra[k] + rb[k]));
        let mean = |of: &dyn Fn(usize) -> f64| (0..3).map(of).sum::<f64>() / 3.0;
        let right = match name.as_str() {
            "error" => mean(&|k| (a[k] - r[k]).powi(2)).sqrt(),
            "relative" => mean(&|k| (a[k] - r[k]).powi(2) / (r[k] * r[k] + 0.01)).sqrt(),
            "signed" => mean(&|k| a[k] - r[k]),
            "bias" => mean(&|k| 0.5 * (a[k] + b[k]) - r[k]),
            // s^2 of two numbers is half their difference squared.
            "deviation" => mean(&|k| 0.5 * (a[k] - b[k]).powi(2)).sqrt(),
            "flip" => continue, // what the page gets is tested where it is made
            other => panic!("an unknown map: {other}"),
        };
        // What is computed in the page has the roundings of picture and reference, and of a division by at least a tenth.
        let both = (0..3).map(|k| a[k].abs() + r[k].abs()).fold(0.0, f64::max);
        let size = match name.as_str() {
            "bias" | "deviation" => right.abs(),
            "relative" => 10.0 * both,
            _ => both,
        };
        assert_near(name, shown(&map["rows"][1][3]), right, size);
    }
}

#[test]
fn every_control_works_on_wide_and_narrow_windows_without_errors_or_network() {
    let Some(program) = find_or_skip() else { return };
    build_programs();
    let folder = Folder::make();
    let out = folder.at("out");
    let scene = scene("cornell-box");
    let runs = [
        "--techniques",
        "pathtrace,photonmap",
        "--with",
        "photonmap: --photons 2000 --gather none",
    ];
    let flags = ["--size", "30x20", "--spp", "4", "--seeds", "2", "--ladder", "2", "-o", &out];
    let output = run(&[&[scene.as_str()], &runs[..], &flags].concat());
    assert_success(&output);
    let file = |name: &str| format!("{out}/{name}.exr");
    let halves = ["a", "b"].map(|half| {
        let ends = format!(".{half}.exr");
        let found = files(Path::new(&out)).into_iter().find(|name| name.ends_with(&ends));
        format!("{out}/{}", found.expect("a half of the reference"))
    });
    let url = format!("file://{out}/index.html");
    let mut browser = Browser::start(&program, folder.path());
    for width in [1400, 390] {
        browser.open(&url, [width, 900]);
        let seen = browser.evaluate(include_str!("checks.js"));
        assert_eq!(browser.complaints(&url), [""; 0], "{width}");
        for nothing in ["problems", "resources", "unlabelled"] {
            assert_eq!(seen[nothing], json!([]), "{width}: {nothing}");
        }
        assert_eq!(seen["finished"], true, "{width}");
        assert_eq!(seen["state"], true, "{width}: pictures were unpacked");
        assert!(seen["overflow"].as_i64().is_some_and(|v| v <= 0), "{width}: the page is too wide");
        assert_eq!(seen["pictures"], json!(["1 reference", "2 pathtrace", "3 photonmap"]));
        assert_eq!(seen["maps"].as_object().map(serde_json::Map::len), Some(6), "{width}");
        for inspected in seen["inspected"].as_array().expect("two pixels") {
            let at = [0, 1].map(|k| inspected["at"][k].as_u64().expect("a number") as usize);
            assert_eq!(inspected["shown"], format!("{}, {}", at[0], at[1]));
            for (index, name) in [(1, "pathtrace"), (2, "photonmap")] {
                for (k, right) in pixel(&file(name), at).into_iter().enumerate() {
                    assert_near(name, shown(&inspected["rows"][index][k]), right, right.abs());
                }
            }
        }
        assert_maps(&seen["maps"], [&file("pathtrace"), &file("pathtrace.seed-1")], halves.clone());
    }
}

#[test]
fn broken_pixels_and_awkward_names_are_shown_as_they_are() {
    let Some(program) = find_or_skip() else { return };
    let folder = Folder::make();
    let path = |name: &str| folder.at(name);
    save_rgb(&path("truth.exr"), [6, 4], &|_| [0.5; 3]);
    let broken = |i: usize| if i == 9 { [0.5, f32::NAN, 0.5] } else { [2e5, -0.25, 0.0] };
    let name = "<b>&amp; ${1} {{data}} 'a\".exr";
    save_rgb(&path(name), [6, 4], &broken);
    let (file, truth, out) = (path(name), path("truth.exr"), path("out"));
    let output = run(&[&file, "--reference", &truth, "-o", &out]);
    assert_success(&output);
    let url = format!("file://{out}/index.html");
    let mut browser = Browser::start(&program, folder.path());
    browser.open(&url, [1000, 800]);
    let checks = include_str!("checks.js").split_once("(async () => {\n  try").expect("its end").0;
    let seen = browser.evaluate(&format!(
        "{checks}(async () => {{
            await drawn();
            await checkStart();
            const canvas = canvases()[0], out = {{ label: byId('a').options[1].text, row: document.querySelector('tbody th').textContent }};
            await put('divider', '1', 'input');
            for (const [name, x, y] of [['broken', 3, 1], ['whole', 4, 1]]) {{
                choosePixel(x, y);
                await frame();
                const s = scaleOf(), point = [canvas.clientWidth / 2 + (x + 0.5 - 3) * s, canvas.clientHeight / 2 + (y + 0.5 - 2) * s];
                out[name] = {{ colour: colourAt(canvas, point), numbers: numbers(1) }};
            }}
            await put('quantity', 'error');
            out.error = colourAt(canvas, [canvas.clientWidth / 2 + 0.5 * scaleOf(), canvas.clientHeight / 2 - 0.5 * scaleOf()]);
            return out;
        }})()"
    ));
    assert_eq!(browser.complaints(&url), [""; 0]);
    let label = name.trim_end_matches(".exr");
    assert_eq!(seen["label"], format!("2 {label}"));
    assert_eq!(seen["broken"]["colour"], json!([255, 0, 255]));
    assert_eq!(seen["error"], json!([255, 0, 255]));
    assert_eq!(seen["broken"]["numbers"][1], "NaN");
    // 2 10^5 is beyond a half float: the plane is scaled.
    assert_eq!(seen["whole"]["colour"], json!([255, 0, 0]));
    assert_eq!(seen["whole"]["numbers"], json!(["2.00e+5", "-0.25", "0", "1.15e+5"]));
}
