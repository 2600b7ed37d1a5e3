use std::io::{Error, Seek, Write};
use std::path::Path;

use exr::block::lines::LineRefMut;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::math::RoundingMode;
use exr::meta::attribute::{LevelMode, SampleType};
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, Image, Layer, LayerAttributes, Text, Vec2,
    WritableImage,
};

use super::Layers;
use crate::files;

/// The formats that a picture can be saved in, by extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFile {
    /// OpenEXR with all layers and metadata.
    Exr,
    /// Portable float map: radiance.
    Pfm,
    /// Radiance RGBE.
    Hdr,
    /// A display image: exposure 0, sRGB.
    Png,
}

impl ImageFile {
    /// The format for a file name, by its extension.
    pub fn from_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "exr" => Some(ImageFile::Exr),
            "pfm" => Some(ImageFile::Pfm),
            "hdr" => Some(ImageFile::Hdr),
            "png" => Some(ImageFile::Png),
            _ => None,
        }
    }
}

/// Save a picture completely or not at all, see [`files`].
///
/// # Errors
/// A message of one line that says what could not be written, without the file's name.
pub fn write_file(path: &Path, format: ImageFile, layers: &Layers) -> Result<(), String> {
    let fill = |out: &mut files::Out| match format {
        ImageFile::Exr => write_exr(out, layers).map_err(Error::other),
        ImageFile::Pfm => write_pfm(out, layers),
        ImageFile::Hdr => write_hdr(out, layers).map_err(Error::other),
        ImageFile::Png => write_png(out, layers).map_err(Error::other),
    };
    files::write_with(path, fill).map_err(|e| e.to_string())
}

fn write_exr<'a>(out: &mut (impl Write + Seek), layers: &'a Layers) -> Result<(), String> {
    let width = layers.width;
    let plane = |(name, values): &'a (String, Vec<f32>)| {
        AnyChannel::new(name.as_str(), Plane { width, values })
    };
    let channels = layers.channels.iter().map(plane).collect();
    let mut attributes = LayerAttributes::default();
    for (name, value) in &layers.metadata {
        attributes
            .other
            .insert(Text::from(name.as_str()), AttributeValue::Text(Text::from(value.as_str())));
    }
    let size = Vec2(layers.width, layers.height);
    let layer = Layer::new(size, attributes, Encoding::FAST_LOSSLESS, AnyChannels::sort(channels));
    Image::from_layer(layer).write().to_buffered(out).map_err(|e| e.to_string())
}

/// The values of a channel, row by row. They are written from where they are; a copy of all layers would need a lot of memory.
#[derive(Clone, Copy)]
struct Plane<'a> {
    width: usize,
    values: &'a [f32],
}

impl<'a> WritableSamples<'_> for Plane<'a> {
    type Writer = Plane<'a>;

    fn sample_type(&self) -> SampleType {
        SampleType::F32
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&self, _: &Header) -> Self {
        *self
    }
}

impl SamplesWriter for Plane<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let Vec2(x, y) = line.location.position;
        let start = y * self.width + x;
        let values = &self.values[start..start + line.location.sample_count];
        line.write_samples_from_slice(values).expect("memory can be written to");
    }
}

/// The radiance of pixel `i`.
fn pixel([r, g, b]: [&[f32]; 3], i: usize) -> [f32; 3] {
    [r[i], g[i], b[i]]
}

fn rgb(layers: &Layers) -> Result<[&[f32]; 3], String> {
    let find =
        |name| layers.channel(name).ok_or_else(|| format!("the picture has no channel {name}"));
    Ok([find("R")?, find("G")?, find("B")?])
}

fn write_pfm(out: &mut impl Write, layers: &Layers) -> std::io::Result<()> {
    let rgb = rgb(layers).map_err(Error::other)?;
    write!(out, "PF\n{} {}\n-1.0\n", layers.width, layers.height)?;
    for y in (0..layers.height).rev() {
        for x in 0..layers.width {
            for value in pixel(rgb, y * layers.width + x) {
                out.write_all(&value.to_le_bytes())?;
            }
        }
    }
    Ok(())
}

fn write_hdr(out: &mut impl Write, layers: &Layers) -> Result<(), String> {
    let rgb = rgb(layers)?;
    let pixels: Vec<image::Rgb<f32>> = (0..layers.width * layers.height)
        .map(|i| image::Rgb(pixel(rgb, i).map(|v| v.max(0.0))))
        .collect();
    let encoder = image::codecs::hdr::HdrEncoder::new(out);
    encoder.encode(&pixels, layers.width, layers.height).map_err(|e| e.to_string())
}

fn write_png(out: &mut (impl Write + Seek), layers: &Layers) -> Result<(), String> {
    let bytes = tone_map(rgb(layers)?, 0.0);
    let picture = image::RgbImage::from_raw(layers.width as u32, layers.height as u32, bytes);
    let picture = picture.ok_or("the picture's size does not match its channels")?;
    picture.write_to(out, image::ImageFormat::Png).map_err(|e| e.to_string())
}

/// The display image of a picture, as the bytes of a PNG.
///
/// # Errors
/// A message of one line: channels are missing, or their size is not that of the picture.
pub fn encode_png(layers: &Layers) -> Result<Vec<u8>, String> {
    let mut out = std::io::Cursor::new(Vec::new());
    write_png(&mut out, layers)?;
    Ok(out.into_inner())
}

/// Convert radiance to sRGB bytes: scale by 2^exposure, clip to [0, 1], apply the curve [IEC 61966-2-1].
pub fn tone_map(rgb: [&[f32]; 3], exposure: f32) -> Vec<u8> {
    let scale = exposure.exp2();
    let encode = |v: f32| {
        let v = (v * scale).clamp(0.0, 1.0);
        let s = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (s * 255.0 + 0.5) as u8
    };
    (0..rgb[0].len()).flat_map(|i| pixel(rgb, i).map(encode)).collect()
}
