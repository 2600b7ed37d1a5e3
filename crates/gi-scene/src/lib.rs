//! Scene input: Mitsuba XML (0.5, 0.6 and 3.x) and bare OBJ files become a [`gi_core::scene::SceneParts`].
//! It is no second scene representation: a file's tree of properties is read once and forgotten.
#![forbid(unsafe_code)]

mod diagnostics;

pub use diagnostics::Diagnostics;
