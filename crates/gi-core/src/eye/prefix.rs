//! What has happened on a path, and what of its future a technique has answered for.

use glam::Vec3;

use super::{Answered, Entrance, EyeVertex, Supplied};
use crate::bsdf::{Bsdf, Scatter};
use crate::geometry::Surface;
use crate::math::Rgb;
use crate::sampler::Sampler;

/// What has happened on a path since the eye.
pub(super) struct Prefix {
    /// Scattered share of the radiance, already divided by all densities.
    pub(super) throughput: Rgb,
    /// Share of the throughput that light counts with which is scattered once more by other than a delta lobe:
    /// the rest of it was supplied at the last vertex.
    pub(super) unanswered: Rgb,
    /// Share of light over delta lobes that was not supplied at the last vertex.
    pub(super) caustic_left: Rgb,
    /// Share of light straight from lights that was not.
    pub(super) direct_left: Rgb,
    /// Where light from the next surface, if it is met straight, was supplied: how much of it shows there.
    pub(super) straight: Option<Straight>,
    /// Where the last scattering was, and its density per solid angle; `None` at the eye and after delta lobes.
    pub(super) last: Option<(Vec3, f32)>,
    /// Scatterings by other than delta lobes.
    pub(super) rough: u32,
    /// Whether the last scattering was by a delta lobe.
    pub(super) after_delta: bool,
    /// Product of the squared indices that refraction divided the throughput by.
    pub(super) eta_sq: f32,
    /// Segments so far, the one that is followed included.
    pub(super) segments: u32,
    /// Length so far, world units.
    pub(super) length: f32,
    /// The medium that it is in, for walks that know media.
    pub(super) medium: Option<usize>,
    /// How it has come in just now.
    pub(super) entered: Option<Entrance>,
}

impl Prefix {
    pub(super) const EYE: Prefix = Prefix {
        throughput: Rgb::WHITE,
        unanswered: Rgb::WHITE,
        caustic_left: Rgb::WHITE,
        direct_left: Rgb::WHITE,
        straight: None,
        last: None,
        rough: 0,
        after_delta: false,
        eta_sq: 1.0,
        segments: 1,
        length: 0.0,
        medium: None,
        entered: None,
    };

    /// The path's point for a technique to answer at, of which `here` nobody has answered for.
    #[inline]
    pub(super) fn vertex<'v, 'a>(
        &self,
        surface: &'v Surface,
        wo: Vec3,
        bsdf: &'v Bsdf<'a>,
        here: Rgb,
    ) -> EyeVertex<'v, 'a> {
        let Prefix { segments, rough, length, medium, .. } = *self;
        let throughput = self.throughput * here;
        EyeVertex { surface, wo, bsdf, segments, rough, length, medium, throughput }
    }

    /// Share of what `surface` scatters, by other than delta lobes if `rough`, that nobody has answered for. Small shares are
    /// rounded to nothing or one by Russian roulette. Where that is not the same for all lobes, `bsdf` is weighed instead.
    #[inline]
    pub(super) fn unanswered_at(
        &self,
        surface: &Surface,
        wo: Vec3,
        bsdf: &mut Bsdf,
        sampler: &mut Sampler,
    ) -> Rgb {
        let Some(straight) = self.straight.as_ref().filter(|_| !bsdf.is_delta()) else {
            let rough = !bsdf.is_delta();
            return if rough { play_for(self.unanswered, sampler) } else { self.unanswered };
        };
        let broad = play_for(straight.unanswered(surface, wo), sampler);
        if !bsdf.is_sharp(straight.min_roughness) {
            return broad;
        }
        *bsdf = bsdf.with_broad(straight.min_roughness, broad);
        Rgb::WHITE
    }

    /// Take in that the path was scattered at `surface`, where `here` was not answered for before and `supplied` is now.
    #[inline]
    pub(super) fn scatter(
        &mut self,
        surface: &Surface,
        bsdf: &Bsdf,
        wo: Vec3,
        scatter: &Scatter,
        supplied: Option<&Supplied>,
        here: Rgb,
    ) {
        self.throughput *= scatter.weight;
        self.segments += 1;
        self.after_delta = scatter.delta;
        self.eta_sq *= scatter.eta * scatter.eta;
        (self.last, self.straight) = (None, None);
        if !scatter.delta {
            self.throughput *= here;
            self.rough += 1;
            self.last = Some((surface.p, scatter.pdf_w));
            self.unanswered = unanswered(supplied, bsdf, wo, scatter.wi);
            let left = |s: &Supplied, supplied| s.left(supplied, bsdf, wo, scatter.wi);
            self.direct_left = supplied.map_or(Rgb::WHITE, |s| left(s, s.direct));
            self.caustic_left = supplied.map_or(Rgb::WHITE, |s| left(s, s.caustic));
            self.straight = supplied.and_then(|s| {
                Straight::new(&s.answered, surface, scatter.wi, |min_roughness| {
                    bsdf.share_broad(min_roughness, wo, scatter.wi)
                })
            });
        }
    }

