//! Maps as files: saved for another run, or exported to look at.
//!
//! A saved map is the line `gilab photons 1`, then little-endian numbers: the world's identity (u64), how many maps there
//! are, the most segments of a path and the layout (u32 each), and for each map the number of paths begun and of photons (u64 each)
//! and the photons, 21 bytes each: the lecture's 20 [slide 25] and the number of segments.

use std::fmt::Write;

use crate::map::{Layout, PhotonMap};
use crate::photon::{Kind, Payload, Photon, Rgbe};
use crate::shoot::{Shot, Stored};

const MAGIC: &[u8] = b"gilab photons 1\n";
const RECORD: usize = 21;

/// What a file holds.
pub(crate) struct Saved {
    /// Identity of the world that the photons are of.
    pub(crate) world: u64,
    /// Most segments of a path; 0 is unbounded.
    pub(crate) max_depth: u32,
    /// Layout of the trees whose order the photons are in.
    pub(crate) layout: Layout,
    /// The global map.
    pub(crate) global: Shot,
    /// The caustic map, if it was made.
    pub(crate) caustic: Option<Shot>,
}

/// Write maps.
pub(crate) fn to_bytes(
    world: u64,
    max_depth: u32,
    layout: Layout,
    maps: [Option<&PhotonMap>; 2],
) -> Vec<u8> {
    let mut out = MAGIC.to_vec();
    out.extend(world.to_le_bytes());
    out.extend((1 + u32::from(maps[1].is_some())).to_le_bytes());
    out.extend(max_depth.to_le_bytes());
    out.extend(u32::from(layout == Layout::Fast).to_le_bytes());
    for map in maps.into_iter().flatten() {
        out.extend(map.emitted.to_le_bytes());
        out.extend((map.len() as u64).to_le_bytes());
        for Stored { photon: Photon { position, payload }, depth } in map.photons() {
            out.extend(position.iter().flat_map(|x| x.to_le_bytes()));
            out.extend(payload.power.to_bytes());
            out.extend([payload.phi, payload.theta]);
            out.extend(payload.flags.to_le_bytes());
            out.push(depth);
        }
    }
    out
}

/// Read maps.
///
/// # Errors
/// What is wrong with the file.
pub(crate) fn from_bytes(bytes: &[u8]) -> Result<Saved, String> {
    let rest = bytes.strip_prefix(MAGIC).ok_or("this is no file of photons of this version")?;
    let mut input = Input(rest);
    let (world, maps, max_depth) = (input.u64()?, input.u32()?, input.u32()?);
    let layout = if input.u32()? == 1 { Layout::Fast } else { Layout::Jensen };
    let global = input.shot()?;
    let caustic = if maps > 1 { Some(input.shot()?) } else { None };
    if !input.0.is_empty() {
        return Err("the file goes on after its last photon".into());
    }
    Ok(Saved { world, max_depth, layout, global, caustic })
}

struct Input<'a>(&'a [u8]);

impl<'a> Input<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let (head, rest) = self.0.split_at_checked(n).ok_or("the file ends too early")?;
        self.0 = rest;
        Ok(head)
    }

    fn u32(&mut self) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.take(4)?.try_into().map_err(|_| "no number")?))
    }

    fn u64(&mut self) -> Result<u64, String> {
        Ok(u64::from_le_bytes(self.take(8)?.try_into().map_err(|_| "no number")?))
    }

    fn shot(&mut self) -> Result<Shot, String> {
        let (emitted, count) = (self.u64()?, self.u64()?);
        // A count that the file cannot hold is refused before anything is reserved for it.
        let size = usize::try_from(count).ok().and_then(|n| n.checked_mul(RECORD));
        let records = self.take(size.ok_or("the file ends too early")?)?;
        let photons: Vec<Stored> = records.chunks_exact(RECORD).map(stored).collect();
        if photons.iter().any(|s| !s.photon.p().is_finite()) {
            return Err("a photon is nowhere".into());
        }
        Ok(Shot { photons, emitted, gave_up: false })
    }
}

fn stored(b: &[u8]) -> Stored {
    let float = |k: usize| f32::from_le_bytes([b[k], b[k + 1], b[k + 2], b[k + 3]]);
    let payload = Payload {
        power: Rgbe::from_bytes([b[12], b[13], b[14], b[15]]),
        phi: b[16],
        theta: b[17],
        flags: u16::from_le_bytes([b[18], b[19]]),
    };
    Stored { photon: Photon { position: [float(0), float(4), float(8)], payload }, depth: b[20] }
}

/// The map that a photon is of.
const MAPS: [&str; 2] = ["global", "caustic"];

