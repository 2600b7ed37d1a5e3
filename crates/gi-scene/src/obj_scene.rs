//! A bare OBJ file with its materials, as a whole scene.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gi_core::filter::Filter;
use gi_core::geometry::{Geometry, Shape};
use gi_core::material::Material;
use gi_core::math::Rgb;
use gi_core::scene::SceneParts;
use gi_core::texture::{Bitmap, Lookup, Texture, Wrap};
use glam::{Affine2, Vec3};

use crate::build::{Origins, ShapeOrigin};
use crate::diagnostics::Report;
use crate::files::{self, Found};
use crate::framing;
use crate::hash::Hash;
use crate::load::{Loaded, Options};
use crate::materials::ior::RELATIVE;
use crate::shapes::{obj, smooth};
use crate::texels;
use crate::textures::BitmapFile;
use crate::value::MAX_NUMBER;

/// Index of refraction of glass that names none.
const DEFAULT_IOR: f32 = 1.5;

/// Read a bare OBJ file.
pub(crate) fn load(path: &Path, options: &Options, report: &Report) -> Option<Loaded> {
    let mut reader = Reader {
        report,
        folder: files::folder_of(path),
        hash: Hash::default(),
        parts: SceneParts::default(),
        origins: Origins::default(),
        pictures: Vec::new(),
    };
    for (name, _) in options.defines.iter().filter(|(name, _)| !name.starts_with("gi.")) {
        report.warn_nowhere(format!("-D {name}: an OBJ file has no such name"));
    }
    let bytes = files::read_bytes(path);
    let contents = bytes.and_then(|bytes| {
        reader.hash.bytes(&bytes);
        obj::parse_by_material(&bytes, true, true)
    });
    let contents = match contents {
        Ok(contents) => contents,
        Err(why) => {
            report.error_nowhere(format!("cannot read `{}`: {why}", path.display()));
            return None;
        }
    };
    reader.shapes(contents);
    let size = options.size.unwrap_or([768, 576]);
    let camera = framing::frame(&reader.parts, &options.camera, size, report)?;
    let presets: BTreeMap<String, String> =
        options.defines.iter().filter(|(n, _)| n.starts_with("gi.")).cloned().collect();
    let world = reader.hash.value();
    for (name, value) in &options.defines {
        reader.hash.bytes(name.as_bytes());
        reader.hash.bytes(value.as_bytes());
    }
    Some(Loaded {
        parts: reader.parts,
        camera,
        filter: Filter::Gaussian { stddev: 0.5 },
        presets,
        integrator_max_depth: None,
        warnings: Vec::new(),
        hash: reader.hash.value(),
        world,
        origins: reader.origins,
    })
}

struct Reader<'a> {
    report: &'a Report,
    folder: PathBuf,
    hash: Hash,
    parts: SceneParts,
    origins: Origins,
    pictures: Vec<(BitmapFile, Option<Arc<Bitmap>>)>,
}

