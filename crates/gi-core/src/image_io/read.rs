use std::io::{BufRead, Read, Seek};
use std::path::Path;

use exr::prelude::{ReadChannels, ReadLayers};
use image::{DynamicImage, ImageReader};

use super::Layers;
use crate::math::Rgb;
use crate::texture::{Bitmap, Lookup, Texels, Wrap, srgb_to_linear};

/// Encoding of the numbers in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// sRGB for integer pictures, linear for float pictures.
    Auto,
    /// Linear numbers for all pictures ("raw").
    Raw,
}

/// The largest picture accepted, in pixels: a gigabyte of float texels.
const MAX_PIXELS: u64 = 1 << 26;

/// Read a picture (png jpg hdr exr tga bmp pfm).
///
/// # Errors
/// A message of one line that says what is wrong with the file, without its name.
pub fn read_bitmap(
    path: &Path,
    encoding: Encoding,
    wrap: Wrap,
    lookup: Lookup,
) -> Result<Bitmap, String> {
    let extension =
        path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let (width, height, texels) = match extension.as_str() {
        "exr" => {
            let layers = read_exr(path)?;
            (layers.width, layers.height, Texels::Float(radiance(&layers)?))
        }
        "pfm" => read_pfm(path)?,
        _ => read_with_image(path, encoding)?,
    };
    if width == 0 || height == 0 {
        return Err("the picture has no pixels".into());
    }
    Ok(Bitmap::new(width, height, texels, wrap, lookup))
}

/// Read every channel of an EXR's first layer, and its text attributes.
pub fn read_exr(path: &Path) -> Result<Layers, String> {
    let meta = exr::meta::MetaData::read_from_file(path, false).map_err(|e| e.to_string())?;
    if let Some(header) = meta.headers.first() {
        check_size(header.layer_size.width() as u64, header.layer_size.height() as u64)?;
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .map_err(|e| e.to_string())?;
    let layer = image.layer_data;
    let channels = layer.channel_data.list.iter();
    let metadata = layer.attributes.other.iter().filter_map(|(name, value)| match value {
        exr::meta::attribute::AttributeValue::Text(text) => {
            Some((name.to_string(), text.to_string()))
        }
        _ => None,
    });
    Ok(Layers {
        width: layer.size.width(),
        height: layer.size.height(),
        channels: channels
            .map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect()))
            .collect(),
        metadata: metadata.collect(),
    })
}

/// The radiance of an EXR: R G B, or grey from Y; if there are no such channels, those of a named layer.
fn radiance(layers: &Layers) -> Result<Vec<Rgb>, String> {
    let find = |name: &str| {
        let suffix = format!(".{name}");
        let in_layer = || {
            layers.channels.iter().find(|(n, _)| n.ends_with(&suffix)).map(|(_, s)| s.as_slice())
        };
        layers.channel(name).or_else(in_layer)
    };
    let [r, g, b] = match (find("R"), find("G"), find("B")) {
        (Some(r), Some(g), Some(b)) => [r, g, b],
        _ => [find("Y").ok_or("no channels R G B, and no Y")?; 3],
    };
    Ok((0..r.len()).map(|i| Rgb::new(r[i], g[i], b[i])).collect())
}

