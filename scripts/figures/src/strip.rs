//! Joins pictures to a strip, with a name and a time below each.

use std::path::PathBuf;

use anyhow::{anyhow, bail};
use gi_core::canvas::Canvas;
use gi_core::image_io::{ImageFile, Layers, write_file};
use gi_core::math::Rgb;
use glam::Vec2;

use crate::Named;
use crate::picture::Picture;

#[derive(clap::Args)]
pub(crate) struct Args {
    /// The strip to write (.png)
    out: PathBuf,
    /// Number of columns [default: all pictures in one row]
    #[arg(long)]
    columns: Option<usize>,
    /// Brighten by this power of two
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    exposure: f32,
    /// Pictures of one size, with their names
    #[arg(value_name = "NAME=PICTURE", required = true)]
    pictures: Vec<Named>,
}

/// Width of the gaps between pictures.
const GAP: usize = 6;

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let pictures = args.pictures.iter().map(|n| Picture::read(&n.file, None));
    let pictures = pictures.collect::<anyhow::Result<Vec<_>>>()?;
    let size = pictures[0].size;
    if let Some(k) = pictures.iter().position(|p| p.size != size) {
        bail!("{} has another size than the first picture", args.pictures[k].file.display());
    }
    let columns = args.columns.unwrap_or(pictures.len()).clamp(1, pictures.len());
    let letter = (size[0] as f32 / 22.0).clamp(6.0, 16.0);
    let cell = [size[0] + GAP, size[1] + (5.6 * letter) as usize];
    let full = [columns * cell[0] - GAP, pictures.len().div_ceil(columns) * cell[1]];
    let mut pixels = vec![Rgb::WHITE; full[0] * full[1]];
    let place = |k: usize| [k % columns * cell[0], k / columns * cell[1]];
    for (k, picture) in pictures.iter().enumerate() {
        let [left, top] = place(k);
        for (i, c) in picture.rgb.chunks(3).enumerate() {
            let colour = Rgb::new(c[0], c[1], c[2]) * args.exposure.exp2();
            let at = (top + i / size[0]) * full[0] + left + i % size[0];
            pixels[at] = colour.map(|v| v.clamp(0.0, 1.0));
        }
    }
    let mut canvas = Canvas::over(full, pixels);
    for (k, (picture, named)) in pictures.iter().zip(&args.pictures).enumerate() {
        let [left, top] = place(k).map(|v| v as f32);
        let middle = Vec2::new(left + 0.5 * size[0] as f32, top + size[1] as f32);
        let line = |n: f32| middle + Vec2::Y * (2.0 * n * letter);
        canvas.text_centred(line(1.0), letter, Rgb::grey(0.01), &named.name);
        if let Some(seconds) = picture.said("seconds").and_then(|s| s.parse::<f64>().ok()) {
            let time = format!("{seconds:.0} s");
            canvas.text_centred(line(2.0), 0.9 * letter, Rgb::grey(0.15), &time);
        }
    }
    let layers = Layers::of_rgb(full, canvas.into_pixels().iter().map(|c| c.to_array()));
    write_file(&args.out, ImageFile::Png, &layers)
        .map_err(|e| anyhow!("{}: {e}", args.out.display()))
}
