//! Records as files for other programs: PLY and CSV.

use std::path::Path;

use glam::Vec3;

use gi_core::files::is_table;

use crate::record::Record;

/// Records as a table if the file name ends in `.csv`, else as a point cloud. `origin` is the origin of the scene.
pub fn to_file<'r>(
    path: &Path,
    records: impl Iterator<Item = &'r Record>,
    origin: Vec3,
) -> Vec<u8> {
    if is_table(path) { to_csv(records, origin).into_bytes() } else { to_ply(records, origin) }
}

/// Records as a table: position, normal, irradiance, radii, and the translational gradient averaged over channels.
/// `origin` is the origin of the scene.
pub fn to_csv<'r>(records: impl Iterator<Item = &'r Record>, origin: Vec3) -> String {
    let mut out =
        String::from("x,y,z,nx,ny,nz,e_r,e_g,e_b,radius_u,radius_v,clear,grad_x,grad_y,grad_z\n");
    for r in records {
        let g = r.translational.0.iter().sum::<Vec3>() / 3.0;
        let numbers =
            [(r.site.p + origin).to_array(), r.site.n.to_array(), r.e.to_array()].concat();
        let more = [r.site.radii[0], r.site.radii[1], r.site.clear, g.x, g.y, g.z];
        let row: Vec<String> = numbers.iter().chain(&more).map(f32::to_string).collect();
        out += &row.join(",");
        out.push('\n');
    }
    out
}

/// Records as a point cloud: position, normal, irradiance, radius, and a colour (irradiance relative to the largest).
/// `origin` is the origin of the scene.
pub fn to_ply<'r>(records: impl Iterator<Item = &'r Record>, origin: Vec3) -> Vec<u8> {
    let records: Vec<&Record> = records.collect();
    let properties = ["x", "y", "z", "nx", "ny", "nz", "e_r", "e_g", "e_b", "radius"];
    let mut out =
        format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", records.len());
    properties.iter().for_each(|p| out += &format!("property float {p}\n"));
    ["red", "green", "blue"].iter().for_each(|p| out += &format!("property uchar {p}\n"));
    out += "end_header\n";
    let mut out = out.into_bytes();
    let brightest = records.iter().map(|r| r.e.max()).fold(f32::MIN_POSITIVE, f32::max);
    for r in &records {
        let numbers =
            [(r.site.p + origin).to_array(), r.site.n.to_array(), r.e.to_array()].concat();
        numbers.iter().chain([&r.site.reach()]).for_each(|f| out.extend(f.to_le_bytes()));
        let byte = |c: f32| ((c / brightest).powf(1.0 / 2.2) * 255.0 + 0.5) as u8;
        out.extend(r.e.to_array().map(byte));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exports_have_one_row_per_record() {
        let floats: Vec<f32> = (0..Record::FLOATS).map(|k| k as f32 * 0.25).collect();
        let records = [Record::from_floats(&floats); 5];
        assert_eq!(to_csv(records.iter(), Vec3::ZERO).lines().count(), 6);
        let ply = to_ply(records.iter(), Vec3::ZERO);
        let header = b"end_header\n";
        let at = ply.windows(header.len()).position(|w| w == header).expect("a header");
        assert_eq!(ply.len() - at - header.len(), 5 * (10 * 4 + 3));
    }
}