impl Reader<'_> {
    fn shapes(&mut self, contents: obj::Contents) {
        let library = self.libraries(&contents.libraries);
        for (name, mut mesh) in contents.meshes {
            let known = library.iter().find(|m| m.name == name);
            if known.is_none() && !name.is_empty() {
                self.report
                    .warn_nowhere(format!("no library has the material `{name}`: it is grey"));
            }
            let entry = known.cloned().unwrap_or_default();
            let (material, emission) = (self.material(&entry), self.emission(&entry));
            let replaced = smooth::replace_bad_normals(&mut mesh);
            if replaced > 0 {
                let name = if name.is_empty() { "the mesh" } else { &name };
                self.report.warn_nowhere(smooth::bad_normals(replaced, name));
            }
            // Material boundaries part the mesh, so smooth normals would show the seams: flat without `vn`.
            let mut shape = Shape::new(name, Geometry::Mesh(mesh), material);
            shape.emission = emission;
            self.parts.shapes.push(shape);
            self.origins.shapes.push(ShapeOrigin::Itself);
        }
        if self.parts.shapes.is_empty() {
            self.report.error_nowhere("the file holds no faces");
        }
    }

    fn libraries(&mut self, names: &[String]) -> Vec<tobj::Material> {
        let mut out = Vec::new();
        for name in names {
            let (Found::Exact(path) | Found::OtherCase(path)) =
                files::find(name, &self.folder, &[])
            else {
                self.report.warn_nowhere(format!("cannot find the material library `{name}`"));
                continue;
            };
            let read = files::read_text(&path).and_then(|text| {
                self.hash.bytes(text.as_bytes());
                tobj::load_mtl_buf(&mut text.as_bytes()).map_err(|e| e.to_string())
            });
            match read {
                Ok((materials, _)) => out.extend(materials),
                Err(why) => {
                    self.report.error_nowhere(format!("cannot read `{}`: {why}", path.display()));
                }
            }
        }
        out
    }

    /// `illum` 3 and 5 mirror, 4, 6, 7 and 9 glass; otherwise Phong where `Ks` > 0. Surfaces have two sides.
    fn material(&mut self, m: &tobj::Material) -> usize {
        let id = (!m.name.is_empty()).then(|| m.name.clone());
        let specular = color(m.specular.unwrap_or([0.0; 3]));
        let inner = match m.illumination_model {
            Some(3 | 5) => self.mirror(if specular.is_black() { Rgb::WHITE } else { specular }),
            Some(4 | 6 | 7 | 9) => return self.glass(m, id),
            _ => self.surface(m, specular),
        };
        let opacity = self.opacity(m);
        let two_sided = Material::TwoSided { front: inner, back: inner };
        match opacity {
            None => self.push(two_sided, id),
            Some(opacity) => {
                let inner = self.push(two_sided, None);
                self.push(Material::Mask { opacity, inner }, id)
            }
        }
    }

    fn surface(&mut self, m: &tobj::Material, specular: Rgb) -> usize {
        let diffuse = color(m.diffuse.unwrap_or([0.5; 3]));
        let diffuse = self.picture(m.diffuse_texture.as_deref(), diffuse, m.diffuse.is_some());
        if specular.is_black() || m.illumination_model == Some(1) || m.illumination_model == Some(0)
        {
            return self.push(Material::Diffuse { reflectance: diffuse }, None);
        }
        // Kd + Ks may not reflect more than comes in.
        let most = diffuse.mean().zip(specular, |a, b| a + b).max();
        let keep = Rgb::grey(if most > 1.0 { 1.0 / most } else { 1.0 });
        let exponent = Texture::grey(m.shininess.unwrap_or(1.0).clamp(0.0, 1e6));
        let specular = Texture::Constant(specular * keep);
        self.push(Material::Phong { diffuse: diffuse.scaled(keep), specular, exponent }, None)
    }

    fn mirror(&mut self, reflectance: Rgb) -> usize {
        let reflectance = Texture::Constant(reflectance.map(|v| v.clamp(0.0, 1.0)));
        let (eta, k) = (Rgb::BLACK, Rgb::WHITE);
        self.push(Material::Conductor { eta, k, reflectance, roughness: None }, None)
    }

    fn glass(&mut self, m: &tobj::Material, id: Option<String>) -> usize {
        // Exporters write 0 where no index was chosen.
        let eta = m.optical_density.filter(|n| *n != 0.0).unwrap_or(DEFAULT_IOR);
        if !RELATIVE.contains(&eta) {
            let name = &m.name;
            self.report.error_nowhere(format!("material `{name}`: `Ni {eta}`: expected 0.1 to 10"));
        }
        let tint = m.unknown_param.get("Tf").and_then(|t| crate::value::triple(t).ok());
        let transmittance = Texture::Constant(
            tint.map_or(Rgb::WHITE, |t| Rgb::from(t.clamp(Vec3::ZERO, Vec3::ONE).to_array())),
        );
        let glass = if eta == 1.0 {
            let reflectance = Texture::grey(1.0);
            Material::ThinDielectric { eta: 1.0 + 1e-4, reflectance, transmittance }
        } else {
            let reflectance = Texture::grey(1.0);
            Material::Dielectric { eta, reflectance, transmittance, roughness: None }
        };
        self.push(glass, id)
    }

    fn opacity(&mut self, m: &tobj::Material) -> Option<Texture> {
        let d = m.dissolve.filter(|d| d.is_finite()).map_or(1.0, |d| d.clamp(0.0, 1.0));
        let picture = m.dissolve_texture.as_deref();
        if d >= 1.0 && picture.is_none() {
            return None;
        }
        Some(self.picture(picture, Rgb::grey(d), true))
    }

    fn emission(&mut self, m: &tobj::Material) -> Option<Texture> {
        let parse = |t: &String| crate::value::triple(t).ok().map(|v| v.to_array());
        let given = m.emissive.or_else(|| m.unknown_param.get("Ke").and_then(parse));
        let map = m.unknown_param.get("map_Ke").cloned();
        let given = Rgb::from(given?);
        if given.to_array().iter().any(|v| !(0.0..=MAX_NUMBER).contains(v)) {
            let [r, g, b] = given.to_array();
            let name = &m.name;
            self.report.error_nowhere(format!(
                "material `{name}`: light `Ke {r} {g} {b}`: expected 0 to 1e15"
            ));
            return None;
        }
        let value = given;
        if value.is_black() {
            return None;
        }
        let mut light = self.picture(map.as_deref(), value, true);
        if let Texture::Bitmap { bitmap, .. } = &mut light
            && let Some(file) = self.origins.bitmap_file(bitmap).cloned()
        {
            let (lifted, negative) = texels::as_light(bitmap, &file);
            if let Some((x, y)) = negative {
                let path = file.path.display();
                self.report.warn_nowhere(format!(
                    "`{path}`: texel ({x}, {y}) and maybe others are below zero: taken for zero"
                ));
                self.origins.note_bitmap(&lifted, &file);
                *bitmap = lifted;
            }
        }
        Some(light)
    }

    /// A picture times a colour, or the colour alone. Options before a picture's name are dropped.
    fn picture(&mut self, text: Option<&str>, factor: Rgb, given: bool) -> Texture {
        let constant = Texture::Constant(factor);
        let Some(text) = text else { return constant };
        let last = text.split_whitespace().last().unwrap_or_default();
        let find = |name: &str| match files::find(name, &self.folder, &[]) {
            Found::Exact(path) | Found::OtherCase(path) => Some(path),
            Found::No => None,
        };
        let Some(path) = find(text.trim()).or_else(|| find(last)) else {
            self.report.error_nowhere(format!("cannot find the picture `{text}`"));
            return constant;
        };
        let file = BitmapFile { path, raw: false, wrap: Wrap::Repeat, lookup: Lookup::Bilinear };
        let bitmap = self.read_picture(file);
        // Where a picture is given, a black Kd is an exporter's way to say "see the picture".
        let scale = if given && !factor.is_black() { factor } else { Rgb::WHITE };
        match bitmap {
            Some(bitmap) => Texture::Bitmap { bitmap, to_uv: Affine2::IDENTITY, scale },
            None => constant,
        }
    }

    fn read_picture(&mut self, file: BitmapFile) -> Option<Arc<Bitmap>> {
        if let Some((_, known)) = self.pictures.iter().find(|(f, _)| *f == file) {
            return known.clone();
        }
        if let Ok(bytes) = files::read_bytes(&file.path) {
            self.hash.bytes(&bytes);
        }
        let read = file.read().map(Arc::new);
        if let Err(why) = &read {
            self.report.error_nowhere(format!("cannot read `{}`: {why}", file.path.display()));
        }
        let bitmap = read.ok();
        if let Some(bitmap) = &bitmap {
            self.origins.note_bitmap(bitmap, &file);
        }
        self.pictures.push((file, bitmap.clone()));
        bitmap
    }

    fn push(&mut self, material: Material, id: Option<String>) -> usize {
        self.parts.materials.push(material);
        self.origins.materials.push(id);
        self.parts.materials.len() - 1
    }
}

/// A colour of a library; what is not finite or below zero counts as zero.
fn color(c: [f32; 3]) -> Rgb {
    Rgb::from(c).map(|v| if v.is_finite() { v.max(0.0) } else { 0.0 })
}
