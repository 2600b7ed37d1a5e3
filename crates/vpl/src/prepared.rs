//! A set of lights prepared for many points. A point is compared with many lights at a time, and the BSDFs of glossy
//! lights are computed once.

use std::ops::Range;

use gi_core::bsdf::Bsdf;
use gi_core::math::Rgb;
use gi_core::ray::{Ray, ShadowRays};
use gi_core::scene::Scene;
use glam::Vec3;

use crate::illuminate::{Connection, Receiver, connect, passing};
use crate::light::{Kind, Vpl, Vpls};

/// Lights prepared for many points.
pub struct Prepared<'v, 'a> {
    set: &'v Vpls,
    scene: &'a Scene,
    /// BSDFs of the glossy lights; empty if there are more than [`MOST_KEPT`].
    bsdfs: Vec<Option<Bsdf<'a>>>,
    /// Positions and normals, one column per coordinate. Lights that emit in all directions have a zero normal;
    /// parallel lights have a position far away.
    columns: [Vec<f32>; 6],
    /// Whether some lights are parallel.
    has_parallel: bool,
}

/// Largest number of glossy lights whose BSDFs are kept.
const MOST_KEPT: usize = 1 << 16;
/// Number of lights per batch.
const BATCH: usize = 64;

impl<'v, 'a> Prepared<'v, 'a> {
    /// Prepare a set.
    pub fn new(set: &'v Vpls, scene: &'a Scene) -> Self {
        let kept = if set.surfaces.len() <= MOST_KEPT { &set.surfaces[..] } else { &[] };
        let bsdfs: Vec<Option<Bsdf>> = kept.iter().map(|lit| lit.bsdf(scene)).collect();
        let opaque = |k: u32| bsdfs.get(k as usize)?.as_ref().and_then(Bsdf::opaque_normal);
        let far = 1e6 * scene.radius();
        let place = |v: &Vpl| match v.kind {
            Kind::Oriented => [v.p, v.n],
            Kind::Directional => [-v.n * far, Vec3::ZERO],
            Kind::Glossy(k) => [v.p, opaque(k).unwrap_or(Vec3::ZERO)],
            Kind::Omni | Kind::Spot(_) => [v.p, Vec3::ZERO],
        };
        let column = |k: usize| set.lights.iter().map(|v| place(v)[k / 3][k % 3]).collect();
        let columns = std::array::from_fn(column);
        let has_parallel = set.lights.iter().any(|v| v.kind == Kind::Directional);
        Prepared { set, scene, bsdfs, columns, has_parallel }
    }

    /// Connect a point with a range of the lights, and call `take` with the unshadowed contribution of each light that
    /// it sees, and the fraction that passes the shadow ray. Returns the number of shadow rays.
    #[inline]
    pub fn for_each_visible(
        &self,
        lights: Range<usize>,
        at: &Receiver,
        mut take: impl FnMut(Contribution, Rgb),
    ) -> u64 {
        let (mut sides, mut seen) = (Sides::default(), [(0, Rgb::BLACK); BATCH]);
        let mut facing = [0; BATCH];
        let rays_from = self.scene.tree().shadow_rays(at.p, at.ng);
        let mut rays = 0;
        for from in lights.clone().step_by(BATCH) {
            self.compare(from..lights.end.min(from + BATCH), at, &mut sides);
            let facing = sides.facing(&mut facing);
            // Trace the shadow rays of a batch first: caches stay warm, and occluded lights are not evaluated.
            let mut passed = 0;
            for &i in facing {
                let ray = self.shadow(from + i, at, &rays_from);
                let start = at.start_medium(self.scene, ray.d);
                let through = passing(self.scene, ray, self.set.lights[from + i].on, start);
                seen[passed] = (i, through);
                passed += usize::from(!through.is_black());
            }
            rays += facing.len() as u64;
            for &(i, through) in &seen[..passed] {
                let vpl = &self.set.lights[from + i];
                let contribution = match at.diffuse_f() {
                    Some(f) if vpl.kind == Kind::Oriented => sides.contribution(i, f, vpl, at),
                    _ => connect(self.scene, vpl, at, |k, d| self.scattered(k, d)).map(Into::into),
                };
                if let Some(contribution) = contribution {
                    take(contribution, through);
                }
            }
        }
        rays
    }

    /// The shadow ray from a point to light `k`. It reads only the columns of the positions, which stay in the cache.
    #[inline]
    fn shadow(&self, k: usize, at: &Receiver, rays_from: &ShadowRays) -> Ray {
        if self.has_parallel && self.set.lights[k].kind == Kind::Directional {
            return at.ray_along(self.scene, -self.set.lights[k].n);
        }
        let [x, y, z] = [0, 1, 2].map(|c| self.columns[c][k]);
        rays_from.to(Vec3::new(x, y, z))
    }

