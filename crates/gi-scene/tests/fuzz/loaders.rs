//! The kinds of files that the loaders read, and what must hold for every input.

use std::path::{Path, PathBuf};

use gi_core::geometry::Geometry;
use gi_core::light::LightSource;
use gi_core::material::Material;
use gi_core::texture::{Bitmap, Texture};
use gi_scene::{Loaded, Options, load};
use glam::Vec2;

use crate::common::{Folder, Slot};
use crate::corpus;

/// All kinds of files, by extension; `sky` is a scene in XML.
pub(crate) const KINDS: [&str; 15] = [
    "xml",
    "sky",
    "pbrt",
    "obj",
    "mtl",
    "ply",
    "serialized",
    "vol",
    "exr",
    "pfm",
    "hdr",
    "png",
    "jpg",
    "tga",
    "bmp",
];

/// Memory that one input may take.
pub(crate) const MEMORY: u64 = 1 << 28;

/// Loads inputs of one kind.
pub(crate) struct Loader {
    /// The name under which inputs are written.
    pub(crate) name: String,
    /// Small valid files.
    pub(crate) files: Vec<Vec<u8>>,
    /// The folder of the inputs, with the files that they name.
    _folder: Folder,
    input: Slot,
    /// The file to load: the input, or a scene that names it.
    scene: PathBuf,
    options: Options,
}

impl Loader {
    pub(crate) fn new(kind: &str) -> Self {
        let folder = Folder::in_memory();
        corpus::write_companions(&folder);
        let stem = match kind {
            "ply" | "serialized" => "m",
            "vol" => "v",
            "xml" | "pbrt" | "obj" | "mtl" => "a",
            _ => "p",
        };
        let name = if kind == "sky" { "sky.xml".into() } else { format!("{stem}.{kind}") };
        let scene = match kind {
            "xml" | "sky" | "pbrt" | "obj" => folder.path(&name),
            "mtl" => folder.path("a.obj"),
            "ply" | "serialized" => folder.write("scene.xml", corpus::scene_of_mesh(kind)),
            "vol" => folder.write("scene.xml", corpus::scene_of_volume()),
            _ => folder.write("scene.xml", corpus::scene_of_picture(kind)),
        };
        let files = corpus::files(kind);
        let input = folder.slot(&name);
        Loader { name, files, _folder: folder, input, scene, options: options() }
    }

    /// Load an input; whether it is valid, or what must not happen.
    pub(crate) fn check(&self, bytes: &[u8]) -> Result<bool, String> {
        self.input.replace(bytes);
        try_load(&self.scene, &self.options)
    }
}

/// Options with the allowed memory. To make them takes a while, because the default depends on the machine.
pub(crate) fn options() -> Options {
    Options { max_memory: MEMORY, ..Options::default() }
}

/// Load a file; whether it is a valid scene, or what must not happen.
pub(crate) fn try_load(path: &Path, options: &Options) -> Result<bool, String> {
    match load(path, options) {
        Ok(loaded) => check(&loaded).map(|()| true),
        Err(problems) if problems.to_string().is_empty() => Err("an error without text".into()),
        Err(_) => Ok(false),
    }
}

/// Check that all numbers are finite.
fn check(loaded: &Loaded) -> Result<(), String> {
    let parts = &loaded.parts;
    for shape in parts.shapes.iter().chain(parts.groups.iter().flatten()) {
        let bounds = shape.geometry.bounds();
        let finite = bounds.min.is_finite() && bounds.max.is_finite();
        if !bounds.is_empty() && !finite {
            return Err(format!("the bounds of {} are not finite", shape.name));
        }
        if let Geometry::Mesh(mesh) = &shape.geometry {
            let finite = mesh.normals.iter().all(|n| n.is_finite())
                && mesh.uvs.iter().all(|uv| uv.is_finite());
            let count = mesh.positions.len();
            let known = mesh.triangles.iter().flatten().all(|&i| (i as usize) < count);
            if !finite || !known {
                return Err(format!("the mesh of {} has invalid numbers", shape.name));
            }
        }
        shape.emission.iter().try_for_each(check_texture)?;
    }
    for material in &parts.materials {
        if let Material::Diffuse { reflectance } = material {
            check_texture(reflectance)?;
        }
    }
    for medium in &parts.media {
        let most = medium.varying.as_ref().map_or(medium.sigma_t, |v| v.sigma_t().most());
        if !most.is_finite() || !medium.albedo.is_finite() {
            return Err("a medium is not finite".into());
        }
    }
    for light in &parts.lights {
        if let LightSource::Environment { image, .. } = light {
            check_bitmap(image)?;
        }
    }
    if !loaded.camera.to_world.is_finite() {
        return Err("the camera is not finite".into());
    }
    Ok(())
}

/// Texture coordinates that overflow, or are none.
const FAR: [f32; 6] = [0.3, -1e5, 3e9, 1e38, -3e38, f32::NAN];

fn check_texture(texture: &Texture) -> Result<(), String> {
    let all = FAR.iter().flat_map(|&u| FAR.map(|v| Vec2::new(u, v)));
    match all.map(|uv| (uv, texture.eval(uv))).find(|(_, value)| !value.is_finite()) {
        Some((uv, value)) => Err(format!("the texture at {uv} is {value:?}")),
        None => Ok(()),
    }
}

fn check_bitmap(bitmap: &Bitmap) -> Result<(), String> {
    let finite = bitmap.range().iter().all(|v| v.is_finite()) && bitmap.mean().is_finite();
    finite.then_some(()).ok_or_else(|| "a picture is not finite".into())
}
