//! Gather points: the vertices of a pixel's camera paths that lights illuminate.

use gi_core::bsdf::Bsdf;
use gi_core::geometry::Surface;
use gi_core::math::Rgb;
use glam::Vec3;

use crate::light::At;
use crate::view::{PathState, View};

/// A vertex of a camera path that receives light.
pub(super) struct GatherPoint<'a> {
    /// The point.
    pub(super) surface: Surface,
    /// Unit direction back along the path.
    pub(super) wo: Vec3,
    /// How it scatters, without narrow lobes.
    pub(super) bsdf: Bsdf<'a>,
    /// The path up to the point.
    pub(super) path: PathState,
    /// Contribution to the pixel of one unit of the point's radiance: the magnitude of the filter's weight times the
    /// throughput of the path, over the number of paths.
    pub(super) strength: Rgb,
    /// Whether the filter's weight is negative.
    pub(super) negative: bool,
}

/// Gather points of a pixel whose light goes to the same sum. Each kind has a tree of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Kind {
    /// Whether the path to the point had only specular scatterings.
    pub(super) seen: bool,
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
    /// Unit shading normal on the side of the eye.
    pub(super) normal: Vec3,
}

/// Smallest colour of a channel, as a fraction of the largest channel and absolute.
const LEAST_COLOUR: [f32; 2] = [0.1, 1e-3];

impl<'s, 'a> Gather<'s, 'a> {
    /// A point that receives light.
    pub(super) fn new(at: At<'s, 's, 'a>, strength: Rgb, seen: bool, negative: bool) -> Self {
        let (ns, wo) = (at.receiver.surface.ns(), at.receiver.wo);
        let normal = match at.site.lambert() {
            Some((_, normal)) => normal,
            None => ns * 1f32.copysign(ns.dot(wo)),
        };
        let albedo = at.receiver.bsdf.albedo();
        let least = (LEAST_COLOUR[0] * albedo.max()).max(LEAST_COLOUR[1]);
        let kind = Kind { seen, negative, deepest: at.deepest, direct: at.direct };
        Gather { at, kind, strength, colour: albedo.map(|a| a.max(least)), normal }
    }

    /// Prepare the gather points of a pixel.
    pub(super) fn prepare(view: &View<'_, 'a>, points: &'s [GatherPoint<'a>]) -> Vec<Self> {
        let prepare = |p: &'s GatherPoint<'a>| {
            let at = view.at(&p.surface, p.wo, &p.bsdf, p.path)?;
            Some(Gather::new(at, p.strength, p.path.non_delta == 0, p.negative))
        };
        points.iter().filter_map(prepare).collect()
    }
}