    /// Connect a point with light `k`, as if the power of the light were one in every channel.
    #[inline]
    pub fn connect_unit(&self, k: usize, at: &Receiver) -> Option<Connection> {
        let vpl = Vpl { power: Rgb::WHITE, ..self.set.lights[k] };
        connect(self.scene, &vpl, at, |k, d| self.scattered(k, d))
    }

    /// The lights.
    pub fn set(&self) -> &'v Vpls {
        self.set
    }

    /// Compare the point with a batch of lights. The loop has no branches, so that the compiler can vectorise it.
    #[inline]
    fn compare(&self, lights: Range<usize>, at: &Receiver, sides: &mut Sides) {
        let n = at.normal.unwrap_or(Vec3::ZERO);
        // Without a normal no light is below the surface.
        let least = if n == Vec3::ZERO { 0.0 } else { f32::MIN_POSITIVE };
        let (p, ng) = (at.p, at.ng);
        let column = |k: usize| &self.columns[k][lights.clone()];
        let (px, py, pz) = (column(0), column(1), column(2));
        let (nx, ny, nz) = (column(3), column(4), column(5));
        sides.count = lights.len();
        for i in 0..lights.len().min(BATCH) {
            let (x, y, z) = (px[i] - p.x, py[i] - p.y, pz[i] - p.z);
            let inverse_sq = 1.0 / (x * x + y * y + z * z);
            let at_light = x * nx[i] + y * ny[i] + z * nz[i];
            let at_point = x * n.x + y * n.y + z * n.z;
            sides.facing[i] = (at_light <= 0.0) & (at_point >= least);
            sides.light[i] = -at_light * inverse_sq;
            sides.point[i] = at_point * inverse_sq;
            sides.ground[i] = (x * ng.x + y * ng.y + z * ng.z).abs() * inverse_sq;
        }
    }

    /// Fraction of the arriving power, per solid angle, that a glossy light scatters toward `d`.
    #[inline]
    fn scattered(&self, k: u32, d: Vec3) -> Rgb {
        let Some(bsdf) = self.bsdfs.get(k as usize) else {
            return self.set.scattered(self.scene, k, d);
        };
        let lit = &self.set.surfaces[k as usize];
        bsdf.as_ref().map_or(Rgb::BLACK, |bsdf| bsdf.f_cos(lit.wo, d))
    }
}

/// The unshadowed light from one virtual light.
#[derive(Clone, Copy, Debug)]
pub struct Contribution {
    /// Radiance toward the eye, with the geometry term not clamped.
    pub radiance: Rgb,
    /// [`Connection::geometry`].
    pub geometry: f32,
}

impl From<Connection> for Contribution {
    fn from(Connection { radiance, geometry, .. }: Connection) -> Self {
        Contribution { radiance, geometry }
    }
}

/// A point compared with a batch of lights. Each cosine is divided by the distance d between the two, so that the product
/// of two of them is a geometry term cos cos' / d^2.
struct Sides {
    /// Number of lights.
    count: usize,
    /// Whether the light faces the point and the point faces the light.
    facing: [bool; BATCH],
    /// Cosine at the light.
    light: [f32; BATCH],
    /// Cosine with the point's shading normal, if light from below does not count.
    point: [f32; BATCH],
    /// Absolute cosine with the point's geometric normal.
    ground: [f32; BATCH],
}

impl Default for Sides {
    fn default() -> Self {
        let column = [0.0; BATCH];
        Sides { count: 0, facing: [false; BATCH], light: column, point: column, ground: column }
    }
}

impl Sides {
    /// The lights that face the point and that the point faces.
    #[inline]
    fn facing<'f>(&self, found: &'f mut [usize; BATCH]) -> &'f [usize] {
        let mut count = 0;
        for (i, &facing) in self.facing[..self.count].iter().enumerate() {
            found[count] = i;
            count += usize::from(facing);
        }
        &found[..count]
    }

    /// Light from the diffuse light `i` at a diffuse point with the constant BSDF `f`.
    #[inline]
    fn contribution(&self, i: usize, f: Rgb, vpl: &Vpl, at: &Receiver) -> Option<Contribution> {
        let radiance = f * vpl.power * (self.light[i] * self.point[i]);
        let is_lit = !radiance.is_black() && (vpl.p - at.p).dot(vpl.ns) < 0.0;
        is_lit.then(|| Contribution { radiance, geometry: self.light[i] * self.ground[i] })
    }
}
