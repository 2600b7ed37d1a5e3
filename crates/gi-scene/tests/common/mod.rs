//! Small scenes, each in its own folder.
#![allow(dead_code)] // each test file uses what it needs

use std::fs::File;
use std::io::{Seek, Write};
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

    /// A folder in the machine's memory, where the system has a place for such folders: a disk allows only some hundred
    /// files per second.
    pub(crate) fn in_memory() -> Self {
        tempfile::tempdir_in("/dev/shm").map_or_else(|_| Folder::new(), Folder)
    }

    /// A file that is replaced many times.
    pub(crate) fn slot(&self, name: &str) -> Slot {
        let path = self.path(name);
        Slot { file: File::create(&path).unwrap(), path }
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

/// A file that stays open, because opening takes longer than writing.
pub(crate) struct Slot {
    pub(crate) path: PathBuf,
    file: File,
}

impl Slot {
    /// Replace what is in it.
    pub(crate) fn replace(&self, bytes: &[u8]) -> &Path {
        let mut file = &self.file;
        file.rewind().unwrap();
        file.write_all(bytes).unwrap();
        file.set_len(bytes.len() as u64).unwrap();
        &self.path
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
