//! Saving: the picture with its layers and metadata, the view beside it, the statistics.

use std::path::{Path, PathBuf};

use gi_core::files;
use gi_core::image_io::{ImageFile, Layers, write_file};
use gi_core::technique::Picture;

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

    /// Check that other files to write can be written, and that no two are one: nor the picture, nor its view.
    pub(crate) fn check_apart(&self, others: &[PathBuf]) -> Result<(), Failure> {
        for (k, other) in others.iter().enumerate() {
            let view = self.path.with_extension("png");
            let picture = files::is_same(other, &self.path) || files::is_same(other, &view);
            if picture || others[..k].iter().any(|before| files::is_same(before, other)) {
                let what = if picture { "the picture" } else { "another of the run's files" };
                let text = format!("error: {} would overwrite {what}", other.display());
                return Err(Failure::Input(text));
            }
            check_writable(other)?;
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

    /// Write the view of a technique's own picture beside them.
    pub(crate) fn save_view(&self, picture: &Picture, size: [usize; 2]) -> Result<(), Failure> {
        let layers = Layers::of_rgb(size, picture.view.iter().map(|c| c.to_array()));
        write(&self.path.with_extension(format!("{}.png", picture.name)), ImageFile::Png, &layers)
    }
}

/// Check that a file can be made where `path` will be.
fn check_writable(path: &Path) -> Result<(), Failure> {
    files::check_writable(path).map_err(|e| cannot_write(path, e))
}

fn write(path: &Path, format: ImageFile, layers: &Layers) -> Result<(), Failure> {
    write_file(path, format, layers).map_err(|e| cannot_write(path, e))
}

/// Write a file that is no picture.
pub(crate) fn save_bytes(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    files::write(path, bytes).map_err(|e| cannot_write(path, e))
}

fn cannot_write(path: &Path, cause: impl std::fmt::Display) -> Failure {
    Failure::Other(format!("cannot write {}: {cause}", path.display()))
}
