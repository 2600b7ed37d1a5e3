//! Writes media.

use std::fs;

use gi_core::math::{Bounds, Rgb};
use gi_core::medium::{Between, Cells, Grid, Medium, Outside, Phase, Varying, Volume};
use glam::{Affine3A, Vec3};

use super::{Exporter, channels};
use crate::volumes;

impl Exporter<'_> {
    pub(super) fn medium(&mut self, index: usize, medium: &Medium) -> Result<(), String> {
        let name = self.media[index].clone();
        match &medium.varying {
            None => {
                self.xml.open("medium", &[("type", "homogeneous"), ("id", &name)]);
                let scale = power_of_two(medium.sigma_t);
                self.xml.color("sigma_t", medium.sigma_t / scale);
                self.xml.value("float", "scale", &scale.to_string());
                self.xml.color("albedo", medium.albedo);
            }
            Some(varying) => {
                self.xml.open("medium", &[("type", "heterogeneous"), ("id", &name)]);
                self.varying(varying)?;
            }
        }
        match medium.phase {
            Phase::Isotropic => self.xml.empty("phase", &[("type", "isotropic")]),
            Phase::Rayleigh => self.xml.empty("phase", &[("type", "rayleigh")]),
            Phase::HenyeyGreenstein { g } => {
                self.xml.open("phase", &[("type", "hg")]);
                self.xml.value("float", "g", &g.to_string());
                self.xml.close();
            }
        }
        self.xml.close();
        Ok(())
    }

    fn varying(&mut self, varying: &Varying) -> Result<(), String> {
        let sigma_t = varying.sigma_t();
        let scale = match sigma_t {
            Volume::Constant(value) => power_of_two(*value),
            Volume::Grid { factor, .. } if is_grey(*factor) && factor.r > 0.0 => factor.r,
            Volume::Grid { .. } => 1.0,
        };
        self.xml.value("float", "scale", &scale.to_string());
        let to_cube = varying.domain().to_cube();
        if let Volume::Grid { to_local, .. } = sigma_t
            && *to_local != to_cube
        {
            self.warn("the exported medium reaches half a cell further than that of the file");
        }
        self.volume("sigma_t", sigma_t, scale, &to_cube)?;
        self.volume("albedo", varying.albedo(), 1.0, &to_cube)
    }

    /// Write a volume divided by `scale`. A constant one fills the cube that `to_cube` leads to.
    fn volume(
        &mut self,
        name: &str,
        volume: &Volume,
        scale: f32,
        to_cube: &Affine3A,
    ) -> Result<(), String> {
        match volume {
            Volume::Constant(value) => {
                self.xml.open("volume", &[("type", "constvolume"), ("name", name)]);
                self.xml.value("rgb", "value", &channels(*value / scale));
                self.xml.transform("to_world", &to_cube.inverse());
            }
            Volume::Grid { grid, to_local, factor } => {
                let (to_world, bytes) = self.file_of(grid, to_local, *factor / scale);
                let file = self
                    .side_file("vol", |path| fs::write(path, bytes).map_err(|e| e.to_string()))?;
                self.xml.open("volume", &[("type", "gridvolume"), ("name", name)]);
                self.xml.value("string", "filename", &file);
                if grid.between() == Between::Nearest {
                    self.xml.value("string", "filter_type", "nearest");
                }
                match grid.outside() {
                    Outside::Repeat => self.xml.value("string", "wrap_mode", "repeat"),
                    Outside::Mirror => self.xml.value("string", "wrap_mode", "mirror"),
                    Outside::Clamp | Outside::Zero => {}
                }
                self.xml.transform("to_world", &to_world);
            }
        }
        self.xml.close();
        Ok(())
    }

    /// The place and the bytes of a file with the values of a grid times `factor`.
    fn file_of(&mut self, grid: &Grid, to_local: &Affine3A, factor: Rgb) -> (Affine3A, Vec<u8>) {
        let unit = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
        if grid.outside() != Outside::Zero {
            let cells = scaled(grid.cells(), factor);
            return (to_local.inverse(), volumes::encode(grid.size(), &cells, unit));
        }
        self.warn(
            "Mitsuba 3 has no grid that is zero outside: one with a border of zeros, half a cell wide, replaces it",
        );
        let n = Vec3::from_array(grid.size().map(|n| n as f32));
        let grown = Affine3A::from_translation(-n.recip()) * Affine3A::from_scale((n + 2.0) / n);
        let (size, cells) = bordered(grid.size(), &scaled(grid.cells(), factor));
        (to_local.inverse() * grown, volumes::encode(size, &cells, unit))
    }
}

/// A power of two that a colour is not above, or 1: Mitsuba 3 expects colours in [0, 1], and scaling by a power of two
/// loses no digits.
fn power_of_two(color: Rgb) -> f32 {
    let most = color.max();
    if most > 1.0 { most.log2().ceil().exp2() } else { 1.0 }
}

fn is_grey(c: Rgb) -> bool {
    c.r == c.g && c.g == c.b
}

/// The values times `factor`.
fn scaled(cells: &Cells, factor: Rgb) -> Cells {
    match cells {
        Cells::Grey(values) if is_grey(factor) => {
            Cells::Grey(values.iter().map(|v| v * factor.r).collect())
        }
        Cells::Grey(values) => Cells::Color(values.iter().map(|v| factor * *v).collect()),
        Cells::Color(values) => Cells::Color(values.iter().map(|v| *v * factor).collect()),
    }
}

/// A grid with a border of zeros, one cell wide.
fn bordered(size: [usize; 3], cells: &Cells) -> ([usize; 3], Cells) {
    fn put<T: Copy + Default>([x, y, z]: [usize; 3], values: &[T]) -> Vec<T> {
        let mut out = vec![T::default(); (x + 2) * (y + 2) * (z + 2)];
        for (row, from) in values.chunks_exact(x).enumerate() {
            let start = ((row / y + 1) * (y + 2) + row % y + 1) * (x + 2) + 1;
            out[start..start + x].copy_from_slice(from);
        }
        out
    }
    let cells = match cells {
        Cells::Grey(values) => Cells::Grey(put(size, values).into()),
        Cells::Color(values) => Cells::Color(put(size, values).into()),
    };
    (size.map(|n| n + 2), cells)
}
