//! Mitsuba 0.6's own mesh format: one zlib stream per mesh, and a directory of their offsets at the end.

use std::io::Read;

use flate2::read::ZlibDecoder;
use gi_core::bytes::{Reader, TOO_SHORT};
use gi_core::geometry::Mesh;
use glam::{DVec3, Vec2, Vec3};

use crate::budget::Claim;

/// The first number of each mesh.
const MAGIC: u16 = 0x041c;
/// Largest inflated mesh: twenty million vertices with all their attributes. Real files are smaller, and a machine with
/// a few gigabytes can still hold it.
const MAX_INFLATED: u64 = 1 << 31;
/// Number of bytes inflated at a time, so that memory grows with the actual data and not with a claimed count.
const CHUNK: usize = 1 << 20;

const HAS_NORMALS: u32 = 0x0001;
const HAS_UVS: u32 = 0x0002;
const HAS_COLORS: u32 = 0x0008;
const FACE_NORMALS: u32 = 0x0010;
const SINGLE: u32 = 0x1000;
const DOUBLE: u32 = 0x2000;

/// Read mesh number `index`, whose positions are relative to `origin`.
pub(crate) fn parse(
    bytes: &[u8],
    (index, origin): (usize, DVec3),
    claim: &mut Claim<'_>,
) -> Result<Mesh, String> {
    let (version, stream) = locate(bytes, index)?;
    let mut stream = Stream { inner: ZlibDecoder::new(stream), left: MAX_INFLATED, double: false };
    let flags = u32::from_le_bytes(stream.array()?);
    if version >= 4 {
        while stream.array::<1>()? != [0] {} // the name
    }
    let vertices = stream.count()?;
    let triangles = stream.count()?;
    match flags & (SINGLE | DOUBLE) {
        0 | SINGLE => {} // old files name no precision
        DOUBLE => stream.double = true,
        other => return Err(format!("its precision is coded as {other:#x}")),
    }
    // Positions are read in their own precision first.
    let position = if stream.double { 12 + 24 } else { 12 + 12 };
    let attributes = [(0, position), (HAS_NORMALS, 12), (HAS_UVS, 8), (HAS_COLORS, 12)];
    let vertex =
        attributes.iter().filter(|(flag, _)| flags & flag == *flag).map(|(_, n)| n).sum::<u64>();
    claim.set(vertices as u64 * vertex + triangles as u64 * 12)?;
    let positions = stream.positions(vertices, origin)?;
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
        positions,
        normals: normals.collect(),
        uvs: uvs.into_iter().map(Vec2::from).collect(),
        triangles: triangles.into(),
    })
}

/// Whether mesh number `index` has positions in single precision.
pub(crate) fn is_single(bytes: &[u8], index: usize) -> bool {
    let flags = locate(bytes, index).and_then(|(_, stream)| {
        let inner = ZlibDecoder::new(stream);
        Stream { inner, left: MAX_INFLATED, double: false }.array()
    });
    flags.is_ok_and(|flags| u32::from_le_bytes(flags) & DOUBLE == 0)
}

