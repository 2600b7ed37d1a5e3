//! Builds a material and its emission from an entry of a library.

use gi_core::material::Material;
use gi_core::math::Rgb;
use gi_core::texture::Texture;

use super::Reader;
use super::mtl::Entry;
use crate::materials::ior::RELATIVE;

/// Default index of refraction of glass.
const DEFAULT_IOR: f32 = 1.5;
/// Default diffuse reflectance.
const DEFAULT_DIFFUSE: Rgb = Rgb::grey(0.5);

impl Reader<'_> {
    /// `illum` 3 and 5 are mirrors; 4, 6, 7 and 9 are glass; otherwise Phong where `Ks` > 0. All surfaces are
    /// two-sided.
    pub(super) fn material(&mut self, entry: &Entry) -> usize {
        let id = (!entry.name.is_empty()).then(|| entry.name.clone());
        let specular = entry.specular.unwrap_or(Rgb::BLACK);
        let inner = match entry.illumination {
            Some(3 | 5) => self.mirror(if specular.is_black() { Rgb::WHITE } else { specular }),
            Some(4 | 6 | 7 | 9) => return self.glass(entry, id),
            _ => self.surface(entry, specular),
        };
        let two_sided = Material::TwoSided { front: inner, back: inner };
        match self.opacity(entry) {
            None => self.push(two_sided, id),
            Some(opacity) => {
                let inner = self.push(two_sided, None);
                self.push(Material::Mask { opacity, inner }, id)
            }
        }
    }

    fn warn(&self, entry: &Entry, message: &str) {
        if let Some(span) = entry.span {
            self.report.warn(span, format!("material `{}`: {message}", entry.name));
        }
    }

    fn surface(&mut self, entry: &Entry, specular: Rgb) -> usize {
        let diffuse = self.picture(entry.diffuse_map.as_ref(), entry.diffuse, DEFAULT_DIFFUSE);
        if specular.is_black() || matches!(entry.illumination, Some(0 | 1)) {
            return self.push(Material::Diffuse { reflectance: diffuse }, None);
        }
        // Kd + Ks must not reflect more light than arrives.
        let most = diffuse.mean().zip(specular, |a, b| a + b).max();
        let keep = Rgb::grey(if most > 1.0 { 1.0 / most } else { 1.0 });
        if most > 1.0 + 1e-3 {
            self.warn(entry, &format!("`Kd` and `Ks` sum to {most}: scaled to one"));
        }
        let exponent = Texture::grey(entry.exponent.unwrap_or(1.0).clamp(0.0, 1e6));
        let specular = Texture::Constant(specular * keep);
        self.push(Material::Phong { diffuse: diffuse.scaled(keep), specular, exponent }, None)
    }

    fn mirror(&mut self, reflectance: Rgb) -> usize {
        let (eta, k) = (Rgb::BLACK, Rgb::WHITE);
        let reflectance = Texture::Constant(reflectance);
        self.push(Material::Conductor { eta, k, reflectance, roughness: None }, None)
    }

    fn glass(&mut self, entry: &Entry, id: Option<String>) -> usize {
        // Exporters write 0 if no index was chosen.
        let mut eta = entry.index.filter(|n| *n != 0.0).unwrap_or(DEFAULT_IOR);
        if !RELATIVE.contains(&eta) {
            self.warn(entry, &format!("`Ni {eta}` is not in 0.1 to 10: {DEFAULT_IOR} is used"));
            eta = DEFAULT_IOR;
        }
        let transmittance = Texture::Constant(entry.filter.unwrap_or(Rgb::WHITE));
        let reflectance = Texture::grey(1.0);
        let glass = if eta == 1.0 {
            Material::ThinDielectric { eta: 1.0 + 1e-4, reflectance, transmittance }
        } else {
            Material::Dielectric { eta, reflectance, transmittance, roughness: None }
        };
        self.push(glass, id)
    }

    fn opacity(&mut self, entry: &Entry) -> Option<Texture> {
        let opacity = entry.opacity.map_or(1.0, |d| d.clamp(0.0, 1.0));
        let map = entry.opacity_map.as_ref();
        if opacity >= 1.0 && map.is_none() {
            return None;
        }
        Some(self.picture(map, Some(Rgb::grey(opacity)), Rgb::WHITE))
    }

    /// `Ke`, `map_Ke`, or their product.
    pub(super) fn emission(&mut self, entry: &Entry) -> Option<Texture> {
        let map = entry.emission_map.as_ref();
        let black = entry.emission.is_none_or(Rgb::is_black);
        if black && map.is_none() {
            return None;
        }
        if black && entry.emission.is_some() {
            self.warn(
                entry,
                "`Ke` is black but `map_Ke` is given: the picture alone gives the emission",
            );
        }
        let mut light = self.picture(map, entry.emission, Rgb::BLACK);
        if let Texture::Bitmap { bitmap, .. } = &mut light
            && let Some(file) = self.origins.bitmap_file(bitmap).cloned()
        {
            let (lifted, negative) = self.origins.as_light(bitmap, &file, self.report);
            if let Some((x, y)) = negative {
                let path = file.path.display();
                self.report.warn_nowhere(format!(
                    "`{path}`: texel ({x}, {y}) and maybe others are negative: set to zero"
                ));
                *bitmap = lifted;
            }
        }
        Some(light)
    }

    fn push(&mut self, material: Material, id: Option<String>) -> usize {
        self.parts.materials.push(material);
        self.origins.materials.push(id);
        self.parts.materials.len() - 1
    }
}
