//! Options that instant radiosity and lightcuts share.

use clap::{Args, ValueEnum};
use gi_core::options::number;

/// When light paths end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Termination {
    /// Fractional absorption: of N paths, the first N rho^j continue after j scatterings; rho is the mean reflectance
    /// of the scene (Keller97)
    Fractional,
    /// Russian roulette with the reflectance of the surface as the probability to continue
    Roulette,
}

/// How direct light is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Direct {
    /// By sampling the lights
    Sample,
    /// By point lights placed on the lights [slides 47, 48]
    Vpl,
}

/// What happens to light that the bound cuts off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Compensation {
    /// It is lost
    None,
    /// Paths from the eye find it, without bias (Kollig04)
    Path,
}

/// The bound on bright spots near virtual point lights.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
pub struct BoundOptions {
    /// Upper bound on the geometry term cos cos'/d^2 of lights on surfaces, in units of 1 / (scene radius)^2; inf for
    /// no bound
    #[arg(long, value_name = "B", default_value_t = 20.0, value_parser = number("a number above 0, or inf", |b: &f32| *b > 0.0))]
    pub clamp: f32,
    /// What happens to the light that the bound cuts off
    #[arg(long, value_enum, default_value_t = Compensation::Path)]
    pub compensation: Compensation,
}

impl BoundOptions {
    /// A bound without compensation.
    pub fn biased(clamp: f32) -> Self {
        BoundOptions { clamp, compensation: Compensation::None }
    }

    /// A bound with compensation by paths.
    pub fn compensated(clamp: f32) -> Self {
        BoundOptions { clamp, compensation: Compensation::Path }
    }

    /// Whether paths restore the light that the bound cuts off.
    pub fn is_compensated(&self) -> bool {
        self.compensation == Compensation::Path
    }

    /// Whether light is lost: a finite bound without compensation.
    pub fn loses_light(&self) -> bool {
        !self.is_compensated() && self.clamp.is_finite()
    }
}
