//! t
#![forbid(unsafe_code)]
pub mod rotate;
pub mod sh;
