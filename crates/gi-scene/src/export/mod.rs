//! Writes the scene, as the loader understood it, as clean Mitsuba 3 XML. Anyone can then compare our pictures with
//! Mitsuba's, and see how a file was interpreted.

mod lights;
mod materials;
mod media;
mod shapes;
mod textures;
mod xml;

use std::collections::HashSet;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use gi_core::camera::{CameraSpec, Projection};
use gi_core::files;
use gi_core::filter::Filter;
use gi_core::math::Rgb;

use crate::diagnostics::Diagnostics;
use crate::load::load;
use crate::options::{Loaded, Options};
use xml::{Xml, degrees, numbers};

/// Why an export failed.
#[derive(Clone, Debug)]
pub enum ExportError {
    /// The scene has errors.
    Scene(Diagnostics),
    /// A file could not be written.
    Write(String),
    /// The export would overwrite a file that the scene reads.
    Overwrite(String),
}

impl fmt::Display for ExportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ExportError::Scene(problems) => problems.fmt(f),
            ExportError::Write(why) | ExportError::Overwrite(why) => f.write_str(why),
        }
    }
}

impl std::error::Error for ExportError {}

/// Read a scene and write it as Mitsuba 3 XML to `out`. Meshes and pictures that Mitsuba 3 can read stay where they
/// are; others are converted and written to a folder beside `out`. Returns a list of what was approximated.
///
/// # Errors
/// The scene's errors, or the file that could not be written. A failed export leaves no partial scene.
pub fn export_mitsuba(
    path: &Path,
    options: &Options,
    out: &Path,
) -> Result<Vec<String>, ExportError> {
    let loaded = load(path, options).map_err(ExportError::Scene)?;
    spare_inputs(&loaded.files, out).map_err(ExportError::Overwrite)?;
    write(&loaded, out).map_err(ExportError::Write)
}

/// The folder for converted files, beside the exported scene.
fn side_folder(out: &Path) -> PathBuf {
    let stem = out.file_stem().unwrap_or_default().to_string_lossy();
    out.with_file_name(format!("{stem}-files"))
}

/// Check that an export to `out` overwrites none of the scene's own files.
fn spare_inputs(inputs: &[PathBuf], out: &Path) -> Result<(), String> {
    let side = side_folder(out).canonicalize().ok();
    let in_side = |file: &Path| match (file.canonicalize(), &side) {
        (Ok(file), Some(side)) => file.starts_with(side),
        _ => false,
    };
    match inputs.iter().find(|file| files::is_same(file, out) || in_side(file)) {
        None => Ok(()),
        Some(file) => Err(format!(
            "`{}` would overwrite `{}`, which is part of the scene: choose another name",
            out.display(),
            file.display()
        )),
    }
}

fn write(loaded: &Loaded, out: &Path) -> Result<Vec<String>, String> {
    let mut exporter = Exporter::new(loaded, out);
    let text = exporter.scene()?;
    files::write(out, text.as_bytes()).map_err(|e| cannot_write(out, e))?;
    let mut warnings = loaded.warnings.clone();
    warnings.extend(exporter.warnings);
    Ok(warnings)
}

fn cannot_write(path: &Path, cause: impl fmt::Display) -> String {
    format!("cannot write `{}`: {cause}", path.display())
}

struct Exporter<'a> {
    loaded: &'a Loaded,
    /// The XML file.
    out: &'a Path,
    /// Folder for converted files, beside the XML file.
    side: PathBuf,
    /// Number of converted files.
    converted: usize,
    xml: Xml,
    /// Names of the materials that are written once and referred to.
    names: Vec<Option<String>>,
    /// Names of the media.
    media: Vec<String>,
    warnings: Vec<String>,
}

impl<'a> Exporter<'a> {
    fn new(loaded: &'a Loaded, out: &'a Path) -> Self {
        let side = side_folder(out);
        let mut taken = HashSet::new();
        let names = materials::names(loaded, &mut taken);
        let media = loaded.origins.media.iter().enumerate();
        let media = media
            .map(|(i, id)| free_name(id.as_deref().unwrap_or("medium"), i, &mut taken))
            .collect();
        let (xml, warnings) = (Xml::default(), Vec::new());
        Exporter { loaded, out, side, converted: 0, xml, names, media, warnings }
    }

    fn warn(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !self.warnings.contains(&text) {
            self.warnings.push(text);
        }
    }

    fn scene(&mut self) -> Result<String, String> {
        let loaded = self.loaded;
        if loaded.parts.origin != glam::Vec3::ZERO {
            let at = numbers(&loaded.parts.origin.to_array());
            self.warn(format!(
                "the exported scene is moved: its origin is at {at} of the file that was read"
            ));
        }
        self.xml.open("scene", &[("version", "3.0.0")]);
        for (name, value) in &loaded.presets {
            self.xml.empty("default", &[("name", name), ("value", value)]);
        }
        let integrator = if loaded.parts.media.is_empty() { "path" } else { "volpath" };
        self.xml.open("integrator", &[("type", integrator)]);
        let depth = loaded.integrator_max_depth.unwrap_or(-1).to_string();
        self.xml.value("integer", "max_depth", &depth);
        if loaded.parts.hides_emitters {
            self.xml.value("boolean", "hide_emitters", "true");
        }
        self.xml.close();
        self.sensor(&loaded.camera);
        for (i, medium) in loaded.parts.media.iter().enumerate() {
            self.medium(i, medium)?;
        }
        for i in 0..loaded.parts.materials.len() {
            if self.names[i].is_some() {
                self.material_itself(i)?;
            }
        }
        self.shapes()?;
        self.lights()?;
        self.xml.close();
        Ok(std::mem::take(&mut self.xml).finish())
    }

