//! Writes materials.

use std::collections::HashSet;

use gi_core::material::{
    BentNormals, Distribution, Material, Principled, PrincipledThin, Roughness,
};
use gi_core::math::Rgb;
use gi_core::texture::Texture;
use glam::Vec2;

use super::{Exporter, free_name};
use crate::options::Loaded;

/// Names of the materials that are written at the top level: those named in the file and those used more than once.
pub(super) fn names(loaded: &Loaded, taken: &mut HashSet<String>) -> Vec<Option<String>> {
    let materials = &loaded.parts.materials;
    let mut uses = vec![0usize; materials.len()];
    for material in materials {
        let mut of_parent = material.children();
        of_parent.dedup(); // a `twosided` whose sides are equal writes its bsdf once
        of_parent.into_iter().for_each(|c| uses[c] += 1);
    }
    let shapes = loaded.parts.shapes.iter().chain(loaded.parts.groups.iter().flatten());
    shapes.for_each(|s| uses[s.material] += 1);
    let name = |(i, id): (usize, &Option<String>)| match id {
        Some(id) => Some(free_name(id, i, taken)),
        None if uses[i] > 1 => Some(free_name("material", i, taken)),
        None => None,
    };
    loaded.origins.materials.iter().enumerate().map(name).collect()
}

/// Writes the opening tag of a material, given its type.
type Open<'f, E> = &'f dyn Fn(&mut E, &str);

