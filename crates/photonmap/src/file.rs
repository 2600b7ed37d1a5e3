//! Save and load maps.
//!
//! A file starts with the line `gilab photons 4`. Little-endian numbers follow:
//! - the hash of the scene (u64);
//! - the sum of 1 if there is a caustic map, 2 if there are maps of media, and 4 if the dipole is used for solids (u32);
//! - the maximum number of segments of a path, and the layout (u32 each);
//! - for each map on surfaces: the number of paths and of photons (u64 each), and the photons (21 bytes each: the 20 of the lecture
//!   [slide 25], and the number of segments, which is 0 if the maximum number is unbounded);
//! - for media: the number of paths (u64), the fraction of the scatterings that was stored (f32), the number of media (u32), and for
//!   each medium the number of photons (u64) and the photons;
//! - a checksum of everything before (u64).
//!
//! Photons are in the order of their trees.

use gi_core::bytes::{Reader, Writer, unseal};
use gi_core::technique::Setting;

use crate::map::{Layout, PhotonMap};
use crate::params::{Gather, Params, Subsurface};
use crate::photon::{Payload, Photon, Rgbe};
use crate::shoot::{Shot, Stored};
use crate::volume::{VolumeMaps, VolumePhoton, VolumeShot};

const MAGIC: &[u8] = b"gilab photons 4\n";
const RECORD: usize = 21;
/// Flags of the maps.
const CAUSTIC: u32 = 1;
const VOLUME: u32 = 2;
const DIPOLE: u32 = 4;

/// Contents of a file.
pub(crate) struct Saved {
    /// Hash of the scene that the photons belong to.
    pub(crate) world: u64,
    /// Maximum number of segments of a path; 0 is unbounded.
    pub(crate) max_depth: u32,
    /// Layout of the trees that define the order of the photons.
    pub(crate) layout: Layout,
    /// The global map.
    pub(crate) global: Shot,
    /// The caustic map, if there is one.
    pub(crate) caustic: Option<Shot>,
    /// The photons in media, if media were simulated.
    pub(crate) volume: Option<VolumeShot>,
    /// How light in solids was simulated.
    pub(crate) subsurface: Subsurface,
}

impl Saved {
    /// Check that these photons can be used here.
    ///
    /// # Errors
    /// The reason, and the way out.
    pub(crate) fn check(&self, setting: &Setting, params: &Params) -> Result<(), String> {
        let wants_caustic = params.gather == Gather::Final && params.caustic_photons > 0;
        let wants_media = params.knows_media(setting.scene);
        let media = setting.scene.media().len();
        let refuse = |why: &str| Err(why.to_string());
        if self.world != setting.world {
            return refuse("these photons belong to another scene; trace them again");
        }
        if self.max_depth != params.limits.max_depth.unwrap_or(0) {
            return refuse("these photons were traced with another --max-depth");
        }
        if wants_caustic && self.caustic.is_none() {
            return refuse(
                "it contains no caustic map; give --caustic-photons 0, or trace photons again",
            );
        }
        if self.subsurface != params.subsurface {
            return refuse("these photons were traced with another --subsurface");
        }
        match &self.volume {
            None if wants_media => refuse(
                "these photons were traced without media; give --volume-photons 0, or trace them again",
            ),
            Some(_) if !wants_media => refuse(
                "these photons were traced in media; do not give --volume-photons 0, or trace them again",
            ),
            Some(shot) if shot.photons.len() != media => {
                refuse("these photons belong to other media; trace them again")
            }
            _ => Ok(()),
        }
    }
}

/// Write maps.
pub(crate) fn to_bytes(
    world: u64,
    max_depth: u32,
    layout: Layout,
    [global, caustic]: [Option<&PhotonMap>; 2],
    (volume, subsurface): (Option<&VolumeMaps>, Subsurface),
) -> Vec<u8> {
    let mut out = Writer::default();
    out.raw(MAGIC);
    out.u64(world);
    let flag = |is_there: bool, flag: u32| if is_there { flag } else { 0 };
    let maps = flag(caustic.is_some(), CAUSTIC)
        | flag(volume.is_some(), VOLUME)
        | flag(subsurface == Subsurface::Dipole, DIPOLE);
    out.u32(maps);
    out.u32(max_depth);
    out.u32(u32::from(layout == Layout::Fast));
    for map in [global, caustic].into_iter().flatten() {
        out.u64(map.emitted);
        write_photons(&mut out, map.len(), map.photons());
    }
    if let Some(volume) = volume {
        out.u64(volume.emitted);
        out.f32(volume.kept);
        out.u32(volume.photons().count() as u32);
        for photons in volume.photons() {
            let stored = |p: &VolumePhoton| Stored { photon: p.photon, depth: p.depth };
            write_photons(&mut out, photons.len(), photons.iter().map(stored));
        }
    }
    out.seal()
}

