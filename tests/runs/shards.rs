//! Runs that are divided into ranges of passes: resumed and merged, they have the bits of a single run.

use std::process::{Command, Output};

use gi_core::image_io::{Layers, read_exr};
use gi_tests::program::{Folder, assert_refused, assert_success, scene};

use crate::running::{PROGRAMS, Program, path_of};

/// Number of passes of a whole run.
const PASSES: u32 = 7;

/// A program with flags whose passes do not depend on each other.
struct Case {
    program: &'static Program,
    flags: Vec<&'static str>,
    folder: Folder,
}

impl Case {
    fn of(program: &'static Program, more: &[&'static str]) -> Self {
        let flags = [program.flags, more].concat();
        Case { program, flags, folder: Folder::make() }
    }

    /// Run it in the Cornell box with glass and a mirror.
    fn run(&self, out: &str, flags: &[&str]) -> Output {
        let (scene, out) = (scene("cornell-spheres"), self.folder.at(out));
        let common = [scene.as_str(), "-o", &out, "--size", "19x13", "-q", "--preview", "0"];
        let mut command = Command::new(path_of(self.program.name));
        command.args(common).args(&self.flags).args(flags).output().expect("it runs")
    }

    /// The picture of a run.
    fn picture(&self, flags: &[&str]) -> Layers {
        let output = self.run("out.exr", flags);
        assert_success(&output);
        read_exr(self.folder.at("out.exr").as_ref()).expect("a picture")
    }

    /// The picture of the whole run.
    fn whole(&self) -> Layers {
        self.picture(&["--spp", &PASSES.to_string()])
    }

    /// Render shards of these numbers of passes. Returns their checkpoints.
    fn shards(&self, passes: &[u32]) -> Vec<String> {
        let mut first = 0;
        let mut paths = Vec::new();
        for (k, passes) in passes.iter().enumerate() {
            let path = self.folder.at(&format!("{k}.checkpoint"));
            let (from, count) = (first.to_string(), passes.to_string());
            let threads = ["1", "2"][k % 2];
            self.picture(&[
                "--first-pass",
                &from,
                "--spp",
                &count,
                "--checkpoint",
                &path,
                "-t",
                threads,
            ]);
            first += passes;
            paths.push(path);
        }
        paths
    }

    /// The picture of shards, merged in this order.
    fn merged<'p>(&self, paths: impl Iterator<Item = &'p String>) -> Layers {
        let flags: Vec<&str> = paths.flat_map(|path| ["--merge", path.as_str()]).collect();
        self.picture(&flags)
    }

    fn assert_same(&self, what: &str, a: &Layers, b: &Layers) {
        for ((name, a), (_, b)) in a.channels.iter().zip(&b.channels) {
            let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<u32>>();
            assert!(bits(a) == bits(b), "{} {:?}, {what}: {name}", self.program.name, self.flags);
        }
        assert_eq!(a.channels.len(), b.channels.len());
    }
}

/// Every program, in every mode whose passes are independent.
fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for program in &PROGRAMS {
        let modes: &[&[&'static str]] = match program.name {
            "pathtrace" => &[
                &["--mode", "path"],
                &["--mode", "light"],
                &["--mode", "bdpt"],
                &["--mode", "vcm"],
            ],
            "ppm" => &[&["--method", "ppa"]],
            "lightcuts" => &[
                &[],
                &["--method", "stochastic"],
                &["--method", "multidimensional", "--gather", "3"],
            ],
            _ => &[&[]],
        };
        cases.extend(modes.iter().map(|mode| Case::of(program, mode)));
    }
    cases
}

#[test]
fn resumed_and_merged_runs_have_the_bits_of_a_single_run_in_every_layer() {
    for case in cases() {
        let whole = case.whole();
        // Resumed.
        let kept = case.folder.at("kept");
        case.picture(&["--spp", "3", "--checkpoint", &kept]);
        let all = PASSES.to_string();
        let resumed = case.picture(&["--spp", &all, "--checkpoint", &kept, "--resume"]);
        case.assert_same("resumed", &whole, &resumed);
        // Two shards, and as many as passes, in two orders.
        let two = case.shards(&[3, PASSES - 3]);
        case.assert_same("2 shards", &whole, &case.merged(two.iter()));
        let seven = case.shards(&[1; PASSES as usize]);
        case.assert_same("7 shards", &whole, &case.merged(seven.iter()));
        case.assert_same("7 shards, backward", &whole, &case.merged(seven.iter().rev()));
    }
}

