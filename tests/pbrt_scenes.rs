//! Renders scenes in pbrt's format.

use std::path::{Path, PathBuf};

use gi_core::film::Show;
use gi_scene::{Options, load};
use gi_tests::World;
use pathtrace::{Params, PathTracer};

use crate::agreement::assert_agree;

/// The folder of the scenes that test the loader.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/gi-scene/tests/pbrt/scenes")
}

/// The world of one of them.
fn world(name: &str, size: [usize; 2]) -> World {
    let options = Options { size: Some(size), ..Options::default() };
    let loaded = load(&folder().join(name), &options);
    let loaded = loaded.unwrap_or_else(|problems| panic!("{problems}"));
    World::new(loaded.parts, &loaded.camera)
}

#[test]
fn the_cornell_box_has_the_same_picture_as_pbrt_and_as_xml() {
    let size = [32, 32];
    let xml = World::load("cornell-box.xml", size, &[]);
    let pbrt = world("cornell-box.pbrt", size);
    let render =
        |world: &World, seed| world.render::<PathTracer>(&Params::default(), 128, seed, Show::All);
    assert_agree("cornell-box", &render(&xml, 1), &render(&pbrt, 2), 4);
}

#[test]
fn all_scenes_have_a_picture() {
    let mut names: Vec<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".pbrt"))
        .collect();
    names.sort();
    assert!(names.len() >= 12, "{names:?}");
    for name in names {
        let world = world(&name, [24, 16]);
        let film = world.render::<PathTracer>(&Params::default(), 4, 0, Show::All);
        let layers = film.layers();
        let pixels = layers.interleaved(["R", "G", "B"]).expect("colours");
        assert!(pixels.iter().all(|v| v.is_finite() && *v >= 0.0), "{name}");
        let lit = pixels.iter().filter(|v| **v > 0.0).count();
        assert!(4 * lit > pixels.len(), "{name}: {lit} of {} numbers are not zero", pixels.len());
    }
}
