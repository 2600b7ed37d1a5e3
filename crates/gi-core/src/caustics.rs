//! Light that mirrors and glass focus onto a surface: photons, stored where light paths first meet a surface that scatters
//! otherwise. Neither virtual lights nor paths from the eye find this light well: behind glass a small lamp is met by luck
//! only, as single bright pixels.
//!
//! | | |
//! |---|---|
//! | estimated | sum of f power / (pi r^2 share) over the photons of a pass within r of the point that it sees, which sees `share` of the disc |
//! | radius | the smallest of a few steps whose disc held 8 photons of a pilot map; it shrinks with the passes \[Knaus11\] |
//! | bias | blur over the disc; none in the limit of many passes |

use std::f32::consts::PI;

use crate::disc::Disc;
use crate::math::Rgb;
use crate::rng::{Pcg, hash_u32, hash_words};
use crate::sampler::Sampler;
use crate::scene::Scene;
use crate::walk::{LightWalk, Photon, Roulette, focused, walk_in_order};
use glam::{IVec3, Vec3};
use rayon::prelude::*;

use crate::bsdf::Bsdf;
use crate::eye::{Covers, Estimate, EyeVertex, PathLimits};
use crate::geometry::Surface;

/// Width of the narrowest lobe that scatters photons: in a narrower one a single photon may be far too bright.
const MIN_ROUGHNESS: f32 = 0.1;
/// Radii that are tried, each half as large as the one before.
const LEVELS: usize = 7;
/// The largest radius, as a fraction of the scene's.
const LARGEST: f32 = 0.03;
/// Photons that a disc of the pilot's must hold.
const WANTED: u32 = 8;
/// A radius shrinks as this power of the number of passes, its area as the power -1/3 \[Knaus11\].
const SHRINK: f32 = -1.0 / 6.0;
/// Photons on surfaces that are inclined by more than this cosine belong to another surface.
const SAME_SURFACE: f32 = 0.7;
/// Photons farther from the tangent plane than this fraction of the radius do, too.
const HEIGHT: f32 = 0.5;
/// Paths that one task walks; their photons are joined in order.
const CHUNK: u32 = 1024;
/// Delta lobes that a path follows at most.
const MOST_MET: u32 = 64;
/// What keeps the numbers of these paths apart from those of others.
const SALT: u32 = 0x666f_6373;

/// The photons of one set of paths, in a grid for each radius.
#[derive(Default)]
struct Map {
    photons: Vec<Photon>,
    grids: Vec<Grid>,
}

/// Focused light: a pilot's photons, which set the radii, and those of a pass.
#[derive(Default)]
pub struct FocusedLight {
    pilot: Map,
    map: Map,
    /// Paths of a pass; 0 where nothing focuses light.
    paths: u32,
    /// The largest radius, world units.
    largest: f32,
    /// By how much the radii of this pass have shrunk.
    shrink: f32,
}

impl FocusedLight {
    /// Shoot the pilot. `pixels` of the picture determine the number of paths; without pixels there are none.
    pub fn new(scene: &Scene, seed: u32, pixels: usize) -> Self {
        if pixels == 0 || scene.focusing().is_empty() {
            return FocusedLight::default();
        }
        let paths = pixels.clamp(1 << 14, 1 << 20) as u32;
        let largest = LARGEST * scene.radius();
        let pilot = Map::shoot(scene, seed ^ SALT ^ 0x0070_696c, (0, paths), largest);
        let paths = if pilot.photons.is_empty() { 0 } else { paths };
        FocusedLight { pilot, map: Map::default(), paths, largest, shrink: 1.0 }
    }

    /// Whether there is such light.
    pub fn is_some(&self) -> bool {
        self.paths > 0
    }

    /// Photons of this pass.
    pub fn photons(&self) -> usize {
        self.map.photons.len()
    }

    /// Mean radius over the pilot's photons, as it has shrunk in this pass, world units: how far the light is blurred.
    pub fn mean_radius(&self) -> f64 {
        let of = |q: &Photon| f64::from(radius(self.largest, self.level(q.p, q.n)));
        // Some of the photons will do.
        let some = self.pilot.photons.iter().step_by(1 + self.pilot.photons.len() / 1024);
        let (sum, count) = some.fold((0.0, 0u32), |(sum, n), q| (sum + of(q), n + 1));
        f64::from(self.shrink) * sum / f64::from(count.max(1))
    }