#[test]
fn shards_that_overlap_or_leave_a_gap_are_refused_by_name() {
    let case = Case::of(&PROGRAMS[0], &[]);
    let shards = case.shards(&[2, 1, 2]);
    let refused = |which: &[usize], words: &[&str]| {
        let flags: Vec<&str> =
            which.iter().flat_map(|k| ["--merge", shards[*k].as_str()]).collect();
        assert_refused(&case.run("m.exr", &flags), 2, words);
    };
    refused(&[0, 2], &["2.checkpoint", "begins with pass 3", "no file holds 2"]);
    refused(&[1, 2], &["1.checkpoint", "no file holds 0 to 1"]);
    refused(&[0, 1, 2, 0], &["0.checkpoint", "0 to 1 are in another file too"]);
    let bytes = std::fs::read(&shards[1]).expect("a checkpoint");
    std::fs::write(&shards[1], &bytes[..bytes.len() / 2]).expect("written");
    refused(&[0, 1, 2], &["1.checkpoint", "damaged"]);
}

#[test]
fn checkpoints_of_other_options_are_refused_by_the_name_of_the_option() {
    for program in &PROGRAMS {
        let case = Case::of(program, &[]);
        let kept = case.folder.at("kept");
        case.picture(&["--spp", "1", "--checkpoint", &kept]);
        let refused = |flags: &[&str], words: &[&str]| {
            let resume = ["--checkpoint", kept.as_str(), "--resume", "--spp", "2"];
            assert_refused(&case.run("o.exr", &[flags, &resume[..]].concat()), 2, words);
        };
        refused(&["--max-depth", "3"], &["another --max-depth: -1, not 3"]);
        refused(&["--seed", "9"], &["another seed: 0, not 9"]);
        refused(&["--size", "8x8"], &["another picture size: 19 x 13, not 8 x 8"]);
        // Writing a file or a picture of the technique changes no pass.
        let output = case
            .run("o.exr", &["--checkpoint", &kept, "--resume", "--max-depth", "-1", "--spp", "2"]);
        assert_success(&output);
    }
}

#[test]
fn a_light_that_was_added_belongs_to_the_scene_of_checkpoints_caches_and_maps() {
    let pathtrace = Case::of(&PROGRAMS[0], &[]);
    let kept = pathtrace.folder.at("kept");
    pathtrace.picture(&["--spp", "1", "--light", "sky", "--checkpoint", &kept]);
    for light in [&[][..], &["--light", "headlight"]] {
        let resume = [&["--spp", "2", "--checkpoint", &kept, "--resume"], light].concat();
        assert_refused(&pathtrace.run("o.exr", &resume), 2, &["another scene"]);
    }
    let cache = Case::of(&PROGRAMS[1], &[]);
    let saved = cache.folder.at("saved");
    cache.picture(&["--spp", "1", "--light", "studio", "--cache-out", &saved]);
    let other = cache.run("o.exr", &["--spp", "1", "--cache-in", &saved]);
    assert_refused(&other, 2, &["another scene"]);
}

#[test]
fn runs_of_a_method_whose_passes_build_on_each_other_merge_over_their_seeds() {
    let ppm = PROGRAMS.iter().find(|program| program.name == "ppm").expect("a program");
    for method in ["sppm", "adaptive", "ppm"] {
        merge_over_seeds(&Case::of(ppm, &["--method", method]));
    }
}

fn merge_over_seeds(case: &Case) {
    let render = |seed: &str| {
        let kept = case.folder.at(&format!("seed-{seed}"));
        // What a run draws or traces does not matter for the merge.
        let trace = ["--trace-pixel", "3,3", "--trace-out", &case.folder.at("trace.csv")];
        let flags = ["--spp", "4", "--seed", seed, "--checkpoint", &kept, "--show", "error"];
        (case.picture(&[&flags[..], &trace].concat()), kept)
    };
    let [(a, kept_a), (b, kept_b)] = ["1", "2"].map(render);
    let merged = case.picture(&["--merge", &kept_a, "--merge", &kept_b]);
    let red = |layers: &Layers| layers.channel("R").expect("a channel").to_vec();
    for ((a, b), m) in red(&a).into_iter().zip(red(&b)).zip(red(&merged)) {
        let mean = 0.5 * (a + b);
        assert!((m - mean).abs() <= 1e-5 * mean.max(1e-3), "{m}, not {mean}");
    }
    let twice = case.run("m.exr", &["--merge", &kept_a, "--merge", &kept_a]);
    assert_refused(&twice, 2, &["same seed", "seed-1"]);
    for (flags, word) in [
        (&["--show", "radius"][..], "--show"),
        (&["--trace-pixel", "3,3", "--trace-out", &case.folder.at("t.csv")], "--trace-out"),
    ] {
        let merge = ["--merge", kept_a.as_str(), "--merge", &kept_b];
        assert_refused(&case.run("m.exr", &[flags, &merge].concat()), 2, &[word, "one run"]);
    }
}

