//! The command line: tables, drawings, figures and the page, from small pictures.

use std::path::Path;
use std::process::{Command, Output};

use gi_core::image_io::{ImageFile, Layers, write_file};

/// A folder of its own, taken away at the end.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Folder(tempfile::tempdir().expect("a folder"))
    }

    fn at(&self, name: &str) -> String {
        self.0.path().join(name).to_str().expect("UTF-8").to_string()
    }

    /// A picture of one grey, and its view.
    fn picture(&self, name: &str, grey: f32, seconds: &str) {
        let channels = ["R", "G", "B"].map(|c| (c.to_string(), vec![grey; 16]));
        let metadata = [("gi.seconds", seconds), ("gi.command", "pathtrace scene.xml --spp <4>")];
        let layers = Layers {
            width: 4,
            height: 4,
            channels: channels.to_vec(),
            metadata: metadata.map(|(k, v)| (k.to_string(), v.to_string())).to_vec(),
        };
        for kind in ["exr", "png"] {
            let path = self.at(&format!("{name}.{kind}"));
            let format = ImageFile::from_path(Path::new(&path)).expect("a format");
            write_file(Path::new(&path), format, &layers).expect("a picture");
        }
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.at(name)).expect("a file")
    }
}

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_figures")).args(arguments).output().expect("it starts")
}

fn succeed(arguments: &[&str]) {
    let output = run(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn refuse(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn pictures_become_tables_drawings_figures_and_a_page_that_needs_nothing_else() {
    let f = Folder::new();
    f.picture("reference", 1.0, "9");
    // A name with a point in it finds its data all the same.
    f.picture("alpha-0.5", 1.2, "2.5");
    f.picture("alpha-0.9", 1.1, "5");
    let (table, reference) = (f.at("errors.csv"), f.at("reference.exr"));
    let [half, most] = ["0.5", "0.9"].map(|a| format!("{a}={}", f.at(&format!("alpha-{a}.exr"))));
    succeed(&["measure", &table, "--reference", &reference, &half, &most]);
    let lines = f.read("errors.csv");
    // relMSE of 1.2 against 1: 0.04 / 1.01.
    assert!(lines.contains("\n0.5,2.5,3.960") && lines.contains(",1.20000"), "{lines}");
    let curve = format!("alpha={table}:x:relmse");
    let plot = f.at("errors.svg");
    let titles = ["--title", "Errors", "--x", "alpha", "--y", "relMSE", "--slopes"];
    succeed(&[&["plot", &plot, &curve][..], &titles].concat());
    // log (0.04 / 0.01) over log (0.5 / 0.9).
    assert!(f.read("errors.svg").contains("alpha (slope -2.36)"));
    let map = f.at("error.svg");
    succeed(&["difference", &map, &f.at("alpha-0.5.exr"), "--reference", &reference]);
    assert!(f.read("error.svg").contains("+20 %"));
    let told =
        ["--slide", "41-42", "--title", "A & B", "--caption", "Seen", "--reference", &reference];
    let panels = ["alpha-0.5.png=half", "errors.svg=a curve", "error.svg=a map"];
    let folder = f.at("");
    succeed(&[&["figure", &folder][..], &told, &panels].concat());
    let sidecar = f.read("figure.json");
    assert!(sidecar.contains("\"relmse\": 0.0396") && sidecar.contains("--spp <4>"), "{sidecar}");
    let page = f.at("index.html");
    succeed(&["index", &page, &folder]);
    let first = f.read("index.html");
    assert!(first.contains("A &amp; B") && first.contains("--spp &lt;4&gt;"));
    assert!(first.contains("relMSE 3.96e-2") && !first.contains("src=\"http"));
    assert_eq!(first.matches("data:image/").count(), 3);
    succeed(&["index", &page, &folder]);
    assert_eq!(first, f.read("index.html"), "the same files make the same page");
}

#[test]
fn what_is_missing_black_or_cut_off_is_refused_by_its_name() {
    let f = Folder::new();
    f.picture("black", 0.0, "1");
    f.picture("fine", 0.5, "1");
    let png = std::fs::read(f.at("fine.png")).expect("a picture");
    std::fs::write(f.at("half.png"), &png[..png.len() / 2]).expect("written");
    let folder = f.at("");
    let figure = |panel: &str| {
        let told = ["--slide", "17", "--title", "t", "--caption", "c"];
        refuse(&[&["figure", &folder][..], &told, &[panel]].concat())
    };
    for (panel, says) in [
        ("black.png=x", "is black"),
        ("half.png=x", "not whole"),
        ("none.png=x", "cannot be read"),
        ("notes.txt=x", "cannot be read"),
    ] {
        let text = figure(panel);
        let name = panel.split('=').next().expect("a name");
        assert!(text.contains("slide 17") && text.contains(name) && text.contains(says), "{text}");
    }
    assert!(!Path::new(&f.at("figure.json")).exists(), "nothing is written for a broken figure");
    let text = refuse(&["index", &f.at("index.html"), &f.at("12"), &f.at("13")]);
    assert!(text.contains("/12") && text.contains("/13"), "{text}");
    std::fs::write(f.at("t.csv"), "x,y\n1,2\n").expect("written");
    let curve = format!("a={}:x:z", f.at("t.csv"));
    let text = refuse(&["plot", &f.at("a.svg"), "--title", "t", "--x", "x", "--y", "y", &curve]);
    assert!(text.contains("no column z"), "{text}");
}