    /// What the maps occupy.
    pub fn memory_bytes(&self) -> usize {
        [&self.pilot, &self.map].map(|m| size_of_val(&m.photons[..])).iter().sum()
    }

    /// Shoot the photons of a pass.
    pub fn shoot(&mut self, scene: &Scene, seed: u32, pass: u32) {
        if self.is_some() {
            let which = (pass.wrapping_mul(self.paths), self.paths);
            self.map = Map::shoot(scene, seed ^ SALT, which, self.largest);
            self.shrink = (pass as f32 + 1.0).powf(SHRINK);
        }
    }

    /// Radiance toward the eye of focused light at a point. Only photons of at most `deepest` scatterings count. `None` where
    /// nothing focuses light.
    pub fn radiance(
        &self,
        scene: &Scene,
        (surface, wo, bsdf): (&Surface, Vec3, &Bsdf),
        deepest: u32,
    ) -> Option<Rgb> {
        if !self.is_some() {
            return None;
        }
        let (p, n) = (surface.p, surface.ng);
        let level = self.level(p, n);
        let r = radius(self.largest, level) * self.shrink;
        let sum_where = |counts: &dyn Fn(&Photon) -> bool| {
            let (mut sum, mut farthest) = (Rgb::BLACK, (0.0, p));
            self.map.for_each(level, (p, n), r, self.shrink.to_bits(), |photon, weight| {
                if photon.segments <= deepest.saturating_add(1) && counts(photon) {
                    sum += bsdf.f(wo, photon.wi) * photon.power * weight as f32;
                    let d = photon.p.distance_squared(p);
                    farthest = if d > farthest.0 { (d, photon.p) } else { farthest };
                }
                true
            });
            (sum, farthest.1)
        };
        let (all, farthest) = sum_where(&|_| true);
        if all.is_black() {
            return Some(all);
        }
        // Walls in the disc, and edges.
        let side = 1f32.copysign(wo.dot(n));
        let disc = |side: f32| Disc::new(scene, p, n * side, r, SAME_SURFACE);
        let mut rng = numbers(p, self.shrink);
        let inverse_share = disc(side).inverse_share(|| [rng.next_f32(), rng.next_f32()]);
        let is_clear = inverse_share == 1.0 && disc(side).sees(farthest);
        let seen = if is_clear {
            all
        } else {
            let sides = [1.0, -1.0].map(|side| disc(side).lowered());
            sum_where(&|q| sides[usize::from(q.wi.dot(n) < 0.0)].sees(q.p)).0
        };
        Some(seen * (inverse_share / (PI * r * r)))
    }

    /// The same where light that paths from the eye find badly is more than a trace; nothing elsewhere.
    pub fn where_it_matters(scene: &Scene, seed: u32, pixels: usize) -> Self {
        let matters = pixels > 0 && focused(scene, seed).matters();
        Self::new(scene, seed, if matters { pixels } else { 0 })
    }

    /// Add focused light to the estimate of a cache at a vertex. Without an estimate the path continues for all other light.
    /// Lobes of a roughness below 0.1 are left to paths.
    pub fn add_to(
        &self,
        estimate: Option<Estimate>,
        scene: &Scene,
        v: &EyeVertex,
        limits: &PathLimits,
    ) -> Option<Estimate> {
        let deepest = match limits.max_depth {
            None => u32::MAX,
            Some(most) => most.saturating_sub(v.segments + 1),
        };
        let radiance = |bsdf: &Bsdf| self.radiance(scene, (&v.surface, v.wo, bsdf), deepest);
        match estimate {
            _ if !self.is_some() => estimate,
            // Nothing else accounts for narrow lobes here.
            Some(_) if v.bsdf.is_sharp(MIN_ROUGHNESS) => estimate,
            Some(known) => Some(Estimate { caustic: radiance(&v.bsdf), ..known }),
            None => {
                let caustic = radiance(&v.bsdf.broad(v.wo, MIN_ROUGHNESS)?);
                // The geometry term is clamped to 0: light from other surfaces is not covered.
                let covers = Covers::Visible { max_geometry: 0.0, min_roughness: MIN_ROUGHNESS };
                Some(Estimate { covers, direct: None, indirect: Rgb::BLACK, caustic })
            }
        }
    }

