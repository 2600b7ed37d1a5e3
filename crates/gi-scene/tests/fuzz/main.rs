//! Damages small valid files in many ways. However a file is damaged, loading it neither panics nor hangs, takes no more
//! than the allowed memory, and gives finite numbers.
//!
//! Inputs that once failed belong into `found`: all of them are loaded too. `tests/coverage` has the same checks, and
//! chooses the damage by what code it reaches.

#[path = "../common/mod.rs"]
mod common;
mod corpus;
mod damage;
mod harness;
mod loaders;

use std::path::Path;

use loaders::{KINDS, Loader};

/// The repository.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Load damaged copies of files until the time is over.
fn fuzz(kind: &str) {
    let loader = Loader::new(kind);
    harness::fuzz(&loader.name, &loader.files, |bytes| loader.check(bytes));
}

#[test]
fn xml_files() {
    fuzz("xml");
    fuzz("sky");
}

#[test]
fn pbrt_files() {
    fuzz("pbrt");
}

#[test]
fn obj_files() {
    fuzz("obj");
}

#[test]
fn material_libraries() {
    fuzz("mtl");
}

#[test]
fn meshes_of_all_formats() {
    fuzz("ply");
    fuzz("serialized");
}

#[test]
fn volumes() {
    fuzz("vol");
}

#[test]
fn pictures_of_all_formats() {
    for kind in ["exr", "pfm", "hdr", "png", "jpg", "tga", "bmp"] {
        fuzz(kind);
    }
}

#[test]
fn files_that_once_failed() {
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/found");
    for entry in std::fs::read_dir(found).unwrap() {
        let path = entry.unwrap().path();
        let kind = path.extension().unwrap_or_default().to_string_lossy().into_owned();
        let checked = harness::guarded(|| match kind.as_str() {
            // What they name is beside them.
            "xml" | "obj" | "pbrt" => loaders::try_load(&path, &loaders::options()),
            kind if KINDS.contains(&kind) => {
                Loader::new(kind).check(&std::fs::read(&path).unwrap())
            }
            _ => Err("no loader reads this kind".into()),
        });
        checked.unwrap_or_else(|why| panic!("{}: {why}", path.display()));
    }
}
