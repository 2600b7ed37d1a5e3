//! Tests each signal with each program in each phase, and checks which files remain.

use std::path::Path;

use gi_core::image_io::read_exr;
use gi_tests::program::{Folder, files, scene};

use crate::running::{PROGRAMS, Program, Running, path_of, picture, says, shell, wait_until};

/// The signals that end a run, and the resulting exit statuses.
const SIGNALS: [(&str, i32); 3] = [("INT", 130), ("TERM", 143), ("HUP", 129)];

/// The command line of a run, and the files in its folder.
struct Line {
    scene: String,
    out: String,
    stats: String,
    checkpoint: String,
}

impl Line {
    fn new(folder: &Folder) -> Self {
        let [out, stats, checkpoint] =
            ["out.exr", "run.json", "run.checkpoint"].map(|name| folder.at(name));
        Line { scene: scene("cornell-box"), out, stats, checkpoint }
    }

    fn arguments<'a>(&'a self, program: &Program, more: &[&'a str]) -> Vec<&'a str> {
        let mut all = vec![self.scene.as_str(), "-o", &self.out, "--stats", &self.stats];
        all.extend(["--checkpoint", &self.checkpoint]);
        all.extend(program.flags);
        all.extend(more);
        all
    }
}

/// The files of a run with at least one finished pass.
const ALL_FILES: [&str; 4] = ["out.exr", "out.png", "run.checkpoint", "run.json"];

/// Check a run that was stopped after its first pass; `stopped` if it was stopped before its last.
fn check_saved(program: &Program, folder: &Folder, stopped: bool) {
    assert_eq!(folder.files(), ALL_FILES, "{}", program.name);
    let picture = picture(folder, "out.exr");
    let passes: u64 = says(&picture, "gi.passes").and_then(|n| n.parse().ok()).expect("passes");
    assert!(passes > 0 && picture.channel("Indirect.R").is_some());
    let stats = std::fs::read(folder.at("run.json")).expect("statistics");
    let stats: serde_json::Value = serde_json::from_slice(&stats).expect("JSON");
    assert_eq!(stats["passes"], passes);
    let said = says(&picture, "gi.stopped");
    assert_eq!((said.is_some(), stats["stopped"].is_string()), (stopped, stopped));
    if let Some(said) = said {
        assert!(said.contains(&format!("after {passes} of")), "{said}");
    }
}

/// During reading of the scene, which has so many shapes that this takes more than a second. The address of the live page
/// is printed just before.
fn while_reading(program: &Program, signal: &str, status: i32) {
    let (folder, scenes) = (Folder::make(), Folder::make());
    let scene = scenes.at("scene.xml");
    let shapes = r#"<shape type="sphere"/>"#.repeat(100_000);
    std::fs::write(&scene, format!(r#"<scene version="3.0.0">{shapes}</scene>"#)).expect("written");
    let line = Line { scene, ..Line::new(&folder) };
    let mut run =
        Running::start(program.name, &line.arguments(program, &["--serve", "127.0.0.1:0"]));
    run.wait_for("live page");
    run.signal(signal);
    let (code, said) = run.end();
    assert_eq!(code, Some(status), "{}: {said}", program.name);
    assert!(!said.contains("shapes, "), "{}: it has read the scene: {said}", program.name);
    assert_eq!(folder.files(), [""; 0], "{}", program.name);
}

/// During the preparation, for programs where it can be made long.
fn while_preparing(program: &Program, signal: &str, status: i32) {
    if program.long_preparation.is_empty() {
        return;
    }
    let folder = Folder::make();
    let line = Line::new(&folder);
    let more = [&["--size", "64x64"], program.long_preparation].concat();
    let mut run = Running::start(program.name, &line.arguments(program, &more));
    run.wait_for("shapes, ");
    run.signal(signal);
    let (code, said) = run.end();
    assert_eq!(code, Some(status), "{}: {said}", program.name);
    assert!(said.contains("no picture is written"), "{}: {said}", program.name);
    assert_eq!(folder.files(), [""; 0], "{}", program.name);
}

/// During a pass, in a run with very many passes.
fn in_a_pass(program: &Program, signal: &str, status: i32) {
    let folder = Folder::make();
    let line = Line::new(&folder);
    let more = ["--size", "32x32", "--spp", "100000000"];
    let mut run = Running::start(program.name, &line.arguments(program, &more));
    run.wait_for("prepared in");
    run.signal(signal);
    let (code, said) = run.end();
    assert_eq!(code, Some(status), "{}: {said}", program.name);
    check_saved(program, &folder, true);
}

/// During writing of the picture.
fn while_saving(program: &Program, signal: &str, status: i32) {
    let folder = Folder::make();
    let line = Line::new(&folder);
    let more = ["--size", "320x320", "--spp", "1"];
    let mut run = Running::start(program.name, &line.arguments(program, &more));
    // Wait first: before the preparation, a file of the same name appears briefly, for the check that the picture can
    // be written.
    run.wait_for("prepared in");
    let is_part_of_picture =
        |name: &String| name.starts_with("out.exr.") && name.ends_with(".part");
    wait_until("it saves", || folder.files().iter().any(is_part_of_picture));
    run.signal(signal);
    let (code, said) = run.end();
    assert_eq!(code, Some(status), "{}: {said}", program.name);
    check_saved(program, &folder, false);
}

#[test]
fn signals_leave_no_files_before_the_first_pass_and_all_files_after_it() {
    println!("signal  program            reading  preparing  pass                saving");
    for (signal, status) in SIGNALS {
        for program in &PROGRAMS {
            while_reading(program, signal, status);
            while_preparing(program, signal, status);
            in_a_pass(program, signal, status);
            while_saving(program, signal, status);
            let prepared = if program.long_preparation.is_empty() { "-" } else { "nothing" };
            let files = ALL_FILES.len();
            println!(
                "{signal:<7} {:<18} nothing  {prepared:<10} all {files} files, {status}    all {files} files, {status}",
                program.name
            );
        }
    }
}

#[test]
fn a_second_signal_abandons_the_pass_and_the_picture_has_those_before_it() {
    // Those that prepare quickly in this size.
    let quick = |program: &&Program| ["pathtrace", "ppm", "lightcuts"].contains(&program.name);
    for program in PROGRAMS.iter().filter(quick) {
        let folder = Folder::make();
        let line = Line::new(&folder);
        // A pass that is long enough for two signals.
        let size = if program.name == "lightcuts" { "384x384" } else { "1024x1024" };
        let more = ["--size", size, "--spp", "100000000"];
        let mut run = Running::start(program.name, &line.arguments(program, &more));
        // The checkpoint is written after the first pass; the second pass is long.
        wait_until("there is a pass", || Path::new(&line.checkpoint).exists());
        std::thread::sleep(std::time::Duration::from_millis(500));
        run.signal("INT");
        run.wait_for("finishing this pass");
        run.signal("INT");
        let (code, said) = run.end();
        assert_eq!(code, Some(130), "{}: {said}", program.name);
        check_saved(program, &folder, true);
        assert!(said.contains("abandoning this pass"), "{}: {said}", program.name);
    }
}

#[test]
fn an_abandoned_first_pass_leaves_nothing() {
    let folder = Folder::make();
    let line = Line::new(&folder);
    let program = PROGRAMS.iter().find(|p| p.name == "irrcache").expect("a program");
    let more = ["--component", "direct", "--size", "2500x2500", "--spp", "2"];
    let mut run = Running::start(program.name, &line.arguments(program, &more));
    run.wait_for("prepared in");
    run.signal("TERM");
    run.wait_for("finishing this pass");
    run.signal("TERM");
    let (code, said) = run.end();
    assert_eq!(code, Some(143), "{said}");
    assert!(said.contains("in the first pass"), "{said}");
    assert_eq!(folder.files(), [""; 0]);
}

#[test]
fn a_resumed_run_equals_an_uninterrupted_one_bit_for_bit() {
    let program = &PROGRAMS[0];
    let folder = Folder::make();
    let line = Line::new(&folder);
    let more = ["--size", "32x32", "--spp", "100000000"];
    let mut run = Running::start(program.name, &line.arguments(program, &more));
    run.wait_for("prepared in");
    run.signal("INT");
    assert_eq!(run.end().0, Some(130));
    let passes = says(&picture(&folder, "out.exr"), "gi.passes").expect("passes").to_string();
    let all = (passes.parse::<u32>().expect("a number") + 3).to_string();
    let resumed = ["--size", "32x32", "--resume", "--spp", &all];
    let run = Running::start(program.name, &line.arguments(program, &resumed));
    assert_eq!(run.end().0, Some(0));
    let out = folder.at("whole.exr");
    let whole = [line.scene.as_str(), "-o", &out, "--size", "32x32", "--spp", &all];
    assert_eq!(Running::start(program.name, &whole).end().0, Some(0));
    assert!(picture(&folder, "out.exr").channels == picture(&folder, "whole.exr").channels);
}

/// A program cannot react to this signal, so the last checkpoint must be sufficient.
#[test]
#[ignore = "140 runs, each killed and resumed"]
fn a_run_that_was_killed_resumes_to_the_same_bits() {
    const PASSES: &str = "150";
    let mut killed = 0;
    for program in &PROGRAMS {
        let folder = Folder::make();
        let line = Line::new(&folder);
        let flags = ["--size", "32x32", "--spp", PASSES, "--checkpoint-interval", "1ms"];
        let whole = Running::start(program.name, &line.arguments(program, &flags));
        assert_eq!(whole.end().0, Some(0));
        let whole = picture(&folder, "out.exr").channels;
        for k in 0..20 {
            let folder = Folder::make();
            let line = Line::new(&folder);
            let arguments = line.arguments(program, &flags);
            let run = Running::start(program.name, &arguments);
            wait_until("there is a checkpoint", || Path::new(&line.checkpoint).exists());
            std::thread::sleep(std::time::Duration::from_millis(7 * k));
            run.signal("KILL");
            killed += u32::from(run.end().0.is_none());
            let resume = [&arguments[..], &["--resume"]].concat();
            assert_eq!(Running::start(program.name, &resume).end().0, Some(0));
            assert!(picture(&folder, "out.exr").channels == whole, "{} {k}", program.name);
        }
    }
    println!("{killed} of 140 runs were killed before their end");
    assert!(killed >= 110);
}

#[test]
fn a_signal_that_is_ignored_from_the_start_stays_ignored() {
    let folder = Folder::make();
    let line = Line::new(&folder);
    let more = ["--size", "32x32", "--spp", "100000000"];
    let arguments = line.arguments(&PROGRAMS[0], &more);
    // The shell ignores the signal, as nohup does.
    let mut run = Running::start_command(shell("trap '' HUP", "pathtrace", &arguments));
    run.wait_for("prepared in");
    run.signal("HUP");
    run.signal("TERM");
    assert_eq!(run.end().0, Some(143));
    let picture = picture(&folder, "out.exr");
    let said = says(&picture, "gi.stopped").expect("it was stopped");
    assert!(said.starts_with("by SIGTERM"), "{said}");
}

#[test]
fn compare_stops_its_runs_which_save_their_pictures() {
    PROGRAMS[..2].iter().for_each(|program| drop(path_of(program.name)));
    for (signal, status) in SIGNALS {
        let folder = Folder::make();
        let out = folder.at("out");
        let previews = "all: --preview 100ms";
        let passes = ["--size", "32x32", "--spp", "100000000", "--with", previews];
        let scene = scene("cornell-box");
        let run = Running::start("compare", &[&[scene.as_str(), "-o", &out], &passes[..]].concat());
        let is_picture = |name: &String| name.ends_with(".exr");
        wait_until("a run has made passes", || {
            Path::new(&out).is_dir() && files(Path::new(&out)).iter().any(is_picture)
        });
        run.signal(signal);
        let (code, said) = run.end();
        assert_eq!(code, Some(status), "{said}");
        let left = files(Path::new(&out));
        assert!(left.iter().all(|name| !name.ends_with(".part")), "{left:?}");
        let name = left.iter().find(|name| name.ends_with(".exr")).expect("a picture");
        let picture = read_exr(&Path::new(&out).join(name)).expect("a whole EXR");
        assert!(says(&picture, "gi.stopped").is_some_and(|said| said.contains("after")));
    }
}
