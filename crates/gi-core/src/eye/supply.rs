//! Who answers for light on the eye walk.

use glam::Vec3;

use crate::bsdf::{Bsdf, DiffusePart};
use crate::film::Components;
use crate::geometry::Surface;
use crate::math::Rgb;
use crate::ray::Ray;
use crate::sampler::Sampler;

/// A surface point that a path has met, scattering by other than delta lobes.
pub struct EyeVertex<'v, 'a> {
    /// The point.
    pub surface: &'v Surface,
    /// Unit direction back along the path.
    pub wo: Vec3,
    /// How it scatters ([`crate::bsdf::Transport::Radiance`]).
    pub bsdf: &'v Bsdf<'a>,
    /// Segments from the eye to here, straight passes not counted.
    pub segments: u32,
    /// Scatterings by other than delta lobes before.
    pub rough: u32,
    /// Length of the path from the eye to here, world units.
    pub length: f32,
    /// The medium that the path reached it in, for walks that know media.
    pub medium: Option<usize>,
    /// What one unit of the radiance that is supplied here adds to the sample.
    pub throughput: Rgb,
}

/// Light that a technique supplies at a vertex, and what it thereby answers for.
#[derive(Clone, Copy, Debug)]
pub struct Supplied {
    /// Which scattering at the vertex is answered for.
    pub answered: Answered,
    /// Radiance of light that comes straight from a light and is scattered by what is answered for, of which
    /// [`Answered::Diffuse`] means all but delta lobes here. `None` lets the path look for it: a light is sampled, and met by
    /// scattering.
    pub direct: Option<Rgb>,
    /// Radiance that the answered scattering sends back along the path, of light that came over other surfaces that
    /// scatter by other than delta lobes.
    pub indirect: Rgb,
    /// The same of light that came over delta lobes alone, one at least. `None` lets the path look for it.
    pub caustic: Option<Rgb>,
}

/// Scattering that a technique answers for.
#[derive(Clone, Copy, Debug)]
pub enum Answered {
    /// All but delta lobes.
    Rough,
    /// All but delta lobes, of light from other such surfaces that are seen straight, not over delta lobes, and of
    /// that what a geometric term cos cos' / d^2 (geometric normals) bounded by `most` leaves, per squared world unit.
    /// Lobes narrower than `min_roughness`, here and there, are left to the path.
    Straight {
        /// The bound; infinite where there is none.
        most: f32,
        /// Width of the narrowest lobe that is answered for, as that of microfacets.
        min_roughness: f32,
    },
    /// The diffuse part. What the whole scatters besides is left to the path.
    Diffuse(DiffusePart),
}

/// A supplier for paths that nobody answers for.
#[inline]
pub fn nothing(_: &EyeVertex, _: &mut Sampler) -> Option<Supplied> {
    None
}

/// What a technique supplies, and whether its walk knows media.
pub trait Supplier<'a> {
    /// Whether media between surfaces absorb and scatter. Without, boundaries of media are what their materials are.
    const MEDIA: bool;
    /// Whether [`Supplier::beam`] is to be asked. If not, nothing beyond where a medium scatters the path is looked for.
    const BEAMS: bool = true;

    /// Asked at every vertex that scatters by other than delta lobes and has segments left.
    fn vertex(&mut self, v: &EyeVertex<'_, 'a>, sampler: &mut Sampler) -> Option<Supplied>;

    /// Asked for every piece of a path that lies in a medium, where nobody has answered for what is scattered and segments are
    /// left. What is supplied is all light that the medium scatters back along the piece; the path then goes on behind it, dimmed.
    fn beam(&mut self, _beam: &Beam, _sampler: &mut Sampler) -> Option<Components> {
        None
    }
}

/// A piece of a path in a medium.
#[derive(Clone, Copy, Debug)]
pub struct Beam<'r> {
    /// From its near end; unit direction.
    pub ray: &'r Ray,
    /// Distance to its far end, world units; may be infinite.
    pub reach: f32,
    /// The medium, by its index in [`crate::scene::Scene::media`].
    pub medium: usize,
    /// How the path has come in just now; `None` where it was in the medium before, and was reflected or scattered, and where
    /// it begins.
    pub entered: Option<Entrance>,
    /// Segments from the eye up to and with the one that this is a piece of, straight passes not counted.
    pub segments: u32,
    /// Scatterings by other than delta lobes before.
    pub rough: u32,
    /// What one unit of the radiance that is supplied here adds to the sample.
    pub throughput: Rgb,
}

/// Where a path has come into a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entrance {
    /// The boundary's primitive.
    pub prim: u32,
    /// Index inside over index outside of the boundary; 1 where nothing is refracted.
    pub eta: f32,
}

/// A technique of surfaces alone.
pub(super) struct OnSurfaces<'s, F>(pub(super) &'s mut F);

impl<'a, F: FnMut(&EyeVertex<'_, 'a>, &mut Sampler) -> Option<Supplied>> Supplier<'a>
    for OnSurfaces<'_, F>
{
    const MEDIA: bool = false;
    const BEAMS: bool = false;

    #[inline]
    fn vertex(&mut self, v: &EyeVertex<'_, 'a>, sampler: &mut Sampler) -> Option<Supplied> {
        (self.0)(v, sampler)
    }
}

/// Nobody answers for anything, on surfaces and in media: volumetric path tracing.
pub struct InMedia;

impl<'a> Supplier<'a> for InMedia {
    const MEDIA: bool = true;
    const BEAMS: bool = false;

    #[inline]
    fn vertex(&mut self, _: &EyeVertex<'_, 'a>, _: &mut Sampler) -> Option<Supplied> {
        None
    }
}
