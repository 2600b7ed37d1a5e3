//! Scene input: Mitsuba XML (0.5, 0.6 and 3.x) and bare OBJ files become a [`gi_core::scene::SceneParts`].
//! It is no second scene representation: a file's tree of properties is read once and forgotten.
//!
//! The way of a file: `document` (text to typed properties with their places) -> `assets` (meshes and
//! pictures, in parallel) -> `build` (materials, shapes, lights) -> [`Loaded`]. Every problem met on the
//! way is noted in a `diagnostics::Report`, so that all of them are shown at once.
#![forbid(unsafe_code)]

mod assets;
mod build;
mod bytes;
mod diagnostics;
mod document;
mod emitters;
mod export;
mod files;
mod framing;
mod hash;
mod integrator;
mod load;
mod materials;
mod media;
mod obj_scene;
mod sensor;
mod shapes;
mod sky;
mod spectrum;
mod statements;
mod texels;
mod textures;
mod transform;
mod value;

pub use diagnostics::Diagnostics;
pub use export::{ExportError, export_mitsuba};
pub use load::{CameraOverride, Loaded, Options, load};
