//! pbrt files: what is read from each of the scenes in `scenes`, errors, and hostile files.

#[path = "../common/mod.rs"]
mod common;
mod errors;
mod export;
mod lights;
mod pictured_lights;
mod surfaces;
mod world;

use std::path::{Path, PathBuf};

use gi_core::geometry::Mesh;
use gi_core::geometry::{Geometry, Shape};
use gi_core::material::Material;
use gi_scene::{Loaded, Options, load};

/// The path of one of the scenes.
fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pbrt/scenes").join(name)
}

/// Load one of the scenes.
fn scene(name: &str) -> Loaded {
    load(&path(name), &Options::default()).unwrap_or_else(|problems| panic!("{problems}"))
}

/// Load a scene with a sphere-free world of these directives.
fn world(directives: &str) -> Loaded {
    let text = format!("Camera \"perspective\"\nWorldBegin\n{directives}\n");
    let folder = common::Folder::new();
    let path = folder.write("scene.pbrt", text);
    load(&path, &Options::default()).unwrap_or_else(|problems| panic!("{problems}"))
}

/// The mesh of a shape.
fn mesh(shape: &Shape) -> &Mesh {
    match &shape.geometry {
        Geometry::Mesh(mesh) => mesh,
        other => panic!("{other:?} is no mesh"),
    }
}

/// The material of the n-th shape, inside `twosided`.
fn inner(loaded: &Loaded, n: usize) -> &Material {
    let materials = &loaded.parts.materials;
    match &materials[loaded.parts.shapes[n].material] {
        Material::TwoSided { front, back } if front == back => &materials[*front],
        other => other,
    }
}

/// The warnings without their places.
fn warnings(loaded: &Loaded) -> Vec<&str> {
    loaded
        .warnings
        .iter()
        .map(|w| w.split_once(".pbrt:").map_or(w.as_str(), |(_, rest)| rest))
        .collect()
}
