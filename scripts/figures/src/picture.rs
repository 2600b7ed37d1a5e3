//! Reads pictures that the programs wrote: the radiance of a layer, and the metadata about how it was made.
//!
//! A reference may have a twin: `box.twin.exr` beside `box.exr`, rendered with another seed. Then the reference is the mean of
//! both, and errors do not contain its noise; see [`compare_with_twins`]. A twin of another picture, or with the same seed, is refused.

use std::path::Path;

use anyhow::{Context, anyhow, bail};
use gi_core::image_io::{ImageFile, Layers, read_exr, write_file};
use gi_stats::metrics::{Metrics, compare, compare_with_twins};

use crate::inset::Inset;

/// A layer of an EXR.
#[derive(Clone)]
pub(crate) struct Picture {
    pub(crate) size: [usize; 2],
    /// Interleaved RGB, row by row. With a twin, the mean of both.
    pub(crate) rgb: Vec<f32>,
    /// RGB of the picture and of its twin.
    twins: Option<[Vec<f32>; 2]>,
    metadata: Vec<(String, String)>,
}

impl Picture {
    /// Read the channels R, G, B, or those of a named layer, of a picture and of its twin. A layer with one channel is grey.
    pub(crate) fn read(path: &Path, layer: Option<&str>) -> anyhow::Result<Self> {
        let mut picture = Self::read_one(path, layer)?;
        let path = path.with_extension("twin.exr");
        if path.is_file() {
            let twin = Self::read_one(&path, layer)?;
            picture.check_twin(&twin).with_context(|| path.display().to_string())?;
            picture.add_effort(&twin);
            let mean = picture.rgb.iter().zip(&twin.rgb).map(|(a, b)| 0.5 * (a + b)).collect();
            let first = std::mem::replace(&mut picture.rgb, mean);
            picture.twins = Some([first, twin.rgb]);
        }
        Ok(picture)
    }

    fn read_one(path: &Path, layer: Option<&str>) -> anyhow::Result<Self> {
        let layers = read_exr(path).map_err(|e| anyhow!("{}: {e}", path.display()))?;
        let names = ["R", "G", "B"].map(|c| layer.map_or(c.into(), |l| format!("{l}.{c}")));
        let grey = || layers.channel(layer?).map(|v| v.iter().flat_map(|v| [*v; 3]).collect());
        let rgb: Vec<f32> = layers
            .interleaved(names.each_ref().map(String::as_str))
            .or_else(grey)
            .with_context(|| format!("{}: no channels {}", path.display(), names.join(", ")))?;
        if let Some(i) = rgb.iter().position(|v| !v.is_finite()) {
            bail!("{}: pixel {} is {}", path.display(), i / 3, rgb[i]);
        }
        let size = [layers.width, layers.height];
        Ok(Picture { size, rgb, twins: None, metadata: layers.metadata })
    }

    /// A twin is the same picture with independent noise.
    fn check_twin(&self, twin: &Picture) -> anyhow::Result<()> {
        if twin.size != self.size {
            bail!("its size is not that of its twin");
        }
        for name in ["program", "scene_hash", "passes", "reach"] {
            if self.said(name) != twin.said(name) {
                bail!("its {name} is not that of its twin: remove both, and they are made anew");
            }
        }
        if self.said("seed").is_some() && self.said("seed") == twin.said("seed") {
            bail!("it has the same seed as its twin, so their noise is not independent");
        }
        Ok(())
    }

    /// Count the passes and the time of a twin: the picture is the mean of both.
    fn add_effort(&mut self, twin: &Picture) {
        for (name, value) in &mut self.metadata {
            let Some(name) = name.strip_prefix("gi.").filter(|n| ["passes", "seconds"].contains(n))
            else {
                continue;
            };
            let other = twin.said(name).and_then(|v| v.parse::<f64>().ok());
            if let (Ok(own), Some(other)) = (value.parse::<f64>(), other) {
                *value = (((own + other) * 1e3).round() / 1e3).to_string();
            }
        }
    }

