//! Virtual point lights as files for other programs: PLY and CSV.

use std::path::Path;

use gi_core::files::is_table;
use gi_core::points::{Ply, csv, row};
use glam::Vec3;

use crate::light::{Kind, Vpl};

/// Lights as a table if the file name ends in `.csv`, else as a point cloud. `origin` is the origin of the scene.
pub fn to_file(path: &Path, vpls: &[Vpl], origin: Vec3) -> Vec<u8> {
    if is_table(path) { to_csv(vpls, origin) } else { to_ply(vpls, origin) }
}

/// Lights as a point cloud: position, normal, power, depth. `origin` is the origin of the scene.
pub fn to_ply(vpls: &[Vpl], origin: Vec3) -> Vec<u8> {
    let properties = [
        ["float x", "float y", "float z", "float nx", "float ny", "float nz"].as_slice(),
        &["float power_r", "float power_g", "float power_b", "uint depth"],
    ];
    let mut ply = Ply::default();
    ply.element("vertex", vpls.len(), &properties.concat());
    for v in vpls {
        floats(v, origin).iter().for_each(|v| ply.body.f32s(v));
        ply.body.u32(v.depth);
    }
    ply.into_bytes()
}

/// Lights as a table. `origin` is the origin of the scene.
pub fn to_csv(vpls: &[Vpl], origin: Vec3) -> Vec<u8> {
    let line = |v: &Vpl| {
        let kind = match v.kind {
            Kind::Oriented => "oriented",
            Kind::Omni => "omni",
            Kind::Spot(_) => "spot",
            Kind::Directional => "directional",
            Kind::Glossy(_) => "glossy",
        };
        format!("{},{},{kind}", row(floats(v, origin).into_iter().flatten()), v.depth)
    };
    csv("x,y,z,nx,ny,nz,power_r,power_g,power_b,depth,kind", vpls.iter().map(line))
}

/// Position, normal and power.
fn floats(v: &Vpl, origin: Vec3) -> [[f32; 3]; 3] {
    [(v.p + origin).to_array(), v.n.to_array(), v.power.to_array()]
}