    /// The step of the radius at a point: a fixed function of the position, so that it does not depend on the photons that
    /// are counted.
    fn level(&self, p: Vec3, n: Vec3) -> usize {
        // Finer grids hold less round the point: where a grid holds too little, finer ones need not be asked.
        let may_hold = |&level: &usize| self.pilot.count_near(level, p) >= WANTED as usize;
        let finest = (0..LEVELS).take_while(may_hold).count();
        let holds_enough = |&level: &usize| {
            let mut found = 0;
            self.pilot.for_each(level, (p, n), radius(self.largest, level), 0, |_, weight| {
                found += weight;
                found < WANTED
            });
            found >= WANTED
        };
        (1..finest).rev().find(holds_enough).unwrap_or(0)
    }
}

/// Random numbers of a point and a pass.
fn numbers(p: Vec3, pass: f32) -> Pcg {
    let [x, y, z] = p.to_array().map(|c| u64::from(c.to_bits()));
    Pcg::new(x << 32 | y, z << 32 | u64::from(pass.to_bits()))
}

fn radius(largest: f32, level: usize) -> f32 {
    largest * 0.5f32.powi(level as i32)
}

impl Map {
    fn shoot(scene: &Scene, seed: u32, (first, paths): (u32, u32), largest: f32) -> Self {
        let targets = scene.focusing();
        let chunks = walk_in_order(paths, CHUNK, |path, photons| {
            let sampler = Sampler::new(seed, 0, first.wrapping_add(path));
            if let Some(walk) = LightWalk::begin_toward(scene, sampler, &targets) {
                leave_photons(walk, paths as f32, photons);
            }
        });
        let photons = chunks.concat();
        let grid = |level| Grid::new(&photons, 2.0 * radius(largest, level));
        Map { grids: (0..LEVELS).into_par_iter().map(grid).collect(), photons }
    }

    /// At most how many photons lie within the radius of a level.
    fn count_near(&self, level: usize, p: Vec3) -> usize {
        let Some(grid) = self.grids.get(level) else { return 0 };
        grid.near(p).map(|cell| grid.members(cell).len()).sum()
    }

    /// Call `take` with every photon on the surface within `r` of a point, until it returns `false`. `r` is at most the
    /// radius of the level. Of cells that hold very many only some are taken, each for as many as its number says; `salt`
    /// varies which.
    fn for_each(
        &self,
        level: usize,
        (p, n): (Vec3, Vec3),
        r: f32,
        salt: u32,
        mut take: impl FnMut(&Photon, u32) -> bool,
    ) {
        let salt = hash_words(&p.to_array().map(f32::to_bits)) ^ salt;
        let mut on_disc = |photon: &Photon, weight: u32| {
            let d = photon.p - p;
            let near = d.length_squared() < r * r
                && d.dot(n).abs() < HEIGHT * r
                && photon.n.dot(n).abs() > SAME_SURFACE;
            !near || take(photon, weight)
        };
        if let Some(grid) = self.grids.get(level) {
            grid.near(p).all(|cell| self.visit(level, cell, (p, r, salt), &mut on_disc));
        }
    }

