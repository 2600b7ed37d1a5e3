//! A set of lights made ready for lighting many points: which of them face a point is found eight at a time, and how glossy
//! ones scatter is asked once.

use std::ops::Range;

use gi_core::bsdf::{Bsdf, Transport};
use gi_core::math::Rgb;
use gi_core::scene::Scene;
use gi_core::walk::adjoint_correction;
use glam::Vec3;

use crate::illuminate::connect;
use crate::{Connection, Kind, Receiver, Vpl, Vpls};

/// Lights ready for lighting many points.
pub struct Prepared<'v, 'a> {
    set: &'v Vpls,
    scene: &'a Scene,
    /// How the glossy ones scatter; none where they are too many to keep.
    bsdfs: Vec<Bsdf<'a>>,
    /// Positions and normals, a column a coordinate. Lights that shine in all directions have no normal; those that shine in
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
        let bsdf = |lit: &crate::LitSurface| scene.bsdf(&lit.surface, lit.wo, Transport::Power);
        let kept = if set.surfaces.len() <= MOST_KEPT { &set.surfaces[..] } else { &[] };
        let bsdfs = kept.iter().map(bsdf).collect();
        let far = 1e6 * scene.radius();
        let place = |v: &Vpl| match v.kind {
            Kind::Oriented => [v.p, v.n],
            Kind::Directional => [-v.n * far, Vec3::ZERO],
            Kind::Omni | Kind::Spot(_) | Kind::Glossy(_) => [v.p, Vec3::ZERO],
        };
        let column = |k: usize| set.lights.iter().map(|v| place(v)[k / 3][k % 3]).collect();
        Prepared { set, scene, bsdfs, columns: std::array::from_fn(column) }
    }

    /// Connect a point with a range of the lights, and call `take` with every connection that carries light.
    #[inline]
    pub fn for_each_connection(
        &self,
        lights: Range<usize>,
        at: &Receiver,
        mut take: impl FnMut(Connection),
    ) {
        let mut facing = [0u8; BATCH];
        // What is connected is traced together: the rays find their code and their tree where they left them.
        let mut ready: Vec<Connection> = Vec::with_capacity(BATCH);
        for from in lights.clone().step_by(BATCH) {
            let count = BATCH.min(lights.end - from);
            self.mark_facing(from, at, &mut facing[..count]);
            for (k, _) in facing[..count].iter().enumerate().filter(|(_, f)| **f != 0) {
                let vpl = &self.set.lights[from + k];
                let scattered = |k: u32, d: Vec3| self.scattered(k, d);
                ready.extend(connect(self.scene, vpl, at, scattered));
            }
            ready.drain(..).for_each(&mut take);
        }
    }

    /// Which lights turn toward the point, and it toward them. Without branches, so that it is done many at a time.
    #[inline]
    fn mark_facing(&self, from: usize, at: &Receiver, facing: &mut [u8]) {
        let n = at.facing_normal().unwrap_or(Vec3::ZERO);
        // Without a normal every direction is above.
        let least = if n == Vec3::ZERO { 0.0 } else { f32::MIN_POSITIVE };
        let p = at.surface.p;
        let column = |k: usize| &self.columns[k][from..from + facing.len()];
        let (px, py, pz) = (column(0), column(1), column(2));
        let (nx, ny, nz) = (column(3), column(4), column(5));
        for i in 0..facing.len() {
            let (x, y, z) = (px[i] - p.x, py[i] - p.y, pz[i] - p.z);
            let at_light = x * nx[i] + y * ny[i] + z * nz[i];
            let at_point = x * n.x + y * n.y + z * n.z;
            facing[i] = u8::from(at_light <= 0.0) & u8::from(at_point >= least);
        }
    }

    /// Share per solid angle of the power at a glossy light that goes along `d`.
    #[inline]
    fn scattered(&self, k: u32, d: Vec3) -> Rgb {
        let Some(bsdf) = self.bsdfs.get(k as usize) else {
            return self.set.scattered(self.scene, k, d);
        };
        let lit = &self.set.surfaces[k as usize];
        bsdf.f_cos(lit.wo, d) * adjoint_correction(&lit.surface, lit.wo, d)
    }
}
