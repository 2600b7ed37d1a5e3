//! A set of lights prepared for many points. Lights that face a point are found eight at a time, and the BSDFs of
//! glossy lights are computed once.

use std::ops::Range;

use gi_core::bsdf::Bsdf;
use gi_core::math::Rgb;
use gi_core::ray::Ray;
use gi_core::scene::Scene;
use glam::Vec3;

use crate::illuminate::{Connection, Receiver, connect};
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
        Prepared { set, scene, bsdfs, columns }
    }

    /// Connect a point with a range of the lights, and call `take` with each connection that carries light and the
    /// fraction of it that passes the shadow ray. Returns the number of shadow rays.
    #[inline]
    pub fn for_each_visible(
        &self,
        lights: Range<usize>,
        at: &Receiver,
        mut take: impl FnMut(Connection, Rgb),
    ) -> u64 {
        let (mut facing, mut seen) = ([0; BATCH], [(0, Rgb::BLACK); BATCH]);
        let mut rays = 0;
        for from in lights.clone().step_by(BATCH) {
            let count = BATCH.min(lights.end - from);
            let turned = self.facing(from..from + count, at, &mut facing);
            // Trace the shadow rays of a batch first: caches stay warm, and occluded lights skip BSDF evaluation.
            let mut passed = 0;
            for &k in turned {
                let vpl = &self.set.lights[k];
                let through = self.scene.transmittance_to(self.shadow(vpl, at), vpl.on);
                seen[passed] = (k, through);
                passed += usize::from(!through.is_black());
            }
            rays += turned.len() as u64;
            for &(k, through) in &seen[..passed] {
                let vpl = &self.set.lights[k];
                let scattered = |k: u32, d: Vec3| self.scattered(k, d);
                if let Some(connection) = connect(self.scene, vpl, at, scattered) {
                    take(connection, through);
                }
            }
        }
        rays
    }

    /// The shadow ray from a point to a light.
    #[inline]
    fn shadow(&self, vpl: &Vpl, at: &Receiver) -> Ray {
        match vpl.kind {
            Kind::Directional => self.scene.spawn(at.surface, -vpl.n),
            _ => self.scene.tree().shadow_ray(at.surface.p, at.surface.ng, vpl.p),
        }
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

    /// The lights of a batch that face the point and that the point faces. The loop has no branches, so that the
    /// compiler can vectorise it.
    #[inline]
    fn facing<'f>(
        &self,
        lights: Range<usize>,
        at: &Receiver,
        found: &'f mut [usize; BATCH],
    ) -> &'f [usize] {
        let n = at.normal.unwrap_or(Vec3::ZERO);
        // Without a normal no light is below the surface.
        let least = if n == Vec3::ZERO { 0.0 } else { f32::MIN_POSITIVE };
        let p = at.surface.p;
        let column = |k: usize| &self.columns[k][lights.clone()];
        let (px, py, pz) = (column(0), column(1), column(2));
        let (nx, ny, nz) = (column(3), column(4), column(5));
        let mut facing = [false; BATCH];
        for i in 0..lights.len() {
            let (x, y, z) = (px[i] - p.x, py[i] - p.y, pz[i] - p.z);
            let at_light = x * nx[i] + y * ny[i] + z * nz[i];
            let at_point = x * n.x + y * n.y + z * n.z;
            facing[i] = (at_light <= 0.0) & (at_point >= least);
        }
        let mut count = 0;
        for (k, facing) in lights.zip(facing) {
            found[count] = k;
            count += usize::from(facing);
        }
        &found[..count]
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
