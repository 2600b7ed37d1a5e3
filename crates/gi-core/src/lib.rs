//! The scene, and the walks of eye paths and light paths: everything that the techniques share.
//!
//! | symbol | here |
//! |---|---|
//! | x, n(x) | [`geometry::Surface`]: `p`, `ng` (geometric), `ns()` (shading) |
//! | omega_o, omega_i | `wo` toward the eye, `wi` toward the light: unit, world space, pointing away from the surface |
//! | f_r, f_s | [`bsdf::Bsdf::f`]; with the cosine of `wi` in it [`bsdf::Bsdf::f_cos`] |
//! | p(omega) | `pdf_w`, per solid angle; `pdf_a`, per area |
//! | L_e, L_i | [`scene::Scene::emitted`], [`scene::Scene::sample_light`]; radiance is [`math::Rgb`] |
//! | Phi | `power` of a light path, [`walk::LightVertex`]; `throughput` for camera paths, [`eye::EyeWalk`] |
//! | V(x, y) | [`scene::Scene::transmittance`] |
//!
//! A technique sees [`scene::Scene`], [`camera::Camera`] and [`film::Film`], draws its numbers from
//! [`sampler::Sampler`], and implements [`technique::Technique`].

pub mod bsdf;
pub mod bytes;
pub mod camera;
pub mod canvas;
pub mod caustics;
pub mod disc;
pub mod eye;
pub mod files;
pub mod film;
pub mod filter;
pub mod geometry;
pub mod grid;
pub mod guard;
pub mod image_io;
pub mod light;
pub mod material;
pub mod math;
pub mod medium;
pub mod nee;
pub mod options;
pub mod points;
pub mod progress;
pub mod rng;
pub mod sampler;
pub mod scene;
pub mod technique;
pub mod texture;
pub mod walk;
pub mod warp;

pub use gi_bvh::{ISA_VARIABLE, check_instruction_set, instruction_set, ray};