    /// Call `take` with the photons of a cell, until it returns `false`; where they are many, only of those finer cells that
    /// the ball reaches, and few of a cell that it holds. Returns whether it went through.
    fn visit(
        &self,
        level: usize,
        cell: IVec3,
        ball: (Vec3, f32, u32),
        take: &mut impl FnMut(&Photon, u32) -> bool,
    ) -> bool {
        let grid = &self.grids[level];
        let members = grid.members(cell);
        let (middle, r) = ((cell.as_vec3() + 0.5) * grid.cell, ball.1);
        let farthest = (middle - ball.0).abs() + 0.5 * grid.cell;
        let is_inside = farthest.length_squared() <= r * r;
        if members.len() > MANY && level + 1 < LEVELS && !is_inside {
            let size = self.grids[level + 1].cell;
            return (0..8).all(|corner| {
                let child = cell * 2 + corner_of(corner);
                let low = child.as_vec3() * size;
                let nearest = ball.0.clamp(low, low + size);
                let reaches = nearest.distance_squared(ball.0) <= ball.1 * ball.1 * SLACK;
                !reaches || self.visit(level + 1, child, ball, take)
            });
        }
        let step = members.len().div_ceil(MOST);
        let first = (hash_u32(ball.2 ^ grid.bucket(cell)) as usize) % step.max(1);
        members.iter().skip(first).step_by(step.max(1)).all(|&k| {
            let photon = &self.photons[k as usize];
            let near = photon.p.distance_squared(ball.0) < r * r;
            !near || grid.cell_of(photon.p) != cell || take(photon, step as u32)
        })
    }
}

/// Photons of a cell that are looked at one by one.
const MANY: usize = 32;
/// Photons of a cell that are looked at: of more, one in every so many.
const MOST: usize = 128;
/// Against rounding where a ball only just reaches a cell.
const SLACK: f32 = 1.001;

/// The cell at a corner of two by two by two.
fn corner_of(corner: i32) -> IVec3 {
    IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2)
}

/// Follow a path over delta lobes, and leave a photon wherever it meets a surface that has others too.
fn leave_photons(mut walk: LightWalk, paths: f32, photons: &mut Vec<Photon>) {
    while let Some(vertex) = walk.next_vertex() {
        if vertex.non_delta > 0 || vertex.depth >= MOST_MET {
            return;
        }
        if !vertex.bsdf.is_delta() && vertex.depth > 0 {
            photons.push(Photon::at(&vertex, paths));
        }
        if !walk.scatter(&vertex, Roulette::ByAlbedo { from: 4 }) || walk.non_delta() > 0 {
            return;
        }
    }
}

/// Photons by the cell that they lie in, hashed.
struct Grid {
    cell: f32,
    /// Where each bucket's photons begin in `order`.
    starts: Vec<u32>,
    order: Vec<u32>,
}

impl Grid {
    fn new(photons: &[Photon], cell: f32) -> Self {
        let buckets = photons.len().next_power_of_two();
        let mut grid = Grid { cell, starts: vec![0; buckets + 1], order: vec![0; photons.len()] };
        let of: Vec<u32> = photons.iter().map(|p| grid.bucket(grid.cell_of(p.p))).collect();
        of.iter().for_each(|&b| grid.starts[b as usize + 1] += 1);
        for b in 0..buckets {
            grid.starts[b + 1] += grid.starts[b];
        }
        let mut next = grid.starts.clone();
        for (k, &b) in of.iter().enumerate() {
            grid.order[next[b as usize] as usize] = k as u32;
            next[b as usize] += 1;
        }
        grid
    }

    fn cell_of(&self, p: Vec3) -> IVec3 {
        (p / self.cell).floor().as_ivec3()
    }

    fn bucket(&self, cell: IVec3) -> u32 {
        let [x, y, z] = cell.to_array().map(|k| k as u32);
        let hash =
            x.wrapping_mul(0x8da6_b343) ^ y.wrapping_mul(0xd816_3841) ^ z.wrapping_mul(0xcb1a_b31f);
        let mixed = (hash ^ hash >> 15).wrapping_mul(0x2c1b_3c6d);
        (mixed ^ mixed >> 12) & (self.starts.len() as u32 - 2)
    }

    /// The photons of a cell, and of others that share its bucket.
    fn members(&self, cell: IVec3) -> &[u32] {
        let bucket = self.bucket(cell) as usize;
        let [from, to] = [0, 1].map(|k| self.starts[bucket + k] as usize);
        &self.order[from..to]
    }

    /// The eight cells that hold what lies within half a cell of a point.
    fn near(&self, p: Vec3) -> impl Iterator<Item = IVec3> {
        let low = self.cell_of(p - Vec3::splat(0.5 * self.cell));
        (0..8).map(move |corner| low + corner_of(corner))
    }
}

#[cfg(test)]
mod tests;