fn write_photons(out: &mut Writer, count: usize, photons: impl Iterator<Item = Stored>) {
    out.u64(count as u64);
    for Stored { photon: Photon { position, payload }, depth } in photons {
        out.f32s(&position);
        out.raw(&payload.power.to_bytes());
        out.raw(&[payload.phi, payload.theta]);
        out.u16(payload.flags);
        out.u8(depth);
    }
}

/// Read maps.
///
/// # Errors
/// What is wrong with the file.
pub(crate) fn from_bytes(bytes: &[u8]) -> Result<Saved, String> {
    if !bytes.starts_with(MAGIC) {
        return Err("it is not a file of photons of this version".into());
    }
    let mut input = Reader::new(&unseal(bytes)?[MAGIC.len()..]);
    let (world, maps, max_depth) = (input.u64()?, input.u32()?, input.u32()?);
    let layout = if input.u32()? == 1 { Layout::Fast } else { Layout::Jensen };
    let global = read_shot(&mut input)?;
    let caustic = if maps & CAUSTIC != 0 { Some(read_shot(&mut input)?) } else { None };
    let volume = if maps & VOLUME != 0 { Some(read_volume(&mut input)?) } else { None };
    input.end()?;
    let subsurface = if maps & DIPOLE != 0 { Subsurface::Dipole } else { Subsurface::Photons };
    Ok(Saved { world, max_depth, layout, global, caustic, volume, subsurface })
}

fn read_shot(input: &mut Reader) -> Result<Shot, String> {
    let (emitted, photons) = (input.u64()?, read_photons(input)?);
    Ok(Shot { photons, emitted, gave_up: false })
}

fn read_volume(input: &mut Reader) -> Result<VolumeShot, String> {
    let (emitted, kept, media) = (input.u64()?, input.f32()?, input.u32()?);
    let mut photons = Vec::new();
    for _ in 0..media {
        let volume = |Stored { photon, depth }| VolumePhoton { photon, depth };
        photons.push(read_photons(input)?.into_iter().map(volume).collect());
    }
    Ok(VolumeShot { photons, emitted, kept, gave_up: false })
}

fn read_photons(input: &mut Reader) -> Result<Vec<Stored>, String> {
    let count = input.u64()?;
    let records = input.records(count, RECORD)?;
    let photons: Vec<Stored> = records.chunks_exact(RECORD).map(stored).collect();
    if photons.iter().any(|s| !s.photon.p().is_finite()) {
        return Err("the position of a photon is not finite".into());
    }
    Ok(photons)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Order;
    use crate::photon::PhotonKind;
    use gi_core::math::Rgb;
    use gi_core::medium::{Medium, Phase};
    use glam::Vec3;

    fn some() -> Vec<Stored> {
        let kinds = [PhotonKind::Direct, PhotonKind::Caustic, PhotonKind::Indirect];
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

    /// Three media, of which two are one: the second has no photons of its own.
    fn volume(order: Order) -> VolumeMaps {
        let medium =
            |sigma_t| Medium::homogeneous(Rgb::grey(sigma_t), Rgb::WHITE, Phase::Isotropic);
        let of = |Stored { photon, depth }| VolumePhoton { photon, depth };
        let photons: Vec<_> = some().into_iter().map(of).collect();
        let photons = vec![photons.clone(), Vec::new(), photons[5..].to_vec()];
        let shot = VolumeShot { photons, emitted: 70, kept: 0.25, gave_up: false };
        VolumeMaps::build(shot, &[medium(1.0), medium(1.0), medium(2.0)], 3, order)
    }

    fn bytes([global, caustic]: &[PhotonMap; 2]) -> Vec<u8> {
        let volume = volume(Order::Any);
        to_bytes(
            7,
            4,
            Layout::Fast,
            [Some(global), Some(caustic)],
            (Some(&volume), Subsurface::Dipole),
        )
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
        assert_eq!(saved.subsurface, Subsurface::Dipole);
        let (shot, volume) = (saved.volume.expect("photons of media"), volume(Order::Any));
        assert_eq!((shot.emitted, shot.kept), (70, 0.25));
        assert!(volume.photons().eq(shot.photons.iter().map(|photons| &photons[..])));
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
        for at in 0..whole.len() {
            let mut other = whole.clone();
            other[at] ^= 0x10;
            assert!(from_bytes(&other).is_err(), "changed at {at}");
        }
        // A count of 2^63, and a position that is no number, said to be right.
        let refused = |at: usize, bytes: &[u8]| {
            let mut content = unseal(&whole).expect("it is whole").to_vec();
            content[MAGIC.len() + at..MAGIC.len() + at + bytes.len()].copy_from_slice(bytes);
            let mut other = Writer::default();
            other.raw(&content);
            from_bytes(&other.seal()).err().unwrap_or_default()
        };
        assert_eq!(refused(35, &[0x80]), "it ends too early");
        assert_eq!(refused(36, &f32::NAN.to_le_bytes()), "the position of a photon is not finite");
        assert_eq!(refused(0, &[]), "");
    }
}
