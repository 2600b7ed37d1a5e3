//! Scene input: Mitsuba XML (0.5, 0.6 and 3.x), pbrt-v4 and pbrt-v3, and bare OBJ files become a [`gi_core::scene::SceneParts`].
//! There is no second scene representation: the tree of properties is dropped once the scene is built.
//!
//! `document` turns XML into typed properties with source positions; `pbrt` does the same for pbrt's format. `assets`
//! reads meshes and pictures in parallel.
//! `build` makes materials, shapes and lights; the result is [`Loaded`]. A `diagnostics::Report` collects all errors,
//! so that the user sees them at once.
#![forbid(unsafe_code)]

mod added_light;
mod assets;
mod attributes;
mod budget;
mod build;
mod builder;
mod diagnostics;
mod document;
mod emitters;
mod equal_area;
mod export;
mod files;
mod framing;
mod hash;
mod integrator;
mod load;
mod local;
mod materials;
mod media;
mod obj_scene;
mod options;
mod origins;
mod pbrt;
mod precision;
mod rotation;
mod sensor;
mod shapes;
mod sky;
mod spectrum;
mod statements;
mod texels;
mod texts;
mod textures;
mod transform;
mod value;
mod volumes;

pub use diagnostics::Diagnostics;
pub use export::{ExportError, export_mitsuba};
pub use load::load;
pub use options::{AddedLight, CameraOverride, Loaded, Options};
