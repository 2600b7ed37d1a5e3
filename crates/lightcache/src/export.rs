//! Records as files for other programs: PLY and CSV.

use std::path::Path;

use glam::Vec3;

use gi_core::files::is_table;
use gi_core::points::{Ply, csv, row};

use crate::record::Record;

/// Records as a table if the file name ends in `.csv`, else as a point cloud. `origin` is the origin of the scene.
pub fn to_file<'r>(
    path: &Path,
    records: impl Iterator<Item = &'r Record>,
    origin: Vec3,
) -> Vec<u8> {
    if is_table(path) { to_csv(records, origin) } else { to_ply(records, origin) }
}

/// Records as a table: position, normal, irradiance, radii, and the translational gradient averaged over channels.
/// `origin` is the origin of the scene.
pub fn to_csv<'r>(records: impl Iterator<Item = &'r Record>, origin: Vec3) -> Vec<u8> {
    let columns = "x,y,z,nx,ny,nz,e_r,e_g,e_b,radius_u,radius_v,clear,grad_x,grad_y,grad_z";
    let line = |r: &Record| {
        let g = r.translational.0.iter().sum::<Vec3>() / 3.0;
        let more = [r.site.radii[0], r.site.radii[1], r.site.clear, g.x, g.y, g.z];
        row(floats(r, origin).into_iter().flatten().chain(more))
    };
    csv(columns, records.map(line))
}

/// Position, normal and irradiance.
fn floats(r: &Record, origin: Vec3) -> [[f32; 3]; 3] {
    [(r.site.p + origin).to_array(), r.site.n.to_array(), r.e.to_array()]
}

/// Records as a point cloud: position, normal, irradiance, radius, and a colour (irradiance relative to the largest).
/// `origin` is the origin of the scene.
pub fn to_ply<'r>(records: impl Iterator<Item = &'r Record>, origin: Vec3) -> Vec<u8> {
    let records: Vec<&Record> = records.collect();
    let properties = [
        ["float x", "float y", "float z", "float nx", "float ny", "float nz"].as_slice(),
        &["float e_r", "float e_g", "float e_b", "float radius"],
        &["uchar red", "uchar green", "uchar blue"],
    ];
    let mut ply = Ply::default();
    ply.element("vertex", records.len(), &properties.concat());
    let brightest = records.iter().map(|r| r.e.max()).fold(f32::MIN_POSITIVE, f32::max);
    for r in &records {
        floats(r, origin).iter().for_each(|v| ply.body.f32s(v));
        ply.body.f32(r.site.reach());
        let byte = |c: f32| ((c / brightest).powf(1.0 / 2.2) * 255.0 + 0.5) as u8;
        ply.body.raw(&r.e.to_array().map(byte));
    }
    ply.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exports_have_one_row_per_record() {
        let floats: Vec<f32> = (0..Record::FLOATS).map(|k| k as f32 * 0.25).collect();
        let records = [Record::from_floats(&floats); 5];
        let table = String::from_utf8(to_csv(records.iter(), Vec3::ZERO)).expect("a text");
        assert_eq!(table.lines().count(), 6);
        let ply = to_ply(records.iter(), Vec3::ZERO);
        let header = b"end_header\n";
        let at = ply.windows(header.len()).position(|w| w == header).expect("a header");
        assert_eq!(ply.len() - at - header.len(), 5 * (10 * 4 + 3));
    }
}
