//! Reads and writes pictures: the only module that uses `image` and `exr`.

mod read;
mod write;

pub use read::{Claim, Encoding, read_bitmap, read_bitmap_within, read_exr};
pub use write::{ImageFile, encode_png, tone_map, write_file};

/// A picture of linear radiance with further layers, as stored in a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Named channels in row order from the top: "R", "G", "B", "Variance.R", "Z" and so on.
    pub channels: Vec<(String, Vec<f32>)>,
    /// Metadata, as names and values.
    pub metadata: Vec<(String, String)>,
}

impl Layers {
    /// A picture with these pixels, row by row from the top: only the channels R, G, B.
    pub fn of_rgb([width, height]: [usize; 2], pixels: impl IntoIterator<Item = [f32; 3]>) -> Self {
        let mut planes = [const { Vec::new() }; 3];
        for pixel in pixels {
            planes.iter_mut().zip(pixel).for_each(|(plane, v)| plane.push(v));
        }
        let names = ["R", "G", "B"].map(String::from);
        let channels = names.into_iter().zip(planes).collect();
        Layers { width, height, channels, metadata: Vec::new() }
    }

    /// The samples of a channel.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|(n, _)| n == name).map(|(_, samples)| samples.as_slice())
    }

    /// The samples of three channels, interleaved by pixel.
    pub fn interleaved(&self, names: [&str; 3]) -> Option<Vec<f32>> {
        let [r, g, b] = names.map(|name| self.channel(name));
        let (r, g, b) = (r?, g?, b?);
        Some((0..r.len()).flat_map(|i| [r[i], g[i], b[i]]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_become_channels_and_channels_pixels() {
        let layers = Layers::of_rgb([2, 1], [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        assert_eq!((layers.width, layers.height), (2, 1));
        assert_eq!(layers.channel("G"), Some(&[2.0, 5.0][..]));
        let rgb = layers.interleaved(["R", "G", "B"]);
        assert_eq!(rgb.as_deref(), Some(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0][..]));
        assert_eq!(layers.interleaved(["R", "G", "Direct.B"]), None);
    }
}
