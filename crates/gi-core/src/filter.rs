//! Reconstruction filters.

/// A reconstruction filter, separable; lengths in pixels. Radii and constants as in Mitsuba.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// One pixel wide.
    Box,
    /// A triangle of radius 1.
    Tent,
    /// A Gaussian cut at four standard deviations and lowered to end at zero.
    Gaussian {
        /// Standard deviation, 0.5 unless said.
        stddev: f32,
    },
    /// Mitchell-Netravali with parameters (b, c), 1/3 each unless said.
    Mitchell {
        /// Blur.
        b: f32,
        /// Ringing.
        c: f32,
    },
    /// Catmull-Rom.
    CatmullRom,
    /// A windowed sinc.
    Lanczos {
        /// Lobes, 3 unless said.
        lobes: u32,
    },
}
