//! The light that estimates have not accounted for, and that the path must still find.

use glam::Vec3;

use super::{Covers, Estimate, EyeVertex};
use crate::bsdf::Bsdf;
use crate::geometry::Surface;
use crate::math::Rgb;
use crate::sampler::Sampler;

/// Fractions of each kind of light that no estimate has accounted for.
pub(super) struct Remainder {
    /// Light that the next vertex scatters, except by delta lobes.
    pub(super) indirect: Rgb,
    /// Emitted light that arrives only over delta lobes.
    caustic: Rgb,
    /// Light that the next vertex emits.
    direct: Rgb,
    /// Set if the last estimate covered light from directly visible surfaces ([`Covers::Visible`]). If the next vertex
    /// is reached without a delta lobe, it replaces `indirect`.
    visible: Option<Visible>,
}

impl Remainder {
    /// No estimate so far.
    pub(super) const ALL: Remainder =
        Remainder { indirect: Rgb::WHITE, caustic: Rgb::WHITE, direct: Rgb::WHITE, visible: None };

    /// An estimate has accounted for the light of sources that the last vertex sees.
    pub(super) const WITHOUT_DIRECT: Remainder = Remainder { direct: Rgb::BLACK, ..Self::ALL };

    /// Update the remainder after a scattering at `v` toward `wi` that is not by a delta lobe.
    #[inline(always)]
    pub(super) fn after_scattering(
        &mut self,
        estimate: Option<&Estimate>,
        v: &EyeVertex,
        wi: Vec3,
    ) {
        match estimate {
            None => *self = Self::ALL,
            Some(estimate) => *self = Self::after(estimate, v, wi),
        }
    }

    fn after(estimate: &Estimate, v: &EyeVertex, wi: Vec3) -> Self {
        let left = |part: Option<Rgb>| match estimate.covers {
            _ if part.is_none() => Rgb::WHITE,
            Covers::Visible { min_roughness, .. } => {
                v.bsdf.share_broad(min_roughness, v.wo, wi).map(|share| 1.0 - share)
            }
            Covers::NonDelta | Covers::Diffuse(_) => Rgb::BLACK,
        };
        let indirect = match estimate.covers {
            // The covered fraction is known only at the next vertex.
            Covers::Visible { .. } => Rgb::WHITE,
            Covers::NonDelta => Rgb::BLACK,
            Covers::Diffuse(part) => v.bsdf.beside_diffuse(&part, v.wo, wi),
        };
        Remainder {
            indirect,
            caustic: left(estimate.caustic),
            direct: left(estimate.direct),
            visible: Visible::new(&estimate.covers, v, wi),
        }
    }

    /// After a delta lobe, the next surface is not directly visible.
    #[inline]
    pub(super) fn after_delta(&mut self) {
        self.visible = None;
    }

    /// Whether estimates have accounted for everything.
    #[inline]
    pub(super) fn is_black(&self) -> bool {
        self.indirect.is_black() && self.direct.is_black() && self.caustic.is_black()
    }

    /// Fraction of emitted light that remains.
    #[inline]
    pub(super) fn emitted(&self, after_delta: bool) -> Rgb {
        if after_delta { self.caustic } else { self.direct }
    }

    /// Fraction of the scattering at `surface` that remains. Russian roulette rounds small fractions to zero or one. If
    /// the fraction differs between lobes, it is multiplied into `bsdf`, and the result is white.
    #[inline(always)]
    pub(super) fn at(
        &self,
        surface: &Surface,
        wo: Vec3,
        bsdf: &mut Bsdf,
        sampler: &mut Sampler,
    ) -> Rgb {
        if bsdf.is_delta() {
            return self.indirect;
        }
        let Some(visible) = &self.visible else { return play(self.indirect, sampler) };
        let broad = play(visible.left(surface, wo), sampler);
        if !bsdf.is_sharp(visible.min_roughness) {
            return broad;
        }
        *bsdf = bsdf.with_broad(visible.min_roughness, broad);
        Rgb::WHITE
    }

    /// Fraction of the scattering in a medium that remains, rounded as on surfaces.
    #[inline]
    pub(super) fn within(&self, sampler: &mut Sampler) -> Rgb {
        play(self.indirect, sampler)
    }
}

/// Round a fraction by Russian roulette. Most fractions are small and not worth a path.
#[inline]
fn play(fraction: Rgb, sampler: &mut Sampler) -> Rgb {
    if fraction.is_black() || fraction == Rgb::WHITE {
        return fraction;
    }
    let survival = fraction.max().min(1.0);
    let survives = sampler.next_1d() < survival;
    if survives { fraction / survival } else { Rgb::BLACK }
}

/// [`Covers::Visible`] on the way to the next surface.
#[derive(Clone, Copy)]
struct Visible {
    p: Vec3,
    cos: f32,
    max_geometry: f32,
    min_roughness: f32,
    /// Fraction of the scattering at `p` that was covered.
    covered: Rgb,
}

impl Visible {
    #[inline]
    fn new(covers: &Covers, v: &EyeVertex, wi: Vec3) -> Option<Self> {
        let Covers::Visible { max_geometry, min_roughness } = *covers else { return None };
        let (p, cos) = (v.surface.p, v.surface.ng.dot(wi).abs());
        let covered = v.bsdf.share_broad(min_roughness, v.wo, wi);
        Some(Visible { p, cos, max_geometry, min_roughness, covered })
    }

    /// Fraction of the light from `surface` that remains because of the clamped geometry term and narrow lobes.
    fn left(&self, surface: &Surface, wo: Vec3) -> Rgb {
        let cos = surface.ng.dot(wo).abs();
        let geometry = self.cos * cos / (surface.p - self.p).length_squared();
        let kept = if geometry > self.max_geometry { self.max_geometry / geometry } else { 1.0 };
        self.covered.map(|covered| (1.0 - covered * kept).max(0.0))
    }
}
