//! `sdfgrid`: the surface where a grid of signed distances is zero, as a mesh.
//!
//! Values stand at the corners of cells that fill the unit cube, and are interpolated trilinearly within a cell. A cell
//! whose corners differ in sign is divided into small cubes, each into six tetrahedra, and each of these is cut by a
//! plane. The shading normals are those of Mitsuba's `smooth`: gradients of the eight nearest cells, blended
//! trilinearly \[Hansson22\].

use std::collections::HashMap;

use gi_core::geometry::Mesh;
use gi_core::medium::Cells;
use glam::{DAffine3, DVec3, Vec3};

use super::place::place;
use crate::budget::Claim;
use crate::builder::Builder;
use crate::document::Node;

/// Number of small cubes along an edge of a cell. With three, the mean of a picture differs from Mitsuba's by 0.1 % at most.
const PARTS: usize = 3;
/// Iterations of false position that find where an edge meets the surface.
const STEPS: usize = 4;

/// The corners of the six tetrahedra of a cube, which share its diagonal: bit k of a corner is its coordinate on axis k.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]];

impl Builder<'_> {
    /// The mesh of an `sdfgrid`; `None` if an error was reported.
    pub(super) fn surface_of_distances(
        &mut self,
        node: Node<'_>,
        to_world: &DAffine3,
    ) -> Option<Mesh> {
        node.warn("`sdfgrid` is approximated by a mesh");
        if node.text_opt("normals").is_some_and(|n| n != "smooth") {
            node.warn("`normals` is ignored: they are `smooth`");
        }
        let file = self.assets.volume(node.id)?;
        let values = match &file.cells {
            Cells::Grey(values) => values,
            Cells::Color(_) => {
                node.error("the distances have three channels", "expected one");
                return None;
            }
        };
        let Some(grid) = Distances::new(file.size, values) else {
            node.error(
                "the grid of distances is flat",
                "expected two or more points along each axis",
            );
            return None;
        };
        let mut claim = node.report.budget.claim("the surfaces of `sdfgrid`");
        let made = grid.mesh(&mut claim).and_then(|mut mesh| {
            let vertices = 2 * size_of_val(&mesh.positions[..]);
            claim.keep((vertices + size_of_val(&mesh.triangles[..])) as u64)?;
            place(&mut mesh, to_world, DVec3::ZERO);
            Ok(mesh)
        });
        made.map_err(|why| node.error(format!("`sdfgrid` cannot become a mesh: {why}"), "")).ok()
    }
}

/// Signed distances at the points of a grid; x varies fastest.
struct Distances<'a> {
    size: [usize; 3],
    values: &'a [f32],
}

impl<'a> Distances<'a> {
    /// `None` if an axis has fewer than two points.
    fn new(size: [usize; 3], values: &'a [f32]) -> Option<Self> {
        let fits = size.iter().all(|n| *n >= 2) && size.iter().product::<usize>() == values.len();
        fits.then_some(Distances { size, values })
    }

    /// Number of cells along each axis.
    fn cells(&self) -> [usize; 3] {
        self.size.map(|n| n - 1)
    }

    /// The values at the corners of a cell.
    fn corners(&self, cell: [usize; 3]) -> [f32; 8] {
        let [w, h, _] = self.size;
        std::array::from_fn(|k| {
            let [x, y, z] = [0, 1, 2].map(|axis| cell[axis] + (k >> axis & 1));
            self.values[(z * h + y) * w + x]
        })
    }

    /// The gradient at a point, in coordinates of the grid: that of the eight nearest cells, blended trilinearly.
    fn normal(&self, p: Vec3) -> Vec3 {
        let from_centres = p - 0.5;
        let low = from_centres.floor();
        let share = from_centres - low;
        let mut sum = Vec3::ZERO;
        for k in 0..8 {
            let mut weight = 1.0;
            let cell = [0, 1, 2].map(|axis| {
                let upper = k >> axis & 1;
                weight *= if upper == 1 { share[axis] } else { 1.0 - share[axis] };
                let most = self.cells()[axis] - 1;
                (low[axis] + upper as f32).clamp(0.0, most as f32) as usize
            });
            let inside = p - Vec3::from_array(cell.map(|i| i as f32));
            sum += weight * gradient(&self.corners(cell), inside).normalize_or_zero();
        }
        sum.try_normalize().unwrap_or(Vec3::Z)
    }

    /// The surface in the unit cube. Counts its memory while it grows.
    ///
    /// # Errors
    /// It takes more memory than the scene may take.
    fn mesh(&self, claim: &mut Claim<'_>) -> Result<Mesh, String> {
        let mut surface = Surface::default();
        let [nx, ny, nz] = self.cells();
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let corners = self.corners([x, y, z]);
                    let inside = corners.iter().filter(|v| **v < 0.0).count();
                    if (1..8).contains(&inside) {
                        surface.add_cell(&corners, [x, y, z]);
                        claim.at_least(surface.bytes())?;
                    }
                }
            }
        }
        let scale = Vec3::from_array(self.cells().map(|n| 1.0 / n as f32));
        let stretched = |n: Vec3| (n / scale).try_normalize().unwrap_or(Vec3::Z);
        let normals = surface.positions.iter().map(|p| stretched(self.normal(*p))).collect();
        let positions = surface.positions.iter().map(|p| *p * scale).collect();
        Ok(Mesh { positions, normals, triangles: surface.triangles.into(), ..Mesh::default() })
    }
}

