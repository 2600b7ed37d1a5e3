//! Small scenes, each in its own folder.
#![allow(dead_code)] // each test file uses what it needs

use std::path::{Path, PathBuf};

use gi_core::material::Material;
use gi_scene::{Diagnostics, Loaded, Options, load};
use tempfile::TempDir;

/// A temporary folder, removed with its files when dropped.
pub(crate) struct Folder(TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Folder(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        path
    }

    /// Load `body` as a scene in a version of the format.
    pub(crate) fn scene(&self, version: &str, body: &str) -> Result<Loaded, Diagnostics> {
        let text = format!("<scene version=\"{version}\">\n{body}\n</scene>\n");
        load(&self.write("scene.xml", text), &Options::default())
    }

    /// The errors of `body`, without the folder's name.
    pub(crate) fn problems(&self, body: &str) -> String {
        let shown = self.scene("3.0.0", body).expect_err("a scene with problems").to_string();
        self.strip(&shown)
    }

    pub(crate) fn strip(&self, text: &str) -> String {
        let folder = format!("{}/", self.0.path().display());
        text.replace(&folder, "").lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
    }
}

/// Load a valid scene in the format of Mitsuba 3.
pub(crate) fn scene(body: &str) -> Loaded {
    Folder::new().scene("3.0.0", body).unwrap_or_else(|e| panic!("{e}"))
}

/// Load a valid scene in the format of Mitsuba 0.6.
pub(crate) fn old_scene(body: &str) -> Loaded {
    Folder::new().scene("0.6.0", body).unwrap_or_else(|e| panic!("{e}"))
}

/// The material of a bsdf.
pub(crate) fn material(bsdf: &str) -> Material {
    of_only_shape(&scene(&format!("<shape type=\"rectangle\">{bsdf}</shape>")))
}

/// The material of the first shape.
pub(crate) fn of_only_shape(loaded: &Loaded) -> Material {
    loaded.parts.materials[loaded.parts.shapes[0].material].clone()
}

/// Everything in a loaded scene, as text.
pub(crate) fn describe(loaded: &Loaded) -> String {
    let Loaded { parts, camera, filter, presets, integrator_max_depth, .. } = loaded;
    format!("{parts:#?}\n{camera:#?}\n{filter:?}\n{presets:?}\n{integrator_max_depth:?}")
}

/// Compare two descriptions and show the first difference.
pub(crate) fn assert_same(a: &str, b: &str) {
    if let Some(n) = a.lines().zip(b.lines()).position(|(x, y)| x != y) {
        let part =
            |t: &str| t.lines().skip(n.saturating_sub(8)).take(10).collect::<Vec<_>>().join("\n");
        panic!("line {n}:\n{}\n--- is not ---\n{}", part(a), part(b));
    }
    assert_eq!(a.lines().count(), b.lines().count());
}

/// A path's text.
pub(crate) fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}
