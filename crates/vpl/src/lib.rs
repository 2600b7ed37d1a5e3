//! Virtual point lights: where light paths meet surfaces, light starts again [slides 47-50, Keller97]. Instant
//! radiosity and lightcuts share them.
//!
//! The power of a light is already divided by the number of paths: the light at a point is the sum over all lights.
//!
//! Read next: `shoot.rs` (light paths leave lights), `illuminate.rs` (one light illuminates a point), `prepared.rs`
//! (many lights illuminate a point), `points.rs` (lights on light sources).

#![forbid(unsafe_code)]

mod energy;
mod export;
mod illuminate;
mod light;
mod options;
mod points;
mod prepared;
mod shoot;

pub use energy::Energy;
pub use export::{to_csv, to_file, to_ply};
pub use illuminate::{Connection, Receiver, Scatterer};
pub use light::{Kind, LitSurface, MIN_ROUGHNESS, Vpl, Vpls};
pub use options::{BoundOptions, Compensation, Direct, Termination};
pub use points::{LightNumbers, points};
pub use prepared::{Contribution, Prepared};
pub use shoot::{Pilot, Shooting, shoot};
