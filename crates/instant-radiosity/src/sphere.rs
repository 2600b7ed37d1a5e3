//! Virtual spherical lights \[Hasan09\]: the power of a light is spread over the surfaces within a radius of it. The
//! light at a point is an integral over the cone in which the point sees the sphere. The integral has no peak at small
//! distances.

use std::f32::consts::PI;
use std::ops::Range;

use gi_core::math::{Frame, Rgb, safe_sqrt};
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use gi_core::warp;
use glam::Vec3;
use rayon::prelude::*;
use vpl::{Kind, Receiver, Vpl, Vpls};

/// Radii of the spheres of a set of lights.
#[derive(Clone, Debug, Default)]
pub struct Spheres {
    /// A radius for each light, world.
    radii: Vec<f32>,
}

/// Each sphere contains this many lights, so that neighbouring spheres overlap.
const NEIGHBOURS: usize = 4;
/// Largest number of lights that are searched for neighbours; of larger sets an even selection is searched.
const SAMPLED: usize = 4096;

impl Spheres {
    /// Each sphere reaches its fourth nearest light, so spheres are small where lights are dense.
    pub fn round(lights: &[Vpl], scene: &Scene) -> Self {
        let step = lights.len().div_ceil(SAMPLED).max(1);
        let some: Vec<Vec3> = lights.iter().step_by(step).map(|v| v.p).collect();
        let nearest = NEIGHBOURS.min(some.len().saturating_sub(1));
        // Lights lie on surfaces: with 1 / step of them, distances grow by the square root of step.
        let closer = 1.0 / (step as f32).sqrt();
        let radius = |v: &Vpl| {
            let mut d: Vec<f32> = some.iter().map(|q| q.distance_squared(v.p)).collect();
            let r = d.select_nth_unstable_by(nearest, f32::total_cmp).1.sqrt() * closer;
            if r > 0.0 { r } else { 1e-3 * scene.radius() }
        };
        Spheres { radii: lights.par_iter().map(radius).collect() }
    }
}

/// Virtual point lights as spheres.
pub(crate) struct SphereLights<'v> {
    pub(crate) scene: &'v Scene,
    pub(crate) vpls: &'v Vpls,
    /// The spheres of `vpls`.
    pub(crate) spheres: &'v Spheres,
    /// Number of directions per sphere.
    pub(crate) samples: u32,
}

impl SphereLights<'_> {
    /// Radiance from a range of the lights, and the number of shadow rays: one per light, to its centre.
    pub(crate) fn gather(
        &self,
        at: &Receiver,
        lights: Range<usize>,
        sampler: &mut Sampler,
    ) -> (Rgb, u64) {
        let scene = self.scene;
        let (mut sum, mut connections) = (Rgb::BLACK, 0);
        // All lights share one pair of random numbers, shifted for each light. The noise averages out over many lights.
        let first = sampler.next_2d();
        for k in lights {
            let vpl = &self.vpls.lights[k];
            let shift = (k as f32 * 0.618_034).fract();
            let u = [first[0], (first[1] + shift).fract()];
            let light = self.light(at, vpl, self.spheres.radii[k], u);
            if light.is_black() {
                continue;
            }
            connections += 1;
            let shadow = scene.tree().shadow_ray(at.p, at.ng, vpl.p);
            sum += light * scene.transmittance_to(shadow, vpl.on);
        }
        (sum, connections)
    }

    /// Unshadowed radiance from one sphere: power / (pi r^2) times the integral of f(x) cos f(y) cos' over its cone.
    fn light(&self, at: &Receiver, vpl: &Vpl, radius: f32, u: [f32; 2]) -> Rgb {
        let to = vpl.p - at.p;
        let distance = to.length();
        if distance == 0.0 {
            return Rgb::BLACK;
        }
        // The sine of the cone's half angle. From inside the sphere, the cone contains all directions.
        let sin = (radius / distance).min(1.0);
        let one_minus_cos = if distance <= radius { 2.0 } else { 1.0 - safe_sqrt(1.0 - sin * sin) };
        let axis = Frame::from_normal(to / distance);
        let samples = self.samples;
        let mut sum = Rgb::BLACK;
        for s in 0..samples {
            let v = (u[0] + (s as f32 + 0.5) / samples as f32).fract();
            let phi = (u[1] + s as f32 * 0.618_034).fract();
            let wi = axis.to_world(warp::cone([v, phi], one_minus_cos));
            let f_cos = at.f_cos(wi);
            if !f_cos.is_black() {
                sum += f_cos * self.emitted(vpl, -wi);
            }
        }
        let omega = 2.0 * PI * one_minus_cos;
        sum * (omega / (samples as f32 * PI * radius * radius))
    }

    /// Power that the light scatters toward `d` per solid angle, including the cosine at the light.
    fn emitted(&self, vpl: &Vpl, d: Vec3) -> Rgb {
        match vpl.kind {
            Kind::Glossy(k) => {
                let lit = &self.vpls.surfaces[k as usize];
                let bsdf = lit.bsdf(self.scene);
                bsdf.map_or(Rgb::BLACK, |bsdf| bsdf.f_cos(lit.wo, d) * vpl.power)
            }
            _ => vpl.power * d.dot(vpl.n).max(0.0),
        }
    }
}