    /// The metadata with the key `gi.NAME`.
    pub(crate) fn said(&self, name: &str) -> Option<&str> {
        let (_, value) = self.metadata.iter().find(|(n, _)| *n == format!("gi.{name}"))?;
        Some(value)
    }

    /// A part of the picture: left, top, width and height as fractions of the picture. At least one pixel.
    pub(crate) fn part(self, part: [f64; 4]) -> anyhow::Result<Self> {
        let [[left, right], [top, bottom]] = pixels_of(part, self.size)?;
        let of = |rgb: &Vec<f32>| -> Vec<f32> {
            let row =
                |y: usize| &rgb[3 * (y * self.size[0] + left)..3 * (y * self.size[0] + right)];
            (top..bottom).flat_map(row).copied().collect()
        };
        let twins = self.twins.as_ref().map(|twins| twins.each_ref().map(of));
        let size = [right - left, bottom - top];
        Ok(Picture { size, rgb: of(&self.rgb), twins, metadata: self.metadata })
    }

    /// The part that the option `--part` asks for; without numbers, the whole picture.
    pub(crate) fn asked_part(self, part: &[f64]) -> anyhow::Result<Self> {
        match *part {
            [] => Ok(self),
            [x, y, w, h] => self.part([x, y, w, h]),
            _ => bail!("--part: expected X,Y,W,H"),
        }
    }

    /// Write a display image, brightened by a power of two, with enlarged parts.
    pub(crate) fn save_view(
        &self,
        path: &Path,
        exposure: f32,
        insets: &[Inset],
    ) -> anyhow::Result<()> {
        let scale = exposure.exp2();
        let (pixels, _) = self.rgb.as_chunks::<3>();
        let mut pixels: Vec<[f32; 3]> =
            pixels.iter().map(|c| c.map(|v| (v * scale).min(1.0))).collect();
        for inset in insets {
            inset.draw(self.size, &mut pixels)?;
        }
        let layers = Layers::of_rgb(self.size, pixels);
        write_file(path, ImageFile::Png, &layers).map_err(|e| anyhow!("{}: {e}", path.display()))
    }

    /// Errors against a reference. With a twin, MSE, RMSE and relMSE are without its noise.
    pub(crate) fn errors(&self, reference: &Picture) -> anyhow::Result<Metrics> {
        if self.size != reference.size {
            let ([w, h], [rw, rh]) = (self.size, reference.size);
            bail!("{w} x {h} pixels, but the reference has {rw} x {rh}");
        }
        let mut errors = compare(&self.rgb, &reference.rgb).map_err(|e| anyhow!(e))?;
        if let Some([a, b]) = &reference.twins {
            let [mse, rel_mse] = compare_with_twins(&self.rgb, [a, b]).map_err(|e| anyhow!(e))?;
            errors = Metrics { mse, rmse: mse.max(0.0).sqrt(), rel_mse, ..errors };
        }
        Ok(errors)
    }
}

/// The columns and rows of a part of a picture, from its left, top, width and height as fractions.
pub(crate) fn pixels_of(
    [x, y, w, h]: [f64; 4],
    size: [usize; 2],
) -> anyhow::Result<[[usize; 2]; 2]> {
    let inside = |a: f64, n: f64| a >= 0.0 && n > 0.0 && a + n <= 1.0 + 1e-9;
    if !(inside(x, w) && inside(y, h)) {
        bail!(
            "{x} {y} {w} {h} is not a part of the picture: left, top, width and height are fractions"
        );
    }
    let range = |a: f64, n: f64, size: usize| {
        let first = ((a * size as f64) as usize).min(size - 1);
        [first, (((a + n) * size as f64).round() as usize).clamp(first + 1, size)]
    };
    Ok([range(x, w, size[0]), range(y, h, size[1])])
}
