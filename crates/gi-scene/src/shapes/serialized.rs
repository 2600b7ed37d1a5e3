//! Mitsuba 0.6's own mesh format: one zlib stream a mesh, a dictionary of their places at the end.

use std::io::Read;

use flate2::read::ZlibDecoder;
use gi_core::geometry::Mesh;
use glam::{Vec2, Vec3};

use crate::bytes::{Bytes, TRUNCATED};

/// The first number of each mesh.
const MAGIC: u16 = 0x041c;
/// A mesh inflates to no more than this: twenty million vertices with all their attributes, more than
/// any file found, and still no danger to a machine with a few gigabytes.
const MAX_INFLATED: u64 = 1 << 31;
/// How much is inflated at a time, so that memory follows what is there and not what a count claims.
const CHUNK: usize = 1 << 20;

const HAS_NORMALS: u32 = 0x0001;
const HAS_UVS: u32 = 0x0002;
const HAS_COLORS: u32 = 0x0008;
const FACE_NORMALS: u32 = 0x0010;
const SINGLE: u32 = 0x1000;
const DOUBLE: u32 = 0x2000;

/// Read mesh number `index`.
pub(crate) fn parse(bytes: &[u8], index: usize) -> Result<Mesh, String> {
    let (version, stream) = locate(bytes, index)?;
    let mut stream = Stream { inner: ZlibDecoder::new(stream), left: MAX_INFLATED, double: false };
    let flags = u32::from_le_bytes(stream.array()?);
    if version >= 4 {
        while stream.array::<1>()? != [0] {} // the name
    }
    let vertices = stream.count()?;
    let triangles = stream.count()?;
    match flags & (SINGLE | DOUBLE) {
        SINGLE => {}
        DOUBLE => stream.double = true,
        other => return Err(format!("its precision is coded as {other:#x}")),
    }
    let positions = stream.vectors::<3>(vertices)?;
    let normals =
        if flags & HAS_NORMALS != 0 { stream.vectors::<3>(vertices)? } else { Vec::new() };
    let uvs = if flags & HAS_UVS != 0 { stream.vectors::<2>(vertices)? } else { Vec::new() };
    if flags & HAS_COLORS != 0 {
        stream.vectors::<3>(vertices)?;
    }
    let triangles = stream.triangles(triangles, vertices)?;
    let keep = flags & FACE_NORMALS == 0;
    let normals = normals.into_iter().filter(|_| keep).map(|n| Vec3::from(n).normalize_or_zero());
    Ok(Mesh {
        positions: positions.into_iter().map(Vec3::from).collect(),
        normals: normals.collect(),
        uvs: uvs.into_iter().map(Vec2::from).collect(),
        triangles,
    })
}

/// The version and the compressed bytes of a mesh.
fn locate(bytes: &[u8], index: usize) -> Result<(u16, &[u8]), String> {
    let mut head = Bytes::little(bytes);
    let (magic, version) = (head.u16()?, head.u16()?);
    if magic != MAGIC {
        return Err(format!("it begins with {magic:#06x} and not with {MAGIC:#06x}"));
    }
    if version != 3 && version != 4 {
        return Err(format!("its version is {version}; 3 and 4 are known"));
    }
    let tail = bytes.len().checked_sub(4).ok_or(TRUNCATED)?;
    let count = Bytes::little(&bytes[tail..]).u32()? as usize;
    if index >= count {
        return Err(format!("it holds {count} meshes, number {index} is asked for"));
    }
    let width = if version == 4 { 8 } else { 4 };
    let dictionary = count.checked_mul(width).and_then(|n| tail.checked_sub(n)).ok_or(TRUNCATED)?;
    let offset = |i: usize| -> Result<usize, String> {
        if i == count {
            return Ok(dictionary);
        }
        let mut entry = Bytes::little(&bytes[dictionary + i * width..]);
        let at = if version == 4 { entry.u64()? } else { u64::from(entry.u32()?) };
        usize::try_from(at).map_err(|_| TRUNCATED.into())
    };
    let (start, end) = (offset(index)?, offset(index + 1)?);
    let stream = bytes.get(start..end.min(dictionary)).and_then(|b| b.get(4..)).ok_or(TRUNCATED)?;
    Ok((version, stream))
}

struct Stream<'a> {
    inner: ZlibDecoder<&'a [u8]>,
    left: u64,
    double: bool,
}

impl Stream<'_> {
    fn fill(&mut self, into: &mut [u8]) -> Result<(), String> {
        self.left = self
            .left
            .checked_sub(into.len() as u64)
            .ok_or_else(|| format!("it inflates to more than {MAX_INFLATED} bytes"))?;
        self.inner.read_exact(into).map_err(|e| match e.kind() {
            std::io::ErrorKind::UnexpectedEof => TRUNCATED.to_owned(),
            _ => format!("its compression is damaged: {e}"),
        })
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut out = [0; N];
        self.fill(&mut out)?;
        Ok(out)
    }

    fn count(&mut self) -> Result<usize, String> {
        let n = u64::from_le_bytes(self.array()?);
        // Twelve bytes each at least: a larger count cannot be honest.
        if n > MAX_INFLATED / 12 || n > u64::from(u32::MAX) {
            return Err(format!("it claims {n} elements"));
        }
        Ok(n as usize)
    }

    /// `n` records of `N` numbers of `width` bytes, a chunk at a time.
    fn records<T, const N: usize>(
        &mut self,
        n: usize,
        width: usize,
        read: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<[T; N]>, String> {
        let size = N * width;
        let mut out = Vec::new();
        let mut chunk = vec![0; (CHUNK / size).min(n.max(1)) * size];
        let mut left = n;
        while left > 0 {
            let now = left.min(chunk.len() / size);
            self.fill(&mut chunk[..now * size])?;
            for record in chunk[..now * size].chunks_exact(size) {
                out.push(std::array::from_fn(|k| read(&record[k * width..(k + 1) * width])));
            }
            left -= now;
        }
        Ok(out)
    }

    fn vectors<const N: usize>(&mut self, n: usize) -> Result<Vec<[f32; N]>, String> {
        if self.double {
            let read = |b: &[u8]| f64::from_le_bytes(b.try_into().expect("eight bytes")) as f32;
            self.records(n, 8, read)
        } else {
            self.records(n, 4, |b| f32::from_le_bytes(b.try_into().expect("four bytes")))
        }
    }

    /// Indices take four bytes, or eight where there are more vertices than that can count.
    fn triangles(&mut self, n: usize, vertices: usize) -> Result<Vec<[u32; 3]>, String> {
        debug_assert!(vertices as u64 <= u64::from(u32::MAX));
        self.records(n, 4, |b| u32::from_le_bytes(b.try_into().expect("four bytes")))
    }
}
