//! Help and versions of all programs.

use std::path::Path;
use std::process::Command;

use gi_tests::program::{Folder, assert_success, run, scene};

use crate::running::{PROGRAMS, path_of, picture, says};

/// All programs.
fn names() -> impl Iterator<Item = &'static str> {
    PROGRAMS.iter().map(|p| p.name).chain(["compare"])
}

/// The help of a program on a terminal with this width.
fn help(program: &str, flag: &str, columns: usize) -> String {
    let mut command = Command::new(path_of(program));
    let output = command.arg(flag).env("COLUMNS", columns.to_string()).output().expect("it runs");
    assert_success(&output);
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[test]
fn all_programs_have_one_version() {
    for program in names() {
        let output = run(path_of(program).to_str().expect("UTF-8"), &["--version"]);
        let text = String::from_utf8(output.stdout).expect("UTF-8");
        let version = env!("CARGO_PKG_VERSION");
        assert!(text.starts_with(&format!("{program} {version}")), "{text}");
    }
}

#[test]
fn help_is_at_most_as_wide_as_the_terminal_and_breaks_no_word() {
    for program in names() {
        for flag in ["--help", "-h"] {
            let narrow = help(program, flag, 80);
            let words =
                |text: &str| -> Vec<String> { text.split_whitespace().map(String::from).collect() };
            for line in narrow.lines() {
                assert!(line.chars().count() <= 80, "{program} {flag}:\n{line}");
            }
            assert_eq!(words(&narrow), words(&help(program, flag, 100)), "{program} {flag}");
        }
    }
}

#[test]
fn help_has_headings_and_ends_with_an_example() {
    for program in &PROGRAMS {
        let help = help(program.name, "--help", 80);
        let mut at = 0;
        for heading in ["Scene", "Picture", "Budget", "Run", "Technique"] {
            let line = format!("\n{heading}:\n");
            assert!(help.contains(&line), "{}: no {heading}:\n{help}", program.name);
            at = at.max(help.find(&line).unwrap_or(0));
        }
        let example = help.find("\nExample: ").expect("an example");
        assert!(example > at && help[example..].contains(program.name));
        assert!(help.contains("--resume"), "{}", program.name);
        assert_eq!(help.contains("Figures:"), help.contains("--show "), "{}", program.name);
    }
}

#[test]
fn the_example_of_the_help_works() {
    for program in &PROGRAMS {
        let help = help(program.name, "--help", 80);
        let line = help.split("\nExample: ").nth(1).and_then(|text| text.split_once('\n'));
        let (_, line) = line.expect("an example");
        let folder = Folder::make();
        let mut words = line.split_whitespace();
        assert_eq!(words.next(), Some(program.name));
        let mut command = Command::new(path_of(program.name));
        command.args(words.map(|word| match word {
            "scenes/cornell-box.xml" => scene("cornell-box"),
            _ => word.to_string(),
        }));
        command.args(["--size", "16x16"]).args(program.flags).current_dir(folder.path());
        assert_success(&command.output().expect("it runs"));
        assert_eq!(folder.files(), ["out.exr", "out.png", "run.json"]);
    }
}

#[test]
fn man_pages_and_completions_come_from_the_programs() {
    for program in names() {
        let made = |what: &str| {
            let output = run(path_of(program).to_str().expect("UTF-8"), &["--generate", what]);
            assert_success(&output);
            String::from_utf8(output.stdout).expect("UTF-8")
        };
        assert!(made("man").contains(&format!(".TH {program}")), "{program}");
        for shell in ["bash", "zsh", "fish"] {
            assert!(made(shell).contains("quiet"), "{program} {shell}");
        }
    }
}

#[test]
fn pictures_and_statistics_say_which_program_on_which_machine() {
    for program in &PROGRAMS {
        let folder = Folder::make();
        let (scene, out, stats) = (scene("cornell-box"), folder.at("a.exr"), folder.at("a.json"));
        let flags = ["-o", &out, "--stats", &stats, "--size", "8x8", "--spp", "1", "-t", "2"];
        let line = [&[scene.as_str()], &flags[..], program.flags].concat();
        assert_success(&run(path_of(program.name).to_str().expect("UTF-8"), &line));
        let picture = picture(&folder, "a.exr");
        let stats = std::fs::read(Path::new(&stats)).expect("statistics");
        let stats: serde_json::Value = serde_json::from_slice(&stats).expect("JSON");
        assert_eq!(stats["schema"], 1);
        assert_eq!(stats["threads"], 2);
        assert_eq!(says(&picture, "gi.threads"), Some("2"));
        let version = env!("CARGO_PKG_VERSION");
        for (name, value) in
            [("program", program.name), ("version", version), ("date", "20"), ("processor", "")]
        {
            let in_json = stats[name].as_str().expect("text");
            assert_eq!(says(&picture, &format!("gi.{name}")), Some(in_json), "{name}");
            assert!(in_json.starts_with(value) && !in_json.is_empty(), "{name}: {in_json}");
        }
        let isa = stats["instruction_set"].as_str().expect("text");
        assert!(["AVX-512", "AVX2", "SSE2", "portable"].contains(&isa), "{isa}");
        assert!(stats["seconds"]["save"].as_f64().is_some_and(|s| s > 0.0));
    }
}
