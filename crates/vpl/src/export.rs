//! Virtual point lights as files for other programs: PLY and CSV.

use std::path::Path;

use gi_core::files::is_table;
use glam::Vec3;

use crate::light::{Kind, Vpl};

/// Lights as a table if the file name ends in `.csv`, else as a point cloud. `origin` is the origin of the scene.
pub fn to_file(path: &Path, vpls: &[Vpl], origin: Vec3) -> Vec<u8> {
    if is_table(path) { to_csv(vpls, origin).into_bytes() } else { to_ply(vpls, origin) }
}

/// Lights as a point cloud: position, normal, power, depth. `origin` is the origin of the scene.
pub fn to_ply(vpls: &[Vpl], origin: Vec3) -> Vec<u8> {
    let floats = ["x", "y", "z", "nx", "ny", "nz", "power_r", "power_g", "power_b"];
    let mut out = format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", vpls.len());
    floats.iter().for_each(|p| out += &format!("property float {p}\n"));
    out += "property uint depth\nend_header\n";
    let mut out = out.into_bytes();
    for v in vpls {
        let numbers = [(v.p + origin).to_array(), v.n.to_array(), v.power.to_array()].concat();
        numbers.iter().for_each(|f| out.extend(f.to_le_bytes()));
        out.extend(v.depth.to_le_bytes());
    }
    out
}

/// Lights as a table. `origin` is the origin of the scene.
pub fn to_csv(vpls: &[Vpl], origin: Vec3) -> String {
    let mut out = String::from("x,y,z,nx,ny,nz,power_r,power_g,power_b,depth,kind\n");
    for v in vpls {
        let numbers = [(v.p + origin).to_array(), v.n.to_array(), v.power.to_array()].concat();
        let row: Vec<String> = numbers.iter().map(f32::to_string).collect();
        let kind = match v.kind {
            Kind::Oriented => "oriented",
            Kind::Omni => "omni",
            Kind::Spot(_) => "spot",
            Kind::Directional => "directional",
            Kind::Glossy(_) => "glossy",
        };
        out += &format!("{},{},{kind}\n", row.join(","), v.depth);
    }
    out
}
