//! Tests the command line: tables, drawings, figures and the page, from small pictures.

use std::path::Path;

use gi_core::image_io::{ImageFile, Layers, write_file};
use gi_tests::program::{Folder, assert_refused, assert_success, run};

/// A picture of uniform grey, and its display image.
fn picture(folder: &Folder, name: &str, grey: f32, seconds: &str) {
    let metadata = [("gi.seconds", seconds), ("gi.command", "pathtrace scene.xml --spp <4>")];
    let layers = Layers {
        metadata: metadata.map(|(k, v)| (k.to_string(), v.to_string())).to_vec(),
        ..Layers::of_rgb([4, 4], [[grey; 3]; 16])
    };
    for kind in ["exr", "png"] {
        let path = folder.at(&format!("{name}.{kind}"));
        let format = ImageFile::from_path(Path::new(&path)).expect("a format");
        write_file(Path::new(&path), format, &layers).expect("a picture");
    }
}

fn read(folder: &Folder, name: &str) -> String {
    std::fs::read_to_string(folder.at(name)).expect("a file")
}

const PROGRAM: &str = env!("CARGO_BIN_EXE_figures");

fn succeed(arguments: &[&str]) {
    assert_success(&run(PROGRAM, arguments));
}

fn refuse(arguments: &[&str], says: &[&str]) {
    assert_refused(&run(PROGRAM, arguments), 1, says);
}

#[test]
fn pictures_become_tables_drawings_figures_and_a_page_that_needs_nothing_else() {
    let f = Folder::make();
    picture(&f, "reference", 1.0, "9");
    // A name that contains a dot must find its data.
    picture(&f, "alpha-0.5", 1.2, "2.5");
    picture(&f, "alpha-0.9", 1.1, "5");
    let (table, reference) = (f.at("errors.csv"), f.at("reference.exr"));
    let [half, most] = ["0.5", "0.9"].map(|a| format!("{a}={}", f.at(&format!("alpha-{a}.exr"))));
    succeed(&["measure", &table, "--reference", &reference, &half, &most]);
    let lines = read(&f, "errors.csv");
    // relMSE of 1.2 against 1: 0.04 / 1.01.
    assert!(lines.contains("\n0.5,2.5,,3.960") && lines.contains(",1.20000"), "{lines}");
    let curve = format!("alpha={table}:x:relmse");
    let plot = f.at("errors.svg");
    let titles = ["--title", "Errors", "--x", "alpha", "--y", "relMSE", "--slopes"];
    succeed(&[&["plot", &plot, &curve][..], &titles].concat());
    // log (0.04 / 0.01) over log (0.5 / 0.9).
    assert!(read(&f, "errors.svg").contains("alpha (slope -2.36)"));
    let map = f.at("error.svg");
    succeed(&["difference", &map, &f.at("alpha-0.5.exr"), "--reference", &reference]);
    assert!(read(&f, "error.svg").contains("+20 %"));
    let told =
        ["--slide", "41-42", "--title", "A & B", "--caption", "Seen", "--reference", &reference];
    let panels =
        ["alpha-0.5.png={ratio(alpha-0.5)} times", "errors.svg=a curve", "error.svg=a map"];
    let claims = ["--claim", "relmse(alpha-0.9) < relmse(alpha-0.5)", "--inset", "0,0,0.25,0.25,2"];
    let folder = f.at("");
    succeed(&[&["figure", &folder][..], &told, &claims, &panels].concat());
    let sidecar = read(&f, "figure.json");
    assert!(sidecar.contains("\"1.2 times\"") && sidecar.contains("0.0099 < 0.0396"), "{sidecar}");
    assert!(sidecar.contains("\"relmse\": 0.0396") && sidecar.contains("--spp <4>"), "{sidecar}");
    let page = f.at("index.html");
    succeed(&["index", &page, &folder]);
    let first = read(&f, "index.html");
    assert!(first.contains("A &amp; B") && first.contains("--spp &lt;4&gt;"));
    assert!(first.contains("relMSE\u{a0}3.96e-2") && !first.contains("src=\"http"));
    assert_eq!(first.matches("data:image/").count(), 3);
    succeed(&["index", &page, &folder]);
    assert_eq!(first, read(&f, "index.html"), "the same files make the same page");
    let deck = f.at("deck.html");
    succeed(&["deck", &deck, &folder]);
    let deck = read(&f, "deck.html");
    assert!(deck.contains("Slides 41-42") && deck.matches("data:image/").count() == 3);
    // Five panels in two columns take two pages.
    let panels = ["alpha-0.5.png=x"; 5];
    succeed(&[&["figure", &folder, "--columns", "2"][..], &told, &panels].concat());
    succeed(&["deck", &f.at("deck.html"), &folder]);
    let deck = read(&f, "deck.html");
    assert!(deck.contains("(1 of 2)") && deck.contains("(2 of 2)") && deck.contains("--rows:1"));
}

