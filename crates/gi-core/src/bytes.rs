//! Read and write numbers as bytes: checkpoints, caches, photon maps, mesh files. Written bytes are little-endian.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use glam::Vec3;

use crate::math::Rgb;

/// Bytes that are being written.
#[derive(Clone, Debug, Default)]
pub struct Writer(Vec<u8>);

impl Writer {
    /// Bytes as they are.
    pub fn raw(&mut self, v: &[u8]) {
        self.0.extend(v);
    }

    /// A byte.
    pub fn u8(&mut self, v: u8) {
        self.0.push(v);
    }

    /// A 16-bit integer.
    pub fn u16(&mut self, v: u16) {
        self.0.extend(v.to_le_bytes());
    }

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

    /// Counts.
    pub fn counts<'c>(&mut self, counts: impl IntoIterator<Item = &'c AtomicU64>) {
        counts.into_iter().for_each(|n| self.u64(n.load(Relaxed)));
    }

    /// Several floats.
    pub fn f32s(&mut self, values: &[f32]) {
        values.iter().for_each(|v| self.f32(*v));
    }

    /// Three floats.
    pub fn vec3(&mut self, v: Vec3) {
        self.f32s(&v.to_array());
    }

    /// Three floats.
    pub fn rgb(&mut self, v: Rgb) {
        self.f32s(&v.to_array());
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

    /// A table: the number of rows, then the floats of each row from `put`. All rows have the same number of floats.
    pub fn table<R>(&mut self, rows: &[R], put: impl Fn(&R, &mut Vec<f32>)) {
        self.u64(rows.len() as u64);
        let mut floats = Vec::new();
        for row in rows {
            floats.clear();
            put(row, &mut floats);
            self.f32s(&floats);
        }
    }

    /// The bytes.
    pub fn into_bytes(self) -> Vec<u8> {
        self.0
    }

    /// The bytes, followed by their checksum (8 bytes). [`unseal`] checks it.
    pub fn seal(mut self) -> Vec<u8> {
        self.u64(checksum(&self.0));
        self.0
    }
}

/// The bytes that [`Writer::seal`] sealed, without their checksum.
///
/// # Errors
/// The checksum is wrong, or missing.
pub fn unseal(bytes: &[u8]) -> Result<&[u8], String> {
    let (sealed, sum) = bytes.split_last_chunk().ok_or(TOO_SHORT)?;
    if checksum(sealed).to_le_bytes() == *sum {
        Ok(sealed)
    } else {
        Err("it is damaged: its checksum is wrong".into())
    }
}

/// FNV-1a with 64 bits. It detects damage, not manipulation.
pub fn checksum(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3))
}

/// The error of bytes that end too early.
pub const TOO_SHORT: &str = "it ends too early";

/// Bytes that are being read, from the front. Every method fails with [`TOO_SHORT`] if they end too early.
#[derive(Clone, Copy, Debug)]
pub struct Reader<'a> {
    rest: &'a [u8],
    big_endian: bool,
}

/// Methods that read one number each.
macro_rules! numbers {
    ($($name:ident),*) => {$(
        /// The next number of this type.
        pub fn $name(&mut self) -> Result<$name, String> {
            let bytes = self.array()?;
            Ok(if self.big_endian { $name::from_be_bytes(bytes) } else { $name::from_le_bytes(bytes) })
        }
    )*};
}

impl<'a> Reader<'a> {
    /// Read little-endian numbers.
    pub fn new(bytes: &'a [u8]) -> Self {
        Reader { rest: bytes, big_endian: false }
    }

    /// Read big-endian numbers.
    pub fn big_endian(bytes: &'a [u8]) -> Self {
        Reader { rest: bytes, big_endian: true }
    }

    /// Number of bytes that are left.
    pub fn len(&self) -> usize {
        self.rest.len()
    }

    /// Whether all bytes are read.
    pub fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// The next `n` bytes.
    ///
    /// # Errors
    /// The bytes end too early. All methods return this error.
    pub fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let (first, rest) = self.rest.split_at_checked(n).ok_or(TOO_SHORT)?;
        self.rest = rest;
        Ok(first)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (first, rest) = self.rest.split_first_chunk().ok_or(TOO_SHORT)?;
        self.rest = rest;
        Ok(*first)
    }

    numbers!(u8, i8, u16, i16, u32, i32, u64, f32, f64);

    /// Several floats.
    pub fn f32s<const N: usize>(&mut self) -> Result<[f32; N], String> {
        let mut values = [0.0; N];
        for v in &mut values {
            *v = self.f32()?;
        }
        Ok(values)
    }

    /// See [`Writer::f64s`].
    pub fn f64s<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let mut values = [0.0; N];
        for v in &mut values {
            *v = self.f64()?;
        }
        Ok(values)
    }

    /// Add what [`Writer::counts`] wrote to these counts.
    pub fn add_to_counts<'c>(
        &mut self,
        counts: impl IntoIterator<Item = &'c AtomicU64>,
    ) -> Result<(), String> {
        for n in counts {
            n.fetch_add(self.u64()?, Relaxed);
        }
        Ok(())
    }

    /// See [`Writer::vec3`].
    pub fn vec3(&mut self) -> Result<Vec3, String> {
        Ok(Vec3::from(self.f32s()?))
    }

    /// See [`Writer::rgb`].
    pub fn rgb(&mut self) -> Result<Rgb, String> {
        let [r, g, b] = self.f32s()?;
        Ok(Rgb::new(r, g, b))
    }

    /// See [`Writer::bytes`].
    pub fn bytes(&mut self) -> Result<&'a [u8], String> {
        let n = self.u64()?;
        self.take(usize::try_from(n).map_err(|_| TOO_SHORT)?)
    }

    /// See [`Writer::text`].
    pub fn text(&mut self) -> Result<&'a str, String> {
        std::str::from_utf8(self.bytes()?).map_err(|_| "a text in it is not UTF-8".into())
    }

    /// The bytes of `count` records of `size` bytes each.
    pub fn records(&mut self, count: u64, size: usize) -> Result<&'a [u8], String> {
        let bytes = usize::try_from(count).ok().and_then(|n| n.checked_mul(size));
        self.take(bytes.ok_or(TOO_SHORT)?)
    }

    /// See [`Writer::table`]; `row` converts `width` floats to a row.
    pub fn table<R>(&mut self, width: usize, row: impl Fn(&[f32]) -> R) -> Result<Vec<R>, String> {
        let count = self.u64()?;
        let mut records = Reader { rest: self.records(count, 4 * width)?, ..*self };
        let mut floats = vec![0.0; width];
        let mut rows = Vec::with_capacity(count as usize);
        for _ in 0..count {
            for f in &mut floats {
                *f = records.f32()?;
            }
            rows.push(row(&floats));
        }
        Ok(rows)
    }

    /// Check that all bytes are read.
    pub fn end(self) -> Result<(), String> {
        if self.is_empty() { Ok(()) } else { Err("it is longer than it should be".into()) }
    }
}

#[cfg(test)]
mod tests;
