//! The world and the walks: everything that the techniques share.

pub mod bvh;
pub mod math;
pub mod ray;
pub mod rng;
