//! Lights, chosen in proportion to their power, or by a tree for the point that they illuminate.
//!
//! Every emitting primitive is a light of its own: a mesh of a thousand triangles is a thousand lights. Many-light
//! methods use the index of a light in their trees.

mod aim;
mod area;
mod ball;
mod distribution;
mod emit;
mod end;
mod environment;
mod kind;
mod sample;
mod slide;
mod source;
mod table;
mod target;
mod tree;

pub use area::{Emitter, EmitterPoint};
pub use distribution::{Discrete, Grid};
pub use emit::{Emission, PointSource};
pub use end::LightEnd;
pub use environment::Environment;
pub use kind::Light;
pub use sample::LightSample;
pub use slide::Slide;
pub use source::{LightSource, Window};
pub use table::Lights;
pub use target::Targets;
pub(crate) use target::sphere_round;
pub use tree::{Facing, LightTree, Vantage};
