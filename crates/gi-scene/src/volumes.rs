//! Reads grids of values from Mitsuba's `.vol` files.
//!
//! The format: the bytes `VOL`, a version (3), then little-endian 32-bit numbers. Integers: the encoding (1 is single
//! precision), the number of cells along x, y and z, the number of channels. Floats: the smallest and the largest corner
//! of the box, then the values. Channels vary fastest, then x, then y.

use std::path::Path;
use std::sync::Arc;

use gi_core::math::{Bounds, Rgb};
use gi_core::medium::Cells;
use glam::Vec3;

use crate::budget::Budget;
use crate::files;
use crate::hash::Hash;
use crate::value::MAX_NUMBER;

/// Number of bytes before the values.
const HEADER: usize = 48;
/// Negative values above minus this come from rounding and count as zero.
const ROUNDING: f32 = 1e-6;
/// Largest number of cells along an axis.
const MOST_CELLS: usize = (1 << 24) - 1;

/// The contents of a file.
#[derive(Clone, Debug)]
pub(crate) struct VolumeFile {
    pub(crate) size: [usize; 3],
    pub(crate) cells: Cells,
    /// The box that the file names for its values.
    pub(crate) bounds: Bounds,
}

impl VolumeFile {
    /// Read a file, if the budget allows it; also returns the hash of its bytes. Only signed values may be negative.
    pub(crate) fn read(path: &Path, signed: bool, budget: &Budget) -> Result<(Self, u64), String> {
        let mut claim = budget.claim(path.display());
        let bytes = files::read_bytes(path, &mut claim)?;
        let header = Header::parse(&bytes)?;
        let cells = header.bytes();
        claim.set(bytes.len() as u64 + cells)?;
        let read = VolumeFile {
            size: header.size,
            cells: header.cells(&bytes[HEADER..], signed)?,
            bounds: header.bounds,
        };
        let mut hash = Hash::default();
        hash.bytes(&bytes);
        drop(bytes);
        claim.keep(cells)?;
        Ok((read, hash.value()))
    }
}

/// What a file says about its values.
struct Header {
    size: [usize; 3],
    channels: usize,
    bounds: Bounds,
}

impl Header {
    fn parse(bytes: &[u8]) -> Result<Header, String> {
        if !bytes.starts_with(b"VOL") {
            return Err("it does not start with `VOL`".into());
        }
        if bytes.len() < HEADER {
            return Err("its header is cut off".into());
        }
        let word = |k: usize| bytes[4 * k..4 * k + 4].try_into().expect("four bytes");
        let integer = |k| i32::from_le_bytes(word(k));
        if bytes[3] != 3 {
            return Err(format!("version {} is not supported, only 3", bytes[3]));
        }
        match integer(1) {
            1 => {}
            n @ 2..=4 => {
                let what = ["half precision", "bytes", "directions"][n as usize - 2];
                return Err(format!("values stored as {what} are not supported: store floats"));
            }
            n => return Err(format!("encoding {n} is not supported, only 1 (floats)")),
        }
        let size = [2, 3, 4].map(|k| usize::try_from(integer(k)).unwrap_or(0));
        if !size.iter().all(|n| (1..=MOST_CELLS).contains(n)) {
            let shown = [2, 3, 4].map(|k| integer(k).to_string()).join(" x ");
            return Err(format!("{shown} cells: expected 1 to {MOST_CELLS} along each axis"));
        }
        let channels = match integer(5) {
            n @ (1 | 3) => n as usize,
            n => return Err(format!("{n} channels are not supported, only 1 or 3")),
        };
        let [a, b, c, d, e, f] = [6, 7, 8, 9, 10, 11].map(|k| f32::from_le_bytes(word(k)));
        let bounds = Bounds { min: Vec3::new(a, b, c), max: Vec3::new(d, e, f) };
        let header = Header { size, channels, bounds };
        let (found, expected) = ((bytes.len() - HEADER) as u64, header.bytes());
        if found < expected {
            return Err(format!("it has {found} bytes of values, and its header says {expected}"));
        }
        Ok(header)
    }

    fn count(&self) -> u64 {
        // Below 2^72 cells; saturated, it exceeds every file.
        self.size.iter().fold(1, |n: u64, s| n.saturating_mul(*s as u64))
    }

    /// Memory of the values.
    fn bytes(&self) -> u64 {
        self.count().saturating_mul(4 * self.channels as u64)
    }

    fn cells(&self, bytes: &[u8], signed: bool) -> Result<Cells, String> {
        let float = |b: &[u8]| {
            let value = f32::from_le_bytes(b.try_into().expect("four bytes"));
            if !signed && (-ROUNDING..0.0).contains(&value) { 0.0 } else { value }
        };
        let values = bytes[..self.bytes() as usize].chunks_exact(4).map(float);
        let (least, fits): (&str, fn(f32) -> bool) =
            if signed { ("-1e15", |v| is_valid(v.abs())) } else { ("0", is_valid) };
        if let Some((k, bad)) = values.clone().enumerate().find(|(_, v)| !fits(*v)) {
            let cell = k / self.channels;
            let [x, y, _] = self.size;
            let at = [cell % x, cell / x % y, cell / x / y].map(|i| i.to_string()).join(", ");
            return Err(format!("the value of cell ({at}) is {bad}: expected {least} to 1e15"));
        }
        Ok(if self.channels == 1 {
            Cells::Grey(values.collect::<Arc<[f32]>>())
        } else {
            let color = |b: &[u8]| Rgb::new(float(&b[..4]), float(&b[4..8]), float(&b[8..]));
            Cells::Color(bytes[..self.bytes() as usize].chunks_exact(12).map(color).collect())
        })
    }
}

/// Whether a number can be a coefficient or an albedo.
pub(crate) fn is_valid(value: f32) -> bool {
    (0.0..=MAX_NUMBER).contains(&value)
}

/// The bytes of a file of values.
pub(crate) fn encode(size: [usize; 3], cells: &Cells, bounds: Bounds) -> Vec<u8> {
    let channels = if matches!(cells, Cells::Grey(_)) { 1 } else { 3 };
    let mut out = b"VOL\x03".to_vec();
    let [x, y, z] = size.map(|n| n as i32);
    out.extend([1, x, y, z, channels].map(i32::to_le_bytes).concat());
    out.extend(
        [bounds.min, bounds.max].iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes),
    );
    match cells {
        Cells::Grey(values) => out.extend(values.iter().flat_map(|v| v.to_le_bytes())),
        Cells::Color(values) => {
            out.extend(values.iter().flat_map(|c| c.to_array()).flat_map(f32::to_le_bytes));
        }
    }
    out
}