    /// Share of what a medium scatters that nobody has answered for, rounded as on surfaces.
    #[inline]
    pub(super) fn unanswered_within(&self, sampler: &mut Sampler) -> Rgb {
        play_for(self.unanswered, sampler)
    }

    /// Take in that the path was scattered at the point `p` of a medium, in a direction of density `pdf_w`, where `here` was not
    /// answered for before.
    #[inline]
    pub(super) fn scatter_within(&mut self, p: Vec3, pdf_w: f32, here: Rgb) {
        self.throughput *= here;
        self.segments += 1;
        self.rough += 1;
        (self.after_delta, self.last, self.straight) = (false, Some((p, pdf_w)), None);
        self.entered = None;
        (self.unanswered, self.caustic_left) = (Rgb::WHITE, Rgb::WHITE);
        self.direct_left = Rgb::WHITE;
    }

    /// Share of the light of what is met now that was not supplied at the last vertex.
    #[inline]
    pub(super) fn lights_left(&self) -> Rgb {
        if self.after_delta { self.caustic_left } else { self.direct_left }
    }
}

/// Where a part of the next scattering was answered for, play Russian roulette for the rest: it is mostly small.
#[inline]
fn play_for(unanswered: Rgb, sampler: &mut Sampler) -> Rgb {
    if unanswered.is_black() || unanswered == Rgb::WHITE {
        return unanswered;
    }
    let survival = unanswered.max().min(1.0);
    let survives = sampler.next_1d() < survival;
    if survives { unanswered / survival } else { Rgb::BLACK }
}

/// [`Answered::Straight`] on its way to the next surface.
#[derive(Clone, Copy)]
pub(super) struct Straight {
    p: Vec3,
    cos: f32,
    most: f32,
    min_roughness: f32,
    /// Share of the scattering there that was answered for.
    share: Rgb,
}

impl Straight {
    fn new(
        answered: &Answered,
        surface: &Surface,
        wi: Vec3,
        share: impl FnOnce(f32) -> Rgb,
    ) -> Option<Self> {
        match *answered {
            Answered::Straight { most, min_roughness } => {
                let (cos, share) = (surface.ng.dot(wi).abs(), share(min_roughness));
                Some(Straight { p: surface.p, cos, most, min_roughness, share })
            }
            _ => None,
        }
    }

    /// Share of the light of `surface`, met straight, that the bounded geometric term and narrow lobes left out.
    fn unanswered(&self, surface: &Surface, wo: Vec3) -> Rgb {
        let cos = surface.ng.dot(wo).abs();
        let geometry = self.cos * cos / (surface.p - self.p).length_squared();
        let kept = if geometry > self.most { self.most / geometry } else { 1.0 };
        self.share.map(|share| (1.0 - share * kept).max(0.0))
    }
}

impl Supplied {
    /// Share of the light from `wi` that was not answered for, of the kind (straight from lights, or over delta lobes) of
    /// which this was supplied.
    #[inline]
    fn left(&self, supplied: Option<Rgb>, bsdf: &Bsdf, wo: Vec3, wi: Vec3) -> Rgb {
        match self.answered {
            _ if supplied.is_none() => Rgb::WHITE,
            Answered::Straight { min_roughness, .. } => {
                bsdf.share_broad(min_roughness, wo, wi).map(|share| 1.0 - share)
            }
            Answered::Rough | Answered::Diffuse(_) => Rgb::BLACK,
        }
    }
}

/// Share of scattering toward `wi` that was not answered for.
#[inline]
fn unanswered(supplied: Option<&Supplied>, bsdf: &Bsdf, wo: Vec3, wi: Vec3) -> Rgb {
    match supplied.map(|s| s.answered) {
        // What is answered of light met straight shows where it is met.
        None | Some(Answered::Straight { .. }) => Rgb::WHITE,
        Some(Answered::Rough) => Rgb::BLACK,
        Some(Answered::Diffuse(part)) => bsdf.beside_diffuse(&part, wo, wi),
    }
}
