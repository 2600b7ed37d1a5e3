//! The knobs.

use gi_core::eye::PathLimits;

use crate::file::SavedCache;
use lightcache::Weights;
use lightcache::control::{ErrorControl, SphereRadius};
use lightcache::figures::Figure;
use lightcache::record::Gradients;

/// The knobs.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// Whether photons supply the light that mirrors and glass focus, instead of paths looking for it.
    pub caustic_photons: bool,
    /// How long paths may be.
    pub limits: PathLimits,
    /// Rays of a record.
    pub rays: u32,
    /// The accuracy a, relative.
    pub accuracy: f32,
    /// Levels of caches; `None` lets gather rays go on as paths.
    pub bounces: Option<u32>,
    /// The split sphere's length.
    pub radius: SphereRadius,
    /// What the error is estimated by.
    pub error: ErrorControl,
    /// Smallest radius of a record, pixels.
    pub min_spacing: f32,
    /// Largest radius of a record, pixels; 0 is the scene's radius.
    pub max_spacing: f32,
    /// Whether the radii of neighbours limit each other.
    pub neighbour_clamping: bool,
    /// Whether a ray looks for walls between a record and where it is used.
    pub leak_guard: bool,
    /// Which gradients are followed.
    pub gradients: Gradients,
    /// How records are weighed.
    pub weights: Weights,
    /// A cache to begin with.
    pub cache: Option<SavedCache>,
    /// What to draw.
    pub figures: Vec<Figure>,
}

impl Default for Params {
    fn default() -> Self {
        Params {
            caustic_photons: true,
            limits: PathLimits::default(),
            rays: 1000,
            accuracy: 0.1,
            bounces: None,
            radius: SphereRadius::Harmonic,
            error: ErrorControl::HessianOcclusion,
            min_spacing: 3.0,
            max_spacing: 40.0,
            neighbour_clamping: true,
            leak_guard: true,
            gradients: Gradients::Both,
            weights: Weights::Smooth,
            cache: None,
            figures: Vec::new(),
        }
    }
}
