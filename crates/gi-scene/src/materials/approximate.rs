//! BSDFs that no material matches: what they are replaced by, each with a warning.

use gi_core::material::{Distribution, Material, Roughness};
use gi_core::math::Rgb;
use gi_core::texture::Texture;

use crate::build::Builder;
use crate::document::{Class, Meaning, Node};
use crate::value;

impl Builder<'_> {
    /// Ward's lobe falls as exp(-tan^2 / alpha^2) about the half vector, Phong's as cos^n about the mirror
    /// direction, which turns twice as fast: near the peak they agree for n = 1 / (2 alpha^2).
    pub(super) fn ward(&mut self, node: Node<'_>) -> Material {
        node.ignore(&["variant"]);
        node.warn("`ward` is approximated by `phong`");
        let alpha = node.within("alpha", 0.1, 0.0..=10.0);
        let [u, v] = ["alpha_u", "alpha_v"].map(|name| node.within(name, alpha, 0.0..=10.0));
        let exponent = 0.5 / (u * v).max(1e-6);
        Material::Phong {
            diffuse: self.share(node, "diffuse_reflectance", 0.5),
            specular: self.share(node, "specular_reflectance", 0.2),
            exponent: Texture::grey(exponent),
        }
    }

    /// The principled model as a blend of plastic, metal and glass; its other lobes are dropped.
    pub(super) fn principled(&mut self, node: Node<'_>) -> Option<Material> {
        const DROPPED: [&str; 14] = [
            "anisotropic",
            "clearcoat",
            "clearcoat_gloss",
            "sheen",
            "sheen_tint",
            "spec_tint",
            "flatness",
            "diff_trans",
            "diffuse_reflectance_sampling_rate",
            "specular_sampling_rate",
            "clearcoat_sampling_rate",
            "main_specular_sampling_rate",
            "spec_trans_sampling_rate",
            "subsurface",
        ];
        node.ignore(&DROPPED);
        node.warn("`principled` is approximated by plastic, metal and glass");
        let base = self.share(node, "base_color", 0.5);
        let rough = self.texture(node, "roughness", Texture::grey(0.5), Meaning::Factor);
        let alpha = Texture::grey(rough.mean().mean().powi(2).max(1e-3));
        let facets =
            Roughness { distribution: Distribution::Ggx, alpha_u: alpha.clone(), alpha_v: alpha };
        // Mitsuba: specular = 5 (eta - 1)^2 / (eta + 1)^2 / 0.4 ... the artist's 0.5 is eta 1.5.
        let f0 = (0.08 * node.float("specular", 0.5)).clamp(0.0, 0.9).sqrt();
        let eta = node.within("eta", (1.0 + f0) / (1.0 - f0), 0.1..=10.0).max(1.0001);
        let plastic = self.push_material(
            Material::Plastic {
                eta,
                diffuse: base.clone(),
                specular: Texture::grey(1.0),
                nonlinear: false,
                roughness: Some(facets.clone()),
            },
            None,
        );
        let trans = self.share(node, "spec_trans", 0.0);
        let body = if trans.is_black() {
            plastic
        } else {
            let (white, roughness) = (Texture::grey(1.0), Some(facets.clone()));
            let glass = Material::Dielectric {
                eta,
                reflectance: white,
                transmittance: base.clone(),
                roughness,
            };
            let glass = self.push_material(glass, None);
            self.push_material(
                Material::Blend { weight: trans, first: plastic, second: glass },
                None,
            )
        };
        let metallic = self.share(node, "metallic", 0.0);
        let metal = Material::Conductor {
            eta: Rgb::BLACK,
            k: Rgb::WHITE,
            reflectance: base,
            roughness: Some(facets),
        };
        let metal = self.push_material(metal, None);
        Some(Material::Blend { weight: metallic, first: body, second: metal })
    }

    /// A weighted sum as nested blends. What the weights lack to one is absorbed.
    pub(super) fn mixture(&mut self, node: Node<'_>) -> Option<Material> {
        let parts: Vec<usize> =
            node.children(Class::Bsdf).into_iter().map(|n| self.material(n)).collect();
        let weights = match node.text("weights").map(value::numbers) {
            Some(Ok(w)) => w,
            Some(Err(why)) => {
                node.report.error(node.span_of("weights"), why, "expected numbers");
                return None;
            }
            None => vec![1.0 / parts.len().max(1) as f32; parts.len()],
        };
        if weights.len() != parts.len() || parts.is_empty() || weights.iter().any(|w| *w < 0.0) {
            let message = format!("{} weights for {} bsdfs", weights.len(), parts.len());
            node.report.error(node.span_of("weights"), message, "expected one each, not negative");
            return None;
        }
        let total: f32 = weights.iter().sum();
        if total > 1.0 + 1e-4 {
            node.warn(format!("the weights sum to {total}: scaled to one"));
        }
        let (mut material, mut sum) = (parts[0], weights[0]);
        for (&next, &w) in parts.iter().zip(&weights).skip(1) {
            sum += w;
            let share = if sum > 0.0 { w / sum } else { 0.0 };
            material = self.blend_constant(material, next, share);
        }
        if total < 1.0 - 1e-4 {
            node.warn(format!("the weights sum to {total}: the rest of the light is absorbed"));
            let black = self.black();
            material = self.blend_constant(material, black, 1.0 - total);
        }
        // The outermost blend is returned to carry the id; a single bsdf is blended with itself.
        let top = self.parts.materials[material].clone();
        let is_last = material + 1 == self.parts.materials.len();
        if is_last && matches!(top, Material::Blend { .. }) {
            self.parts.materials.pop();
            self.origins.materials.pop();
            self.transmits.pop();
            return Some(top);
        }
        Some(Material::Blend { weight: Texture::grey(0.0), first: material, second: material })
    }

    fn blend_constant(&mut self, first: usize, second: usize, share: f32) -> usize {
        self.push_material(Material::Blend { weight: Texture::grey(share), first, second }, None)
    }
}