fn read_pfm(path: &Path) -> Result<(usize, usize, Texels), String> {
    let io = |e: std::io::Error| e.to_string();
    let mut file = std::io::BufReader::new(std::fs::File::open(path).map_err(io)?);
    let mut line = || -> Result<String, String> {
        let mut text = String::new();
        file.by_ref().take(64).read_line(&mut text).map_err(io)?;
        Ok(text.trim().to_string())
    };
    let channels = match line()?.as_str() {
        "PF" => 3,
        "Pf" => 1,
        _ => return Err("not a PFM: it starts with neither PF nor Pf".into()),
    };
    let size: Vec<u64> = line()?.split_whitespace().filter_map(|t| t.parse().ok()).collect();
    let [width, height] = size[..] else {
        return Err("the PFM's second line is not its width and height".into());
    };
    check_size(width, height)?;
    let scale: f32 = line()?.parse().map_err(|_| "the PFM's third line is not a scale")?;
    let (width, height) = (width as usize, height as usize);
    let mut bytes = vec![0u8; width * height * channels * 4];
    file.read_exact(&mut bytes).map_err(|_| "the PFM is cut short")?;
    let decode: fn([u8; 4]) -> f32 =
        if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let floats: Vec<f32> =
        bytes.chunks_exact(4).map(|b| decode([b[0], b[1], b[2], b[3]])).collect();
    // A PFM stores its bottom row first.
    let rows = floats.chunks_exact(width * channels).rev();
    let pixel =
        |p: &[f32]| if channels == 3 { Rgb::new(p[0], p[1], p[2]) } else { Rgb::grey(p[0]) };
    let texels = rows.flat_map(|row| row.chunks_exact(channels).map(pixel)).collect();
    Ok((width, height, Texels::Float(texels)))
}

/// The first bytes of a Radiance picture: those of Radiance itself, and those written by some other programs.
const RADIANCE: [&[u8]; 2] = [b"#?RADIANCE", b"#?"];

/// Open a file. For a Radiance picture, the first line is replaced by the one that the decoder expects.
fn open_picture(path: &Path) -> std::io::Result<Box<dyn ReadSeek>> {
    let mut file = std::fs::File::open(path)?;
    let mut head = Vec::new();
    file.by_ref().take(RADIANCE[0].len() as u64).read_to_end(&mut head)?;
    file.rewind()?;
    if !head.starts_with(RADIANCE[1]) || head == RADIANCE[0] {
        return Ok(Box::new(std::io::BufReader::new(file)));
    }
    let mut bytes = Vec::new();
    file.take(MAX_RADIANCE).read_to_end(&mut bytes)?;
    let line = bytes.iter().position(|&b| b == b'\n').unwrap_or(bytes.len());
    bytes.splice(..line, RADIANCE[0].iter().copied());
    Ok(Box::new(std::io::Cursor::new(bytes)))
}

/// No Radiance picture of the largest size has more bytes.
const MAX_RADIANCE: u64 = 5 * MAX_PIXELS;

trait ReadSeek: BufRead + Seek {}

impl<T: BufRead + Seek> ReadSeek for T {}

fn read_with_image(path: &Path, encoding: Encoding) -> Result<(usize, usize, Texels), String> {
    let open = || {
        let mut reader = ImageReader::new(open_picture(path).map_err(|e| e.to_string())?);
        if let Ok(format) = image::ImageFormat::from_path(path) {
            reader.set_format(format);
        }
        reader.with_guessed_format().map_err(|e| e.to_string())
    };
    let (width, height) = open()?.into_dimensions().map_err(|e| e.to_string())?;
    check_size(u64::from(width), u64::from(height))?;
    let picture = open()?.decode().map_err(|e| e.to_string())?;
    let texels = match picture {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            Texels::Float(picture.into_rgb32f().pixels().map(|p| Rgb::from(p.0)).collect())
        }
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => {
            let decode = |v: u16| {
                let v = f32::from(v) / 65535.0;
                if encoding == Encoding::Raw { v } else { srgb_to_linear(v) }
            };
            Texels::Float(
                picture.into_rgb16().pixels().map(|p| Rgb::from(p.0.map(decode))).collect(),
            )
        }
        _ => {
            let bytes = picture.into_rgb8().pixels().map(|p| p.0).collect();
            if encoding == Encoding::Raw { Texels::Linear8(bytes) } else { Texels::Srgb8(bytes) }
        }
    };
    Ok((width as usize, height as usize, texels))
}

fn check_size(width: u64, height: u64) -> Result<(), String> {
    if width.saturating_mul(height) > MAX_PIXELS {
        return Err(format!(
            "{width} x {height} pixels are more than the largest accepted number, {MAX_PIXELS}"
        ));
    }
    Ok(())
}
