//! Runs the program as a user would: messages, exit status, files.

use std::path::Path;
use std::process::Output;

use gi_core::image_io::read_exr;
use gi_tests::program::{self, Folder, assert_refused, assert_success};

const PROGRAM: &str = env!("CARGO_BIN_EXE_lightcuts");

/// Run the program on a scene of the repository, with a small picture.
fn run(scene: &str, arguments: &[&str]) -> Output {
    let small = [&program::scene(scene), "--spp=1", "--size=32x24", "--lights=200", "--vpls=300"];
    program::run(PROGRAM, &[&small, arguments].concat())
}

#[test]
fn pictures_and_tables_are_written_and_every_bound_in_them_holds() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let output = run(
        "gallery",
        &[
            "-o",
            &at("a.exr"),
            "--show=cut-size,bounds,clusters,tree",
            "--bounds-out",
            &at("bounds.csv"),
            "--lights-out",
            &at("lights.ply"),
        ],
    );
    assert_success(&output);
    for name in ["a.cut-size.png", "a.bounds.png", "a.clusters-8.png", "a.tree.png", "lights.ply"] {
        assert!(Path::new(&at(name)).exists(), "no {name}");
    }
    let layers = read_exr(Path::new(&at("a.exr"))).expect("an EXR");
    let sizes = layers.channel("Cut-size.Clusters").expect("a layer");
    assert!(sizes.iter().all(|s| *s <= 1000.0) && sizes.iter().any(|s| *s > 10.0));
    let csv = std::fs::read_to_string(at("bounds.csv")).expect("a table");
    let mut rows = 0;
    for line in csv.lines().skip(1) {
        let numbers: Vec<f32> = line.split(',').map(|t| t.parse().expect("a number")).collect();
        let [error, bound] = [numbers[6], numbers[7]];
        assert!(error <= bound, "{line}");
        rows += 1;
    }
    assert!(rows > 1000, "{rows} clusters");
}

#[test]
fn cut_sizes_of_pixels_count_pairs() {
    let folder = Folder::make();
    let out = folder.at("a.exr");
    let how = ["--method=multidimensional", "--gather=4", "--show=cut-size", "--error=0.1"];
    assert_success(&run("gallery", &[&["-o", out.as_str()], &how[..]].concat()));
    let layers = read_exr(Path::new(&out)).expect("an EXR");
    let sizes = layers.channel("Cut-size.Clusters").expect("a layer");
    assert!(sizes.iter().all(|s| *s <= 1000.0) && sizes.iter().any(|s| *s > 10.0));
}

#[test]
fn four_lights_have_the_cuts_of_the_lecture() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let arguments = ["-D", "lights=4", "--lights=4", "--component=direct", "--show=cuts"];
    let files = ["-o", &at("a.exr"), "--cuts-out", &at("cuts.csv")];
    let output = run("gallery", &[&arguments[..], &files[..]].concat());
    assert_success(&output);
    let csv = std::fs::read_to_string(at("cuts.csv")).expect("a table");
    let rows: Vec<Vec<&str>> = csv.lines().skip(1).map(|l| l.split(',').collect()).collect();
    let sizes: Vec<&str> = rows.iter().map(|r| r[1]).collect();
    // One light per lamp; the lamps form two pairs of neighbours.
    assert_eq!(sizes, ["4", "3", "3", "2", "1"], "{csv}");
    let errors: Vec<f32> = rows.iter().map(|r| r[3].parse().expect("a number")).collect();
    assert!(errors[0] == 0.0 && errors[1] > 0.0 && errors[4] > errors[1], "{csv}");
    assert!(Path::new(&at("a.cut-4.png")).exists());
}

#[test]
fn the_table_of_trees_has_each_light_in_one_cluster_of_the_cut() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let arguments = ["-D", "lights=4", "--lights=16", "--component=direct", "--error=0.1"];
    let files = ["-o", &at("a.exr"), "--tree-out", &at("tree.csv")];
    assert_success(&run("gallery", &[&arguments[..], &files[..]].concat()));
    let csv = std::fs::read_to_string(at("tree.csv")).expect("a table");
    let column = |name: &str| -> Vec<f32> {
        let k = csv.lines().next().and_then(|l| l.split(',').position(|c| c == name)).expect(name);
        let number = |l: &str| l.split(',').nth(k).expect(name).parse().expect("a number");
        csv.lines().skip(1).map(number).collect()
    };
    let (lights, extents, in_cut) = (column("lights"), column("extent"), column("in_cut"));
    assert_eq!((lights.len(), lights[0]), (31, 16.0), "{csv}");
    assert_eq!(in_cut.iter().sum::<f32>(), 16.0, "{csv}");
    let is_light = |k: &usize| lights[*k] == 1.0;
    assert!((0..31).filter(is_light).all(|k| extents[k] == 0.0), "{csv}");
    let parents = csv.lines().skip(1).map(|l| l.split(',').nth(2).expect("parent"));
    assert!(parents.enumerate().all(|(k, p)| p.parse().map_or(k == 0, |p: usize| p < k)), "{csv}");
    assert!(extents[1..].iter().all(|e| *e < extents[0]), "{csv}");
}

#[test]
fn invalid_options_are_refused_with_a_way_out() {
    assert_refused(&run("gallery", &["--error=2"]), 2, &["from 0 to 1"]);
    assert_refused(&run("gallery", &["--lights=moon=3"]), 2, &["area, sky or sun"]);
    assert_refused(&run("gallery", &["--clamp=-1"]), 2, &["above 0, or inf"]);
    assert_refused(&run("gallery", &["--max-cut=0"]), 2, &["--max-cut"]);
    assert_refused(&run("gallery", &["--pixel=7"]), 2, &["X,Y"]);
    assert_refused(&run("gallery", &["--lights-out=lights.txt"]), 2, &[".ply or .csv"]);
    assert_refused(&run("gallery", &["--reconstruct", "--method=one"]), 2, &["--method cuts only"]);
    let of_points = ["--show=bounds", "--method=multidimensional"];
    assert_refused(&run("gallery", &of_points), 2, &["cuts of pixels", "--method cuts"]);
    assert_refused(&run("gallery", &["--gather=0"]), 2, &["--gather"]);
}

#[test]
fn a_resumed_run_makes_the_picture_of_one_run() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let kept = at("run.state");
    let render = |name: &str, flags: &[&str]| {
        let out = at(name);
        let output = run("cornell-box", &[&["-o", out.as_str()], flags].concat());
        assert_success(&output);
        read_exr(Path::new(&out)).expect("an EXR").channels
    };
    let whole = render("whole.exr", &["--passes=3"]);
    let keep = ["--checkpoint", kept.as_str()];
    render("first.exr", &[&keep[..], &["--passes=1"]].concat());
    let resumed = render("rest.exr", &[&keep[..], &["--passes=3", "--resume"]].concat());
    assert!(resumed == whole, "resumed: another picture");
    let other = [&keep[..], &["--passes=3", "--resume", "--error=0.1"]].concat();
    assert_refused(&run("cornell-box", &other), 2, &["another --error: 0.02, not 0.1"]);
}
