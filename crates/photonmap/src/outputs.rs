//! Files that a run writes besides its picture.

use std::path::Path;

use gi_core::files::is_table;
use gi_core::technique::Setting;

use crate::gather::Gatherer;
use crate::params::Params;
use crate::{estimate, export, file};

impl Gatherer<'_, '_> {
    /// The contents of a file that the parameters ask for.
    pub(crate) fn contents(&self, path: &Path) -> Vec<u8> {
        let Params { map_out, probe_out, probe, .. } = self.params;
        if map_out.as_deref() == Some(path) {
            return self.save();
        }
        match (probe_out, probe) {
            (Some(file), Some(pixel)) if file == path => self.probe(*pixel),
            _ => self.export_points(is_table(path)),
        }
    }

    /// The maps as a file for `--map-in`. The photons of the dipole are not in it: they are traced anew.
    pub(crate) fn save(&self) -> Vec<u8> {
        let max_depth = self.params.limits.max_depth.unwrap_or(0);
        let Setting { world, .. } = *self.setting;
        let in_media = (self.maps.volume(), self.params.subsurface);
        file::to_bytes(world, max_depth, self.params.layout, self.maps.on_surfaces(), in_media)
    }

    /// All photons, as comma-separated values or as a PLY point cloud.
    fn export_points(&self, as_csv: bool) -> Vec<u8> {
        let (volume, origin) = (self.maps.volume(), self.setting.scene.origin());
        if as_csv {
            export::to_csv(self.maps.on_surfaces(), volume, origin)
        } else {
            export::to_ply(self.maps.on_surfaces(), volume, origin)
        }
    }

    /// The estimate [slide 24] at the surface in the middle of a pixel, one line for each number of photons k.
    fn probe(&self, [x, y]: [usize; 2]) -> Vec<u8> {
        let Setting { scene, camera, .. } = *self.setting;
        let mut out = "k,found,radius,red,green,blue\n".to_string();
        let ray = camera.ray([x as f32 + 0.5, y as f32 + 0.5], [0.5; 2]);
        let Some((surface, _)) = scene.intersect(&ray) else { return out.into_bytes() };
        let n = estimate::facing(&surface, -ray.d);
        for k in [10, 15, 20, 30, 50, 70, 100, 150, 200, 300, 500, 700, 1000] {
            let e = self.maps.global.irradiance_of(k, surface.p, n);
            let (c, r) = (e.all(), e.found.radius_sq.sqrt() / scene.radius());
            out += &format!("{k},{},{r},{},{},{}\n", e.found.count, c.r, c.g, c.b);
        }
        out.into_bytes()
    }
}
