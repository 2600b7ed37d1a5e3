//! What a sample finds, by the kind of light path.

use glam::Vec3;

use crate::math::Rgb;
use crate::options::Show;

/// What one sample of a pixel found.
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

/// Radiance parted by the kind of path; the whole is the sum. In the notation of light paths (E eye, L light,
/// S delta lobe, D any other):
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Components {
    /// E S* L and E S* D L: seen, or after one scattering.
    pub direct: Rgb,
    /// E S* D .* D .* L: after two scatterings or more.
    pub indirect: Rgb,
    /// E S* D S+ L: focused by mirrors and glass onto what the eye sees.
    pub caustic: Rgb,
}

impl Components {
    /// Everything.
    #[inline]
    pub fn all(&self) -> Rgb {
        self.direct + self.indirect + self.caustic
    }

    /// The kind of path that has met `rough` scatterings on its way from the eye and then, up to the light,
    /// delta scatterings or none.
    #[inline]
    pub fn of_path(&mut self, rough: u32, then_delta: bool) -> &mut Rgb {
        match (rough, then_delta) {
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
        for (rough, delta) in [(0, false), (0, true), (1, false), (1, true), (2, false), (2, true)]
        {
            *c.of_path(rough, delta) += Rgb::WHITE;
        }
        assert_eq!([c.direct.r, c.caustic.r, c.indirect.r], [3.0, 1.0, 2.0]);
    }
}
