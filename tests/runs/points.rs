//! `--points`: irradiance at points as a table.

use gi_tests::program::{Folder, assert_refused, assert_success};

use crate::running::start;

/// A closed room that emits 1 and reflects one half: the irradiance is 2 pi everywhere, half of it direct.
const FURNACE: &str = "<scene version='3.0.0'><sensor type='perspective'/>\
    <shape type='cube'><boolean name='flip_normals' value='true'/>\
    <bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf>\
    <emitter type='area'><rgb name='radiance' value='1'/></emitter></shape></scene>";

/// In the air, on a wall, and near an edge.
const POINTS: &str =
    "x y z nx ny nz\n0 0 0.2  0.6 0 0.8\n\n-1,0.3,-0.2, 2,0,0 # on a wall\n0.9 -0.9 0  0 1 0\n";

fn folder() -> Folder {
    let folder = Folder::make();
    std::fs::write(folder.at("scene.xml"), FURNACE).expect("written");
    std::fs::write(folder.at("points.csv"), POINTS).expect("written");
    folder
}

/// A table's header, and its numbers.
fn table(text: &str) -> (Vec<&str>, Vec<Vec<f64>>) {
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().expect("a header");
    let row = |words: Vec<&str>| words.iter().map(|w| w.parse().expect("a number")).collect();
    (header, lines.map(row).collect())
}

/// Every program, with the largest relative error that its bias may have.
#[test]
fn every_program_measures_the_irradiance_of_a_furnace() {
    let folder = folder();
    // Photons are blurred near the edges of the room, and records hold the same light everywhere.
    for (program, flags, bias) in [
        ("pathtrace", "--spp 8", 0.0),
        ("irrcache", "--spp 2 --rays 200", 0.005),
        ("radcache", "--spp 2 --rays 200", 0.005),
        ("photonmap", "--spp 2", 0.02),
        ("ppm", "--spp 8", 0.02),
        ("instant-radiosity", "--spp 16", 0.005),
        ("lightcuts", "--spp 4 --vpls 1000 --lights 500", 0.005),
    ] {
        let out = format!("{program}.csv");
        let flags = format!("--points @points.csv -q --seed 3 -o @{out} {flags}");
        assert_success(&start(&folder, program, &flags));
        let text = std::fs::read_to_string(folder.at(&out)).expect("a table");
        let (header, rows) = table(&text);
        assert_eq!(header[..9], ["x", "y", "z", "nx", "ny", "nz", "r", "g", "b"]);
        assert_eq!(header[9..12], ["se_r", "se_g", "se_b"]);
        assert_eq!(rows.len(), 3, "{program}");
        for row in &rows {
            let expected = std::f64::consts::TAU;
            let (value, error) = (row[7], row[10]);
            // Three of a million results are further away than 4.7 standard errors.
            let most = 4.7 * error + (bias + 1e-5) * expected;
            assert!((value - expected).abs() < most, "{program}: {value} +- {error}");
            assert!(error < 0.05 * expected, "{program}: a standard error of {error}");
            let parts: f64 = [13, 16, 19].iter().map(|k| row[*k]).sum();
            assert!((parts / value - 1.0).abs() < 1e-5, "{program}: components are {parts}");
        }
        assert_eq!(rows[1][..6], [-1.0, 0.3, -0.2, 1.0, 0.0, 0.0], "{program}");
    }
}

#[test]
fn tables_of_merged_shards_have_the_bits_of_a_single_run() {
    let folder = folder();
    let common = "--points @points.csv -q --rays 50";
    let run =
        |flags: &str| assert_success(&start(&folder, "irrcache", &format!("{common} {flags}")));
    run("--spp 6 -o @whole.csv");
    run("--spp 2 -o @a.csv --checkpoint @a");
    run("--spp 4 --first-pass 2 -o @b.csv --checkpoint @b");
    run("--merge @b --merge @a -o @merged.csv");
    let read = |name: &str| std::fs::read(folder.at(name)).expect("a table");
    assert_eq!(read("whole.csv"), read("merged.csv"));
    // The points are a part of what a checkpoint must match.
    std::fs::write(folder.at("points.csv"), "0 0 0 0 0 1\n").expect("written");
    let other = start(&folder, "irrcache", &format!("{common} --merge @a -o @other.csv"));
    assert_refused(&other, 2, &["a", "size"]);
}

#[test]
fn wrong_points_are_refused_by_name() {
    let folder = folder();
    let refuses = |flags: &str, says: &[&str]| {
        assert_refused(&start(&folder, "pathtrace", flags), 2, says);
    };
    std::fs::write(folder.at("short.csv"), "0,0,0,0,0,1\n1,2,3\n").expect("written");
    std::fs::write(folder.at("bytes.csv"), [0xff, 0xfe, 0x00]).expect("written");
    refuses("--points @short.csv -o @out.csv", &["short.csv:2", "1,2,3"]);
    refuses("--points @bytes.csv -o @out.csv", &["bytes.csv", "UTF-8"]);
    refuses("--points @none.csv -o @out.csv", &["none.csv"]);
    refuses("--points /dev/zero -o @out.csv", &["/dev/zero", "regular file"]);
    refuses("--points @points.csv -o @out.exr", &["out.exr", ".csv"]);
    refuses("--points @points.csv -o @points.csv", &["points.csv", "overwrite"]);
    refuses("--points @points.csv -o @out.csv --size 4x4", &["--size"]);
    refuses("--points @points.csv -o @out.csv --mode vcm", &["--mode path"]);
    refuses("--points @points.csv -o @out.csv --mode bdpt --show strategies", &["--show"]);
    assert!(!folder.files().contains(&"out.csv".into()));
    let fog = FURNACE.replace(
        "</shape>",
        "<medium type='homogeneous' name='interior'><rgb name='sigma_t' value='1'/></medium></shape>",
    );
    std::fs::write(folder.at("scene.xml"), fog).expect("written");
    refuses("--points @points.csv -o @out.csv", &["media"]);
}
