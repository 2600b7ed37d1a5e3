//! Read and write numbers as little-endian bytes, for checkpoints and for files of caches and photon maps.

use glam::Vec3;

use crate::math::Rgb;

/// Bytes that are being written.
#[derive(Clone, Debug, Default)]
pub struct Writer(Vec<u8>);

impl Writer {
    /// A 32-bit integer.
    pub fn u32(&mut self, v: u32) {
        self.0.extend(v.to_le_bytes());
    }

    /// A 64-bit integer.
    pub fn u64(&mut self, v: u64) {
        self.0.extend(v.to_le_bytes());
    }

    /// A float.
    pub fn f32(&mut self, v: f32) {
        self.u32(v.to_bits());
    }

    /// A double.
    pub fn f64(&mut self, v: f64) {
        self.u64(v.to_bits());
    }

    /// Several doubles.
    pub fn f64s(&mut self, values: &[f64]) {
        values.iter().for_each(|v| self.f64(*v));
    }

    /// Three floats.
    pub fn vec3(&mut self, v: Vec3) {
        v.to_array().into_iter().for_each(|x| self.f32(x));
    }

    /// Three floats.
    pub fn rgb(&mut self, v: Rgb) {
        v.to_array().into_iter().for_each(|x| self.f32(x));
    }

    /// Bytes, preceded by their number.
    pub fn bytes(&mut self, v: &[u8]) {
        self.u64(v.len() as u64);
        self.0.extend(v);
    }

    /// A text, preceded by its length.
    pub fn text(&mut self, v: &str) {
        self.bytes(v.as_bytes());
    }

    /// The bytes.
    pub fn into_bytes(self) -> Vec<u8> {
        self.0
    }
}

/// Bytes that are being read. Every method fails if they end too early.
#[derive(Clone, Copy, Debug)]
pub struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    /// Read `bytes` from the start.
    pub fn new(bytes: &'a [u8]) -> Self {
        Reader(bytes)
    }

    /// The next `n` bytes.
    ///
    /// # Errors
    /// The bytes end too early; so do all methods.
    pub fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let (first, rest) = self.0.split_at_checked(n).ok_or_else(cut_short)?;
        self.0 = rest;
        Ok(first)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (first, rest) = self.0.split_first_chunk().ok_or_else(cut_short)?;
        self.0 = rest;
        Ok(*first)
    }

    /// See [`Writer::u32`].
    pub fn u32(&mut self) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    /// See [`Writer::u64`].
    pub fn u64(&mut self) -> Result<u64, String> {
        Ok(u64::from_le_bytes(self.array()?))
    }

    /// See [`Writer::f32`].
    pub fn f32(&mut self) -> Result<f32, String> {
        Ok(f32::from_bits(self.u32()?))
    }

    /// See [`Writer::f64`].
    pub fn f64(&mut self) -> Result<f64, String> {
        Ok(f64::from_bits(self.u64()?))
    }

    /// See [`Writer::f64s`].
    pub fn f64s<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let mut values = [0.0; N];
        for v in &mut values {
            *v = self.f64()?;
        }
        Ok(values)
    }

    /// See [`Writer::vec3`].
    pub fn vec3(&mut self) -> Result<Vec3, String> {
        Ok(Vec3::new(self.f32()?, self.f32()?, self.f32()?))
    }

    /// See [`Writer::rgb`].
    pub fn rgb(&mut self) -> Result<Rgb, String> {
        Ok(Rgb::new(self.f32()?, self.f32()?, self.f32()?))
    }

    /// See [`Writer::bytes`].
    pub fn bytes(&mut self) -> Result<&'a [u8], String> {
        let n = usize::try_from(self.u64()?).map_err(|_| cut_short())?;
        self.take(n)
    }

    /// See [`Writer::text`].
    pub fn text(&mut self) -> Result<&'a str, String> {
        std::str::from_utf8(self.bytes()?).map_err(|_| "a text in it is not UTF-8".into())
    }

    /// Check that all bytes are read.
    pub fn end(self) -> Result<(), String> {
        if self.0.is_empty() { Ok(()) } else { Err("it is longer than it should be".into()) }
    }
}

fn cut_short() -> String {
    "it is cut short".into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_and_what_is_cut_short_is_refused() {
        let mut w = Writer::default();
        w.u32(7);
        w.f64s(&[0.1, f64::NEG_INFINITY]);
        w.text("R, N");
        w.vec3(Vec3::new(1.0, -0.0, f32::MIN_POSITIVE));
        let bytes = w.into_bytes();
        let read = |bytes: &[u8]| -> Result<(u32, [f64; 2], String, Vec3), String> {
            let mut r = Reader::new(bytes);
            let all = (r.u32()?, r.f64s()?, r.text()?.to_string(), r.vec3()?);
            r.end()?;
            Ok(all)
        };
        let (a, b, c, d) = read(&bytes).expect("what was written");
        assert_eq!((a, b, c.as_str()), (7, [0.1, f64::NEG_INFINITY], "R, N"));
        assert_eq!(d.to_array().map(f32::to_bits)[1], (-0.0f32).to_bits());
        for n in 0..bytes.len() {
            assert!(read(&bytes[..n]).is_err(), "cut at {n}");
        }
        assert!(read(&[bytes.as_slice(), &[0]].concat()).is_err());
        // A length that no file has.
        let mut huge = Writer::default();
        huge.u64(u64::MAX);
        assert!(Reader::new(&huge.into_bytes()).bytes().is_err());
    }
}
