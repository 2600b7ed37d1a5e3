//! The program run as a user runs it: messages, exit status, files.

use std::path::Path;
use std::process::Output;

use gi_core::image_io::read_exr;
use gi_tests::program::{self, Folder, assert_refused, assert_success};

const PROGRAM: &str = env!("CARGO_BIN_EXE_photonmap");

/// Run the program on a scene of the repository, small and quick.
fn run(scene: &str, arguments: &[&str]) -> Output {
    let small = [
        &program::scene(scene),
        "--spp=1",
        "--size=32x24",
        "--photons=5000",
        "--caustic-photons=2000",
    ];
    program::run(PROGRAM, &[&small, arguments].concat())
}

#[test]
fn pictures_maps_and_exports_are_written_and_a_saved_map_gives_the_same_picture() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let (a, map) = (at("a.exr"), at("photons.map"));
    let output = run(
        "cornell-spheres",
        &[
            "-o",
            &a,
            "--map-out",
            &map,
            "--photons-out",
            &at("photons.csv"),
            "--show=paths,photons,cells,gathering",
            "--probe=16,12",
            "--probe-out",
            &at("probe.csv"),
        ],
    );
    assert_success(&output);
    let own = ["paths", "photons", "caustic-photons", "cells", "caustic-gather", "final-gather"];
    for name in own {
        assert!(Path::new(&at(&format!("a.{name}.png"))).exists(), "no {name}");
    }
    let csv = std::fs::read_to_string(at("photons.csv")).expect("a table");
    let of = |map: &str| csv.lines().filter(|l| l.starts_with(map)).count();
    assert!((5000..5040).contains(&of("global,")) && (2000..2010).contains(&of("caustic,")));
    assert_eq!(std::fs::read_to_string(at("probe.csv")).expect("a table").lines().count(), 14);

    for layout in ["fast", "jensen"] {
        let (b, c, saved) = (at("b.exr"), at("c.exr"), at("saved.map"));
        let layout = format!("--photon-layout={layout}");
        let fresh = run("cornell-spheres", &["-o", &b, &layout, "--map-out", &saved]);
        assert_success(&fresh);
        let again = run("cornell-spheres", &["-o", &c, &layout, "--map-in", &saved]);
        assert_success(&again);
        let pixels = |path: &str| read_exr(Path::new(path)).expect("an EXR").channels;
        assert!(pixels(&b) == pixels(&c), "{layout}: another picture");
    }
}

#[test]
fn photons_in_media_are_drawn_exported_and_saved_with_the_others() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let (a, map) = (at("a.exr"), at("photons.map"));
    let fog = |out: &str, more: &[&str]| {
        let mut arguments = vec!["--volume-photons=3000", "--photons=1000", "-o", out];
        arguments.extend(more);
        run("fog", &arguments)
    };
    let (csv, ply) = (at("photons.csv"), at("photons.ply"));
    let output = fog(&a, &["--map-out", &map, "--photons-out", &csv, "--show=photons"]);
    assert_success(&output);
    assert!(Path::new(&at("a.volume-photons.png")).exists());
    let csv = std::fs::read_to_string(csv).expect("a table");
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().expect("a head");
    let rows: Vec<Vec<&str>> = lines.collect();
    assert!(rows.iter().all(|row| row.len() == head.len()));
    // A photon lies on a surface, with a normal, or in a medium, which has a number.
    let in_media: Vec<_> = rows.iter().filter(|row| row[0] == "volume").collect();
    assert!((3000..3100).contains(&in_media.len()), "{} photons", in_media.len());
    assert!(in_media.iter().all(|row| row[11..] == ["", "", "", "0"] && row[1] != "direct"));
    let on_surfaces = rows.iter().filter(|row| row[0] != "volume");
    assert!(on_surfaces.clone().all(|row| !row[11].is_empty() && row[14].is_empty()));

    // Read again, they make the same picture and the same photons.
    let b = at("b.exr");
    let output = fog(&b, &["--map-in", &map, "--photons-out", &ply]);
    assert_success(&output);
    let pixels = |path: &str| read_exr(Path::new(path)).expect("an EXR").channels;
    let shown = |name: &str| name.starts_with("Photons") || name.contains("-photons");
    let first: Vec<_> = pixels(&a).into_iter().filter(|(name, _)| !shown(name)).collect();
    assert!(first == pixels(&b), "another picture");
    let ply = std::fs::read(ply).expect("points");
    let end = b"end_header\n";
    let body = ply.windows(end.len()).position(|w| w == end).expect("a head") + end.len();
    let head = String::from_utf8_lossy(&ply[..body]);
    assert!(head.contains(&format!("element vertex {}\n", rows.len())), "{head}");
    assert_eq!(ply.len() - body, rows.len() * (9 * 4 + 1 + 4));

    // With media and without are not the same light.
    let none = at("none.map");
    assert!(fog(&b, &["--volume-photons=0", "--map-out", &none]).status.success());
    assert_refused(&fog(&b, &["--map-in", &none]), 2, &["without media"]);
    assert_refused(&fog(&b, &["--map-in", &map, "--volume-photons=0"]), 2, &["in media"]);
    assert!(fog(&b, &["--map-in", &none, "--volume-photons=0"]).status.success());
    let marble = |more: &[&str]| {
        run("marble", &[&["--volume-photons=1000", "--photons=1000", "-o", &b], more].concat())
    };
    let stone = at("stone.map");
    assert_success(&marble(&["--map-out", &stone]));
    let refused = marble(&["--map-in", &stone, "--subsurface=dipole"]);
    assert_refused(&refused, 2, &["another --subsurface"]);
}

#[test]
fn what_cannot_be_used_is_refused_with_the_cause() {
    let folder = Folder::make();
    let at = |name: &str| folder.at(name);
    let (out, map) = (at("a.exr"), at("photons.map"));
    assert!(run("cornell-box", &["-o", &out, "--map-out", &map]).status.success());
    let with = |scene: &str, more: &[&str]| {
        let mut arguments = vec!["-o", out.as_str()];
        arguments.extend(more);
        run(scene, &arguments)
    };
    assert_refused(&with("cornell-spheres", &["--map-in", &map]), 2, &["another scene"]);
    assert_refused(&with("cornell-box", &["--map-in", &map, "--max-depth=4"]), 2, &["--max-depth"]);
    let bytes = std::fs::read(&map).expect("the map");
    std::fs::write(at("cut.map"), &bytes[..bytes.len() / 2]).expect("written");
    assert_refused(&with("cornell-box", &["--map-in", &at("cut.map")]), 2, &["damaged"]);
    assert_refused(&with("cornell-box", &["--map-in", &at("none.map")]), 2, &["cannot read"]);
    for (flag, says) in [
        ("--photons=0", "at least 1"),
        ("--lookup=0", "at least 1"),
        ("--max-radius=-1", "0 or more"),
        ("--max-radius=nan", "0 or more"),
        ("--guided=1", "below 1"),
        ("--gather-rays=0", "gather-rays"),
        ("--kernel=sphere", "epanechnikov"),
        ("--photons-out=photons.txt", ".csv"),
    ] {
        assert_refused(&with("cornell-box", &[flag]), 2, &[says]);
    }
}
