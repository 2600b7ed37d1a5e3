//! A set of lights made ready for lighting many points: which of them face a point is found eight at a time, and how glossy
//! ones scatter is asked once.

use std::ops::Range;

use gi_core::bsdf::Bsdf;
use gi_core::math::Rgb;
use gi_core::ray::Ray;
use gi_core::scene::Scene;
use glam::Vec3;

use crate::illuminate::connect;
use crate::{Connection, Kind, Receiver, Vpl, Vpls};

/// Lights ready for lighting many points.
pub struct Prepared<'v, 'a> {
    set: &'v Vpls,
    scene: &'a Scene,
    /// How the glossy ones scatter; none where they are too many to keep.
    bsdfs: Vec<Option<Bsdf<'a>>>,
    /// Positions and normals, a column a coordinate. Lights that may shine in all directions have no normal; those that shine in
    /// parallel stand far away.
    columns: [Vec<f32>; 6],
}

/// Glossy lights whose scattering is kept.
const MOST_KEPT: usize = 1 << 16;
/// Lights that are looked at together.
const BATCH: usize = 64;

impl<'v, 'a> Prepared<'v, 'a> {
    /// Make a set ready.
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

    /// Connect a point with a range of the lights, and call `take` with every connection that carries light and the share
    /// of it that nothing stops. Returns how many shadow rays that took.
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
            // A batch is traced together, and before anything is scattered: the rays find their code and their tree where
            // they left them, and what is hidden is asked nothing else.
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

    /// The ray from a point to a light.
    #[inline]
    fn shadow(&self, vpl: &Vpl, at: &Receiver) -> Ray {
        match vpl.kind {
            Kind::Directional => self.scene.spawn(at.surface, -vpl.n),
            _ => self.scene.tree().shadow_ray(at.surface.p, at.surface.ng, vpl.p),
        }
    }

    /// Connect a point with light `k`, as if its power were one in every channel.
    #[inline]
    pub fn connect_unit(&self, k: usize, at: &Receiver) -> Option<Connection> {
        let vpl = Vpl { power: Rgb::WHITE, ..self.set.lights[k] };
        connect(self.scene, &vpl, at, |k, d| self.scattered(k, d))
    }

    /// The lights.
    pub fn set(&self) -> &'v Vpls {
        self.set
    }

    /// The lights of a batch that turn toward the point, and it toward them. Without branches: many are looked at together, and
    /// nothing is guessed.
    #[inline]
    fn facing<'f>(
        &self,
        lights: Range<usize>,
        at: &Receiver,
        found: &'f mut [usize; BATCH],
    ) -> &'f [usize] {
        let n = at.normal.unwrap_or(Vec3::ZERO);
        // Without a normal every direction is above.
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

    /// Share per solid angle of the power at a glossy light that goes along `d`.
    #[inline]
    fn scattered(&self, k: u32, d: Vec3) -> Rgb {
        let Some(bsdf) = self.bsdfs.get(k as usize) else {
            return self.set.scattered(self.scene, k, d);
        };
        let lit = &self.set.surfaces[k as usize];
        bsdf.as_ref().map_or(Rgb::BLACK, |bsdf| bsdf.f_cos(lit.wo, d))
    }
}
