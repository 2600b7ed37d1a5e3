//! A point lit by one virtual point light [slide 50].

use gi_core::bsdf::{Bsdf, Transport};
use gi_core::geometry::Surface;
use gi_core::math::Rgb;
use gi_core::ray::Ray;
use gi_core::scene::Scene;
use gi_core::walk::adjoint_correction;
use glam::Vec3;

use crate::{Kind, Vpl, Vpls};

/// A point that is lit, as a path from the eye met it.
#[derive(Clone, Copy)]
pub struct Receiver<'r, 'a> {
    /// The point.
    pub surface: &'r Surface,
    /// Unit direction back to the eye.
    pub wo: Vec3,
    /// How it scatters.
    pub bsdf: &'r Bsdf<'a>,
}

/// What a light would send the eye by way of a point, if nothing stood in between.
#[derive(Clone, Copy, Debug)]
pub struct Connection {
    /// Radiance toward the eye, the geometric term unbounded.
    pub radiance: Rgb,
    /// The geometric term cos cos' / d^2 with the geometric normals, per squared world unit; 0 for lights that are no
    /// surfaces, which no other way of sampling finds.
    pub geometry: f32,
    /// Unit direction to the light.
    pub wi: Vec3,
    /// Whatever this ray meets stands in between.
    pub shadow: Ray,
}

impl Vpls {
    /// Connect a point with a light. `None` where the light turns away or the point scatters nothing of it.
    #[inline]
    pub fn connect(&self, scene: &Scene, vpl: &Vpl, at: &Receiver) -> Option<Connection> {
        let x = at.surface;
        if vpl.kind == Kind::Directional {
            let wi = -vpl.n;
            let radiance = at.bsdf.f_cos(at.wo, wi) * vpl.power;
            return (!radiance.is_black()).then(|| Connection {
                radiance,
                geometry: 0.0,
                wi,
                shadow: scene.spawn(x, wi),
            });
        }
        let to = vpl.p - x.p;
        let distance_sq = to.length_squared();
        if distance_sq == 0.0 {
            return None;
        }
        let wi = to / distance_sq.sqrt();
        let cos_light = -wi.dot(vpl.n);
        let (intensity, cos_light) = match vpl.kind {
            Kind::Oriented => (vpl.power * cos_light.max(0.0), cos_light),
            Kind::Omni => (vpl.power, 0.0),
            Kind::Spot(light) => {
                (vpl.power * scene.lights().all()[light as usize].spot_fade(-wi), 0.0)
            }
            Kind::Glossy(k) => (self.scattered(scene, k, -wi) * vpl.power, cos_light.abs()),
            Kind::Directional => unreachable!("parallel light has no position"),
        };
        if intensity.is_black() {
            return None;
        }
        let radiance = at.bsdf.f_cos(at.wo, wi) * intensity * (1.0 / distance_sq);
        if radiance.is_black() {
            return None;
        }
        let geometry = x.ng.dot(wi).abs() * cos_light.max(0.0) / distance_sq;
        Some(Connection {
            radiance,
            geometry,
            wi,
            shadow: scene.tree().shadow_ray(x.p, x.ng, vpl.p),
        })
    }

    /// Share per solid angle of the power at a glossy light that goes along `d`.
    fn scattered(&self, scene: &Scene, k: u32, d: Vec3) -> Rgb {
        let lit = &self.surfaces[k as usize];
        let bsdf = scene.bsdf(&lit.surface, lit.wo, Transport::Power);
        bsdf.f_cos(lit.wo, d) * adjoint_correction(&lit.surface, lit.wo, d)
    }
}
