//! Participating media as a scene gives them. (The walks do not scatter in them yet.)

use crate::math::Rgb;

/// A medium of constant density.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Extinction, one over world units.
    pub sigma_t: Rgb,
    /// Scattering over extinction, in [0, 1].
    pub albedo: Rgb,
    /// Where scattered light goes.
    pub phase: Phase,
}

/// A phase function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// The same in all directions.
    Isotropic,
    /// Henyey-Greenstein with mean cosine `g` in (-1, 1).
    HenyeyGreenstein {
        /// Mean cosine of the deflection.
        g: f32,
    },
}
