//! Reads pictures that the programs wrote: the radiance of a layer, and the metadata about how it was made.

use std::path::Path;

use anyhow::{Context, anyhow, bail};
use gi_core::image_io::{ImageFile, Layers, read_exr, write_file};
use gi_stats::metrics::{Metrics, compare};

/// A layer of an EXR.
pub(crate) struct Picture {
    pub(crate) size: [usize; 2],
    /// Interleaved RGB, row by row.
    pub(crate) rgb: Vec<f32>,
    layers: Layers,
}

impl Picture {
    /// Read the channels R, G, B, or those of a named layer.
    pub(crate) fn read(path: &Path, layer: Option<&str>) -> anyhow::Result<Self> {
        let layers = read_exr(path).map_err(|e| anyhow!("{}: {e}", path.display()))?;
        let names = ["R", "G", "B"].map(|c| layer.map_or(c.into(), |l| format!("{l}.{c}")));
        let rgb = layers
            .interleaved(names.each_ref().map(String::as_str))
            .with_context(|| format!("{}: no channels {}", path.display(), names.join(", ")))?;
        if let Some(i) = rgb.iter().position(|v| !v.is_finite()) {
            bail!("{}: pixel {} is {}", path.display(), i / 3, rgb[i]);
        }
        Ok(Picture { size: [layers.width, layers.height], rgb, layers })
    }

    /// The metadata with the key `gi.NAME`.
    pub(crate) fn said(&self, name: &str) -> Option<&str> {
        let (_, value) = self.layers.metadata.iter().find(|(n, _)| *n == format!("gi.{name}"))?;
        Some(value)
    }

    /// Write a display image, brightened by a power of two.
    pub(crate) fn save_view(&self, path: &Path, exposure: f32) -> anyhow::Result<()> {
        let scale = exposure.exp2();
        let (pixels, _) = self.rgb.as_chunks::<3>();
        let layers = Layers::of_rgb(self.size, pixels.iter().map(|c| c.map(|v| v * scale)));
        write_file(path, ImageFile::Png, &layers).map_err(|e| anyhow!("{}: {e}", path.display()))
    }

    /// Errors against a reference.
    pub(crate) fn errors(&self, reference: &Picture) -> anyhow::Result<Metrics> {
        if self.size != reference.size {
            let ([w, h], [rw, rh]) = (self.size, reference.size);
            bail!("{w} x {h} pixels, but the reference has {rw} x {rh}");
        }
        compare(&self.rgb, &reference.rgb).map_err(|e| anyhow!(e))
    }
}
