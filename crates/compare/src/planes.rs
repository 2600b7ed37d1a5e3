//! Encodes pixel values as text for the page: packed half floats.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;

/// Pack interleaved values of some channels as half floats: channel by channel all upper bytes, then all lower ones; zlib; base64.
/// Returns the scale of the half floats, and the text.
pub(crate) fn pack_halves(values: &[f32], channels: usize) -> (f64, String) {
    let in_order = (0..channels).flat_map(|k| values.iter().skip(k).step_by(channels));
    let halves = gi_page::halves(in_order);
    let upper = halves.bits.iter().map(|h| (h >> 8) as u8);
    let lower = halves.bits.iter().map(|h| *h as u8);
    (halves.scale, pack(&upper.chain(lower).collect::<Vec<u8>>()))
}

/// Pack numbers in [0, 1] as bytes.
pub(crate) fn shares(values: &[f64]) -> String {
    pack(&values.iter().map(|v| (v * 255.0).round() as u8).collect::<Vec<u8>>())
}

fn pack(bytes: &[u8]) -> String {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // Writing to memory cannot fail.
    encoder.write_all(bytes).expect("writing to memory");
    STANDARD.encode(encoder.finish().expect("writing to memory"))
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    fn unpack(text: &str) -> Vec<u8> {
        let packed = STANDARD.decode(text).expect("base64");
        let mut bytes = Vec::new();
        flate2::read::ZlibDecoder::new(&packed[..]).read_to_end(&mut bytes).expect("zlib");
        bytes
    }

    #[test]
    fn channels_come_one_after_the_other_upper_bytes_first() {
        let values = [1.0, -2.0, 0.5, 3.0, 4.0, -0.25];
        let (scale, text) = pack_halves(&values, 3);
        let bytes = unpack(&text);
        let halves = gi_page::halves([1.0, 3.0, -2.0, 4.0, 0.5, -0.25].iter());
        assert_eq!(scale, halves.scale);
        for (i, bits) in halves.bits.into_iter().enumerate() {
            assert_eq!([bytes[i], bytes[6 + i]], bits.to_be_bytes());
        }
    }

    #[test]
    fn shares_are_bytes() {
        assert_eq!(unpack(&shares(&[0.0, 0.5, 1.0])), [0, 128, 255]);
    }
}
