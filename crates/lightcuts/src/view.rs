//! Turns a vertex of a path into a point for cuts: decides which lights count there, and how they are clamped.

use gi_core::bsdf::Bsdf;
use gi_core::eye::{EyeWalk, GatherRay};
use gi_core::film::Show;
use gi_core::geometry::Surface;
use gi_core::medium::MediumId;
use gi_core::options::Parameters;
use gi_core::sampler::Sampler;
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
    /// The medium of the last segment.
    pub(crate) medium: Option<MediumId>,
}

impl PathState {
    /// The path up to a point of `medium` where it is scattered now.
    pub(crate) fn of(walk: &EyeWalk, medium: Option<MediumId>) -> Self {
        PathState { segments: walk.segments(), non_delta: walk.non_delta(), medium }
    }
}

impl<'a> View<'_, 'a> {
    /// The point for cuts; `None` if the path is too long for any light, or has a non-specular scattering already in a scene with media.
    pub(crate) fn at<'s>(
        &self,
        surface: &'s Surface,
        wo: Vec3,
        bsdf: &'s Bsdf<'a>,
        path: PathState,
    ) -> Option<At<'s, 's, 'a>> {
        let deepest = self.deepest(path)?;
        let indirect = matches!(self.setting.show, Show::All | Show::Indirect);
        let receiver = Receiver::new(surface, wo, bsdf);
        Some(At {
            receiver: if self.is_in_media() {
                receiver.through_media(path.medium)
            } else {
                receiver
            },
            site: Site::new(surface, wo, bsdf, self.max_geometry()),
            deepest: if indirect { deepest } else { 0 },
            direct: self.wants_direct(path),
        })
    }

    /// A point of a medium for cuts: only lights on light sources count there. `None` if they do not illuminate it, see
    /// [`View::is_lit_in_medium`].
    pub(crate) fn at_medium<'s>(
        &self,
        (p, wo): (Vec3, Vec3),
        medium: MediumId,
        path: PathState,
    ) -> Option<At<'s, 's, 'a>> {
        let scene = self.setting.scene;
        let at = || At {
            receiver: Receiver::in_medium(scene, p, wo, medium),
            site: Site::in_medium(p, wo, scene.medium(medium).phase),
            deepest: 0,
            direct: true,
        };
        self.is_lit_in_medium(path).then(at)
    }

    /// Whether lights on light sources illuminate a point of a medium: the path is not too long for them, has no non-specular
    /// scattering yet, and the picture shows their light.
    pub(crate) fn is_lit_in_medium(&self, path: PathState) -> bool {
        self.deepest(path).is_some() && self.wants_direct(path)
    }

    /// Largest number of scatterings of a light that may illuminate a vertex; `None` if no light may.
    pub(crate) fn deepest(&self, path: PathState) -> Option<u32> {
        // In media most paths are scattered many times: later vertices count little, and a light sample is enough.
        if self.is_in_media() && path.non_delta > 0 {
            return None;
        }
        self.max_scatterings(path.segments)
    }

    /// Whether the scene has media that the method simulates.
    pub(crate) fn is_in_media(&self) -> bool {
        self.setting.scene.has_media() && self.params.simulates_media()
    }

    /// Whether lights on light sources illuminate a vertex. After a non-specular scattering all light is indirect.
    fn wants_direct(&self, path: PathState) -> bool {
        let is_shown = match self.setting.show {
            Show::All => true,
            Show::Direct => path.non_delta == 0,
            Show::Indirect => path.non_delta > 0,
            Show::Caustic => false,
        };
        is_shown && self.params.direct == Direct::Vpl
    }

    /// Call `look` with the point that the middle of a pixel shows; `None` if nothing there receives light.
    pub(crate) fn at_pixel<T>(
        &self,
        [x, y]: [usize; 2],
        look: impl FnOnce(&At<'_, '_, 'a>) -> T,
    ) -> Option<T> {
        self.at_film([x as f32 + 0.5, y as f32 + 0.5], look)
    }

    /// The same at a film position. Surfaces that let all light pass straight through are skipped.
    pub(crate) fn at_film<T>(
        &self,
        film: [f32; 2],
        look: impl FnOnce(&At<'_, '_, 'a>) -> T,
    ) -> Option<T> {
        let Setting { scene, camera, seed, .. } = *self.setting;
        let start = GatherRay { ray: camera.ray(film, [0.5; 2]), segments: 1, length: 0.0 };
        let mut walk = EyeWalk::along(scene, self.params.limits, start, Sampler::new(seed, 0, 0));
        if self.is_in_media() {
            walk.use_media(self.setting.camera_medium());
        }
        while let Some(v) = &walk.next_vertex() {
            if let Some(bsdf) = v.bsdf.broad(v.wo, MIN_ROUGHNESS) {
                let path = PathState { segments: 1, non_delta: 0, medium: v.medium };
                return Some(look(&self.at(&v.surface, v.wo, &bsdf, path)?));
            }
            if !walk.pass_straight(v) {
                break;
            }
        }
        None
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
