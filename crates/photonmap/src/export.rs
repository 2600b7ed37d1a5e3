//! Export photons as tables and point clouds.

use gi_core::points::{Ply, csv, row};
use glam::Vec3;

use crate::map::PhotonMap;
use crate::photon::{Photon, PhotonKind};
use crate::volume::VolumeMaps;

/// A photon of any map.
struct Exported {
    photon: Photon,
    map: Map,
}

/// The map that a photon is of.
#[derive(Clone, Copy)]
enum Map {
    Global,
    Caustic,
    /// That of a medium, by its index in the scene; equal media share the first one's.
    Volume(usize),
}

fn all<'m>(
    [global, caustic]: [Option<&'m PhotonMap>; 2],
    volume: Option<&'m VolumeMaps>,
    origin: Vec3,
) -> impl Iterator<Item = Exported> + 'm {
    let on_surfaces = [(Map::Global, global), (Map::Caustic, caustic)].into_iter();
    let on_surfaces = on_surfaces.flat_map(|(map, photons)| {
        let photons = photons.into_iter().flat_map(PhotonMap::photons);
        photons.map(move |s| Exported { photon: s.photon, map })
    });
    let media = volume.into_iter().flat_map(VolumeMaps::photons).enumerate();
    let in_media = media.flat_map(|(medium, photons)| {
        photons.iter().map(move |s| Exported { photon: s.photon, map: Map::Volume(medium) })
    });
    on_surfaces.chain(in_media).map(move |mut exported| {
        exported.photon.position = (exported.photon.p() + origin).to_array();
        exported
    })
}

fn kind_name(kind: PhotonKind) -> &'static str {
    match kind {
        PhotonKind::Direct => "direct",
        PhotonKind::Caustic => "caustic",
        PhotonKind::Indirect => "indirect",
    }
}

/// Photons as comma-separated values: map, kind of path, position, power, direction back to the light, and the surface normal or
/// the number of the medium. `origin` is that of the scene.
pub(crate) fn to_csv(
    maps: [Option<&PhotonMap>; 2],
    volume: Option<&VolumeMaps>,
    origin: Vec3,
) -> Vec<u8> {
    let line = |Exported { photon, map }| {
        let (c, d, n) =
            (photon.payload.power.to_rgb(), photon.payload.direction(), photon.payload.normal());
        let (name, place) = match map {
            Map::Global => ("global", row(n.to_array()) + ","),
            Map::Caustic => ("caustic", row(n.to_array()) + ","),
            Map::Volume(medium) => ("volume", format!(",,,{medium}")),
        };
        let (kind, position) = (kind_name(photon.payload.kind()), row(photon.position));
        format!(
            "{name},{kind},{position},{:e},{:e},{:e},{},{place}",
            c.r,
            c.g,
            c.b,
            row(d.to_array())
        )
    };
    let columns = "map,kind,x,y,z,red,green,blue,dx,dy,dz,nx,ny,nz,medium";
    csv(columns, all(maps, volume, origin).map(line))
}

/// Photons as the points of a binary PLY: position, direction back to the light (`nx ny nz`), power, `type` and `medium`. `type` is
/// 0, 1 or 2 for direct, caustic and indirect photons of the global map, 3 for the caustic map, 4 and 5 for caustic and indirect
/// photons in media. `medium` is -1 on surfaces. `origin` is that of the scene.
pub(crate) fn to_ply(
    maps: [Option<&PhotonMap>; 2],
    volume: Option<&VolumeMaps>,
    origin: Vec3,
) -> Vec<u8> {
    let properties = [
        ["float x", "float y", "float z", "float nx", "float ny", "float nz"].as_slice(),
        &["float red", "float green", "float blue", "uchar type", "int medium"],
    ];
    let mut ply = Ply::default();
    ply.element("vertex", all(maps, volume, origin).count(), &properties.concat());
    for Exported { photon, map } in all(maps, volume, origin) {
        ply.body.f32s(&photon.position);
        ply.body.vec3(photon.payload.direction());
        ply.body.rgb(photon.payload.power.to_rgb());
        let kind = photon.payload.kind() as u8;
        let (kind, medium) = match map {
            Map::Global => (kind, -1),
            Map::Caustic => (3, -1),
            Map::Volume(medium) => (3 + kind, medium as i32),
        };
        ply.body.u8(kind);
        ply.body.raw(&medium.to_le_bytes());
    }
    ply.into_bytes()
}
