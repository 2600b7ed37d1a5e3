//! Pictures that programs wrote: a layer's radiance, and what the file says about how it came to be.

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
    /// Read R G B, or those of a named layer.
    pub(crate) fn read(path: &Path, layer: Option<&str>) -> anyhow::Result<Self> {
        let layers = read_exr(path).map_err(|e| anyhow!("{}: {e}", path.display()))?;
        let mut channels = Vec::new();
        for c in ["R", "G", "B"] {
            let name = layer.map_or_else(|| c.to_string(), |l| format!("{l}.{c}"));
            let channel = layers
                .channel(&name)
                .with_context(|| format!("{}: no channel {name}", path.display()))?;
            channels.push(channel);
        }
        let rgb: Vec<f32> =
            (0..channels[0].len()).flat_map(|i| channels.iter().map(move |c| c[i])).collect();
        if let Some(i) = rgb.iter().position(|v| !v.is_finite()) {
            bail!("{}: pixel {} is {}", path.display(), i / 3, rgb[i]);
        }
        Ok(Picture { size: [layers.width, layers.height], rgb, layers })
    }

    /// What the file says about itself under `gi.NAME`.
    pub(crate) fn said(&self, name: &str) -> Option<&str> {
        let (_, value) = self.layers.metadata.iter().find(|(n, _)| *n == format!("gi.{name}"))?;
        Some(value)
    }

    /// Write a view, brighter by a power of two than radiance itself.
    pub(crate) fn save_view(&self, path: &Path, exposure: f32) -> anyhow::Result<()> {
        let scale = exposure.exp2();
        let channel = |k: usize| self.rgb.iter().skip(k).step_by(3).map(|v| v * scale).collect();
        let names = ["R", "G", "B"].iter().enumerate();
        let layers = Layers {
            width: self.size[0],
            height: self.size[1],
            channels: names.map(|(k, n)| (n.to_string(), channel(k))).collect(),
            metadata: Vec::new(),
        };
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