fn kind_name(kind: Kind) -> &'static str {
    match kind {
        Kind::Direct => "direct",
        Kind::Caustic => "caustic",
        Kind::Indirect => "indirect",
    }
}

/// Photons as comma-separated values, with the number of the map (see the first column) and all that they carry.
pub(crate) fn to_csv(maps: [Option<&PhotonMap>; 2]) -> Vec<u8> {
    let mut out = "map,kind,x,y,z,red,green,blue,dx,dy,dz,nx,ny,nz\n".to_string();
    for (name, map) in MAPS.into_iter().zip(maps) {
        for Stored { photon, .. } in map.into_iter().flat_map(PhotonMap::photons) {
            let (c, d, n) = (
                photon.payload.power.to_rgb(),
                photon.payload.direction(),
                photon.payload.normal(),
            );
            let (kind, [x, y, z]) = (kind_name(photon.payload.kind()), photon.position);
            let _ = writeln!(
                out,
                "{name},{kind},{x},{y},{z},{:e},{:e},{:e},{},{},{},{},{},{}",
                c.r, c.g, c.b, d.x, d.y, d.z, n.x, n.y, n.z
            ); // a String takes everything
        }
    }
    out.into_bytes()
}

/// Photons as the points of a binary PLY: position, direction back to the light as `nx ny nz`, power, and as `type` 0, 1, 2 for
/// direct, caustic and indirect photons of the global map, 3 for those of the caustic map.
pub(crate) fn to_ply(maps: [Option<&PhotonMap>; 2]) -> Vec<u8> {
    let (mut points, mut count) = (Vec::new(), 0);
    for (which, map) in maps.into_iter().enumerate() {
        for Stored { photon, .. } in map.into_iter().flat_map(PhotonMap::photons) {
            let (power, d) = (photon.payload.power.to_rgb().to_array(), photon.payload.direction());
            for x in photon.position.into_iter().chain(d.to_array()).chain(power) {
                points.extend(x.to_le_bytes());
            }
            points.push(if which == 1 { 3 } else { photon.payload.kind() as u8 });
            count += 1;
        }
    }
    let floats = ["x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"];
    let properties: String = floats.iter().map(|f| format!("property float {f}\n")).collect();
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {count}\n{properties}property uchar type\nend_header\n"
    )
    .into_bytes();
    out.extend(points);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Order;
    use gi_core::math::Rgb;
    use glam::Vec3;

    fn some() -> Vec<Stored> {
        let kinds = [Kind::Direct, Kind::Caustic, Kind::Indirect];
        (0..9u8)
            .map(|k| {
                let p = Vec3::splat(f32::from(k) + 0.1);
                let power = Rgbe::nearest(Rgb::new(f32::from(k), 1.0, 0.5));
                let photon = Photon::new(p, power, Vec3::X, Vec3::Y, kinds[usize::from(k) % 3]);
                Stored { photon, depth: k + 1 }
            })
            .collect()
    }

    fn maps() -> [PhotonMap; 2] {
        let map =
            |photons, emitted| PhotonMap::build(photons, emitted, Layout::Fast, Order::Any, true);
        [map(some(), 100), map(some()[3..].to_vec(), 50)]
    }

    fn bytes([global, caustic]: &[PhotonMap; 2]) -> Vec<u8> {
        to_bytes(7, 4, Layout::Fast, [Some(global), Some(caustic)])
    }

    #[test]
    fn saved_photons_come_back() {
        let maps = maps();
        let saved = from_bytes(&bytes(&maps)).expect("a good file");
        assert_eq!((saved.world, saved.max_depth, saved.layout), (7, 4, Layout::Fast));
        for (map, shot) in maps.iter().zip([saved.global, saved.caustic.expect("a second map")]) {
            assert_eq!(shot.emitted, map.emitted);
            assert_eq!(shot.photons, map.photons().collect::<Vec<_>>());
        }
    }

    #[test]
    fn damaged_files_are_refused_wherever_they_are_cut() {
        let whole = bytes(&maps());
        for end in 0..whole.len() {
            assert!(from_bytes(&whole[..end]).is_err(), "cut at {end}");
        }
        let mut more = whole.clone();
        more.push(0);
        assert!(from_bytes(&more).is_err());
        // A count of 2^63, and a position that is no number.
        let (mut huge, mut nowhere) = (whole.clone(), whole);
        huge[MAGIC.len() + 35] = 0x80;
        nowhere[MAGIC.len() + 36..MAGIC.len() + 40].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(from_bytes(&huge).is_err() && from_bytes(&nowhere).is_err());
    }
}