/// The trilinear interpolation of the values at the corners of a cell.
fn value(corners: &[f32; 8], p: Vec3) -> f32 {
    // Exact at both ends, so that cells agree on their common faces.
    let along = |a: f32, b: f32, t: f32| a * (1.0 - t) + b * t;
    let row = |k: usize| along(corners[k], corners[k + 1], p.x);
    along(along(row(0), row(2), p.y), along(row(4), row(6), p.y), p.z)
}

/// Its gradient.
fn gradient(corners: &[f32; 8], p: Vec3) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for (k, v) in corners.iter().enumerate() {
        let upper = [0, 1, 2].map(|axis| k >> axis & 1 == 1);
        let weight = |axis: usize| if upper[axis] { p[axis] } else { 1.0 - p[axis] };
        let sign = |axis: usize| if upper[axis] { 1.0 } else { -1.0 };
        sum += *v
            * Vec3::new(
                sign(0) * weight(1) * weight(2),
                weight(0) * sign(1) * weight(2),
                weight(0) * weight(1) * sign(2),
            );
    }
    sum
}

/// A mesh while it grows, in coordinates of the grid.
#[derive(Default)]
struct Surface {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// Index of the mesh vertex on an edge of a small cube. The key holds the two ends of the edge.
    on_edge: HashMap<[[usize; 3]; 2], u32>,
}

/// A corner of a small cube: its place in the grid of small cubes, and its value.
#[derive(Clone, Copy)]
struct Corner {
    place: [usize; 3],
    value: f32,
}

/// Whether the last three corners turn counter-clockwise, seen from the side that the first is not on.
fn is_positive(corners: [Corner; 4]) -> bool {
    let [a, b, c, d] = corners.map(|c| Vec3::from_array(c.place.map(|i| i as f32)));
    (b - a).cross(c - a).dot(d - a) > 0.0
}

impl Surface {
    /// Memory in bytes: the maps of edges take about 80 per vertex.
    fn bytes(&self) -> u64 {
        (self.positions.len() * (2 * size_of::<Vec3>() + 80) + size_of_val(&self.triangles[..]))
            as u64
    }

    fn add_cell(&mut self, corners: &[f32; 8], cell: [usize; 3]) {
        let first = cell.map(|i| i * PARTS);
        for k in 0..PARTS.pow(3) {
            let part = [k % PARTS, k / PARTS % PARTS, k / PARTS / PARTS];
            let cube: [Corner; 8] = std::array::from_fn(|k| {
                let step = [0, 1, 2].map(|axis| part[axis] + (k >> axis & 1));
                let p = Vec3::from_array(step.map(|i| i as f32 / PARTS as f32));
                let place = [0, 1, 2].map(|axis| first[axis] + step[axis]);
                Corner { place, value: value(corners, p) }
            });
            for corners_of in TETRAHEDRA {
                self.add_tetrahedron(corners_of.map(|k| cube[k]), corners, cell);
            }
        }
    }

    /// Cut a tetrahedron: into a triangle if one corner is apart from the others, into two if they are two and two.
    fn add_tetrahedron(&mut self, all: [Corner; 4], corners: &[f32; 8], cell: [usize; 3]) {
        let (inside, outside): (Vec<Corner>, Vec<Corner>) =
            all.into_iter().partition(|c| c.value < 0.0);
        let mut cut = |a: Corner, b: Corner| self.vertex(a, b, corners, cell);
        let (cuts, faces_out): (Vec<u32>, bool) = match (&inside[..], &outside[..]) {
            ([a], [b, c, d]) | ([b, c, d], [a]) => {
                let is_inside = a.value < 0.0;
                let cuts = [b, c, d].map(|x| cut(*a, *x)).to_vec();
                (cuts, is_positive([*a, *b, *c, *d]) == is_inside)
            }
            ([a, b], [c, d]) => {
                let cuts = vec![cut(*a, *c), cut(*a, *d), cut(*b, *d), cut(*b, *c)];
                (cuts, is_positive([*a, *b, *c, *d]))
            }
            _ => return,
        };
        for k in 2..cuts.len() {
            let [a, b, c] = [cuts[0], cuts[k - 1], cuts[k]];
            self.triangles.push(if faces_out { [a, b, c] } else { [a, c, b] });
        }
    }

    /// The vertex where the surface cuts the edge from `a` to `b`, within a cell.
    fn vertex(&mut self, a: Corner, b: Corner, corners: &[f32; 8], cell: [usize; 3]) -> u32 {
        // From the same end in every cell, so that cells agree.
        let (a, b) = if a.place <= b.place { (a, b) } else { (b, a) };
        let key = [a.place, b.place];
        if let Some(index) = self.on_edge.get(&key) {
            return *index;
        }
        let base = Vec3::from_array(cell.map(|i| i as f32));
        let at = |c: Corner| Vec3::from_array(c.place.map(|i| i as f32 / PARTS as f32));
        let (from, along) = (at(a), at(b) - at(a));
        let (mut low, mut high) = ((0.0, a.value), (1.0, b.value));
        let mut t = 0.0;
        for _ in 0..STEPS {
            t = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
            let v = value(corners, from + along * t - base);
            if (v < 0.0) == (low.1 < 0.0) { low = (t, v) } else { high = (t, v) }
        }
        let index = self.positions.len() as u32;
        self.positions.push(from + along * t);
        self.on_edge.insert(key, index);
        index
    }
}

#[cfg(test)]
mod tests;
