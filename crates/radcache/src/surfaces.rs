//! Which kind of record each surface uses, and the BRDF tables of the materials.

use gi_core::bsdf::{DiffusePart, Kind};
use gi_core::eye::EyeVertex;
use gi_core::math::{Frame, Rgb};
use gi_core::scene::Scene;
use glam::Vec3;

use crate::brdf::BrdfTable;
use crate::params::Params;

/// The source of the indirect light at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// Irradiance records, for the diffuse part. The path continues over the other lobes.
    Diffuse(DiffusePart),
    /// Radiance records, for all lobes but delta lobes.
    Glossy {
        /// The diffuse part, if there is one: radiance records contain irradiance too.
        part: Option<DiffusePart>,
        /// Normal of all lobes.
        n: Vec3,
    },
    /// The path, which continues over all lobes.
    Path,
}

/// BRDF tables of the materials that have them.
pub struct Surfaces {
    tables: Vec<Option<BrdfTable>>,
    /// For each material with a glossy lobe, a text that says how it is handled.
    pub decided: Vec<String>,
}

impl Surfaces {
    /// Tabulate the lobes of a scene that are rough enough.
    pub fn new(scene: &Scene, params: &Params) -> Self {
        let mut decided = Vec::new();
        let mut table = |material: usize| {
            let lobe = scene.glossy_lobe(material)?;
            let (name, roughness) = (lobe.name(), lobe.roughness());
            if roughness < params.min_roughness {
                decided.push(format!("material {material} ({name}, {roughness:.2}): path"));
                return None;
            }
            let table = BrdfTable::new(&lobe, params.basis, params.window, params.order as usize);
            decided.push(format!(
                "material {material} ({name}, {roughness:.2}): order {}, leaves out {:.1} %",
                table.order,
                100.0 * table.left_out
            ));
            Some(table)
        };
        let tables = (0..scene.material_count()).map(&mut table).collect();
        Surfaces { tables, decided }
    }

    /// The table of a material.
    pub fn table(&self, material: usize) -> Option<&BrdfTable> {
        self.tables[material].as_ref()
    }

    /// All tables, with their materials.
    pub fn tables(&self) -> impl Iterator<Item = (usize, &BrdfTable)> {
        self.tables.iter().enumerate().filter_map(|(k, t)| Some((k, t.as_ref()?)))
    }

    /// The order of the radiance records: the largest order of all tables; 0 without tables.
    pub fn order(&self) -> usize {
        self.tables().map(|(_, t)| t.order).max().unwrap_or(0)
    }

    /// The source of the indirect light at a vertex. If one glossy lobe is too sharp for a table, the path continues
    /// over all glossy lobes of the vertex.
    #[inline]
    pub fn rule(&self, v: &EyeVertex) -> Rule {
        let part = v.bsdf.diffuse_part(v.wo);
        let mut n = part.map(|p| p.normal);
        let (mut glossy, mut whole) = (false, true);
        for lobe in v.bsdf.lobes() {
            let normal = *n.get_or_insert(lobe.frame.n);
            whole &= normal == lobe.frame.n;
            if lobe.kind == Kind::Glossy {
                glossy = true;
                whole &= self.table(lobe.material).is_some();
            }
        }
        match (n, part) {
            (Some(n), _) if glossy && whole && n.dot(v.wo) > 0.0 => Rule::Glossy { part, n },
            (_, Some(part)) => Rule::Diffuse(part),
            _ => Rule::Path,
        }
    }

    /// The frame of the tables: z is the normal, and the outgoing direction lies in the plane of x and z.
    pub fn frame(n: Vec3, wo: Vec3) -> Frame {
        Frame::from_normal_tangent(n, wo)
    }

    /// The sum of `of` over the glossy lobes of a vertex, times their tints; `of` gets a lobe's table and the cosine of
    /// the outgoing direction.
    #[inline]
    pub fn sum_lobes(&self, v: &EyeVertex, of: impl Fn(&BrdfTable, f32) -> Rgb) -> Rgb {
        let lobes = v.bsdf.lobes().filter(|lobe| lobe.kind == Kind::Glossy);
        lobes
            .filter_map(|lobe| {
                Some(lobe.tint * of(self.table(lobe.material)?, lobe.frame.n.dot(v.wo)))
            })
            .sum()
    }
}
