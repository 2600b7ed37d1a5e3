//! Functions that the tests of the program share.

use std::path::Path;
use std::process::{Command, Output};

use gi_core::image_io::{ImageFile, Layers, write_file};

/// Run the program.
pub(crate) fn run(arguments: &[&str]) -> Output {
    gi_tests::program::run(env!("CARGO_BIN_EXE_compare"), arguments)
}

/// Make sure that two techniques' programs exist beside this one. They do if the whole workspace is tested.
pub(crate) fn build_programs() {
    let beside = Path::new(env!("CARGO_BIN_EXE_compare")).parent().expect("a folder");
    for program in ["pathtrace", "photonmap"] {
        if beside.join(format!("{program}{}", std::env::consts::EXE_SUFFIX)).exists() {
            continue;
        }
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["build", "--quiet", "-p", program]);
        if beside.ends_with("release") {
            cargo.arg("--release");
        }
        cargo.arg("--target-dir").arg(beside.parent().expect("a target folder"));
        assert!(cargo.status().expect("cargo runs").success(), "{program} cannot be built");
    }
}

/// Save a picture; each channel has a name and a formula of the pixel's index.
pub(crate) fn save(
    path: &str,
    [width, height]: [usize; 2],
    channels: &[(&str, &dyn Fn(usize) -> f32)],
) {
    let channels = channels
        .iter()
        .map(|(name, of)| (name.to_string(), (0..width * height).map(of).collect()))
        .collect();
    let layers = Layers { width, height, channels, ..Layers::default() };
    write_file(Path::new(path), ImageFile::Exr, &layers).expect("it is written");
}

/// Save a picture with channels R, G, B.
pub(crate) fn save_rgb(path: &str, size: [usize; 2], of: &dyn Fn(usize) -> [f32; 3]) {
    save(path, size, &[("R", &|i| of(i)[0]), ("G", &|i| of(i)[1]), ("B", &|i| of(i)[2])]);
}
