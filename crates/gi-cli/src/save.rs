//! Saving: the picture with its layers and metadata, the view beside it, the statistics.

use std::path::{Path, PathBuf};

use gi_core::image_io::{ImageFile, Layers, write_file};
use serde_json::Value;

use crate::Failure;

/// Where a run's pictures go, found to be writable before the work begins.
pub(crate) struct Output {
    path: PathBuf,
    format: ImageFile,
}

impl Output {
    /// Check a file name, and that its folder takes files.
    pub(crate) fn new(path: PathBuf) -> Result<Self, Failure> {
        let format = ImageFile::from_path(&path).filter(|f| *f != ImageFile::Png).ok_or_else(|| {
            let advice = "end the name in .exr (all layers), .pfm or .hdr; a .png view is written beside it";
            Failure::Input(format!("error: cannot save to {}: {advice}", path.display()))
        })?;
        check_writable(&path)?;
        check_writable(&path.with_extension("png"))?;
        Ok(Output { path, format })
    }

    /// Check that another file to write is neither the picture nor its view.
    pub(crate) fn check_apart(&self, other: &Path) -> Result<(), Failure> {
        if other == self.path || other == self.path.with_extension("png") {
            let text = format!("error: --stats {} would overwrite the picture", other.display());
            return Err(Failure::Input(text));
        }
        Ok(())
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Write the picture and its view.
    pub(crate) fn save(&self, layers: &Layers) -> Result<(), Failure> {
        write(&self.path, self.format, layers)?;
        write(&self.path.with_extension("png"), ImageFile::Png, layers)
    }
}

/// Check that a file can be made beside where `path` will be.
pub(crate) fn check_writable(path: &Path) -> Result<(), Failure> {
    if path.is_dir() {
        return Err(Failure::Other(format!("cannot write {}: it is a folder", path.display())));
    }
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.try", std::process::id()));
    let trial = path.with_file_name(name);
    std::fs::File::create(&trial)
        .map_err(|e| Failure::Other(format!("cannot write {}: {e}", path.display())))?;
    let _ = std::fs::remove_file(&trial); // an empty file left behind does no harm
    Ok(())
}

fn write(path: &Path, format: ImageFile, layers: &Layers) -> Result<(), Failure> {
    write_file(path, format, layers)
        .map_err(|e| Failure::Other(format!("cannot write {}: {e}", path.display())))
}

/// Write statistics: to a temporary name first, as pictures are.
pub(crate) fn save_json(path: &Path, value: &Value) -> Result<(), Failure> {
    let text = format!("{value:#}\n");
    let part = path.with_extension(format!("json.{}.part", std::process::id()));
    std::fs::write(&part, text)
        .and_then(|()| std::fs::rename(&part, path))
        .map_err(|e| Failure::Other(format!("cannot write {}: {e}", path.display())))
}
