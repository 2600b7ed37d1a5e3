//! The Python package and its notebook. Where Python or a package that they need is missing, the test says so and ends.

use std::path::Path;
use std::process::Command;

use gi_tests::program::{Folder, said};

use crate::running::{PROGRAMS, path_of};

#[test]
#[allow(clippy::print_stderr)] // a skipped test says so
fn the_python_package_runs_programs_and_its_notebook_draws_its_figures() {
    let needed = "import numpy, matplotlib, OpenEXR; OpenEXR.File";
    let there = Command::new("python3").args(["-c", needed]).output();
    if !there.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: python3 with numpy, OpenEXR 3.3 and matplotlib is not installed");
        return;
    }
    let programs: Vec<_> = PROGRAMS.iter().map(|program| path_of(program.name)).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let figures = Folder::make();
    let output = Command::new("python3")
        .arg("python/tests/check.py")
        .current_dir(&root)
        .env("PYTHONPATH", "python")
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("MPLBACKEND", "agg")
        .env("GILAB_BIN", programs[0].parent().expect("a folder"))
        .env("GILAB_FIGURES", figures.path())
        .envs([("GILAB_SIZE", "64x64"), ("GILAB_PASSES", "20")])
        .output()
        .expect("python3 runs");
    assert!(output.status.success(), "{}", said(&output));
    assert_eq!(figures.files(), ["slide-13.png", "slide-24.png", "slide-42.png"]);
}
