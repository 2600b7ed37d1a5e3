//! Virtual spherical lights \[Hasan09\]: the power of a light spread over the surfaces within a radius of it. What a point
//! receives is an integral over the cone in which it sees the sphere, which has no peak however near the two are.

use std::f32::consts::PI;
use std::ops::Range;

use gi_core::math::{Frame, Rgb, safe_sqrt};
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;
use gi_core::warp;
use glam::Vec3;
use rayon::prelude::*;
use vpl::{Kind, Receiver, Vpl};

use crate::InstantRadiosity;

/// Radii of the spheres of a set of lights.
#[derive(Clone, Debug, Default)]
pub struct Spheres {
    /// A radius for each light, world.
    radii: Vec<f32>,
}

/// Lights that a sphere reaches: enough that neighbouring spheres overlap.
const NEIGHBOURS: usize = 4;
/// Lights among which neighbours are looked for; of more, evenly chosen ones stand for all.
const SAMPLED: usize = 4096;

impl Spheres {
    /// Let each sphere reach its fourth nearest light: small where lights are dense.
    pub fn round(lights: &[Vpl], scene: &Scene) -> Self {
        let step = lights.len().div_ceil(SAMPLED).max(1);
        let some: Vec<Vec3> = lights.iter().step_by(step).map(|v| v.p).collect();
        let nearest = NEIGHBOURS.min(some.len().saturating_sub(1));
        // Lights lie on surfaces: of so many fewer, neighbours are farther by the root.
        let closer = 1.0 / (step as f32).sqrt();
        let radius = |v: &Vpl| {
            let mut d: Vec<f32> = some.iter().map(|q| q.distance_squared(v.p)).collect();
            let r = d.select_nth_unstable_by(nearest, f32::total_cmp).1.sqrt() * closer;
            if r > 0.0 { r } else { 1e-3 * scene.radius() }
        };
        Spheres { radii: lights.par_iter().map(radius).collect() }
    }

    /// The sum over lights as spheres. One shadow ray a light, to its middle.
    pub fn gather(
        &self,
        technique: &InstantRadiosity,
        at: &Receiver,
        lights: Range<usize>,
        sampler: &mut Sampler,
    ) -> Rgb {
        let scene = technique.setting.scene;
        let (mut sum, mut connections) = (Rgb::BLACK, 0);
        // One pair of numbers for all lights, turned for each: lights are many, their noise averages out.
        let first = sampler.next_2d();
        for k in lights {
            let vpl = &technique.vpls().lights[k];
            let shift = (k as f32 * 0.618_034).fract();
            let u = [first[0], (first[1] + shift).fract()];
            let light = self.light(technique, at, vpl, self.radii[k], u);
            if light.is_black() {
                continue;
            }
            connections += 1;
            let shadow = scene.tree().shadow_ray(at.surface.p, at.surface.ng, vpl.p);
            sum += light * scene.transmittance_to(shadow, vpl.on);
        }
        technique.energy.note(sum.luminance(), 0.0, connections);
        sum
    }

    /// Radiance from one sphere, nothing in between: power / (pi r^2) times the integral over its cone of f(x) cos f(y) cos'.
    /// Both cosines are in the f of this house.
    fn light(
        &self,
        technique: &InstantRadiosity,
        at: &Receiver,
        vpl: &Vpl,
        radius: f32,
        u: [f32; 2],
    ) -> Rgb {
        let to = vpl.p - at.surface.p;
        let distance = to.length();
        if distance == 0.0 {
            return Rgb::BLACK;
        }
        // The sine of half the cone's angle; from within, all directions.
        let sin = (radius / distance).min(1.0);
        let one_minus_cos = if distance <= radius { 2.0 } else { 1.0 - safe_sqrt(1.0 - sin * sin) };
        let axis = Frame::from_normal(to / distance);
        let samples = technique.params.vsl_samples;
        let mut sum = Rgb::BLACK;
        for s in 0..samples {
            let v = (u[0] + (s as f32 + 0.5) / samples as f32).fract();
            let phi = (u[1] + s as f32 * 0.618_034).fract();
            let wi = axis.to_world(warp::cone([v, phi], one_minus_cos));
            let f_cos = at.f_cos(wi);
            if !f_cos.is_black() {
                sum += f_cos * self.emitted(technique, vpl, -wi);
            }
        }
        let omega = 2.0 * PI * one_minus_cos;
        sum * (omega / (samples as f32 * PI * radius * radius))
    }

    /// Intensity of the light along `d`, its cosine taken with its own normal.
    fn emitted(&self, technique: &InstantRadiosity, vpl: &Vpl, d: Vec3) -> Rgb {
        match vpl.kind {
            Kind::Glossy(k) => {
                let lit = &technique.vpls.surfaces[k as usize];
                let bsdf = lit.bsdf(technique.setting.scene);
                bsdf.map_or(Rgb::BLACK, |bsdf| bsdf.f_cos(lit.wo, d) * vpl.power)
            }
            _ => vpl.power * d.dot(vpl.n).max(0.0),
        }
    }
}
