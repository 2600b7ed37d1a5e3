//! Draws a map, with a legend, of where a picture is too bright or too dark.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Context, anyhow};
use gi_core::image_io::{Layers, encode_png};

use crate::picture::Picture;
use crate::svg::{FONT, data_uri};

#[derive(clap::Args)]
pub(crate) struct Args {
    /// The drawing to write (.svg)
    out: PathBuf,
    /// The picture
    picture: PathBuf,
    /// The reference picture
    #[arg(long)]
    reference: PathBuf,
    /// Layer of both pictures: Direct, Indirect, Caustic [default: all light]
    #[arg(long)]
    layer: Option<String>,
    /// Relative difference at the ends of the scale
    #[arg(long, default_value_t = 0.2)]
    most: f32,
}

/// Blue for too dark, white, brown for too bright. Colour-blind readers can distinguish them, and in grey print the
/// legend's ends help. Positions from -1 to 1; sRGB.
const SCALE: [(f32, [f32; 3]); 5] = [
    (-1.0, [0.02, 0.19, 0.38]),
    (-0.5, [0.40, 0.66, 0.81]),
    (0.0, [1.0, 1.0, 1.0]),
    (0.5, [0.85, 0.55, 0.30]),
    (1.0, [0.38, 0.15, 0.02]),
];

/// Colour of a number from -1 to 1.
fn colour(x: f32) -> [f32; 3] {
    let x = x.clamp(-1.0, 1.0);
    let k = SCALE.iter().rposition(|(at, _)| *at <= x).unwrap_or(0).min(SCALE.len() - 2);
    let ((a, low), (b, high)) = (SCALE[k], SCALE[k + 1]);
    let t = (x - a) / (b - a);
    std::array::from_fn(|c| low[c] + t * (high[c] - low[c]))
}

fn luminance(rgb: &[f32]) -> f32 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let layer = args.layer.as_deref();
    let picture = Picture::read(&args.picture, layer)?;
    let reference = Picture::read(&args.reference, layer)?;
    picture.errors(&reference).with_context(|| args.picture.display().to_string())?;
    // Adding a thousandth of the mean avoids division by zero at black pixels.
    let pixels = reference.rgb.len() / 3;
    let floor = 1e-3 * reference.rgb.chunks(3).map(luminance).sum::<f32>() / pixels as f32;
    let relative = |(a, r): (&[f32], &[f32])| {
        let (a, r) = (luminance(a), luminance(r));
        (a - r) / (r + floor.max(f32::MIN_POSITIVE))
    };
    let map: Vec<f32> = picture.rgb.chunks(3).zip(reference.rgb.chunks(3)).map(relative).collect();
    let png = png(picture.size, map.iter().map(|x| colour(x / args.most)))?;
    let svg = drawing(picture.size, &png, args.most);
    std::fs::write(&args.out, svg).with_context(|| args.out.display().to_string())
}

/// A PNG of sRGB colours.
fn png(size: [usize; 2], colours: impl Iterator<Item = [f32; 3]>) -> anyhow::Result<Vec<u8>> {
    let linear = |s: f32| if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) };
    let layers = Layers::of_rgb(size, colours.map(|c| c.map(linear)));
    encode_png(&layers).map_err(|e| anyhow!(e))
}

/// Smaller maps are enlarged to this size, so that their legend is readable.
const LEAST_SIZE: usize = 256;

/// The map with its legend to the right.
fn drawing([w, h]: [usize; 2], png: &[u8], most: f32) -> String {
    let larger = LEAST_SIZE.div_ceil(w.min(h)).max(1);
    let (w, h) = (w * larger, h * larger);
    let (gap, bar, text) = (w / 40, w / 24, (w / 18).min(28));
    let (full, left) = (w + gap + bar + 5 * text, w + gap);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {full} {h}\" width=\"{full}\" height=\"{h}\">\n\
         <rect width=\"{full}\" height=\"{h}\" fill=\"#fff\"/>\n\
         <image width=\"{w}\" height=\"{h}\" style=\"image-rendering:pixelated\" href=\"{}\"/>\n\
         <linearGradient id=\"scale\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">",
        data_uri("image/png", png)
    );
    for (at, c) in SCALE {
        let [r, g, b] = c.map(|x| (255.0 * x).round());
        let _ =
            write!(out, "<stop offset=\"{}\" stop-color=\"rgb({r},{g},{b})\"/>", 0.5 * (at + 1.0));
    }
    let _ = write!(
        out,
        "</linearGradient>\n<rect x=\"{left}\" y=\"0.5\" width=\"{bar}\" height=\"{}\" fill=\"url(#scale)\" stroke=\"#444\"/>\n",
        h - 1
    );
    for (share, label) in [
        (1.0, format!("+{:.0} %", 100.0 * most)),
        (0.5, "0".to_string()),
        (0.0, format!("\u{2212}{:.0} %", 100.0 * most)),
    ] {
        // The labels of both ends stay inside the drawing.
        let (full, text_height) = (h as f32, text as f32);
        let y = ((1.0 - share) * full + 0.35 * text_height)
            .clamp(0.9 * text_height, full - 0.2 * text_height);
        let _ = writeln!(
            out,
            "<text x=\"{}\" y=\"{y:.1}\" font-family=\"{FONT}\" font-size=\"{text}\" fill=\"#222\">{label}</text>",
            left + bar + 4
        );
    }
    out + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_is_white_in_the_middle_and_is_clamped_at_both_ends() {
        assert_eq!(colour(0.0), [1.0; 3]);
        for (x, expected) in [(-7.0, SCALE[0].1), (1.0, SCALE[4].1), (-0.25, [0.7, 0.83, 0.905])] {
            let found = colour(x);
            assert!(
                found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6),
                "{x}: {found:?}"
            );
        }
    }
}
