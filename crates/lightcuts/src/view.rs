//! Turns a vertex of a path into a point for cuts: decides which lights count there, and how they are clamped.

use gi_core::bsdf::{Bsdf, Transport};
use gi_core::film::Show;
use gi_core::geometry::Surface;
use gi_core::technique::Setting;
use glam::Vec3;
use vpl::{Direct, MIN_ROUGHNESS, Receiver};

use crate::bound::Site;
use crate::light::At;
use crate::params::Params;

/// The settings that decide which lights illuminate a point.
#[derive(Clone, Copy)]
pub(crate) struct View<'f, 'a> {
    pub(crate) setting: &'f Setting<'a>,
    pub(crate) params: &'f Params,
}

/// The path up to a point.
#[derive(Clone, Copy)]
pub(crate) struct PathState {
    /// Number of segments.
    pub(crate) segments: u32,
    /// Number of non-specular scatterings.
    pub(crate) non_delta: u32,
}

impl PathState {
    /// A point that the eye sees directly.
    pub(crate) const SEEN: PathState = PathState { segments: 1, non_delta: 0 };
}

impl<'a> View<'_, 'a> {
    /// The point for cuts; `None` if the path is too long for any light.
    pub(crate) fn at<'s>(
        &self,
        surface: &'s Surface,
        wo: Vec3,
        bsdf: &'s Bsdf<'a>,
        path: PathState,
    ) -> Option<At<'s, 's, 'a>> {
        let max_scatterings = self.max_scatterings(path.segments)?;
        // After a non-specular scattering all light is indirect.
        let direct = match self.setting.show {
            Show::All => true,
            Show::Direct => path.non_delta == 0,
            Show::Indirect => path.non_delta > 0,
            Show::Caustic => false,
        };
        let indirect = matches!(self.setting.show, Show::All | Show::Indirect);
        Some(At {
            receiver: Receiver::new(surface, wo, bsdf),
            site: Site::new(surface, wo, bsdf, self.max_geometry()),
            deepest: if indirect { max_scatterings } else { 0 },
            direct: direct && self.params.direct == Direct::Vpl,
        })
    }

    /// Call `look` with the point that the middle of a pixel shows; `None` if nothing there receives light.
    pub(crate) fn at_pixel<T>(
        &self,
        [x, y]: [usize; 2],
        look: impl FnOnce(&At<'_, '_, 'a>) -> T,
    ) -> Option<T> {
        self.at_film([x as f32 + 0.5, y as f32 + 0.5], look)
    }

    /// The same for a film position.
    pub(crate) fn at_film<T>(
        &self,
        film: [f32; 2],
        look: impl FnOnce(&At<'_, '_, 'a>) -> T,
    ) -> Option<T> {
        let scene = self.setting.scene;
        let ray = self.setting.camera.ray(film, [0.5; 2]);
        let (surface, _) = scene.intersect(&ray)?;
        let bsdf = scene.bsdf(&surface, -ray.d, Transport::Radiance);
        let bsdf = bsdf.broad(-ray.d, MIN_ROUGHNESS)?;
        Some(look(&self.at(&surface, -ray.d, &bsdf, PathState::SEEN)?))
    }

    /// Largest number of scatterings of a light or photon that may illuminate a vertex after `segments` segments. After
    /// j scatterings it has j + 1 segments behind it.
    pub(crate) fn max_scatterings(&self, segments: u32) -> Option<u32> {
        match self.params.limits.max_depth {
            None => Some(u32::MAX),
            Some(max_depth) => max_depth.checked_sub(segments + 1),
        }
    }

    /// The bound of the geometry term, per squared world unit.
    pub(crate) fn max_geometry(&self) -> f32 {
        let radius = self.setting.scene.radius();
        self.params.bound.clamp / (radius * radius)
    }

    /// The geometry term above which paths find the light that the bound cuts off.
    pub(crate) fn compensated_geometry(&self) -> f32 {
        if self.params.bound.is_compensated() { self.max_geometry() } else { f32::INFINITY }
    }
}