impl Exporter<'_> {
    /// Write a material where it is used, as a reference if it has a name.
    pub(super) fn material(&mut self, index: usize) -> Result<(), String> {
        match &self.names[index] {
            Some(name) => {
                self.xml.empty("ref", &[("id", name)]);
                Ok(())
            }
            None => self.material_itself(index),
        }
    }

    /// Write a material in full.
    pub(super) fn material_itself(&mut self, index: usize) -> Result<(), String> {
        let loaded = self.loaded;
        let name = self.names[index].clone();
        let open = |this: &mut Self, kind: &str| match &name {
            Some(id) => this.xml.open("bsdf", &[("type", kind), ("id", id)]),
            None => this.xml.open("bsdf", &[("type", kind)]),
        };
        self.surface(&loaded.parts.materials[index], &open)?;
        self.xml.close();
        Ok(())
    }

    /// The parameters of a material that contains no other. `open` writes its opening tag.
    fn surface(&mut self, material: &Material, open: Open<'_, Self>) -> Result<(), String> {
        let rough = |plain, rough, r: &Option<Roughness>| if r.is_some() { rough } else { plain };
        match material {
            Material::Diffuse { reflectance } => {
                open(self, "diffuse");
                self.texture("reflectance", reflectance)?;
            }
            Material::RoughDiffuse { reflectance, .. } => {
                self.warn("`roughdiffuse` is exported as `diffuse`: Mitsuba 3 has no such bsdf");
                open(self, "diffuse");
                self.texture("reflectance", reflectance)?;
            }
            Material::Conductor { eta, k, reflectance, roughness } => {
                open(self, rough("conductor", "roughconductor", roughness));
                self.xml.color("eta", *eta);
                self.xml.color("k", *k);
                self.factor("specular_reflectance", reflectance)?;
                self.roughness(roughness.as_ref())?;
            }
            Material::Dielectric { eta, reflectance, transmittance, roughness } => {
                open(self, rough("dielectric", "roughdielectric", roughness));
                self.ior(*eta);
                self.factor("specular_reflectance", reflectance)?;
                self.factor("specular_transmittance", transmittance)?;
                self.roughness(roughness.as_ref())?;
            }
            Material::ThinDielectric { eta, reflectance, transmittance } => {
                open(self, "thindielectric");
                self.ior(*eta);
                self.factor("specular_reflectance", reflectance)?;
                self.factor("specular_transmittance", transmittance)?;
            }
            Material::Plastic { eta, diffuse, specular, nonlinear, roughness } => {
                open(self, rough("plastic", "roughplastic", roughness));
                self.ior(*eta);
                self.texture("diffuse_reflectance", diffuse)?;
                self.factor("specular_reflectance", specular)?;
                self.xml.value("boolean", "nonlinear", &nonlinear.to_string());
                if let Some(Roughness { distribution, alpha_u, .. }) = roughness {
                    self.xml.value("string", "distribution", distribution_name(*distribution));
                    self.xml.value("float", "alpha", &alpha_u.scalar(Vec2::ZERO).to_string());
                }
            }
            Material::Phong { diffuse, specular, exponent } => {
                self.phong(open, diffuse, specular, exponent)?;
            }
            Material::Principled(p) => {
                open(self, "principled");
                self.principled(p)?;
            }
            Material::PrincipledThin(p) => {
                open(self, "principledthin");
                self.principled_thin(p)?;
            }
            Material::Null => open(self, "null"),
            _ => self.nested(material, open)?,
        }
        Ok(())
    }

    /// The parameters of a material that contains others.
    fn nested(&mut self, material: &Material, open: Open<'_, Self>) -> Result<(), String> {
        match material {
            Material::Mask { opacity, inner } => {
                open(self, "mask");
                self.scalar("opacity", opacity)?;
                self.material(*inner)?;
            }
            Material::TwoSided { front, back } => {
                open(self, "twosided");
                self.material(*front)?;
                if back != front {
                    self.material(*back)?;
                }
            }
            Material::Blend { weight, first, second } => {
                open(self, "blendbsdf");
                self.scalar("weight", weight)?;
                self.material(*first)?;
                self.material(*second)?;
            }
            Material::Bump { height, inner, normals } => {
                open(self, "bumpmap");
                self.bent_normals(*normals);
                self.map("bump", height)?;
                self.material(*inner)?;
            }
            Material::NormalMap { map, inner, normals } => {
                open(self, "normalmap");
                self.bent_normals(*normals);
                self.map("normalmap", map)?;
                self.material(*inner)?;
            }
            _ => unreachable!("surface() writes the other materials"),
        }
        Ok(())
    }

    fn bent_normals(&mut self, normals: BentNormals) {
        self.xml.value("boolean", "flip_invalid_normals", &normals.flipped.to_string());
        self.xml.value("boolean", "use_shadowing_function", &normals.shadowed.to_string());
    }

    /// Mitsuba 3 has no Phong BSDF, so write a blend of Lambert and a rough mirror with the same albedos. Near its peak,
    /// cos^n about the mirror direction equals a Beckmann lobe about the half vector with alpha = sqrt(1 / 2n).
    fn phong(
        &mut self,
        open: Open<'_, Self>,
        diffuse: &Texture,
        specular: &Texture,
        exponent: &Texture,
    ) -> Result<(), String> {
        self.warn("`phong` is exported as a blend of `diffuse` and `roughconductor`");
        let (d, s) = (diffuse.mean().max(), specular.mean().max());
        let weight = if d + s > 0.0 { s / (d + s) } else { 0.0 };
        let alpha = (2.0 / (4.0 * exponent.mean().mean() + 2.0)).sqrt();
        let rescale = |t: &Texture, by: f32| {
            let factor = if by > 0.0 { 1.0 / by } else { 0.0 };
            t.clone().scaled(Rgb::grey(factor))
        };
        open(self, "blendbsdf");
        self.xml.value("float", "weight", &weight.to_string());
        self.xml.open("bsdf", &[("type", "diffuse")]);
        self.texture("reflectance", &clamped(rescale(diffuse, 1.0 - weight)))?;
        self.xml.close();
        self.xml.open("bsdf", &[("type", "roughconductor")]);
        self.xml.value("string", "material", "none");
        self.texture("specular_reflectance", &clamped(rescale(specular, weight)))?;
        self.xml.value("string", "distribution", "beckmann");
        self.xml.value("float", "alpha", &alpha.to_string());
        self.xml.close();
        Ok(())
    }

    fn principled(&mut self, p: &Principled) -> Result<(), String> {
        self.texture("base_color", &p.base_color)?;
        self.scalar("roughness", &p.roughness)?;
        self.xml.value("float", "eta", &p.eta.to_string());
        self.parts(&[
            ("anisotropic", &p.anisotropic),
            ("metallic", &p.metallic),
            ("spec_trans", &p.spec_trans),
            ("spec_tint", &p.spec_tint),
            ("sheen", &p.sheen),
            ("sheen_tint", &p.sheen_tint),
            ("flatness", &p.flatness),
            ("clearcoat", &p.clearcoat),
            ("clearcoat_gloss", &p.clearcoat_gloss),
        ])
    }

    fn principled_thin(&mut self, p: &PrincipledThin) -> Result<(), String> {
        self.texture("base_color", &p.base_color)?;
        self.scalar("roughness", &p.roughness)?;
        self.scalar("eta", &p.eta)?;
        self.parts(&[
            ("anisotropic", &p.anisotropic),
            ("spec_trans", &p.spec_trans),
            ("diff_trans", &p.diff_trans),
            ("spec_tint", &p.spec_tint),
            ("sheen", &p.sheen),
            ("sheen_tint", &p.sheen_tint),
            ("flatness", &p.flatness),
        ])
    }

    /// Write parameters whose default is zero. (Mitsuba skips a lobe if its parameter is not given.)
    fn parts(&mut self, parts: &[(&str, &Texture)]) -> Result<(), String> {
        let given = parts.iter().filter(|(_, texture)| !texture.is_black());
        given.into_iter().try_for_each(|(name, texture)| self.scalar(name, texture))
    }

    fn ior(&mut self, eta: f32) {
        self.xml.value("float", "int_ior", &eta.to_string());
        self.xml.value("float", "ext_ior", "1");
    }

    fn roughness(&mut self, roughness: Option<&Roughness>) -> Result<(), String> {
        let Some(Roughness { distribution, alpha_u, alpha_v }) = roughness else { return Ok(()) };
        self.xml.value("string", "distribution", distribution_name(*distribution));
        self.scalar("alpha_u", alpha_u)?;
        self.scalar("alpha_v", alpha_v)
    }
}

fn distribution_name(distribution: Distribution) -> &'static str {
    match distribution {
        Distribution::Ggx => "ggx",
        Distribution::Beckmann => "beckmann",
    }
}

/// Clamp reflectances to at most one: Mitsuba 3 refuses larger ones.
fn clamped(texture: Texture) -> Texture {
    match texture {
        Texture::Constant(c) => Texture::Constant(c.map(|v| v.clamp(0.0, 1.0))),
        other => other,
    }
}
