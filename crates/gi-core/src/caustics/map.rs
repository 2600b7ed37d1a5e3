//! The photons of focused light, with one grid for each search radius.

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use super::grid::{Grid, corner_of};
use crate::rng::{hash_u32, hash_words};
use crate::sampler::Sampler;
use crate::scene::Scene;
use crate::walk::{LightWalk, Photon, Roulette, walk_in_order};

/// Number of radii to choose from. Each is half as large as the one before.
pub(super) const LEVELS: usize = 7;
/// Photons on surfaces whose normals have a smaller cosine than this belong to another surface. Caustics have sharp
/// edges, so the limit is tight enough to keep them on one side of an edge, and wide enough for the facets of a curved
/// mesh.
pub(super) const SAME_SURFACE: f32 = 0.7;
/// So do photons farther from the tangent plane than this fraction of the radius.
const HEIGHT: f32 = 0.5;
/// Paths per task. The photons of all tasks are joined in order.
const CHUNK: u32 = 1024;
/// Most delta lobes that a path follows.
const MOST_MET: u32 = 64;
/// A cell with more photons than this is searched in the finer grid, unless the ball contains all of it.
const MANY: usize = 32;
/// About this many photons of a cell are examined. If it has more, one in every few is taken.
const MOST: usize = 128;
/// Factor on the squared radius, against rounding where a ball only just reaches a cell.
const SLACK: f32 = 1.001;

/// The search radius of a level.
pub(super) fn radius(largest: f32, level: usize) -> f32 {
    largest * 0.5f32.powi(level as i32)
}

/// Which light paths to trace.
#[derive(Clone, Copy)]
pub(super) struct Paths {
    pub(super) seed: u32,
    /// Index of the first path.
    pub(super) first: u32,
    pub(super) count: u32,
}

/// Which photons to visit: those on the surface at `p`, within `radius`.
#[derive(Clone, Copy)]
pub(super) struct Query {
    /// The level whose grid is searched.
    pub(super) level: usize,
    pub(super) p: Vec3,
    /// Unit geometric normal at `p`.
    pub(super) n: Vec3,
    /// At most the radius of the level, world units.
    pub(super) radius: f32,
    /// Varies which photons of a crowded cell are visited.
    pub(super) salt: u32,
}

/// The ball of a [`Query`].
#[derive(Clone, Copy)]
struct Ball {
    center: Vec3,
    radius: f32,
    /// The salt of the query, mixed with its position.
    salt: u32,
}

/// The photons of one set of paths.
#[derive(Default)]
pub(super) struct Map {
    pub(super) photons: Vec<Photon>,
    /// By level.
    grids: Vec<Grid>,
}

impl Map {
    /// Trace paths toward the surfaces that focus light, and store their photons. `largest` is the radius of level 0.
    pub(super) fn shoot(scene: &Scene, paths: Paths, largest: f32) -> Self {
        let targets = scene.focusing();
        let Paths { seed, first, count } = paths;
        let chunks = walk_in_order(count, CHUNK, |path, photons| {
            let sampler = Sampler::new(seed, 0, first.wrapping_add(path));
            if let Some(walk) = LightWalk::begin_toward(scene, sampler, &targets) {
                leave_photons(walk, count as f32, photons);
            }
        });
        let photons = chunks.concat();
        let grid = |level| Grid::new(photons.iter().map(|q| q.p), 2.0 * radius(largest, level));
        Map { grids: (0..LEVELS).into_par_iter().map(grid).collect(), photons }
    }

    /// An upper bound for the number of photons within the radius of a level.
    pub(super) fn count_near(&self, level: usize, p: Vec3) -> usize {
        let Some(grid) = self.grids.get(level) else { return 0 };
        grid.near(p).map(|cell| grid.members(cell).len()).sum()
    }

    /// Call `take` with each photon of the query and its weight, until `take` returns `false`. Only some photons of a
    /// crowded cell are taken; the weight is the number of photons that each of them stands for.
    pub(super) fn for_each(&self, query: Query, mut take: impl FnMut(&Photon, u32) -> bool) {
        let Query { level, p, n, radius: r, salt } = query;
        let salt = hash_words(&p.to_array().map(f32::to_bits)) ^ salt;
        let ball = Ball { center: p, radius: r, salt };
        let mut on_disc = |photon: &Photon, weight: u32| {
            let d = photon.p - p;
            let near = d.length_squared() < r * r
                && d.dot(n).abs() < HEIGHT * r
                && photon.n.dot(n).abs() > SAME_SURFACE;
            !near || take(photon, weight)
        };
        if let Some(grid) = self.grids.get(level) {
            grid.near(p).all(|cell| self.visit(level, cell, ball, &mut on_disc));
        }
    }

    /// Call `take` with the photons of a cell that are in the ball, until `take` returns `false`. A crowded cell is
    /// searched in the finer grid, where only the cells that the ball reaches are visited. If it is entirely inside the
    /// ball, a subset of its photons is taken instead. Returns whether all calls returned `true`.
    fn visit(
        &self,
        level: usize,
        cell: IVec3,
        ball: Ball,
        take: &mut impl FnMut(&Photon, u32) -> bool,
    ) -> bool {
        let grid = &self.grids[level];
        let members = grid.members(cell);
        let Ball { center, radius: r, salt } = ball;
        let middle = (cell.as_vec3() + 0.5) * grid.cell;
        let farthest = (middle - center).abs() + 0.5 * grid.cell;
        let is_inside = farthest.length_squared() <= r * r;
        if members.len() > MANY && level + 1 < LEVELS && !is_inside {
            let size = self.grids[level + 1].cell;
            return (0..8).all(|corner| {
                let child = cell * 2 + corner_of(corner);
                let low = child.as_vec3() * size;
                let nearest = center.clamp(low, low + size);
                let reaches = nearest.distance_squared(center) <= r * r * SLACK;
                !reaches || self.visit(level + 1, child, ball, take)
            });
        }
        let step = members.len().div_ceil(MOST);
        let first = (hash_u32(salt ^ grid.bucket(cell)) as usize) % step.max(1);
        members.iter().skip(first).step_by(step.max(1)).all(|&k| {
            let photon = &self.photons[k as usize];
            let near = photon.p.distance_squared(center) < r * r;
            !near || grid.cell_of(photon.p) != cell || take(photon, step as u32)
        })
    }
}

/// Follow a path over delta lobes, and store a photon at each surface that also has other lobes.
fn leave_photons(mut walk: LightWalk, paths: f32, photons: &mut Vec<Photon>) {
    while let Some(vertex) = &walk.next_vertex() {
        if vertex.non_delta > 0 || vertex.depth >= MOST_MET {
            return;
        }
        if !vertex.bsdf.is_delta() && vertex.depth > 0 {
            photons.push(Photon::at(vertex, paths));
        }
        if !walk.scatter(vertex, Roulette::ByAlbedo { from: 4 }) || walk.non_delta() > 0 {
            return;
        }
    }
}
