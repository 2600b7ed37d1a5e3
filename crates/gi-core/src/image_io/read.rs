use std::io::{BufRead, Read, Seek};
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageReader, Limits};

use super::Layers;
use crate::files::open_regular;
use crate::guard::guarded;
use crate::math::Rgb;
use crate::texture::{Bitmap, Lookup, Texels, Wrap, srgb_to_linear};

mod open_exr;

/// Allows a number of bytes, or says why not.
pub type Claim<'a> = &'a dyn Fn(u64) -> Result<(), String>;

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
    read_bitmap_within(path, encoding, wrap, lookup, &|_| Ok(()))
}

/// Like [`read_bitmap`], for a picture of which the caller must allow the memory: `allow` is asked for the number of
/// bytes that the decoder will take before it takes them.
///
/// # Errors
/// Those of [`read_bitmap`], and that of `allow`.
pub fn read_bitmap_within(
    path: &Path,
    encoding: Encoding,
    wrap: Wrap,
    lookup: Lookup,
    allow: Claim<'_>,
) -> Result<Bitmap, String> {
    let extension =
        path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let (width, height, texels) = guarded(|| match extension.as_str() {
        "exr" => {
            let (width, height, pixels) = open_exr::radiance(path, allow)?;
            Ok((width, height, Texels::Float(pixels)))
        }
        "pfm" => read_pfm(path, allow),
        _ => read_with_image(path, encoding, allow),
    })?;
    if width == 0 || height == 0 {
        return Err("the picture has no pixels".into());
    }
    Ok(Bitmap::new(width, height, texels, wrap, lookup))
}

/// Read every channel of an EXR's first layer, and its text attributes.
///
/// # Errors
/// A message of one line, without the file's name.
pub fn read_exr(path: &Path) -> Result<Layers, String> {
    guarded(|| open_exr::layers(path))
}

fn read_pfm(path: &Path, allow: Claim<'_>) -> Result<(usize, usize, Texels), String> {
    let io = |e: std::io::Error| e.to_string();
    let file = open_regular(path)?;
    let length = file.metadata().map_err(io)?.len();
    let mut file = std::io::BufReader::new(file);
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
    let row = width * channels * 4;
    if length < (row * height) as u64 {
        return Err(CUT_SHORT.into());
    }
    allow((width * height * size_of::<Rgb>() + row) as u64)?;
    let decode: fn([u8; 4]) -> f32 =
        if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let pixel = |bytes: &[u8]| {
        let v = |k: usize| decode([0, 1, 2, 3].map(|i| bytes[4 * k + i]));
        if channels == 3 { Rgb::new(v(0), v(1), v(2)) } else { Rgb::grey(v(0)) }
    };
    let mut texels = vec![Rgb::BLACK; width * height];
    let mut bytes = vec![0u8; row];
    // A PFM stores its bottom row first.
    for line in texels.chunks_exact_mut(width.max(1)).rev() {
        file.read_exact(&mut bytes).map_err(|_| CUT_SHORT)?;
        line.iter_mut().zip(bytes.chunks_exact(channels * 4)).for_each(|(t, b)| *t = pixel(b));
    }
    Ok((width, height, Texels::Float(texels)))
}

const CUT_SHORT: &str = "the PFM is cut short";

/// The first bytes of a Radiance picture: those of Radiance itself, and those written by some other programs.
const RADIANCE: [&[u8]; 2] = [b"#?RADIANCE", b"#?"];

/// Open a file. For a Radiance picture, the first line is replaced by the one that the decoder expects.
fn open_picture(path: &Path) -> Result<Box<dyn ReadSeek>, String> {
    let io = |e: std::io::Error| e.to_string();
    let mut file = open_regular(path)?;
    let mut head = Vec::new();
    file.by_ref().take(RADIANCE[0].len() as u64).read_to_end(&mut head).map_err(io)?;
    file.rewind().map_err(io)?;
    if !head.starts_with(RADIANCE[1]) || head == RADIANCE[0] {
        return Ok(Box::new(std::io::BufReader::new(file)));
    }
    let mut bytes = Vec::new();
    file.take(MAX_RADIANCE).read_to_end(&mut bytes).map_err(io)?;
    let line = bytes.iter().position(|&b| b == b'\n').unwrap_or(bytes.len());
    bytes.splice(..line, RADIANCE[0].iter().copied());
    Ok(Box::new(std::io::Cursor::new(bytes)))
}

/// No Radiance picture of the largest size has more bytes.
const MAX_RADIANCE: u64 = 5 * MAX_PIXELS;

trait ReadSeek: BufRead + Seek {}

impl<T: BufRead + Seek> ReadSeek for T {}

fn read_with_image(
    path: &Path,
    encoding: Encoding,
    allow: Claim<'_>,
) -> Result<(usize, usize, Texels), String> {
    let mut reader = ImageReader::new(open_picture(path)?);
    if let Ok(format) = image::ImageFormat::from_path(path) {
        reader.set_format(format);
    }
    let mut reader = reader.with_guessed_format().map_err(|e| e.to_string())?;
    // The limit is the caller's: memory is checked below, once the size is known.
    reader.limits(Limits::no_limits());
    let decoder = reader.into_decoder().map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions();
    check_size(u64::from(width), u64::from(height))?;
    // Decoded bytes twice: some decoders assemble them before they copy them. Then three bytes or floats per texel.
    let texels = u64::from(width) * u64::from(height) * size_of::<Rgb>() as u64;
    allow(decoder.total_bytes().saturating_mul(2).saturating_add(texels))?;
    let picture = DynamicImage::from_decoder(decoder).map_err(|e| e.to_string())?;
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