#[test]
fn missing_black_and_incomplete_panels_are_refused_by_name() {
    let f = Folder::make();
    picture(&f, "black", 0.0, "1");
    picture(&f, "fine", 0.5, "1");
    let png = std::fs::read(f.at("fine.png")).expect("a picture");
    std::fs::write(f.at("half.png"), &png[..png.len() / 2]).expect("written");
    let folder = f.at("");
    for (panel, says) in [
        ("black.png=x", "is black"),
        ("half.png=x", "is incomplete"),
        ("none.png=x", "cannot be read"),
        ("notes.txt=x", "cannot be read"),
    ] {
        let told = ["--slide", "17", "--title", "t", "--caption", "c"];
        let name = panel.split('=').next().expect("a name");
        refuse(&[&["figure", &folder][..], &told, &[panel]].concat(), &["slide 17", name, says]);
    }
    assert!(!Path::new(&f.at("figure.json")).exists(), "nothing is written for a broken figure");
    refuse(&["index", &f.at("index.html"), &f.at("12"), &f.at("13")], &["/12", "/13"]);
    std::fs::write(f.at("t.csv"), "x,y\n1,2\n").expect("written");
    let curve = format!("a={}:x:z", f.at("t.csv"));
    let plot = ["plot", &f.at("a.svg"), "--title", "t", "--x", "x", "--y", "y", &curve];
    refuse(&plot, &["no column z"]);
}

#[test]
fn a_false_claim_fails_the_figure_and_shows_both_sides() {
    let f = Folder::make();
    picture(&f, "a", 1.0, "1");
    picture(&f, "b", 0.5, "1");
    std::fs::write(f.at("t.csv"), "x,y\n1,2\n1,4\n2,2\n").expect("written");
    let folder = f.at("");
    let told = ["--slide", "12", "--title", "t", "--caption", "c", "a.png=x"];
    for (claim, says) in [
        ("mean(a) < mean(b)", "is false: 1 < 0.5"),
        ("mean(a) / mean(b) in 0.9..1.1", "is false: 2 in 0.9..1.1"),
        ("mean(a)", "expected <, > or in"),
        ("mean(c) < 1", "c.exr"),
        ("median(a) < 1", "median(a)"),
        ("size(a) < 1", "no function size"),
        ("within(t.csv:x:y, 0 1 2 3) > 1", "is false: 1 > 1"),
        ("within(t.csv:x:y, 0 1 2) > 1", "expected four numbers"),
        ("relmse(a) < 1", "no --reference"),
        ("mean(a[0 0 2 1]) < 1", "not a part of the picture"),
    ] {
        let arguments = [&["figure", &folder, "--claim", claim][..], &told].concat();
        refuse(&arguments, &["slide 12", says]);
    }
    assert!(!Path::new(&f.at("figure.json")).exists(), "nothing is written for a false claim");
}

