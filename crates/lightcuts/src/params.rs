//! The knobs.

use gi_core::eye::PathLimits;
use vpl::LightNumbers;

use crate::cut::{Limits, Rule};
use crate::figures::Figure;

/// How a point is lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// By a cut.
    Cuts,
    /// By all lights: brute force.
    All,
    /// By one light drawn from each of so many clusters.
    Stochastic(u32),
    /// By so many lights drawn by importance.
    Some(u32),
}

/// Reconstruction cuts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reconstruction {
    /// Side of a block in pixels.
    pub block: u32,
    /// Difference between samples that is interpolated, relative to the whole.
    pub agree: f32,
}

/// The knobs.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// How long paths may be.
    pub limits: PathLimits,
    /// What a cut may cost and how far it may be wrong.
    pub cut: Limits,
    /// How many points lights have.
    pub lights: LightNumbers,
    /// Whether points of lights are lights too, instead of direct light being sampled.
    pub direct_by_points: bool,
    /// About how many virtual point lights indirect light has.
    pub vpls: u32,
    /// Whether all passes have the lights of the first.
    pub fixed_lights: bool,
    /// Bound of the geometric term of lights of surfaces, in units of one over the squared radius of the scene.
    pub clamp: f32,
    /// Whether paths bring back what the bound cut off.
    pub compensation: bool,
    /// Whether photons supply the light that mirrors and glass focus, instead of paths looking for it.
    pub caustic_photons: bool,
    /// How points are lit.
    pub method: Method,
    /// Reconstruction cuts, if any.
    pub reconstruction: Option<Reconstruction>,
    /// What to draw.
    pub figures: Vec<Figure>,
}

impl Default for Params {
    fn default() -> Self {
        Params {
            limits: PathLimits::default(),
            cut: Limits { error: 0.02, rule: Rule::Whole, max_cut: 1000 },
            lights: LightNumbers { total: 4096, area: None, sky: None, sun: None },
            direct_by_points: true,
            vpls: 16_384,
            fixed_lights: false,
            clamp: 20.0,
            compensation: true,
            caustic_photons: true,
            method: Method::Cuts,
            reconstruction: None,
            figures: Vec::new(),
        }
    }
}
