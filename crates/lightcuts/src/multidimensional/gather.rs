//! Gather points: the vertices of a pixel's camera paths that lights illuminate, on surfaces and in media.

use gi_core::bsdf::Bsdf;
use gi_core::geometry::Surface;
use gi_core::math::Rgb;
use gi_core::medium::MediumId;
use glam::Vec3;
use vpl::Scatterer;

use crate::light::At;
use crate::view::{PathState, View};

/// A vertex of a camera path that receives light.
pub(super) struct GatherPoint<'a> {
    /// The point.
    pub(super) place: Place<'a>,
    /// Unit direction back along the path.
    pub(super) wo: Vec3,
    /// The path up to the point.
    pub(super) path: PathState,
    /// Contribution to the pixel of one unit of the point's radiance: the magnitude of the filter's weight times the
    /// throughput of the path, over the number of paths.
    pub(super) strength: Rgb,
    /// Whether the filter's weight is negative.
    pub(super) negative: bool,
}

/// Where a gather point is.
#[expect(clippy::large_enum_variant, reason = "most are on surfaces")]
pub(super) enum Place<'a> {
    /// On a surface, with its BSDF without narrow lobes.
    Surface(Surface, Bsdf<'a>),
    /// In a medium.
    Medium(Vec3, MediumId),
}

/// Gather points of a pixel whose light goes to the same sum. Each kind has a tree of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Kind {
    /// Whether the path to the point had only specular scatterings.
    pub(super) seen: bool,
    /// The medium of the points, if they are not on surfaces.
    pub(super) medium: Option<MediumId>,
    /// Whether the light is subtracted, because the filter is negative there.
    pub(super) negative: bool,
    /// Largest number of scatterings of lights that count there.
    pub(super) deepest: u32,
    /// Whether lights on light sources count there.
    pub(super) direct: bool,
}

/// A gather point, prepared for bounds and connections.
pub(super) struct Gather<'s, 'a> {
    /// The point.
    pub(super) at: At<'s, 's, 'a>,
    /// Its kind.
    pub(super) kind: Kind,
    /// See [`GatherPoint::strength`].
    pub(super) strength: Rgb,
    /// Approximate albedo, above 0. A representative point stands for other points with their own colours: a cluster sums
    /// strength times colour, and the light at the representative is divided by its colour.
    pub(super) colour: Rgb,
    /// Unit shading normal on the side of the eye; in media, the direction back along the path.
    pub(super) normal: Vec3,
}

/// Smallest colour of a channel, as a fraction of the largest channel and absolute.
const LEAST_COLOUR: [f32; 2] = [0.1, 1e-3];

impl<'s, 'a> Gather<'s, 'a> {
    /// A point that receives light.
    pub(super) fn new(at: At<'s, 's, 'a>, strength: Rgb, seen: bool, negative: bool) -> Self {
        let (normal, albedo) = match at.receiver.scatterer {
            Scatterer::Surface(surface, bsdf) => {
                let (ns, wo) = (surface.ns(), at.receiver.wo);
                let toward_eye = || ns * 1f32.copysign(ns.dot(wo));
                let normal = at.site.lambert().map_or_else(toward_eye, |(_, normal)| normal);
                (normal, bsdf.albedo())
            }
            Scatterer::Medium(_) => (at.receiver.wo, Rgb::WHITE),
        };
        let least = (LEAST_COLOUR[0] * albedo.max()).max(LEAST_COLOUR[1]);
        let medium = at.receiver.medium();
        let kind = Kind { seen, medium, negative, deepest: at.deepest, direct: at.direct };
        Gather { at, kind, strength, colour: albedo.map(|a| a.max(least)), normal }
    }

    /// Prepare the gather points of a pixel.
    pub(super) fn prepare(view: &View<'_, 'a>, points: &'s [GatherPoint<'a>]) -> Vec<Self> {
        let prepare = |p: &'s GatherPoint<'a>| {
            let at = match &p.place {
                Place::Surface(surface, bsdf) => view.at(surface, p.wo, bsdf, p.path),
                Place::Medium(at, medium) => view.at_medium((*at, p.wo), *medium, p.path),
            }?;
            Some(Gather::new(at, p.strength, p.path.non_delta == 0, p.negative))
        };
        points.iter().filter_map(prepare).collect()
    }
}
