//! BSDF plugins to [`Material`]s.

mod approximate;
pub(crate) mod ior;
mod parameters;
mod principled;
mod remap;
mod wrappers;

use gi_core::material::{BentNormals, Distribution, Material, Roughness};
use gi_core::math::Rgb;
use gi_core::texture::Texture;

use crate::builder::Builder;
use crate::document::{Meaning, Node};
use crate::textures::one_channel;

/// The supported plugins.
const KNOWN: [&str; 29] = [
    "diffuse",
    "roughdiffuse",
    "dielectric",
    "roughdielectric",
    "thindielectric",
    "conductor",
    "roughconductor",
    "plastic",
    "roughplastic",
    "phong",
    "ward",
    "mask",
    "twosided",
    "bumpmap",
    "bump",
    "normalmap",
    "blendbsdf",
    "mixturebsdf",
    "null",
    "principled",
    "principledthin",
    "pplastic",
    "coating",
    "roughcoating",
    "lambertian",
    "opacity",
    "polarizer",
    "retarder",
    "circular",
];

/// Largest depth of nested materials. The builder is recursive, and no real scene comes near this depth.
const MAX_NESTING: usize = 32;

impl Builder<'_> {
    /// The material of a BSDF, built when first used; black if an error was reported.
    pub(crate) fn material(&mut self, node: Node<'_>) -> usize {
        let shared = self.attributes.is_none();
        if let Some(&known) = self.material_of.get(&node.id).filter(|_| shared) {
            return known;
        }
        if self.open_materials.contains(&node.id) {
            node.error("this bsdf contains itself", "");
            return self.black();
        }
        if self.open_materials.len() >= MAX_NESTING {
            node.error("bsdfs are nested too deeply", "");
            return self.black();
        }
        self.open_materials.push(node.id);
        let material = self.make_material(node);
        self.open_materials.pop();
        let index = match material {
            Some(material) => self.push_material(material, node.object().id.clone()),
            None => self.black(),
        };
        if shared {
            self.material_of.insert(node.id, index);
        }
        index
    }

    /// Add a material to the table and return its index.
    pub(crate) fn push_material(&mut self, material: Material, id: Option<String>) -> usize {
        let of = |index: &usize| self.transmits[*index];
        let transmits = match &material {
            Material::Dielectric { .. } | Material::ThinDielectric { .. } | Material::Null => true,
            Material::Mask { .. } | Material::PrincipledThin(_) => true,
            Material::Principled(p) => !p.spec_trans.is_black(),
            Material::TwoSided { front, back } => of(front) || of(back),
            Material::Blend { first, second, .. } => of(first) || of(second),
            Material::Bump { inner, .. } | Material::NormalMap { inner, .. } => of(inner),
            _ => false,
        };
        self.transmits.push(transmits);
        self.parts.materials.push(material);
        self.origins.materials.push(id);
        self.parts.materials.len() - 1
    }

    /// The material that reflects nothing.
    pub(crate) fn black(&mut self) -> usize {
        if let Some(black) = self.black {
            return black;
        }
        let index = self.push_material(Material::Diffuse { reflectance: Texture::grey(0.0) }, None);
        *self.black.insert(index)
    }

    fn make_material(&mut self, node: Node<'_>) -> Option<Material> {
        Some(match node.plugin() {
            "diffuse" | "lambertian" => {
                Material::Diffuse { reflectance: self.share(node, "reflectance", 0.5) }
            }
            "roughdiffuse" => {
                if !node.bool("use_fast_approx", false) {
                    node.warn("`roughdiffuse` is computed by Oren and Nayar's qualitative model");
                }
                let alpha = self.texture(node, "alpha", Texture::grey(0.2), Meaning::Factor);
                let alpha = one_channel(node, alpha);
                Material::RoughDiffuse { reflectance: self.share(node, "reflectance", 0.5), alpha }
            }
            "dielectric" | "roughdielectric" => self.dielectric(node)?,
            "thindielectric" => Material::ThinDielectric {
                eta: ior::relative(node, "bk7")?,
                reflectance: self.share(node, "specular_reflectance", 1.0),
                transmittance: self.share(node, "specular_transmittance", 1.0),
            },
            "conductor" | "roughconductor" => self.conductor(node)?,
            "plastic" | "roughplastic" | "pplastic" => self.plastic(node)?,
            "coating" | "roughcoating" => return self.coating(node),
            "phong" => Material::Phong {
                diffuse: self.share(node, "diffuse_reflectance", 0.5),
                specular: self.share(node, "specular_reflectance", 0.2),
                exponent: self.exponent(node),
            },
            "ward" => self.ward(node),
            "principled" => self.principled(node),
            "principledthin" => self.principled_thin(node),
            "null" => Material::Null,
            "polarizer" | "circular" => self.filter(node, 0.5),
            "retarder" => self.filter(node, 1.0),
            "mask" | "opacity" => {
                let opacity = self.one_channel_share(node, "opacity", 0.5);
                Material::Mask { opacity, inner: self.only_child(node)? }
            }
            "twosided" => self.twosided(node)?,
            "bumpmap" | "bump" => {
                let scale = Rgb::grey(node.float("scale", 1.0));
                let height = self.only_texture(node)?.scaled(scale);
                Material::Bump {
                    height,
                    inner: self.only_child(node)?,
                    normals: Self::bent_normals(node),
                }
            }
            "normalmap" => {
                let map = self.only_texture(node)?;
                Material::NormalMap {
                    map,
                    inner: self.only_child(node)?,
                    normals: Self::bent_normals(node),
                }
            }
            "blendbsdf" => self.blend(node)?,
            "mixturebsdf" => return self.mixture(node),
            _ => {
                node.unknown_plugin(&KNOWN);
                return None;
            }
        })
    }

    /// How `bumpmap` and `normalmap` treat normals that face away. Mitsuba 3 repairs them by default, also in files of
    /// Mitsuba 2; Mitsuba 0.6 never does.
    fn bent_normals(node: Node<'_>) -> BentNormals {
        let repaired = node.doc.version >= 2;
        BentNormals {
            flipped: node.bool("flip_invalid_normals", repaired),
            shadowed: node.bool("use_shadowing_function", repaired),
        }
    }

    fn dielectric(&mut self, node: Node<'_>) -> Option<Material> {
        Some(Material::Dielectric {
            eta: ior::relative(node, "bk7")?,
            reflectance: self.share(node, "specular_reflectance", 1.0),
            transmittance: self.share(node, "specular_transmittance", 1.0),
            roughness: self.roughness(node, "roughdielectric"),
        })
    }

    fn conductor(&mut self, node: Node<'_>) -> Option<Material> {
        let named = match node.text("material") {
            Some(name) => Some(ior::conductor_of(node, name)?),
            // The default conductor is copper in Mitsuba 0.6 and a perfect mirror in Mitsuba 3.
            None if node.doc.version == 0 => ior::conductor("Cu"),
            None => ior::conductor("none"),
        };
        let (mut eta, mut k) = named?;
        if node.has("eta") || node.has("k") || node.child("eta").is_some() {
            eta = node.color("eta", Meaning::Factor).unwrap_or(Rgb::BLACK);
            k = node.color("k", Meaning::Factor).unwrap_or(Rgb::WHITE);
        }
        // The material stores eta and k relative to the outside.
        let outside = ior::interface(node, "ext_eta").or_else(|| ior::interface(node, "ext_ior"));
        if let Some(outside) = outside {
            (eta, k) = (eta / outside, k / outside);
        }
        let reflectance = self.share(node, "specular_reflectance", 1.0);
        Some(Material::Conductor {
            eta,
            k,
            reflectance,
            roughness: self.roughness(node, "roughconductor"),
        })
    }

    fn plastic(&mut self, node: Node<'_>) -> Option<Material> {
        let mut roughness = self.roughness(node, "roughplastic");
        if let Some(Roughness { alpha_u, alpha_v, .. }) = &mut roughness {
            if !alpha_u.is_constant() || !alpha_v.is_constant() {
                node.warn("a textured roughness of plastic is replaced by its mean");
                *alpha_u = Texture::grey(alpha_u.mean().mean());
            }
            *alpha_v = alpha_u.clone();
        }
        Some(Material::Plastic {
            eta: ior::relative(node, "polypropylene")?,
            diffuse: self.share(node, "diffuse_reflectance", 0.5),
            specular: self.share(node, "specular_reflectance", 1.0),
            nonlinear: node.bool("nonlinear", false),
            roughness,
        })
    }

    /// The microfacet roughness, if the plugin is the rough one.
    fn roughness(&mut self, node: Node<'_>, rough: &str) -> Option<Roughness> {
        if node.plugin() != rough && node.plugin() != "pplastic" {
            return None;
        }
        node.ignore(&["sample_visible"]);
        let distribution = match node.text("distribution").unwrap_or("beckmann") {
            "beckmann" => Distribution::Beckmann,
            "ggx" => Distribution::Ggx,
            "phong" | "as" => {
                let span = node.span_of("distribution");
                node.report.warn(span, "distribution `phong` is approximated by `beckmann`");
                Distribution::Beckmann
            }
            other => {
                let help = node.report.suggestion(other, ["beckmann", "ggx", "phong"]);
                let message = format!("unknown distribution `{other}`");
                let span = node.span_of("distribution");
                node.report.error_help(span, message, "expected `beckmann` or `ggx`", help);
                return None;
            }
        };
        let alpha = self.alpha(node, "alpha", Texture::grey(0.1));
        let alpha_u = self.alpha(node, "alpha_u", alpha.clone());
        let alpha_v = self.alpha(node, "alpha_v", alpha);
        let [alpha_u, alpha_v] = [alpha_u, alpha_v].map(|alpha| self.remapped(node, alpha));
        Some(Roughness { distribution, alpha_u, alpha_v })
    }
}
