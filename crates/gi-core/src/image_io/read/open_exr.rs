//! OpenEXR pictures.

use std::path::Path;

use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel};

use super::{Claim, check_size};
use crate::files::open_regular;
use crate::image_io::Layers;
use crate::math::Rgb;

/// The largest number of samples of a layer: four gigabytes. The decoder decompresses all channels, even if few of them
/// are kept.
const MAX_SAMPLES: u64 = 1 << 30;
/// A block takes at least so many bytes of a file: its position, its place in the picture and its length.
const SMALLEST_BLOCK: u64 = 16;

/// The layers of a file, after a check of the sizes that it claims.
fn headers(path: &Path) -> Result<Vec<Header>, String> {
    let file = open_regular(path)?;
    let length = file.metadata().map_err(|e| e.to_string())?.len();
    let file = std::io::BufReader::new(file);
    let meta = MetaData::read_from_buffered(file, false).map_err(|e| e.to_string())?;
    for header in &meta.headers {
        let (width, height) = (header.layer_size.width() as u64, header.layer_size.height() as u64);
        check_size(width, height)?;
        let channels = header.channels.list.len() as u64;
        if (width * height).saturating_mul(channels) > MAX_SAMPLES {
            return Err(format!(
                "{channels} channels of {width} x {height} pixels are more than the largest accepted number of samples, \
                 {MAX_SAMPLES}"
            ));
        }
        if (header.chunk_count as u64).saturating_mul(SMALLEST_BLOCK) > length {
            return Err("the file is cut short".into());
        }
    }
    Ok(meta.headers.into_iter().filter(|header| !header.deep).collect())
}

/// Bytes that the decoder takes to read a layer, besides the result: blocks of all channels, and their positions.
fn decoding(header: &Header) -> u64 {
    const BLOCKS: u64 = 3; // compressed, decompressed and sorted
    let block = header.max_block_byte_size() as u64;
    block.saturating_mul(BLOCKS).saturating_add((header.chunk_count as u64).saturating_mul(16))
}

/// Read every channel of an EXR's first layer, and its text attributes.
pub(super) fn layers(path: &Path) -> Result<Layers, String> {
    headers(path)?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_unbuffered(open_regular(path)?)
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

/// The radiance of an EXR; only the channels that it needs are read.
pub(super) fn radiance(path: &Path, claim: Claim<'_>) -> Result<(usize, usize, Vec<Rgb>), String> {
    let headers = headers(path)?;
    let found = headers.iter().find_map(|header| Some((header, names(header)?)));
    let (header, names) = found.ok_or("no channels R G B, and no Y")?;
    let pixels = header.layer_size.area() as u64;
    claim(pixels * size_of::<Rgb>() as u64 + decoding(header))?;
    let file = open_regular(path)?;
    let layers = exr::prelude::read().no_deep_data().largest_resolution_level();
    let (size, pixels) = match names {
        Names::Color([r, g, b]) => {
            let image = layers
                .specific_channels()
                .required(r.as_str())
                .required(g.as_str())
                .required(b.as_str())
                .collect_pixels(
                    |size, _| Pixels::black(size),
                    |all: &mut Pixels, at, (r, g, b): (f32, f32, f32)| {
                        all.set(at, Rgb::new(r, g, b));
                    },
                )
                .first_valid_layer()
                .all_attributes()
                .from_unbuffered(file);
            let layer = image.map_err(|e| e.to_string())?.layer_data;
            (layer.size, layer.channel_data.pixels)
        }
        Names::Grey(y) => {
            let image = layers
                .specific_channels()
                .required(y.as_str())
                .collect_pixels(
                    |size, _| Pixels::black(size),
                    |all: &mut Pixels, at, (y,): (f32,)| all.set(at, Rgb::grey(y)),
                )
                .first_valid_layer()
                .all_attributes()
                .from_unbuffered(file);
            let layer = image.map_err(|e| e.to_string())?.layer_data;
            (layer.size, layer.channel_data.pixels)
        }
    };
    Ok((size.width(), size.height(), pixels.all))
}

/// The pixels of a picture that is being read.
struct Pixels {
    width: usize,
    all: Vec<Rgb>,
}

impl Pixels {
    fn black(size: Vec2<usize>) -> Self {
        Pixels { width: size.width(), all: vec![Rgb::BLACK; size.area()] }
    }

    fn set(&mut self, at: Vec2<usize>, color: Rgb) {
        self.all[at.y() * self.width + at.x()] = color;
    }
}

/// The channels that hold the radiance.
enum Names {
    Color([String; 3]),
    Grey(String),
}

/// R G B, or grey from Y; if there are no such channels, those of a named layer.
fn names(header: &Header) -> Option<Names> {
    let all: Vec<String> = header.channels.list.iter().map(|c| c.name.to_string()).collect();
    let find = |name: &str| {
        let suffix = format!(".{name}");
        let exact = all.iter().find(|n| *n == name);
        exact.or_else(|| all.iter().find(|n| n.ends_with(&suffix))).cloned()
    };
    match (find("R"), find("G"), find("B")) {
        (Some(r), Some(g), Some(b)) => Some(Names::Color([r, g, b])),
        _ => find("Y").map(Names::Grey),
    }
}
