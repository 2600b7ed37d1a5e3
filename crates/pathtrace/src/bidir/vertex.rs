//! A vertex of either subpath: a point of a surface, or of a medium.

use gi_core::bsdf::{Bsdf, Transport};
use gi_core::geometry::Surface;
use gi_core::light::LightSample;
use gi_core::math::Rgb;
use gi_core::medium::{MediumId, Tracking};
use gi_core::scene::Scene;
use glam::Vec3;

use super::weight::{Joint, Partials};
use crate::to_camera::transmittance;

/// Where a path is scattered.
#[derive(Clone, Copy)]
pub(crate) enum Site<'v, 'a> {
    /// At a surface.
    Surface { surface: &'v Surface, bsdf: &'v Bsdf<'a>, medium: Option<MediumId> },
    /// In a medium.
    Medium { p: Vec3, medium: MediumId },
}

impl Site<'_, '_> {
    pub(crate) fn p(&self) -> Vec3 {
        match self {
            Site::Surface { surface, .. } => surface.p,
            Site::Medium { p, .. } => *p,
        }
    }
}

/// A vertex of a subpath.
pub(crate) struct Vertex<'v, 'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) site: Site<'v, 'a>,
    /// The direction of the subpath.
    pub(crate) transport: Transport,
    /// Unit direction back along the subpath.
    pub(crate) wo: Vec3,
    /// Throughput of a path from the eye, power of a path from a light.
    pub(crate) carried: Rgb,
    pub(crate) partials: Partials,
    /// Number of segments of the subpath.
    pub(crate) segments: u32,
    /// Number of scatterings before this vertex that were not by delta lobes.
    pub(crate) non_delta: u32,
}

impl Vertex<'_, '_> {
    pub(crate) fn p(&self) -> Vec3 {
        self.site.p()
    }

    /// Cosine with the geometric normal, which turns perpendicular areas into areas of the surface; 1 in media.
    #[inline]
    pub(crate) fn facing(&self, d: Vec3) -> f32 {
        facing(self.site, d)
    }

    /// Whether the path can be connected here.
    pub(crate) fn connects(&self) -> bool {
        match self.site {
            Site::Surface { bsdf, .. } => !bsdf.is_delta(),
            Site::Medium { .. } => true,
        }
    }

    /// Whether photons are merged here.
    pub(crate) fn merges(&self) -> bool {
        matches!(self.site, Site::Surface { bsdf, .. } if !bsdf.is_delta())
    }

    /// f times cosine toward `wi`, and its density per solid angle.
    #[inline]
    pub(crate) fn f_cos_pdf(&self, wi: Vec3) -> (Rgb, f32) {
        match self.site {
            Site::Surface { bsdf, .. } => bsdf.f_cos_pdf(self.wo, wi),
            Site::Medium { medium, .. } => {
                // A phase function equals its own density.
                let phase = self.scene.medium(medium).phase.eval(self.wo, wi);
                (Rgb::grey(phase), phase)
            }
        }
    }

    /// Density per solid angle with which the reverse path, which arrives from `wi`, samples `wo`.
    #[inline]
    pub(crate) fn reverse_pdf_w(&self, wi: Vec3) -> f32 {
        match self.site {
            Site::Surface { surface, bsdf, .. } => {
                self.scene.reverse_pdf_w((surface, bsdf), self.transport, self.wo, wi)
            }
            Site::Medium { medium, .. } => self.scene.medium(medium).phase.eval(wi, self.wo),
        }
    }

    /// This vertex in a connection along `wi`. `arrival` is the density with which the other side reaches it, per area
    /// perpendicular to `wi`.
    #[inline]
    pub(crate) fn joint(&self, wi: Vec3, arrival: f32) -> Joint {
        Joint {
            reached: arrival * self.facing(wi),
            reverse: self.reverse_pdf_w(wi),
            merges: self.merges(),
        }
    }

    /// Transmittance to the point `q` in direction `wi`; `end` is the flat primitive that it lies on.
    pub(crate) fn transmittance_to(&self, q: Vec3, wi: Vec3, end: Option<u32>) -> Rgb {
        let (ng, medium) = match self.site {
            Site::Surface { surface, medium, .. } => {
                (surface.ng, self.scene.medium_toward(surface, wi, medium))
            }
            // A point in a medium needs no ray offset.
            Site::Medium { medium, .. } => (Vec3::ZERO, Some(medium)),
        };
        let ray = self.scene.tree().shadow_ray(self.p(), ng, q);
        transmittance(self.scene, ray, end, medium, &mut Tracking::none())
    }

    /// Fraction of the light of a light sample that arrives.
    pub(crate) fn visibility(&self, light: &LightSample) -> Rgb {
        match self.site {
            Site::Surface { surface, medium, .. } if self.scene.has_media() => {
                self.scene.visibility_through_media(surface, medium, light, &mut Tracking::none())
            }
            Site::Surface { surface, .. } => self.scene.visibility(surface, light),
            Site::Medium { p, medium } => {
                self.scene.visibility_from_within(p, Some(medium), light, &mut Tracking::none())
            }
        }
    }
}

/// See [`Vertex::facing`].
#[inline]
pub(crate) fn facing(site: Site, d: Vec3) -> f32 {
    match site {
        // A path along a surface would have no density.
        Site::Surface { surface, .. } => surface.ng.dot(d).abs().max(1e-6),
        Site::Medium { .. } => 1.0,
    }
}