#[test]
fn shards_of_one_saved_cache_or_map_have_the_bits_of_a_single_run() {
    for (name, out, read) in [
        ("irrcache", "--cache-out", "--cache-in"),
        ("radcache", "--cache-out", "--cache-in"),
        ("photonmap", "--map-out", "--map-in"),
    ] {
        let program = PROGRAMS.iter().find(|program| program.name == name).expect("a program");
        let case = Case::of(program, &[]);
        let saved = case.folder.at("saved");
        let whole = case.picture(&["--spp", "4", out, &saved]);
        let kept: Vec<String> = ["0", "2"]
            .iter()
            .map(|first| {
                let kept = case.folder.at(&format!("from-{first}"));
                case.picture(&[
                    "--first-pass",
                    first,
                    "--spp",
                    "2",
                    read,
                    &saved,
                    "--checkpoint",
                    &kept,
                ]);
                kept
            })
            .collect();
        let merge = ["--merge", kept[0].as_str(), "--merge", &kept[1], read, &saved];
        case.assert_same("from a file", &whole, &case.picture(&merge));
        // Another set of records or photons is not the same run.
        let other = case.folder.at("other");
        case.picture(&["--spp", "1", "--seed", "5", out, &other]);
        let merge = ["--merge", kept[0].as_str(), "--merge", &kept[1], read, &other];
        assert_refused(&case.run("m.exr", &merge), 2, &["another set of records or photons"]);
    }
}

#[test]
fn lights_of_the_last_pass_are_drawn_and_written_after_a_merge_and_after_resuming_a_finished_run() {
    for (name, flags) in [
        ("instant-radiosity", ["--show", "vpls,connections", "--vpls-out"]),
        ("lightcuts", ["--show", "clusters", "--lights-out"]),
    ] {
        let program = PROGRAMS.iter().find(|program| program.name == name).expect("a program");
        let case = Case::of(program, &flags[..2]);
        let written = |what: &str, more: &[&str]| {
            let [lights, stats] = ["lights.csv", "stats.json"].map(|name| case.folder.at(name));
            let picture = case.picture(&[&[flags[2], &lights, "--stats", &stats], more].concat());
            let stats = std::fs::read_to_string(stats).expect("statistics");
            let mut stats: serde_json::Value = serde_json::from_str(&stats).expect("JSON");
            let mut numbers = stats["technique"].take();
            numbers.as_object_mut().expect("names").remove("tree_seconds");
            let lights = std::fs::read_to_string(lights).expect("a table");
            assert!(lights.lines().count() > 3, "{name}, {what}: there are no lights");
            (picture, lights, numbers)
        };
        let whole = written("whole", &["--spp", "7"]);
        let shards = case.shards(&[3, 4]);
        let merge = ["--merge", shards[1].as_str(), "--merge", &shards[0]];
        let kept = case.folder.at("kept");
        case.picture(&["--spp", "7", "--checkpoint", &kept]);
        let resume = ["--spp", "7", "--checkpoint", kept.as_str(), "--resume"];
        for (what, flags) in [("merged", &merge[..]), ("resumed", &resume[..])] {
            let again = written(what, flags);
            case.assert_same(what, &whole.0, &again.0);
            assert!(whole.1 == again.1, "{name}, {what}: other lights");
            assert_eq!(whole.2, again.2, "{name}, {what}");
        }
    }
}

#[test]
fn numbers_of_the_last_pass_are_known_after_a_merge() {
    let case = Case::of(&PROGRAMS[0], &["--mode", "vcm"]);
    let shards = case.shards(&[1, 1]);
    let stats = case.folder.at("stats.json");
    case.picture(&["--merge", &shards[0], "--merge", &shards[1], "--stats", &stats]);
    let stats = std::fs::read_to_string(stats).expect("statistics");
    let stats: serde_json::Value = serde_json::from_str(&stats).expect("JSON");
    assert!(stats["technique"]["light_vertices"].as_f64() > Some(0.0), "{stats}");
}

#[test]
fn a_merge_that_is_to_resume_is_refused() {
    let case = Case::of(&PROGRAMS[0], &[]);
    let shards = case.shards(&[1]);
    let output = case.run("m.exr", &["--merge", &shards[0], "--resume"]);
    assert_refused(&output, 2, &["--merge", "--resume"]);
}
