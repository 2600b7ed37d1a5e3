//! Tests the recipes, with stand-in programs that only log how they were called.
#![cfg(unix)]

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};

use gi_tests::program::Folder;

/// Make a target with stand-ins for all programs. Runs whose arguments contain `breaks` fail. `None` if make is not
/// installed.
fn make(folder: &Path, breaks: &str, arguments: &[&str]) -> Option<Output> {
    if Command::new("make").arg("--version").output().is_err() {
        eprintln!("skipped: make is not installed");
        return None;
    }
    // Each stand-in writes a line to the log, and its picture unless it fails.
    let script = "#!/bin/sh\necho \"${0##*/} $*\" >> \"${0%/*}/log\"\n\
        case \"$*\" in *\"$BREAKS\"*) exit 1;; esac\n\
        while [ $# -gt 0 ]; do if [ \"$1\" = -o ]; then : > \"$2\"; : > \"${2%.exr}.png\"; fi; shift; done\n";
    for program in ["pathtrace", "irrcache", "ppm", "figures"] {
        let file = folder.join(program);
        std::fs::write(&file, script).expect("a stand-in");
        std::fs::set_permissions(&file, PermissionsExt::from_mode(0o755)).expect("it may run");
    }
    let show = folder.display();
    let output = Command::new("make")
        .args(["-C", concat!(env!("CARGO_MANIFEST_DIR"), "/../.."), "CARGO=true"])
        .args([format!("BIN={show}"), format!("FIGURES_OUT={show}/out")])
        .args(arguments)
        .env_remove("MAKEFLAGS")
        .env("BREAKS", breaks)
        .output();
    Some(output.expect("make runs"))
}

fn log(folder: &Path) -> String {
    std::fs::read_to_string(folder.join("log")).expect("programs were called")
}

const NOTHING: &str = "no command line has these words";

#[test]
fn a_run_that_fails_in_a_loop_fails_the_figure_though_an_older_picture_is_there() {
    let folder = Folder::make();
    let Some(output) = make(folder.path(), NOTHING, &["figure-43", "QUALITY=quick"]) else {
        return;
    };
    assert!(output.status.success(), "{output:?}");
    let drawn = log(folder.path()).matches("figures figure").count();
    let output = make(folder.path(), "--passes 10 ", &["figure-43", "QUALITY=quick"]);
    assert!(
        output.is_some_and(|o| !o.status.success()),
        "the figure was made from an older picture"
    );
    assert_eq!(log(folder.path()).matches("figures figure").count(), drawn);
}

#[test]
fn references_of_quick_figures_are_not_used_for_others() {
    let folder = Folder::make();
    for quality in ["QUALITY=quick", "QUALITY=default", "QUALITY=default"] {
        let Some(output) = make(folder.path(), NOTHING, &["figure-12", quality]) else { return };
        assert!(output.status.success(), "{output:?}");
    }
    let log = log(folder.path());
    let references: Vec<&str> = log.lines().filter(|l| l.starts_with("pathtrace")).collect();
    // One reference with its twin of each size; the last run reuses them.
    assert_eq!(references.len(), 4, "{references:#?}");
    let size = |line: &str| {
        let mut words = line.split_whitespace().skip_while(|w| *w != "--size");
        words.nth(1).map(str::to_string).expect("a reference has a size")
    };
    let sizes: Vec<String> = references.iter().map(|line| size(line)).collect();
    assert!(sizes[0] == sizes[1] && sizes[2] == sizes[3], "{references:#?}");
    assert_ne!(sizes[0], sizes[2], "{references:#?}");
    let seeds = references.iter().map(|line| line.split_once("--seed").map(|(_, s)| &s[..3]));
    assert_eq!(seeds.collect::<Vec<_>>(), [Some(" 98"), Some(" 99"), Some(" 98"), Some(" 99")]);
}

#[test]
fn a_twin_that_is_missing_is_made_again() {
    let folder = Folder::make();
    let draw = || make(folder.path(), NOTHING, &["figure-12", "QUALITY=quick"]);
    let Some(output) = draw() else { return };
    assert!(output.status.success(), "{output:?}");
    let twin = folder.path().join("out/reference-quick/cornell-box.indirect.twin.exr");
    std::fs::remove_file(&twin).expect("the reference has a twin");
    assert!(draw().is_some_and(|o| o.status.success()) && twin.is_file());
}

/// What make says and returns, without running any recipe's programs.
fn refusal(arguments: &[&str]) -> Option<(Option<i32>, String)> {
    let output = make(Folder::make().path(), NOTHING, arguments)?;
    Some((output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned()))
}

#[test]
fn unknown_qualities_and_slides_without_a_figure_are_refused_by_name() {
    for (arguments, says) in [
        (["figure-12", "QUALITY=medium"], ["QUALITY=medium", "quick, default or full"]),
        (["figure-21", "QUALITY=quick"], ["slide 21 has no figure", " 22 23 24 "]),
    ] {
        let Some((code, text)) = refusal(&arguments) else { return };
        assert_eq!(code, Some(2), "{text}");
        assert!(says.iter().all(|s| text.contains(s)), "{text}");
    }
}

#[test]
fn a_slide_that_shares_its_figure_has_a_target_and_help_lists_targets() {
    let folder = Folder::make();
    let Some(output) = make(folder.path(), NOTHING, &["figure-45", "QUALITY=quick"]) else {
        return;
    };
    assert!(output.status.success(), "{output:?}");
    assert!(log(folder.path()).contains("figures figure") && log(folder.path()).contains("43-46"));
    let help = make(folder.path(), NOTHING, &["help"]).expect("make is installed");
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    for target in ["build", "test", "figures", "mistakes", "figure-N"] {
        let line = help.lines().find(|l| l.split_whitespace().next() == Some(target));
        assert!(line.is_some_and(|l| l.len() > 24), "{target}:\n{help}");
    }
}