/// The version and the compressed bytes of a mesh.
fn locate(bytes: &[u8], index: usize) -> Result<(u16, &[u8]), String> {
    let mut head = Reader::new(bytes);
    let (magic, version) = (head.u16()?, head.u16()?);
    if magic != MAGIC {
        return Err(format!("it starts with {magic:#06x} instead of {MAGIC:#06x}"));
    }
    if version != 3 && version != 4 {
        return Err(format!("version {version} is not supported, only 3 and 4"));
    }
    let tail = bytes.len().checked_sub(4).ok_or(TOO_SHORT)?;
    let count = Reader::new(&bytes[tail..]).u32()? as usize;
    if index >= count {
        return Err(format!("it contains {count} meshes, but mesh {index} (from 0) was requested"));
    }
    let width = if version == 4 { 8 } else { 4 };
    let dictionary = count.checked_mul(width).and_then(|n| tail.checked_sub(n)).ok_or(TOO_SHORT)?;
    let offset = |i: usize| -> Result<usize, String> {
        if i == count {
            return Ok(dictionary);
        }
        let mut entry = Reader::new(&bytes[dictionary + i * width..]);
        let at = if version == 4 { entry.u64()? } else { u64::from(entry.u32()?) };
        usize::try_from(at).map_err(|_| TOO_SHORT.into())
    };
    let (start, end) = (offset(index)?, offset(index + 1)?);
    let stream = bytes.get(start..end.min(dictionary)).and_then(|b| b.get(4..)).ok_or(TOO_SHORT)?;
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
            std::io::ErrorKind::UnexpectedEof => TOO_SHORT.to_owned(),
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
        // Each element has at least twelve bytes, so a larger count must be false.
        if n > MAX_INFLATED / 12 || n > u64::from(u32::MAX) {
            return Err(format!("it claims {n} elements"));
        }
        Ok(n as usize)
    }

    /// Read `n` records of `N` numbers, each `width` bytes, a chunk at a time.
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

    fn positions(&mut self, n: usize, origin: DVec3) -> Result<Vec<Vec3>, String> {
        let relative = |p: DVec3| (p - origin).as_vec3();
        if !self.double {
            let positions = self.vectors::<3>(n)?;
            return Ok(positions.into_iter().map(|p| relative(Vec3::from(p).as_dvec3())).collect());
        }
        let read = |b: &[u8]| f64::from_le_bytes(b.try_into().expect("eight bytes"));
        let positions = self.records::<f64, 3>(n, 8, read)?;
        Ok(positions.into_iter().map(|p| relative(DVec3::from(p))).collect())
    }

    /// Indices have four bytes, or eight if there are more vertices than four bytes can count.
    fn triangles(&mut self, n: usize, vertices: usize) -> Result<Vec<[u32; 3]>, String> {
        debug_assert!(vertices as u64 <= u64::from(u32::MAX));
        self.records(n, 4, |b| u32::from_le_bytes(b.try_into().expect("four bytes")))
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::ZlibEncoder;

    use super::*;
    use crate::budget::Budget;

    fn read(bytes: &[u8], index: usize) -> Result<Mesh, String> {
        parse(bytes, (index, DVec3::ZERO), &mut Budget::new(u64::MAX).claim("a test"))
    }

    /// A file of meshes, each given as (flags, name, vertices, triangles).
    fn file(version: u16, meshes: &[(u32, &str, u64, u64)]) -> Vec<u8> {
        let (mut out, mut offsets) = (Vec::new(), Vec::new());
        for (k, &(flags, name, vertices, triangles)) in meshes.iter().enumerate() {
            offsets.push(out.len() as u64);
            out.extend(MAGIC.to_le_bytes());
            out.extend(version.to_le_bytes());
            let mut zip = ZlibEncoder::new(&mut out, Compression::fast());
            let mut put = |bytes: &[u8]| zip.write_all(bytes).unwrap();
            put(&flags.to_le_bytes());
            if version == 4 {
                put(name.as_bytes());
                put(&[0]);
            }
            put(&vertices.to_le_bytes());
            put(&triangles.to_le_bytes());
            let mut numbers = 3;
            for (flag, n) in [(HAS_NORMALS, 3), (HAS_UVS, 2), (HAS_COLORS, 3)] {
                numbers += if flags & flag != 0 { n } else { 0 };
            }
            for i in 0..numbers * vertices.min(100) {
                let x = (i + k as u64) as f64 + 0.5;
                match flags & DOUBLE {
                    0 => put(&(x as f32).to_le_bytes()),
                    _ => put(&x.to_le_bytes()),
                }
            }
            for i in 0..3 * triangles.min(100) {
                put(&((i % vertices.max(1)) as u32).to_le_bytes());
            }
            zip.finish().unwrap();
        }
        for o in &offsets {
            match version {
                4 => out.extend(o.to_le_bytes()),
                _ => out.extend((*o as u32).to_le_bytes()),
            }
        }
        out.extend((offsets.len() as u32).to_le_bytes());
        out
    }

    #[test]
    fn each_mesh_of_each_version_and_precision_is_found() {
        for version in [3, 4] {
            for precision in [0, SINGLE, DOUBLE] {
                let all = precision | HAS_NORMALS | HAS_UVS | HAS_COLORS;
                let bytes = file(version, &[(precision, "a", 3, 1), (all, "b\u{e9}", 5, 2)]);
                let (a, b) = (read(&bytes, 0).unwrap(), read(&bytes, 1).unwrap());
                assert_eq!((a.positions.len(), a.normals.len(), a.uvs.len()), (3, 0, 0));
                assert_eq!(a.positions[1], Vec3::new(3.5, 4.5, 5.5));
                assert_eq!((b.positions.len(), b.normals.len(), b.uvs.len()), (5, 5, 5));
                assert_eq!(b.uvs[0], Vec2::new(31.5, 32.5));
                assert_eq!(b.triangles, [[0, 1, 2], [3, 4, 0]]);
                assert!(read(&bytes, 2).unwrap_err().contains("contains 2 meshes"));
            }
        }
    }

    #[test]
    fn a_file_cut_or_damaged_at_any_byte_never_panics() {
        let whole = file(4, &[(SINGLE | HAS_UVS, "a", 4, 2), (SINGLE, "b", 3, 1)]);
        for end in 0..whole.len() {
            assert!(read(&whole[..end], 1).is_err());
        }
        for at in 0..whole.len() {
            for value in [0, 1, 0x7f, 0xff] {
                let mut bytes = whole.clone();
                bytes[at] = value;
                let _ = read(&bytes, 1);
            }
        }
    }

    #[test]
    fn false_counts_end_where_the_data_ends() {
        let bytes = file(4, &[(SINGLE, "a", u64::MAX, 1)]);
        assert!(read(&bytes, 0).unwrap_err().contains("claims"));
        let bytes = file(4, &[(SINGLE, "a", 100_000_000, 1)]);
        assert_eq!(read(&bytes, 0).unwrap_err(), TOO_SHORT);
    }

    #[test]
    fn a_zip_bomb_is_not_inflated() {
        // Without a limit, the reader would inflate a name of a gigabyte.
        let mut zip = ZlibEncoder::new(Vec::new(), Compression::best());
        zip.write_all(&SINGLE.to_le_bytes()).unwrap();
        zip.write_all(&(u64::from(u32::MAX) / 64).to_le_bytes()).unwrap();
        zip.write_all(&[0; 1 << 20]).unwrap();
        let mut bytes = [MAGIC.to_le_bytes(), 3u16.to_le_bytes()].concat();
        bytes.extend(zip.finish().unwrap());
        bytes.extend(0u32.to_le_bytes());
        bytes.extend(1u32.to_le_bytes());
        assert_eq!(read(&bytes, 0).unwrap_err(), TOO_SHORT);
    }
}
