//! Saving: the picture with its layers and metadata and the view beside it, or a table; the statistics.

use std::path::{Path, PathBuf};

use gi_core::files;
use gi_core::image_io::{ImageFile, Layers, write_file};
use gi_core::technique::Picture;

use crate::Failure;
use crate::sensors::Sensors;

/// Where the results of a run go.
pub(crate) struct Output {
    path: PathBuf,
    kind: Kind,
}

enum Kind {
    Picture(ImageFile),
    /// Irradiance at points.
    Table(Sensors),
}

impl Output {
    /// Check the file name. With `points`, read them.
    pub(crate) fn new(path: PathBuf, points: Option<&Path>) -> Result<Self, Failure> {
        let cannot = |advice: &str| {
            Failure::Input(format!("error: cannot save to {}: {advice}", path.display()))
        };
        let Some(points) = points else {
            let format = ImageFile::from_path(&path).filter(|f| *f != ImageFile::Png);
            let advice =
                "end the name in .exr (all layers), .pfm or .hdr; a .png view is written beside it";
            let kind = Kind::Picture(format.ok_or_else(|| cannot(advice))?);
            return Ok(Output { path, kind });
        };
        if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("csv")) {
            return Err(cannot("with --points the name must end in .csv"));
        }
        let kind = Kind::Table(Sensors::read(points)?);
        Ok(Output { path, kind })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The view that is written beside a picture.
    pub(crate) fn view(&self) -> Option<PathBuf> {
        matches!(self.kind, Kind::Picture(_)).then(|| self.path.with_extension("png"))
    }

    /// The points of a table.
    pub(crate) fn sensors(&self) -> Option<&Sensors> {
        match &self.kind {
            Kind::Picture(_) => None,
            Kind::Table(sensors) => Some(sensors),
        }
    }

    /// Write the picture and its view, or the table, after a number of passes. If one of them fails, the other is written all the same.
    pub(crate) fn save(&self, layers: &Layers, passes: u32) -> Result<(), Failure> {
        let format = match &self.kind {
            Kind::Picture(format) => *format,
            Kind::Table(sensors) => return save_bytes(&self.path, &sensors.table(layers, passes)),
        };
        let picture = write(&self.path, format, layers);
        let view = write(&self.path.with_extension("png"), ImageFile::Png, layers);
        picture.and(view)
    }

    /// Write the view of a technique's own picture beside them, with its legend.
    pub(crate) fn save_view(&self, picture: &Picture, size: [usize; 2]) -> Result<(), Failure> {
        let framed = picture.legend.as_ref().map(|legend| legend.below(size, &picture.view));
        let (size, view) =
            framed.as_ref().map_or((size, &picture.view), |(size, view)| (*size, view));
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
