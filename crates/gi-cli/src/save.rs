//! Saving: the picture with its layers and metadata, the view beside it, the statistics.

use std::path::{Path, PathBuf};

use gi_core::files;
use gi_core::image_io::{ImageFile, Layers, write_file};
use gi_core::technique::Picture;

use crate::Failure;

/// Where a run's pictures go.
pub(crate) struct Output {
    path: PathBuf,
    format: ImageFile,
}

impl Output {
    /// Check a file name.
    pub(crate) fn new(path: PathBuf) -> Result<Self, Failure> {
        let format = ImageFile::from_path(&path).filter(|f| *f != ImageFile::Png).ok_or_else(|| {
            let advice = "end the name in .exr (all layers), .pfm or .hdr; a .png view is written beside it";
            Failure::Input(format!("error: cannot save to {}: {advice}", path.display()))
        })?;
        Ok(Output { path, format })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Write the picture and its view. If one of them fails, the other is written all the same.
    pub(crate) fn save(&self, layers: &Layers) -> Result<(), Failure> {
        let picture = write(&self.path, self.format, layers);
        let view = write(&self.path.with_extension("png"), ImageFile::Png, layers);
        picture.and(view)
    }

    /// Write the view of a technique's own picture beside them, with its legend.
    pub(crate) fn save_view(&self, picture: &Picture, size: [usize; 2]) -> Result<(), Failure> {
        let (size, view) = match &picture.legend {
            Some(legend) => legend.below(size, &picture.view),
            None => (size, picture.view.clone()),
        };
        let layers = Layers::of_rgb(size, view.iter().map(|c| c.to_array()));
        write(&self.path.with_extension(format!("{}.png", picture.name)), ImageFile::Png, &layers)
    }
}

fn write(path: &Path, format: ImageFile, layers: &Layers) -> Result<(), Failure> {
    write_file(path, format, layers).map_err(|e| cannot_write(path, e))
}

/// Write a file that is no picture.
pub(crate) fn save_bytes(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    files::write(path, bytes).map_err(|e| cannot_write(path, e))
}

pub(crate) fn cannot_write(path: &Path, cause: impl std::fmt::Display) -> Failure {
    Failure::Other(format!("cannot write {}: {cause}", path.display()))
}
