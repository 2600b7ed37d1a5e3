//! Encodes pixel values as text for the page: packed half floats.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use half::f16;

/// Half floats, scaled so that the largest value fits. Values down to a billionth of the largest keep 11 bits; smaller
/// ones keep fewer.
pub(crate) struct Halves {
    /// Factor of the half floats: a power of two.
    pub(crate) scale: f64,
    /// For each channel, all upper bytes, then all lower bytes; compressed with zlib; in base64.
    pub(crate) text: String,
}

/// Pack the interleaved values of some channels.
pub(crate) fn halves(values: &[f32], channels: usize) -> Halves {
    let largest = values.iter().filter(|v| v.is_finite()).fold(0f32, |m, v| m.max(v.abs()));
    let exponent = match largest {
        0.0 => 0,
        largest => (f64::from(f16::MAX) / f64::from(largest)).log2().floor() as i32,
    };
    let factor = 2f64.powi(exponent);
    let half = |v: f32| f16::from_f64(f64::from(v) * factor).to_bits();
    let plane = |k: usize| values.iter().skip(k).step_by(channels).map(|v| half(*v));
    let upper = (0..channels).flat_map(|k| plane(k).map(|h| (h >> 8) as u8));
    let lower = (0..channels).flat_map(|k| plane(k).map(|h| h as u8));
    Halves { scale: 1.0 / factor, text: pack(&upper.chain(lower).collect::<Vec<u8>>()) }
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
    fn values_come_back_to_eleven_bits_over_nine_decades() {
        for top in [1e-20f32, 1.0, 65_504.0, 3e7, 3e38] {
            let values: Vec<f32> = (0..90)
                .map(|i| top * 10f32.powf(-0.1 * i as f32) * if i % 2 == 0 { 1.0 } else { -1.0 })
                .collect();
            let packed = halves(&values, 3);
            let bytes = unpack(&packed.text);
            for (i, v) in values.iter().enumerate() {
                let at = 30 * (i % 3) + i / 3;
                let bits = u16::from(bytes[at]) << 8 | u16::from(bytes[90 + at]);
                let back = f16::from_bits(bits).to_f64() * packed.scale;
                assert!(
                    (back / f64::from(*v) - 1.0).abs() <= 2f64.powi(-11),
                    "{v} came back as {back}"
                );
            }
        }
    }

    #[test]
    fn values_that_are_not_finite_stay_so_and_black_stays_black() {
        let bytes = unpack(&halves(&[f32::NAN, f32::INFINITY, 1.0], 3).text);
        let value = |k: usize| f16::from_bits(u16::from(bytes[k]) << 8 | u16::from(bytes[3 + k]));
        assert!(value(0).is_nan() && value(1).is_infinite());
        assert_eq!(unpack(&halves(&[0.0; 3], 3).text), [0; 6]);
        assert_eq!(unpack(&shares(&[0.0, 0.5, 1.0])), [0, 128, 255]);
    }
}
