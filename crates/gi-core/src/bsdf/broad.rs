//! Separates narrow lobes from broad ones: virtual lights illuminate broad lobes, BSDF samples find the light in narrow
//! ones.

use glam::Vec3;

use super::component::Component;
use super::{Bsdf, Parts};
use crate::math::Rgb;

impl<'a> Bsdf<'a> {
    /// Whether any lobe that is not a delta lobe is narrower than `min_roughness`.
    #[inline]
    pub fn is_sharp(&self, min_roughness: f32) -> bool {
        self.components().iter().any(|c| c.is_sharp(min_roughness))
    }

    /// The same BSDF with a factor on all lobes at least as wide as `min_roughness`. The diffuse part of a narrower
    /// lobe also gets the factor; delta lobes do not. Sampling is unchanged.
    pub fn with_broad(&self, min_roughness: f32, factor: Rgb) -> Self {
        self.clone().weighed(min_roughness, factor, Rgb::WHITE)
    }

    /// Only the lobes at least as wide as `min_roughness`; `None` if there are none.
    pub fn broad(&self, wo: Vec3, min_roughness: f32) -> Option<Self> {
        let broad = if self.is_sharp(min_roughness) {
            self.clone().weighed(min_roughness, Rgb::WHITE, Rgb::BLACK)
        } else {
            self.clone()
        };
        broad.components().iter().any(|c| c.scatters(wo)).then_some(broad)
    }

    /// Fraction of [`Bsdf::f_cos`] that [`Bsdf::broad`] keeps.
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
