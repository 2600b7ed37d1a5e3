//! Pictures in and out: the one place that names `image` and `exr`.

mod read;
mod write;

pub use read::{Encoding, read_bitmap, read_exr};
pub use write::{ImageFile, encode_png, tone_map, write_file};

/// A picture of linear radiance with further layers, as it is saved.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Named channels in row order from the top: "R", "G", "B", "Variance.R", "Z" and so on.
    pub channels: Vec<(String, Vec<f32>)>,
    /// Name and value of what else is worth knowing.
    pub metadata: Vec<(String, String)>,
}

impl Layers {
    /// The samples of a channel.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|(n, _)| n == name).map(|(_, samples)| samples.as_slice())
    }
}
