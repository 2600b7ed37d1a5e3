//! The README's commands work as they are typed.

use std::collections::{BTreeMap, BTreeSet};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;

use gi_tests::program::{Folder, said};

use crate::running::path_of;

/// The repository.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

const PROGRAMS: [&str; 8] = [
    "pathtrace",
    "irrcache",
    "radcache",
    "photonmap",
    "ppm",
    "instant-radiosity",
    "lightcuts",
    "compare",
];

/// The commands in blocks of `kind` of a document.
fn commands(file: &Path, kind: &str) -> Vec<String> {
    let text = std::fs::read_to_string(file).expect("a document").replace("\\\n", " ");
    let blocks = text.split("```").skip(1).step_by(2);
    let lines = blocks.filter_map(|block| block.strip_prefix(&format!("{kind}\n")));
    lines.flat_map(str::lines).map(String::from).collect()
}

/// A folder that looks like a clone after `make build`. Its programs make pictures of 24 x 24 pixels, because tests must be quick.
/// Points have no picture.
fn clone() -> Folder {
    let folder = Folder::make();
    std::fs::create_dir_all(folder.at("target/release")).expect("a folder");
    for name in ["scenes", "Makefile", "scripts"] {
        symlink(Path::new(ROOT).join(name), folder.at(name)).expect("a link");
    }
    for program in PROGRAMS {
        let flags = if program == "compare" { "" } else { "--size 24x24" };
        let binary = path_of(program).display().to_string();
        let text = format!(
            "#!/bin/sh\ncase \" $* \" in *' --points '*) exec '{binary}' \"$@\";; esac\nexec '{binary}' \"$@\" {flags}\n"
        );
        let script = folder.at(&format!("target/release/{program}"));
        std::fs::write(&script, text).expect("written");
        std::fs::set_permissions(&script, PermissionsExt::from_mode(0o755)).expect("executable");
    }
    folder
}

/// Run a command in the folder. Of `make`, only whether the target exists is tried.
fn try_command(folder: &Folder, command: &str) {
    for part in command.split("&&") {
        let part = part.split(" #").next().expect("a command").trim();
        let part =
            part.strip_prefix("make ").map_or(part.to_string(), |it| format!("make -n {it}"));
        let output = Command::new("sh").args(["-c", &part]).current_dir(folder.path()).output();
        let output = output.expect("a shell");
        assert!(output.status.success(), "{part}\n{}", said(&output));
    }
}

#[test]
fn the_commands_of_the_readme_work_as_typed() {
    let folder = clone();
    let all = commands(&Path::new(ROOT).join("README.md"), "sh");
    assert!(all.len() >= 6, "{all:?}");
    all.iter().for_each(|command| try_command(&folder, command));
    for file in ["out.exr", "out.png", "photons.exr", "out/first/index.html", "box.json"] {
        assert!(Path::new(&folder.at(file)).exists(), "{file}");
    }
}

/// The options that a text names: `--spp`, also within longer pieces of code.
fn options(text: &str) -> BTreeSet<String> {
    let is_letter = |c: char| c.is_ascii_lowercase() || c == '-';
    let after = text.split("--").skip(1);
    let names = after.map(|rest| rest.split(|c| !is_letter(c)).next().unwrap_or_default());
    let names = names.filter(|name| name.starts_with(|c: char| c.is_ascii_lowercase()));
    names.map(|name| name.trim_end_matches('-').to_string()).collect()
}

/// Options of other tools that the documents name.
const FOREIGN: [&str; 12] = [
    "release",
    "metric",
    "ch",
    "hdr",
    "alb",
    "nrm",
    "snakefile",
    "cores",
    "retries",
    "cpus-per-task",
    "claim",
    "bench",
];

#[test]
fn every_option_that_a_page_names_is_an_option_of_its_program() {
    let help = |program: &&str| {
        let output = Command::new(path_of(program)).arg("--help").output().expect("the program");
        (program.to_string(), options(&String::from_utf8_lossy(&output.stdout)))
    };
    let known: BTreeMap<String, BTreeSet<String>> = PROGRAMS.iter().map(help).collect();
    let all: BTreeSet<&String> = known.values().flatten().collect();
    let mut wrong = Vec::new();
    for entry in std::fs::read_dir(Path::new(ROOT).join("docs")).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|e| e != "md") {
            continue;
        }
        let page = path.file_stem().expect("a name").to_string_lossy().into_owned();
        for option in options(&std::fs::read_to_string(&path).expect("a document")) {
            if !all.contains(&option) && !FOREIGN.contains(&option.as_str()) {
                wrong.push(format!("docs/{page}.md: --{option}"));
            }
        }
    }
    assert!(wrong.is_empty(), "no program has these options:\n{}", wrong.join("\n"));
    // The table of options on a program's page lists only options of that program.
    for (program, own) in &known {
        let text = std::fs::read_to_string(Path::new(ROOT).join(format!("docs/{program}.md")));
        for row in text.expect("a page").lines().filter(|line| line.starts_with("| `--")) {
            let first = row.split('|').nth(1).expect("a cell");
            for option in options(first) {
                assert!(own.contains(&option), "docs/{program}.md: --{option} is no option of it");
            }
        }
    }
}

/// The commands of the techniques' pages; those with a time limit are left out.
#[test]
#[ignore = "minutes"]
fn the_commands_of_the_pages_work_as_typed() {
    let folder = clone();
    std::fs::write(folder.at("sensors.csv"), "278,0,280,0,1,0\n").expect("written");
    let mut count = 0;
    for entry in std::fs::read_dir(Path::new(ROOT).join("docs")).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|e| e != "md") {
            continue;
        }
        for command in commands(&path, "") {
            if command.starts_with("target/release/")
                && !command.starts_with("target/release/compare")
            {
                // A picture has another size here.
                let command = command.replace("--trace-pixel 260,300", "--trace-pixel 12,14");
                try_command(&folder, &command);
                count += 1;
            }
        }
    }
    assert!(count > 10, "{count} commands");
}
