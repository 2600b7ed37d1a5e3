//! Samples, by the kind of light path.

use glam::Vec3;

use crate::math::Rgb;
use crate::options::Show;

/// One sample of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample {
    /// Radiance by the kind of path that brought it.
    pub radiance: Components,
    /// Albedo of the first surface.
    pub albedo: Rgb,
    /// Shading normal of the first surface; zero where there is none.
    pub normal: Vec3,
    /// Distance to the first surface; 0 where there is none.
    pub depth: f32,
    /// Where in the pixel the sample was taken, from its middle: -0.5 to 0.5 along each axis.
    pub offset: [f32; 2],
}

/// Radiance by the kind of path; the whole is the sum. In the notation of light paths (E eye, L light, S delta lobe, D any other
/// lobe):
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Components {
    /// E S* L and E S* D L: light seen directly, or after one scattering.
    pub direct: Rgb,
    /// E S* D .* D .* L: light after two or more scatterings.
    pub indirect: Rgb,
    /// E S* D S+ L: light focused by mirrors and glass onto a surface that the eye sees.
    pub caustic: Rgb,
}

impl Components {
    /// Everything.
    #[inline]
    pub fn all(&self) -> Rgb {
        self.direct + self.indirect + self.caustic
    }

    /// Add `weight` times other components.
    #[inline]
    pub fn add(&mut self, other: &Components, weight: f32) {
        self.direct += other.direct * weight;
        self.indirect += other.indirect * weight;
        self.caustic += other.caustic * weight;
    }

    /// The component of a path with `non_delta` scatterings from the eye, after which there are only delta scatterings up to the
    /// light (`then_delta`), or none.
    #[inline]
    pub fn of_path(&mut self, non_delta: u32, then_delta: bool) -> &mut Rgb {
        match (non_delta, then_delta) {
            (0, _) | (1, false) => &mut self.direct,
            (1, true) => &mut self.caustic,
            _ => &mut self.indirect,
        }
    }
}

impl Show {
    #[inline]
    pub(super) fn of(self, c: &Components) -> Rgb {
        match self {
            Show::All => c.all(),
            Show::Direct => c.direct,
            Show::Indirect => c.indirect,
            Show::Caustic => c.caustic,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_are_disjoint_by_path() {
        let mut c = Components::default();
        for (non_delta, delta) in
            [(0, false), (0, true), (1, false), (1, true), (2, false), (2, true)]
        {
            *c.of_path(non_delta, delta) += Rgb::WHITE;
        }
        assert_eq!([c.direct.r, c.caustic.r, c.indirect.r], [3.0, 1.0, 2.0]);
    }
}
