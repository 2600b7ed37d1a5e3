//! Damages scenes and the files that programs write and read again. Whatever the damage, no program panics or hangs, and
//! the pictures of scenes are finite.
//!
//! Inputs that once failed belong into `found`: all of them are tried too. The loaders alone have tests like these in
//! `gi-scene`. `coverage` has the same checks, and chooses the damage by what code it reaches.

#[path = "../../crates/gi-scene/tests/common/mod.rs"]
mod common;
#[path = "../../crates/gi-scene/tests/fuzz/corpus.rs"]
#[allow(dead_code)] // the loaders' tests use the rest
mod corpus;
#[path = "../../crates/gi-scene/tests/fuzz/damage.rs"]
mod damage;
#[path = "../../crates/gi-scene/tests/fuzz/harness.rs"]
mod harness;
mod pixels;
mod saved;

use std::path::Path;

/// The repository.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

#[test]
fn inputs_that_once_failed() {
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/found");
    let scenes = ["xml", "pbrt"].map(|kind| (kind, pixels::Target::new(kind)));
    let saved = saved::all();
    for entry in std::fs::read_dir(found).expect("the folder") {
        let path = entry.expect("an entry").path();
        let bytes = std::fs::read(&path).expect("a file");
        let kind = path.extension().unwrap_or_default().to_string_lossy().into_owned();
        let saved = saved.iter().find(|target| target.name == kind);
        let scene = scenes.iter().find(|(name, _)| *name == kind);
        let checked = harness::guarded(|| match (saved, scene) {
            (Some(target), _) => target.check_and_use(&bytes),
            (None, Some((_, target))) => target.check(&bytes, None),
            (None, None) => Err("nothing reads this kind".into()),
        });
        checked.unwrap_or_else(|why| panic!("{}: {why}", path.display()));
    }
}
