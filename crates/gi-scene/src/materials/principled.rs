//! The principled model and its variant for thin sheets.

use gi_core::material::{Material, Principled, PrincipledThin};
use gi_core::texture::Texture;

use super::ior;
use crate::builder::Builder;
use crate::document::{Meaning, Node};
use crate::textures::one_channel;

/// Mitsuba's sampling options, which have no effect here: our model chooses its own sampling rates.
const SAMPLING_RATES: [&str; 6] = [
    "diffuse_reflectance_sampling_rate",
    "diffuse_transmittance_sampling_rate",
    "specular_reflectance_sampling_rate",
    "specular_transmittance_sampling_rate",
    "main_specular_sampling_rate",
    "clearcoat_sampling_rate",
];
/// Relative index used in place of 1 for a refracting surface, as in Mitsuba.
const MATCHED: f32 = 1.001;
/// Smallest `specular` of a refracting surface, as in Mitsuba.
const LEAST_SPECULAR: f32 = 1e-3;

impl Builder<'_> {
    pub(super) fn principled(&mut self, node: Node<'_>) -> Material {
        node.ignore(&SAMPLING_RATES);
        let spec_trans = self.part(node, "spec_trans");
        let eta = self.principled_eta(node, !spec_trans.is_black());
        Material::Principled(Box::new(Principled {
            base_color: self.share(node, "base_color", 0.5),
            roughness: self.one_channel_share(node, "roughness", 0.5),
            anisotropic: self.part(node, "anisotropic"),
            metallic: self.part(node, "metallic"),
            spec_trans,
            eta,
            spec_tint: self.part(node, "spec_tint"),
            sheen: self.part(node, "sheen"),
            sheen_tint: self.part(node, "sheen_tint"),
            flatness: self.part(node, "flatness"),
            clearcoat: self.part(node, "clearcoat"),
            clearcoat_gloss: self.part(node, "clearcoat_gloss"),
        }))
    }

    pub(super) fn principled_thin(&mut self, node: Node<'_>) -> Material {
        node.ignore(&SAMPLING_RATES);
        let eta = self.in_range(node, "eta", 1.5, [*ior::RELATIVE.start(), *ior::RELATIVE.end()]);
        Material::PrincipledThin(Box::new(PrincipledThin {
            base_color: self.share(node, "base_color", 0.5),
            roughness: self.one_channel_share(node, "roughness", 0.5),
            anisotropic: self.part(node, "anisotropic"),
            spec_trans: self.part(node, "spec_trans"),
            diff_trans: self.in_range(node, "diff_trans", 0.0, [0.0, 2.0]),
            eta,
            spec_tint: self.part(node, "spec_tint"),
            sheen: self.part(node, "sheen"),
            sheen_tint: self.part(node, "sheen_tint"),
            flatness: self.part(node, "flatness"),
        }))
    }

    /// A factor in [0, 1] that is zero if not given.
    fn part(&mut self, node: Node<'_>, name: &'static str) -> Texture {
        self.one_channel_share(node, name, 0.0)
    }

    /// A parameter in a range. Outside the range, an error is reported and the default is returned.
    fn in_range(
        &mut self,
        node: Node<'_>,
        name: &'static str,
        default: f32,
        [low, high]: [f32; 2],
    ) -> Texture {
        let texture = self.texture(node, name, Texture::grey(default), Meaning::Factor);
        let texture = one_channel(node, texture);
        let [least, most] = self.origins.range(&texture);
        if low <= least && most <= high {
            return texture;
        }
        let value = if least < low { least } else { most };
        let message = format!("`{name}` is {value}");
        node.report.error(node.place_of(name), message, &format!("expected {low} to {high}"));
        Texture::grey(default)
    }

    /// The index of refraction, from `eta` or from `specular` (0.5 means an index of 1.5).
    fn principled_eta(&mut self, node: Node<'_>, refracts: bool) -> f32 {
        if node.has("eta") {
            if node.has("specular") || node.child("specular").is_some() {
                let message = "`specular` is ignored because `eta` is given too";
                node.report.warn(node.place_of("specular"), message);
            }
            let eta = node.within("eta", 1.5, ior::RELATIVE);
            return if refracts && eta == 1.0 { MATCHED } else { eta };
        }
        let texture = self.share(node, "specular", 0.5);
        if !texture.is_constant() {
            let message = "a textured `specular` is replaced by its mean";
            node.report.warn(node.place_of("specular"), message);
        }
        let specular = texture.mean().mean();
        let specular = if refracts { specular.max(LEAST_SPECULAR) } else { specular };
        2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0
    }
}