#[test]
fn the_noise_of_a_reference_with_a_twin_is_not_part_of_the_error() {
    let f = Folder::make();
    picture(&f, "a", 1.2, "1");
    let told = ["--slide", "12", "--title", "t", "--caption", "c", "a.png=x"];
    let other = Folder::make();
    for (name, grey) in [("other", 0.9), ("other.twin", 1.1)] {
        picture(&other, name, grey, "1");
    }
    // An older reference in the figure's folder is not used.
    picture(&f, "reference", 7.0, "1");
    let reference = other.at("other.exr");
    // relMSE: (1.2 - 0.9) (1.2 - 1.1) over the squared mean of both references and 0.01.
    for claim in ["relmse(a) * 1.01 in 0.02999..0.03001", "ratio(a) in 1.1999..1.2001"] {
        let claim = ["--claim", claim, "--reference", &reference];
        succeed(&[&["figure", &f.at("")][..], &claim, &told].concat());
    }
}

#[test]
fn errors_may_be_of_a_part() {
    let f = Folder::make();
    picture(&f, "reference", 1.0, "1");
    // The left half is twice as bright as it should be.
    let half = |x: usize| if x % 4 < 2 { [2.0; 3] } else { [1.0; 3] };
    let layers = Layers::of_rgb([4, 4], (0..16).map(half));
    picture(&f, "a", 1.0, "1");
    let path = f.at("a.exr");
    write_file(Path::new(&path), ImageFile::Exr, &layers).expect("a picture");
    let told = ["--slide", "12", "--title", "t", "--caption", "c", "a.png=x"];
    let part = ["--part", "0,0,0.5,1", "--reference", &f.at("reference.exr")];
    succeed(&[&["figure", &f.at("")][..], &part, &told].concat());
    let sidecar: String = read(&f, "figure.json").split_whitespace().collect();
    assert!(sidecar.contains("\"mean_ratio\":[2.0,2.0,2.0]"), "{sidecar}");
}

#[test]
fn twins_that_are_not_independent_runs_of_one_picture_are_refused() {
    let f = Folder::make();
    let write = |name: &str, metadata: &[(&str, &str)]| {
        let metadata = metadata.iter().map(|(k, v)| (format!("gi.{k}"), v.to_string())).collect();
        let layers = Layers { metadata, ..Layers::of_rgb([1, 1], [[1.0; 3]]) };
        let path = f.at(&format!("{name}.exr"));
        write_file(Path::new(&path), ImageFile::Exr, &layers).expect("a picture");
    };
    let own = [("seed", "1"), ("passes", "4"), ("seconds", "2.5"), ("scene_hash", "a")];
    write("a", &own);
    let (table, reference) = (f.at("t.csv"), f.at("a.exr"));
    let measure = ["measure", &table, "--reference", &reference, &format!("1={reference}")];
    let other = |k: usize, value| {
        let mut twin = own;
        (twin[0].1, twin[k].1) = ("2", value);
        twin
    };
    for (twin, says) in [
        (own, "same seed"),
        (other(1, "8"), "its passes is not that of its twin"),
        (other(3, "b"), "its scene_hash is not that of its twin"),
    ] {
        write("a.twin", &twin);
        refuse(&measure, &["a.twin.exr", says]);
    }
    write("a.twin", &other(2, "3"));
    succeed(&measure);
    // The picture is the mean of both, so it took the time of both.
    assert!(read(&f, "t.csv").contains("\n1,5.5,0.687500,"), "{}", read(&f, "t.csv"));
}

#[test]
fn noise_and_bias_of_two_pictures_are_told_apart() {
    let f = Folder::make();
    for (name, grey) in [("reference", 1.0), ("a", 1.3), ("b", 1.1)] {
        picture(&f, name, grey, "1");
    }
    let pair = format!("4={},{}", f.at("a.exr"), f.at("b.exr"));
    succeed(&["measure", &f.at("t.csv"), "--reference", &f.at("reference.exr"), &pair]);
    // Noise: 0.2^2 / 2; bias: 0.3 * 0.1; both over 1.01.
    let table = read(&f, "t.csv");
    assert!(table.contains(",1.980") && table.contains(",2.970"), "{table}");
}
