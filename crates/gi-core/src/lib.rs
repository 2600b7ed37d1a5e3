//! The world and the walks: everything that the techniques share.

pub mod camera;
pub mod filter;
pub mod geometry;
pub mod image_io;
pub mod light;
pub mod material;
pub mod math;
pub mod medium;
pub mod ray;
pub mod rng;
pub mod sampler;
pub mod scene;
pub mod texture;
pub mod warp;
