//! Focused light: caustics from mirrors and glass. Light paths trace photons through delta scatterings; each photon is
//! stored where the path first meets a surface with other lobes. Virtual lights and eye paths find this light badly:
//! paths reach a small lamp behind glass only by luck, which gives single bright pixels.
//!
//! | | |
//! |---|---|
//! | estimate | sum of f power / (pi r^2 share) over the photons of a pass within r of the point, where `share` is the fraction of the disc that the point sees |
//! | radius | the smallest of a few steps whose disc held at least 8 photons of a pilot map; it shrinks with the passes \[Knaus11\] |
//! | bias | blur over the disc; it vanishes in the limit of many passes |

mod grid;
mod map;

use std::f32::consts::PI;

use glam::Vec3;

use crate::bsdf::Bsdf;
use crate::disc::Disc;
use crate::eye::{Covers, Estimate, EyeVertex, PathLimits};
use crate::geometry::Surface;
use crate::math::Rgb;
use crate::rng::Pcg;
use crate::scene::Scene;
use crate::walk::{Photon, focused};
use map::{LEVELS, Map, Paths, Query, SAME_SURFACE, radius};

/// Photons are scattered only by lobes at least this wide: in a narrower one a single photon may be far too bright.
const MIN_ROUGHNESS: f32 = 0.1;
/// The largest radius, as a fraction of the scene's.
const LARGEST: f32 = 0.03;
/// Photons of the pilot that a disc must contain.
const WANTED: u32 = 8;
/// A radius shrinks as this power of the number of passes, its area as the power -1/3 \[Knaus11\].
const SHRINK: f32 = -1.0 / 6.0;
/// Separates the random numbers of these paths from those of others.
const SALT: u32 = 0x666f_6373;

/// Focused light: a pilot's photons, which set the radii, and those of a pass.
#[derive(Default)]
pub struct FocusedLight {
    pilot: Map,
    map: Map,
    /// Number of paths per pass; 0 if nothing focuses light.
    paths: u32,
    /// The largest radius, world units.
    largest: f32,
    /// Factor on the radii in this pass.
    shrink: f32,
}

impl FocusedLight {
    /// Trace the pilot. The number of paths depends on `pixels`, the size of the picture; 0 disables focused light.
    pub fn new(scene: &Scene, seed: u32, pixels: usize) -> Self {
        if pixels == 0 || scene.focusing().is_empty() {
            return FocusedLight::default();
        }
        let paths = pixels.clamp(1 << 14, 1 << 20) as u32;
        let largest = LARGEST * scene.radius();
        let of_pilot = Paths { seed: seed ^ SALT ^ 0x0070_696c, first: 0, count: paths };
        let pilot = Map::shoot(scene, of_pilot, largest);
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

    /// Mean radius in this pass over the pilot's photons, world units: the size of the blur.
    pub fn mean_radius(&self) -> f64 {
        let of = |q: &Photon| f64::from(radius(self.largest, self.level(q.p, q.n)));
        // A sample of the photons is enough.
        let some = self.pilot.photons.iter().step_by(1 + self.pilot.photons.len() / 1024);
        let (sum, count) = some.fold((0.0, 0u32), |(sum, n), q| (sum + of(q), n + 1));
        f64::from(self.shrink) * sum / f64::from(count.max(1))
    }

    /// Memory of the maps.
    pub fn memory_bytes(&self) -> usize {
        [&self.pilot, &self.map].map(|m| size_of_val(&m.photons[..])).iter().sum()
    }

    /// Trace the photons of a pass.
    pub fn shoot(&mut self, scene: &Scene, seed: u32, pass: u32) {
        if self.is_some() {
            let first = pass.wrapping_mul(self.paths);
            let paths = Paths { seed: seed ^ SALT, first, count: self.paths };
            self.map = Map::shoot(scene, paths, self.largest);
            self.shrink = (pass as f32 + 1.0).powf(SHRINK);
        }
    }

    /// Radiance of focused light that a point scatters toward `wo`. Only photons after at most `deepest` scatterings
    /// count. `None` if nothing focuses light.
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
        let query = Query { level, p, n, radius: r, salt: self.shrink.to_bits() };
        let sum_where = |counts: &dyn Fn(&Photon) -> bool| {
            let (mut sum, mut farthest) = (Rgb::BLACK, (0.0, p));
            self.map.for_each(query, |photon, weight| {
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
        // Account for walls in the disc, and for edges.
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

    /// The same, but empty unless paths from the eye would miss a noticeable amount of light.
    pub fn where_it_matters(scene: &Scene, seed: u32, pixels: usize) -> Self {
        let matters = pixels > 0 && focused(scene, seed).matters();
        Self::new(scene, seed, if matters { pixels } else { 0 })
    }

    /// Add focused light to the estimate of a cache at a vertex. Without an estimate the path continues for all other
    /// light. Lobes of a roughness below 0.1 are left to paths.
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
            // Here, only paths find the light in narrow lobes.
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

    /// The level of the radius at a point. It depends on the pilot only, not on the photons that are counted.
    fn level(&self, p: Vec3, n: Vec3) -> usize {
        // If a grid has too few photons near the point, finer grids do too.
        let may_hold = |&level: &usize| self.pilot.count_near(level, p) >= WANTED as usize;
        let finest = (0..LEVELS).take_while(may_hold).count();
        let holds_enough = |&level: &usize| {
            let mut found = 0;
            let query = Query { level, p, n, radius: radius(self.largest, level), salt: 0 };
            self.pilot.for_each(query, |_, weight| {
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

#[cfg(test)]
mod tests;
