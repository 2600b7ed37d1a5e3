//! BSDFs without an exact counterpart: each is approximated, with a warning.

use gi_core::bsdf::dielectric_hemispherical;
use gi_core::material::Material;
use gi_core::math::Rgb;
use gi_core::texture::Texture;

use super::ior;
use crate::builder::Builder;
use crate::document::{Class, Meaning, Node};
use crate::value;

/// Mean transmittance of an absorbing coat of this optical thickness, for diffuse light that is refracted into it.
fn mean_passage(depth: f32, eta: f32) -> f32 {
    const STEPS: usize = 64;
    let passage = |k: usize| {
        let sin_sq = (k as f32 + 0.5) / STEPS as f32;
        let cos = (1.0 - sin_sq / (eta * eta)).max(0.0).sqrt();
        (-depth / cos).exp()
    };
    (0..STEPS).map(passage).sum::<f32>() / STEPS as f32
}

/// Fraction of the light that a coat does not absorb on its way in and out.
fn passage(node: Node<'_>, eta: f32) -> Rgb {
    let sigma = node.color("sigma_a", Meaning::Factor).unwrap_or(Rgb::BLACK);
    let thickness = node.within("thickness", 1.0, 0.0..=value::MAX_NUMBER);
    if sigma.to_array().iter().any(|v| *v < 0.0) {
        node.warn("negative values of `sigma_a` are read as 0");
    }
    if !sigma.is_black() {
        node.warn("the absorption of the coating is approximated by its mean over all directions");
    }
    (sigma * thickness).map(|depth| mean_passage(depth.max(0.0), eta).powi(2))
}

impl Builder<'_> {
    /// Ward's lobe falls as exp(-tan^2 / alpha^2) about the half vector, Phong's as cos^n about the mirror direction.
    /// The mirror direction turns twice as fast, so near the peak they agree for n = 1 / (2 alpha^2).
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

    /// A coat over a diffuse base, as `plastic`. Mitsuba 0.6 leaves out the light that the coat reflects back to the base;
    /// a darker base makes up for that, so that a smooth clear coat is the same.
    pub(super) fn coating(&mut self, node: Node<'_>) -> Option<Material> {
        node.ignore(&["specular_sampling_weight"]);
        let bases = node.children(Class::Bsdf);
        let [mut base] = bases[..] else {
            node.wrong_count("bsdfs", bases.len(), "expected one");
            return None;
        };
        if let ("twosided", [inner]) = (base.plugin(), &base.children(Class::Bsdf)[..]) {
            base = *inner;
        }
        if ["conductor", "roughconductor"].contains(&base.plugin()) {
            return self.coated_conductor(node, base);
        }
        if !["diffuse", "lambertian"].contains(&base.plugin()) {
            let (kind, inner) = (node.plugin(), base.plugin());
            let help =
                "`principled` has a `clearcoat`; without the coat, the base is supported alone";
            let message = format!("`{kind}` around `{inner}` is not supported");
            node.report.error_help(
                node.span(),
                message,
                "only around `diffuse` and conductors",
                Some(help.into()),
            );
            return None;
        }
        let eta = ior::relative(node, "bk7")?;
        let leaves = 1.0 - dielectric_hemispherical(1.0 / eta);
        let diffuse = self.share(base, "reflectance", 0.5).scaled(Rgb::grey(leaves));
        let passes = passage(node, eta);
        let roughness = self.roughness(node, "roughcoating");
        if roughness.is_some() {
            node.warn("`roughcoating` is approximated by `roughplastic`");
        }
        Some(Material::Plastic {
            eta,
            diffuse: diffuse.scaled(passes),
            specular: self.share(node, "specular_reflectance", 1.0),
            nonlinear: false,
            roughness,
        })
    }

    /// A conductor instead of a coat over it. At normal incidence, a coat that reflects a fraction f of the light lets
    /// (1 - f)^2 of it reach the conductor and leave again.
    fn coated_conductor(&mut self, node: Node<'_>, base: Node<'_>) -> Option<Material> {
        if !node.doc.is_pbrt {
            let how = "the conductor alone, as bright along the normal as with its coat";
            node.warn(format!("`{}` around a conductor is approximated by {how}", node.plugin()));
        }
        node.ignore(&["alpha", "distribution"]);
        let coat_eta = ior::relative(node, "bk7")?;
        let coat = ((coat_eta - 1.0) / (coat_eta + 1.0)).powi(2);
        let passes = passage(node, coat_eta) * (1.0 - coat).powi(2);
        let coat = self.share(node, "specular_reflectance", 1.0).mean() * coat;
        let made = self.conductor(base)?;
        let Material::Conductor { eta, k, reflectance, roughness } = made else {
            return Some(made);
        };
        let metal =
            |eta: f32, k: f32| ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k);
        let own = eta.zip(k, metal) * reflectance.mean();
        // At most one: more would make light near grazing angles.
        let factor = (passes + coat.zip(own, |f, r| f / r.max(1e-6))).map(|factor| factor.min(1.0));
        let reflectance = reflectance.scaled(factor);
        Some(Material::Conductor { eta, k, reflectance, roughness })
    }

    /// A weighted sum as nested blends. If the weights sum to less than one, the rest of the light is absorbed.
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
            node.report.error(
                node.span_of("weights"),
                message,
                "expected one non-negative weight per bsdf",
            );
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
        // Return the outermost blend, which gets the id. A single bsdf is blended with itself.
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
