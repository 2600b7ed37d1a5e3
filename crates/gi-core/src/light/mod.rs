//! Lights.

mod source;

pub use source::LightSource;
