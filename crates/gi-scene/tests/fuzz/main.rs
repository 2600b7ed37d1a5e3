//! Damages small valid files in many ways. However a file is damaged, loading it neither panics nor hangs, takes no more
//! than the allowed memory, and gives finite numbers.
//!
//! Inputs that once failed belong into `found`: all of them are loaded too.

#[path = "../common/mod.rs"]
mod common;
mod corpus;
mod damage;
mod harness;

use std::path::Path;

use common::Folder;
use gi_core::geometry::Geometry;
use gi_core::light::LightSource;
use gi_core::material::Material;
use gi_core::texture::{Bitmap, Texture};
use gi_scene::{Loaded, Options, load};
use glam::Vec2;

/// Memory that one input may take.
const MEMORY: u64 = 1 << 28;

/// Load damaged copies of a file until the time is over. `scene` is the name and the text of the file to load, if it is
/// not the damaged one.
fn fuzz(name: &str, files: &[Vec<u8>], scene: Option<(&str, String)>) {
    let folder = Folder::new();
    corpus::write_companions(&folder);
    let path = folder.path(scene.as_ref().map_or(name, |(name, _)| name));
    if let Some((name, text)) = scene {
        folder.write(name, text);
    }
    harness::fuzz(name, files, |bytes| {
        folder.write(name, bytes);
        try_load(&path)
    });
}

/// Load a file; whether it is a valid scene, or what must not happen.
fn try_load(path: &Path) -> Result<bool, String> {
    let options = Options { max_memory: MEMORY, ..Options::default() };
    harness::guarded(|| match load(path, &options) {
        Ok(loaded) => check(&loaded).map(|()| true),
        Err(problems) if problems.to_string().is_empty() => Err("an error without text".into()),
        Err(_) => Ok(false),
    })
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

#[test]
fn xml_files() {
    fuzz("a.xml", &corpus::xml(), None);
}

#[test]
fn pbrt_files() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pbrt/scenes");
    fuzz("a.pbrt", &corpus::pbrt(&scenes), None);
}

#[test]
fn obj_files() {
    fuzz("a.obj", &corpus::obj(), None);
}

#[test]
fn material_libraries() {
    fuzz("a.mtl", &corpus::mtl(), Some(("a.obj", corpus::OBJ.into())));
}

#[test]
fn meshes_of_all_formats() {
    fuzz("m.ply", &corpus::ply(), Some(("scene.xml", corpus::scene_of_mesh("ply"))));
    let scene = ("scene.xml", corpus::scene_of_mesh("serialized"));
    fuzz("m.serialized", &corpus::serialized(), Some(scene));
}

#[test]
fn volumes() {
    fuzz("v.vol", &corpus::volumes(), Some(("scene.xml", corpus::scene_of_volume())));
}

#[test]
fn pictures_of_all_formats() {
    for kind in ["exr", "pfm", "hdr", "png"] {
        let scene = ("scene.xml", corpus::scene_of_picture(kind));
        fuzz(&format!("p.{kind}"), &corpus::pictures(kind), Some(scene));
    }
}

#[test]
fn files_that_once_failed() {
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/found");
    for entry in std::fs::read_dir(found).unwrap() {
        let path = entry.unwrap().path();
        let kind = path.extension().unwrap_or_default().to_string_lossy().into_owned();
        let bytes = std::fs::read(&path).unwrap();
        let folder = Folder::new();
        let path = match kind.as_str() {
            "xml" | "obj" | "pbrt" => path,
            "mtl" => continue, // an OBJ file names it
            "ply" | "serialized" => {
                folder.write(&format!("m.{kind}"), bytes);
                folder.write("scene.xml", corpus::scene_of_mesh(&kind))
            }
            "vol" => {
                folder.write("v.vol", bytes);
                folder.write("scene.xml", corpus::scene_of_volume())
            }
            _ => {
                folder.write(&format!("p.{kind}"), bytes);
                folder.write("scene.xml", corpus::scene_of_picture(&kind))
            }
        };
        try_load(&path).unwrap_or_else(|why| panic!("{}: {why}", path.display()));
    }
}
