//! Generates the project's scenes: Mitsuba 3 XML in `scenes/`, with meshes beside it.
//!
//! `make-scenes [FOLDER] [--lights N]` writes all scenes to FOLDER (default: `scenes`), and the lamps of `gallery` for
//! one additional number of lights. The output is the same, byte for byte, in every run.

mod buildings;
mod cornell;
mod gallery;
mod glass;
mod media;
mod mesh;
mod outdoors;
mod rooms;
mod table;
mod xml;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use mesh::Mesh;

/// A scene file and the meshes that it uses.
struct SceneFile {
    name: &'static str,
    xml: String,
    meshes: Vec<(String, Mesh)>,
}

fn main() -> anyhow::Result<()> {
    let mut folder = PathBuf::from("scenes");
    let mut lights = None;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--lights" {
            let n = arguments.next().context("--lights needs a number")?;
            lights = Some(
                n.parse::<u32>()
                    .ok()
                    .filter(|n| *n > 0)
                    .with_context(|| format!("--lights {n}: not a number above zero"))?,
            );
        } else if argument.starts_with('-') {
            bail!("unknown flag {argument}; usage: make-scenes [FOLDER] [--lights N]");
        } else {
            folder = argument.into();
        }
    }
    std::fs::create_dir_all(folder.join("meshes"))
        .with_context(|| format!("cannot make {}", folder.display()))?;
    let scenes = [
        cornell::cornell_box(),
        cornell::cornell_spheres(),
        cornell::cornell_glossy(),
        rooms::bulb(),
        rooms::ring(),
        glass::torus_in_glass(),
        glass::pool(),
        gallery::gallery(),
        outdoors::patio(),
        buildings::pavilion(),
        buildings::colonnade(),
        rooms::lamp(),
        table::cognac(),
        media::fog(),
        media::marble(),
        media::milk(),
    ];
    for scene in scenes {
        write(&folder.join(format!("{}.xml", scene.name)), &scene.xml)?;
        write_meshes(&folder, &scene.meshes)?;
    }
    if let Some(n) = lights {
        write_meshes(&folder, &[gallery::gallery_lights(n)])?;
    }
    Ok(())
}

fn write_meshes(folder: &Path, meshes: &[(String, Mesh)]) -> anyhow::Result<()> {
    meshes.iter().try_for_each(|(name, mesh)| {
        write(&folder.join("meshes").join(format!("{name}.ply")), mesh.to_ply())
    })
}

fn write(path: &Path, bytes: impl AsRef<[u8]>) -> anyhow::Result<()> {
    std::fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}
