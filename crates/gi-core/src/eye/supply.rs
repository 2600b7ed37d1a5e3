//! Who answers for light on the eye walk.

use super::{EyeVertex, Supplied};
use crate::film::Components;
use crate::math::Rgb;
use crate::ray::Ray;
use crate::sampler::Sampler;

/// What a technique supplies, and whether its walk knows media.
pub trait Supplier<'a> {
    /// Whether media between surfaces absorb and scatter. Without, boundaries of media are what their materials are.
    const MEDIA: bool;

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
    /// The primitive of the boundary that the path has come in over just now; `None` where it was in the medium before, and
    /// was reflected or scattered, and where it begins.
    pub entered: Option<u32>,
    /// Product of the squared indices that refraction has divided the throughput by: the squared index of the medium over that of
    /// what the eye is in.
    pub eta_sq: f32,
    /// Segments from the eye up to and with the one that this is a piece of, straight passes not counted.
    pub segments: u32,
    /// Scatterings by other than delta lobes before.
    pub rough: u32,
    /// What one unit of the radiance that is supplied here adds to the sample.
    pub throughput: Rgb,
}

/// A technique of surfaces alone.
pub(super) struct OnSurfaces<'s, F>(pub(super) &'s mut F);

impl<'a, F: FnMut(&EyeVertex<'_, 'a>, &mut Sampler) -> Option<Supplied>> Supplier<'a>
    for OnSurfaces<'_, F>
{
    const MEDIA: bool = false;

    #[inline]
    fn vertex(&mut self, v: &EyeVertex<'_, 'a>, sampler: &mut Sampler) -> Option<Supplied> {
        (self.0)(v, sampler)
    }
}

/// Nobody answers for anything, on surfaces and in media: volumetric path tracing.
pub struct InMedia;

impl<'a> Supplier<'a> for InMedia {
    const MEDIA: bool = true;

    #[inline]
    fn vertex(&mut self, _: &EyeVertex<'_, 'a>, _: &mut Sampler) -> Option<Supplied> {
        None
    }
}
