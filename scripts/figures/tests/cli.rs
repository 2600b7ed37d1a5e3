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
    assert!(lines.contains("\n0.5,2.5,3.960") && lines.contains(",1.20000"), "{lines}");
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
    let panels = ["alpha-0.5.png=half", "errors.svg=a curve", "error.svg=a map"];
    let folder = f.at("");
    succeed(&[&["figure", &folder][..], &told, &panels].concat());
    let sidecar = read(&f, "figure.json");
    assert!(sidecar.contains("\"relmse\": 0.0396") && sidecar.contains("--spp <4>"), "{sidecar}");
    let page = f.at("index.html");
    succeed(&["index", &page, &folder]);
    let first = read(&f, "index.html");
    assert!(first.contains("A &amp; B") && first.contains("--spp &lt;4&gt;"));
    assert!(first.contains("relMSE 3.96e-2") && !first.contains("src=\"http"));
    assert_eq!(first.matches("data:image/").count(), 3);
    succeed(&["index", &page, &folder]);
    assert_eq!(first, read(&f, "index.html"), "the same files make the same page");
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
