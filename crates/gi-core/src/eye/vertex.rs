//! A vertex of the eye walk, and the estimate that a technique may add there.

use crate::medium::MediumId;
use glam::Vec3;

use crate::bsdf::{Bsdf, DiffusePart};
use crate::geometry::Surface;
use crate::math::Rgb;

/// A surface point that a path from the camera has reached.
pub struct EyeVertex<'a> {
    /// The point.
    pub surface: Surface,
    /// Unit direction back along the path.
    pub wo: Vec3,
    /// How the point scatters ([`crate::bsdf::Transport::Radiance`]).
    pub bsdf: Bsdf<'a>,
    /// Number of segments from the camera to here. Passing straight through a surface does not end a segment.
    pub segments: u32,
    /// Number of scatterings before this vertex that were not by delta lobes.
    pub non_delta: u32,
    /// Length of the path from the camera to here, world units.
    pub length: f32,
    /// The medium that the path came through.
    pub medium: Option<MediumId>,
    /// Contribution to the sample of one unit of estimated radiance.
    pub throughput: Rgb,
    /// Fraction of the scattering here that no earlier estimate has accounted for.
    pub(super) remainder: Rgb,
    /// Whether the path may not have another segment.
    pub(super) is_last: bool,
}

impl EyeVertex<'_> {
    /// Whether an estimate of scattered light is useful here: the surface has lobes that are not delta lobes, the path
    /// may have another segment, and no earlier estimate accounts for the light.
    #[inline]
    pub fn wants_estimate(&self) -> bool {
        !self.is_last && !self.remainder.is_black() && !self.bsdf.is_delta()
    }
}

/// A technique's estimate of the light that a vertex scatters back along the path.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// The scattering at the vertex that the estimate covers. The path continues for the rest.
    pub covers: Covers,
    /// Radiance of light that comes straight from a light source. With [`Covers::Diffuse`] it must cover all lobes but
    /// delta lobes. `None` leaves this light to the path: it samples a light, and may hit one.
    pub direct: Option<Rgb>,
    /// Radiance of light that was scattered at another surface, not by delta lobes only.
    pub indirect: Rgb,
    /// Radiance of light that came only over delta lobes, at least one. `None` leaves this light to the path.
    pub caustic: Option<Rgb>,
}

/// Scattering that an estimate covers. Delta lobes are never covered.
#[derive(Clone, Copy, Debug)]
pub enum Covers {
    /// All lobes but delta lobes.
    NonDelta,
    /// All lobes but delta lobes, for light from surfaces that are directly visible from the vertex, with the geometry
    /// term cos cos' / d^2 (geometric normals) clamped. Virtual point lights estimate this.
    Visible {
        /// Largest geometry term, per squared world unit; may be infinite.
        max_geometry: f32,
        /// Smallest roughness (microfacet alpha) of a covered lobe. Narrower lobes, at either end of the connection,
        /// are left to the path.
        min_roughness: f32,
    },
    /// The diffuse part. All other lobes are left to the path.
    Diffuse(DiffusePart),
}