    fn sensor(&mut self, camera: &CameraSpec) {
        let shift = camera.principal_point_offset;
        let has_lens = matches!(camera.projection, Projection::Perspective { aperture_radius, .. } if aperture_radius > 0.0);
        if has_lens && shift != glam::Vec2::ZERO {
            self.warn("`principal_point_offset` is not exported: Mitsuba 3's `thinlens` has none");
        }
        let xml = &mut self.xml;
        match camera.projection {
            Projection::Orthographic => xml.open("sensor", &[("type", "orthographic")]),
            Projection::Perspective { fov_x, aperture_radius, focus_distance } => {
                let kind = if aperture_radius > 0.0 { "thinlens" } else { "perspective" };
                xml.open("sensor", &[("type", kind)]);
                xml.value("float", "fov", &degrees(fov_x));
                xml.value("string", "fov_axis", "x");
                if aperture_radius > 0.0 {
                    xml.value("float", "aperture_radius", &aperture_radius.to_string());
                    xml.value("float", "focus_distance", &focus_distance.to_string());
                }
            }
        }
        if camera.near > 0.0 {
            xml.value("float", "near_clip", &camera.near.to_string());
        }
        if !has_lens && shift != glam::Vec2::ZERO {
            xml.value("float", "principal_point_offset_x", &shift.x.to_string());
            xml.value("float", "principal_point_offset_y", &shift.y.to_string());
        }
        xml.transform("to_world", &camera.to_world);
        xml.open("sampler", &[("type", "independent")]);
        xml.value("integer", "sample_count", "64");
        xml.close();
        xml.open("film", &[("type", "hdrfilm")]);
        xml.value("integer", "width", &camera.size[0].to_string());
        xml.value("integer", "height", &camera.size[1].to_string());
        filter(xml, self.loaded.filter);
        xml.close();
        xml.close();
    }

    /// Write a file that the scene needs and return its name as used in the XML. `write` returns only the cause of a
    /// failure.
    fn side_file(
        &mut self,
        extension: &str,
        write: impl FnOnce(&Path) -> Result<(), String>,
    ) -> Result<String, String> {
        fs::create_dir_all(&self.side)
            .map_err(|e| format!("cannot make the folder `{}`: {e}", self.side.display()))?;
        let path = self.side.join(format!("{:04}.{extension}", self.converted));
        self.converted += 1;
        // The name may be a link that leads out of the folder.
        if let Some(input) = self.loaded.files.iter().find(|input| files::is_same(input, &path)) {
            let cause =
                format!("it would overwrite `{}`, which is part of the scene", input.display());
            return Err(cannot_write(&path, cause));
        }
        write(&path).map_err(|e| cannot_write(&path, e))?;
        Ok(self.file_name(&path))
    }

    /// A file's path relative to the XML's folder.
    fn file_name(&self, path: &Path) -> String {
        let absolute = |p: &Path| p.canonicalize().unwrap_or_else(|_| p.to_owned());
        let folder = absolute(&crate::files::folder_of(self.out));
        let path = absolute(path);
        let common = folder.components().zip(path.components()).take_while(|(a, b)| a == b).count();
        let up = folder.components().count() - common;
        let parts = std::iter::repeat_n("..".to_owned(), up).chain(
            path.components().skip(common).map(|c| c.as_os_str().to_string_lossy().into_owned()),
        );
        parts.collect::<Vec<_>>().join("/")
    }
}

/// `wanted`, changed if necessary so that it is unique.
fn free_name(wanted: &str, index: usize, taken: &mut HashSet<String>) -> String {
    let name = xml::identifier(wanted);
    let name = if taken.contains(&name) { format!("{name}-{index}") } else { name };
    taken.insert(name.clone());
    name
}

fn filter(xml: &mut Xml, filter: Filter) {
    let (kind, parameters): (&str, Vec<(&str, &str, String)>) = match filter {
        Filter::Box => ("box", vec![]),
        Filter::Tent => ("tent", vec![]),
        Filter::Gaussian { stddev } => ("gaussian", vec![("float", "stddev", stddev.to_string())]),
        Filter::Mitchell { b, c } => {
            ("mitchell", vec![("float", "B", b.to_string()), ("float", "C", c.to_string())])
        }
        Filter::CatmullRom => ("catmullrom", vec![]),
        Filter::Lanczos { lobes } => ("lanczos", vec![("integer", "lobes", lobes.to_string())]),
    };
    xml.open("rfilter", &[("type", kind)]);
    for (tag, name, value) in parameters {
        xml.value(tag, name, &value);
    }
    xml.close();
}

/// A colour's channels as text.
fn channels(c: Rgb) -> String {
    numbers(&c.to_array())
}
