//! The knobs.

use gi_core::eye::PathLimits;
use lightcache::Weights;
use lightcache::control::{ErrorControl, SphereRadius};

use crate::figures::Show;
use crate::file::SavedCache;
use crate::sh::{Basis, Window};

/// What glossy surfaces make of the light that comes to them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The dot product of BRDF and light in the basis.
    Sh,
    /// rho_hd(w) E / pi [slide 15]: light as if it were the same from everywhere.
    RhoE,
}

/// The knobs.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// Whether photons supply the light that mirrors and glass focus, instead of paths looking for it.
    pub caustic_photons: bool,
    /// How long paths may be.
    pub limits: PathLimits,
    /// Rays of an irradiance record.
    pub rays: u32,
    /// Rays of a radiance record: narrow lobes average over fewer of them.
    pub glossy_rays: u32,
    /// The accuracy a of irradiance records, relative.
    pub accuracy: f32,
    /// The accuracy a of radiance records.
    pub glossy_accuracy: f32,
    /// Bands of the basis; 0 lets each material choose.
    pub order: u32,
    /// The basis.
    pub basis: Basis,
    /// What is done against ringing.
    pub window: Window,
    /// What glossy surfaces do with the light.
    pub mode: Mode,
    /// Lobes at least this rough are answered from records, narrower ones are path-traced.
    pub min_roughness: f32,
    /// What the error of irradiance records is estimated by.
    pub error: ErrorControl,
    /// The same for radiance records.
    pub glossy_error: ErrorControl,
    /// The split sphere's length.
    pub radius: SphereRadius,
    /// Smallest radius of a record, pixels.
    pub min_spacing: f32,
    /// Largest radius of a record, pixels; 0 is the scene's radius.
    pub max_spacing: f32,
    /// Whether the radii of neighbours limit each other.
    pub neighbour_clamping: bool,
    /// Whether a ray looks for walls between a record and where it is used.
    pub leak_guard: bool,
    /// Whether gradients are followed.
    pub gradients: bool,
    /// How records are weighed.
    pub weights: Weights,
    /// A cache to begin with.
    pub cache: Option<SavedCache>,
    /// What to draw.
    pub figures: Vec<Show>,
}

impl Default for Params {
    fn default() -> Self {
        Params {
            caustic_photons: true,
            limits: PathLimits::default(),
            rays: 1000,
            glossy_rays: 2000,
            accuracy: 0.1,
            glossy_accuracy: 0.1,
            order: 10,
            basis: Basis::Sh,
            window: Window::None,
            mode: Mode::Sh,
            min_roughness: 0.2,
            error: ErrorControl::HessianOcclusion,
            glossy_error: ErrorControl::Bounded,
            radius: SphereRadius::Harmonic,
            min_spacing: 3.0,
            max_spacing: 40.0,
            neighbour_clamping: true,
            leak_guard: true,
            gradients: true,
            weights: Weights::Smooth,
            cache: None,
            figures: Vec::new(),
        }
    }
}
