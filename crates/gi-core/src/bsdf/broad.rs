//! Narrow lobes apart from broad ones: what many points can light, and what only its own samples find.

use glam::Vec3;

use super::component::Component;
use super::{Bsdf, Parts};
use crate::math::Rgb;

impl<'a> Bsdf<'a> {
    /// Whether any lobe, delta lobes apart, is narrower than `min_roughness`.
    #[inline]
    pub fn is_sharp(&self, min_roughness: f32) -> bool {
        self.components().iter().any(|c| c.is_sharp(min_roughness))
    }

    /// The same with a factor on all that is scattered but by delta lobes and by lobes narrower than `min_roughness`, of
    /// which the diffuse part counts as broad. Directions are drawn as before.
    pub fn with_broad(&self, min_roughness: f32, factor: Rgb) -> Self {
        self.clone().weighed(min_roughness, factor, Rgb::WHITE)
    }

    /// What is scattered neither by delta lobes nor by lobes narrower than `min_roughness`; `None` where there is nothing.
    pub fn broad(&self, wo: Vec3, min_roughness: f32) -> Option<Self> {
        let broad = if self.is_sharp(min_roughness) {
            self.clone().weighed(min_roughness, Rgb::WHITE, Rgb::BLACK)
        } else {
            self.clone()
        };
        broad.components().iter().any(|c| c.scatters(wo)).then_some(broad)
    }

    /// The share of [`Bsdf::f_cos`] that [`Bsdf::broad`] has.
    pub fn share_broad(&self, min_roughness: f32, wo: Vec3, wi: Vec3) -> Rgb {
        if !self.is_sharp(min_roughness) {
            return Rgb::WHITE;
        }
        let broad = self.clone().weighed(min_roughness, Rgb::WHITE, Rgb::BLACK);
        self.f_cos(wo, wi).zip(broad.f_cos(wo, wi), |all, f| if all > 0.0 { f / all } else { 1.0 })
    }

    fn weighed(mut self, min_roughness: f32, broad: Rgb, sharp: Rgb) -> Self {
        let weigh = |c: &mut Component<'a>| *c = c.weighed(min_roughness, broad, sharp);
        match &mut self.parts {
            Parts::One(component) => weigh(component),
            Parts::Blend { components, .. } => components.iter_mut().for_each(weigh),
        }
        self
    }
}
