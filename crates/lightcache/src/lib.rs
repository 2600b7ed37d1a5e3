//! Caches of light that changes slowly from place to place [slides 7-14]: what irradiance and radiance caching share.
//!
//! Read next: `cache.rs` (records in an octree, and the weights of those near a point), `site.rs` (where a record is
//! valid), `record.rs` (the irradiance record), `gather.rs` (how a record is made from rays over the hemisphere),
//! `control.rs` (how far a record is valid), `fill.rs` (in which order a cache is filled).
//!
//! A [`Cache`] knows only the sites of its records, not their contents: interpolation is written in each technique's
//! `lib.rs`.

#![forbid(unsafe_code)]

pub mod cache;
pub mod control;
pub mod export;
pub mod figures;
pub mod file;
pub mod fill;
pub mod gather;
pub mod gradients;
pub mod guard;
pub mod hemisphere;
pub mod hessian;
pub mod octree;
pub mod options;
pub mod record;
pub mod site;

pub use cache::{Cache, Weighing};
pub use options::Weights;
